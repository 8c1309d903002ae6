// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/formats/part.hpp"
#include "host/inspection/distance_field.hpp"
#include "shared/geometry/frames.hpp"

namespace sc::host {

/// What was measured does not allow the answer that was asked for: too little overlap, another part, a reference point
/// that the scan does not show. The text says which and what to do.
class InspectionError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// From the scan's frame to that of the CAD model.
using Placement = Rigid<frame::W, frame::C>;

struct FitOptions {
    unsigned threads = 0;
    /// One a triangle: whether points that are nearest to it count (the surfaces that both scan and CAD have). Empty =
    /// all do.
    std::vector<bool> use = {};
    double reach = 0.0;  ///< metres: points farther off count at the start; 0 = a tenth of the CAD model's diagonal
};

struct Fit {
    Placement w_from_c;
    std::size_t used = 0;      ///< points that decided
    std::size_t rejected = 0;  ///< points too far off what the others say, of those that could have
    double sigma = 0.0;        ///< metres: robust spread of what was used
    int passes = 0;            ///< over all points
    /// Least eigenvalue of the normal equations over the largest; near 0 = a motion that the surfaces do not fix.
    double stiffness = 0.0;
};

/// Moves points onto a mesh: Gauss-Newton on the signed distances to its triangles, robust (Tukey's weights, its width
/// from the residuals), first on few points, then on all. Finds the nearest optimum: start within some degrees and a
/// tenth of the part, or from `global_start`. Two passes over all points, some 0.1 s each for a million and two
/// threads. Throws InspectionError if too few points count.
[[nodiscard]] Fit fit_to_mesh(const DistanceField& field, std::span<const Vec3> points, const Placement& start,
                              const FitOptions& options = {});

struct GlobalStart {
    Placement w_from_c;
    double score = 0.0;   ///< mean distance, cut off, of a spread sample; metres
    double second = 0.0;  ///< the same of the best that is another placement (15 degrees or a tenth of the part away)
};

/// A first placement from nothing: some thousand rotations, each settled in a coarse distance grid, the best ones on
/// the mesh. Some 0.7 s on two cores. `second` near `score` means that the part looks alike from there.
[[nodiscard]] GlobalStart global_start(const DistanceField& field, std::span<const Vec3> points, unsigned threads = 0);

struct ReferenceUse {
    std::string id;
    std::size_t points = 0;  ///< of the scan, about it
    double offset = 0.0;     ///< metres along its normal, after the alignment: 0 for a 3-2-1
};
struct ReferenceAlignment {
    Placement w_from_c;
    std::vector<ReferenceUse> references;
    double stiffness = 0.0;  ///< as of Fit
};

/// 3-2-1: six reference points on as-cast surfaces fix the part, whatever the rest of it looks like; more than six by
/// least squares. Each is measured as the mean of the scan within `radius` of its normal and `depth` along it (less
/// than the walls are thick). Throws InspectionError that names a reference point without scan, or says that they leave
/// a motion free.
[[nodiscard]] ReferenceAlignment align_by_references(std::span<const ReferencePoint> references,
                                                     std::span<const Vec3> points, const Placement& start,
                                                     double radius = 1.5e-3, double depth = 2.5e-3);

/// How much of the CAD surface has a scanned point within `reach` of it, 0 to 1, from a spread sample.
[[nodiscard]] double coverage(const DistanceField& field, std::span<const Vec3> points, const Placement& w_from_c,
                              double reach);

/// A turn by the vector's length (radians) about its direction.
[[nodiscard]] Mat3 turn_by(const Vec3& vector);
/// Applies a placement to many points.
[[nodiscard]] std::vector<Vec3> placed(const Placement& w_from_c, std::span<const Vec3> points);
/// Lowest and highest coordinates.
struct Extent {
    Vec3 low;
    Vec3 high;
    [[nodiscard]] double diagonal() const noexcept { return norm(high - low); }
};
[[nodiscard]] Extent extent_of(std::span<const Vec3> points);
/// About `count` of the points, spread evenly over space: at most one a cell of a grid. Indices in rising order.
[[nodiscard]] std::vector<std::uint32_t> spread_sample(std::span<const Vec3> points, std::size_t count);

}  // namespace sc::host
