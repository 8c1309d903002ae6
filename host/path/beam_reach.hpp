// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "shared/geometry/frames.hpp"
#include "shared/machine/machine.hpp"

/// From which turntable face the beam reaches which part of a line on the workpiece.

namespace sc::host {

/// A place on a surface, in c.
struct SurfacePlace {
    Vec3 place;          ///< metres
    Vec3 normal;         ///< unit, out of the metal
    double sigma = 0.0;  ///< metres: standard deviation of its height along the normal
};

enum class Unreached : std::uint8_t { none, incidence, travel, keep_out, occluded, too_short, edge, unsure };
[[nodiscard]] std::string_view name_of(Unreached why) noexcept;

struct ReachOptions {
    std::vector<double> faces{0.0, 90.0, 180.0, 270.0};  ///< degrees
    double incidence_deg = 60.0;                         ///< the largest angle between beam and surface normal
    double room = 5e-3;            ///< metres kept from the ends of travel and keep-out volumes, for run-in
    double beam_radius = 0.3e-3;   ///< metres, at the focus, with what the cloud's spacing asks for
    double beam_opening = 0.0313;  ///< how much it grows for each metre above the focus (10 mm aperture, f = 160 mm)
    double edge = 0.3e-3;          ///< metres left out before an edge: about what lies between two points of the scan
    double off_plane = 40e-6;      ///< metres that three sigma of height may move a mark off its plane
    double unseen_rim = 1.5e-3;    ///< metres: so far the edge of what stands before a place may reach past its scan
    double least_length = 1e-3;    ///< metres: shorter pieces are not burnt
};

/// Part of a line that one face burns, in c.
struct ReachedPiece {
    double face_deg = 0.0;
    std::vector<SurfacePlace> places;  ///< a closed one ends where it began
    double length = 0.0;               ///< metres
    double worst_incidence_deg = 0.0;
};
struct MissedPiece {
    Vec3 from;  ///< in c
    Vec3 to;
    double length = 0.0;
    Unreached why = Unreached::none;  ///< at the face that looks at it best
};
struct SplitLine {
    std::vector<ReachedPiece> reached;
    std::vector<MissedPiece> missed;
};

/// The faces, degrees in (−180, 180], before which the beam lies in planes with this normal (unit, in c): there an
/// error of depth moves a mark within the plane and not off it. None for planes that any face shows so, or that no face
/// does.
[[nodiscard]] std::vector<double> faces_along(const CalibrationSet& calibration, const Vec3& normal);

/// What the beam can reach of a scanned workpiece. The beam is taken along −y of h; what stands before a place is known
/// from the cloud alone, so what was not scanned hides nothing.
class BeamReach {
public:
    /// `cloud` in c. Throws InputError if the calibration has no h_from_c or no turntable axis. A million points: some
    /// 20 ms a face.
    BeamReach(const CalibrationSet& calibration, const MachineConfig& machine, std::span<const Vec3> cloud,
              const ReachOptions& options = {});

    /// One place from one face (an index of the options' list).
    [[nodiscard]] Unreached at(const SurfacePlace& place, std::size_t face) const;
    /// Angle between beam and normal there, degrees.
    [[nodiscard]] double incidence_deg(const SurfacePlace& place, std::size_t face) const;
    /// Cuts a line into as few pieces as can be, each reached from one face. Pieces that follow one another share the
    /// place between them. With the normal of the line's plane (unit, in c), faces before which the beam lies in that
    /// plane go first, and others burn what those do not reach.
    [[nodiscard]] SplitLine split(std::span<const SurfacePlace> places, bool closed, const Vec3& normal = {}) const;
    /// The place in h with that face before the laser.
    [[nodiscard]] Vec3 in_h(const Vec3& place, std::size_t face) const;
    [[nodiscard]] const ReachOptions& options() const noexcept { return options_; }

private:
    /// The highest y of the cloud over cells of x and z.
    struct View {
        Rigid<frame::H, frame::C> h_from_c;
        double x = 0.0;
        double z = 0.0;
        std::size_t columns = 0;
        std::size_t rows = 0;
        double top = 0.0;
        std::vector<float> highest;
    };
    void fill(View& view, std::span<const Vec3> cloud) const;
    [[nodiscard]] bool hidden(const View& view, const Vec3& place) const;
    /// A line with places at least every half millimetre.
    struct FineLine {
        std::vector<SurfacePlace> places;
        std::vector<bool> original;  ///< it had this place before
        std::vector<bool> corner;    ///< within `edge` of an edge between faces
    };
    [[nodiscard]] FineLine refined(std::span<const SurfacePlace> places, bool closed) const;
    /// Why a face does not burn a place of a line. `sway`: how far an error along the beam leads off the plane, a sine;
    /// near 0 the face lies along the plane, and the corners of the line and a poorly seen surface do not count.
    [[nodiscard]] Unreached why_not(const FineLine& line, std::size_t i, std::size_t face, double sway) const;
    /// Which places of a line each face may burn, and which of them a face along the line's plane does.
    struct Reached {
        std::vector<std::vector<Unreached>> by;  ///< [face][place]
        std::vector<bool> along;                 ///< [face]
        std::vector<bool> kept;                  ///< [place] for faces along the plane
        /// Burnt from `begin` on without a break: up to this index.
        [[nodiscard]] std::size_t to(std::size_t begin, std::size_t face) const;
    };
    [[nodiscard]] Reached reached(const FineLine& line, const Vec3& normal) const;
    /// The face that burns the most from place `begin` on, and up to where; of equals the one that looks straightest.
    [[nodiscard]] std::pair<std::size_t, std::size_t> farthest(const Reached& faces, std::size_t begin,
                                                               const SurfacePlace& place) const;
    [[nodiscard]] std::size_t straightest(const SurfacePlace& place) const;

    MachineConfig machine_;
    ReachOptions options_;
    std::vector<View> views_;
};

}  // namespace sc::host
