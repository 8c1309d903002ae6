// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/formats/part.hpp"
#include "host/inspection/alignment.hpp"
#include "host/inspection/borrowing.hpp"
#include "host/inspection/distance_field.hpp"
#include "host/inspection/face_gauge.hpp"
#include "host/inspection/faces.hpp"

namespace sc::host {

/// Which faces of the CAD model ask for metal. Group i of a plan asks for `groups[i]`.
struct AllowancePlan {
    std::vector<BorrowGroup> groups;
    std::vector<std::uint32_t> group_of_face;  ///< kNoGroup for faces that ask for nothing
    std::vector<std::string> notes;            ///< for a person: features that share a face, say
};
inline constexpr std::uint32_t kNoGroup = 0xffffffffU;

/// Finds the faces of a part's machined features by the points on them, and checks kind, direction and diameter.
/// Features on one face share a group that asks for the larger allowance. Throws InputError that names the feature.
[[nodiscard]] AllowancePlan plan_from(const Part& part, const DistanceField& field, const FaceMap& map);
/// Every face larger than a thousandth of the surface asks for the same.
[[nodiscard]] AllowancePlan plan_for_all(const FaceMap& map, double least);

/// Why points over a face do not count there.
struct LeftOut {
    std::size_t at_edges =
        0;  ///< nearest to an edge between faces, or on a rim of the blank: beside the face, not over it
    std::size_t other_way = 0;  ///< the scanned surface there stands across the face: a wall beside it
    std::size_t outliers = 0;   ///< alone, or off the surface that its neighbours make
};

/// Points that lie over the faces of a plan.
struct OverFaces {
    std::vector<BorrowPoint> points;
    std::vector<std::uint32_t> index;  ///< of each in the scan
    LeftOut left_out;
};

/// Sorts the points of a scan, already in w, onto the faces of a plan. `distances` are those of `places`. Normals and
/// outliers come from neighbours within three mean spacings. Some 1 µs for a point over a face.
[[nodiscard]] OverFaces points_over(const DistanceField& field, const FaceMap& map, const AllowancePlan& plan,
                                    std::span<const Vec3> places, std::span<const Distance> distances,
                                    unsigned threads = 0);

struct WorstPlace {
    Vec3 place;  ///< metres, in w
    double allowance = 0.0;
};
inline constexpr std::size_t kHistogram = 24;

/// Allowance over one face, metres. Without points there is no verdict.
struct FaceAllowance {
    std::string id;
    double least_asked = 0.0;
    std::size_t count = 0;
    double least = 0.0;
    double most = 0.0;
    double mean = 0.0;
    double sigma = 0.0;
    std::array<std::size_t, kHistogram> histogram{};  ///< from `histogram_low`, bins of `histogram_width`
    double histogram_low = 0.0;
    double histogram_width = 0.0;
    std::vector<WorstPlace> worst;  ///< up to three, apart by at least 5 mm, the least first
    [[nodiscard]] double margin() const noexcept { return least - least_asked; }
    [[nodiscard]] bool enough() const noexcept { return count > 0 && margin() >= 0.0; }
};
/// Allowance on the sides that look along and against an axis: the paper's Fig. 10.
struct Side {
    std::size_t count = 0;
    double least = 0.0;
    double mean = 0.0;
};
struct AllowanceReport {
    std::vector<FaceAllowance> faces;            ///< in the order of the plan's groups
    std::array<std::array<Side, 2>, 3> sides{};  ///< [x, y, z][towards +, towards −]
    double least_margin = 0.0;
    [[nodiscard]] bool enough() const noexcept;
    [[nodiscard]] const FaceAllowance* worst() const noexcept;
};

/// Measures the points at another place: `motion` moves them from where they were sorted.
[[nodiscard]] AllowanceReport evaluate(const FaceGauge& gauge, std::span<const BorrowPoint> points,
                                       std::span<const BorrowGroup> groups, const Rigid<frame::W, frame::W>& motion,
                                       unsigned threads = 0);

/// Surfaces that stay as cast: how far the scan lies off them, metres.
struct AsCast {
    std::size_t count = 0;
    double mean = 0.0;
    double sigma = 0.0;
    double least = 0.0;  ///< at one in a thousand: outliers do not count
    double most = 0.0;
};
[[nodiscard]] AsCast as_cast(const FaceMap& map, const AllowancePlan& plan, std::span<const Distance> distances);

}  // namespace sc::host
