// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "shared/geometry/frames.hpp"
#include "shared/machine/machine.hpp"

/// From which turntable face the beam reaches which part of a line on the workpiece.

namespace sc::host {

/// A place on a surface, in c.
struct SurfacePlace {
    Vec3 place;   ///< metres
    Vec3 normal;  ///< unit, out of the metal
};

enum class Unreached : std::uint8_t { none, incidence, travel, keep_out, occluded, too_short };
[[nodiscard]] std::string_view name_of(Unreached why) noexcept;

struct ReachOptions {
    std::vector<double> faces{0.0, 90.0, 180.0, 270.0};  ///< degrees
    double incidence_deg = 60.0;                         ///< the largest angle between beam and surface normal
    double room = 5e-3;            ///< metres kept from the ends of travel and keep-out volumes, for run-in
    double beam_radius = 0.3e-3;   ///< metres, at the focus, with what the cloud's spacing asks for
    double beam_opening = 0.0313;  ///< how much it grows for each metre above the focus (10 mm aperture, f = 160 mm)
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
    /// place between them.
    [[nodiscard]] SplitLine split(std::span<const SurfacePlace> places, bool closed) const;
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
    /// Reached from `begin` on without a break: up to this index.
    [[nodiscard]] std::size_t reached_to(std::span<const SurfacePlace> places, std::size_t begin,
                                         std::size_t face) const;

    MachineConfig machine_;
    ReachOptions options_;
    std::vector<View> views_;
};

}  // namespace sc::host
