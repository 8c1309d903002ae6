// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/machine/galvo_lag.hpp"

/// A plate of lines that show how the mirrors follow: what was burnt, and where its marks were measured. Two CSV files,
/// in millimetres (docs/formats.md). In memory all is metres and seconds.

namespace sc::host {

/// One line, straight or swinging as a sine, at constant speed; mark k lies k · pitch along it. (x, z) of the galvo.
struct LagLine {
    int no = 0;
    bool along_x = true;  ///< it runs along x and swings along z; else the other way round
    int way = 1;          ///< +1 towards greater coordinates, −1 back
    std::array<double, 2> start{};
    double run = 0.0;         ///< how far it runs along its axis
    double amplitude = 0.0;   ///< of the swing; 0: straight
    double wavelength = 0.0;  ///< of the swing, along the axis; 0 of a straight line
    double speed = 0.0;       ///< along the path
    double pitch = 0.0;       ///< between marks, along the path
    Vec3 anchor;              ///< where the axes stood, h
    bool operator==(const LagLine&) const noexcept = default;
};
struct LagPlan {
    GalvoLag told;  ///< the lag that the controller made up for while it burnt
    std::vector<LagLine> lines;
};
struct LagMark {
    int line = 0;
    int mark = 0;  ///< from 0, in the order of burning
    Vec3 place;    ///< h
    double sigma = 0.0;
};

/// Header: line,along,way,start_x,start_z,run,amplitude,wavelength,speed,pitch,anchor_x,anchor_y,anchor_z,
/// told_latency_us,told_frequency_hz,told_damping. Throws InputError; lines must not repeat, and were all burnt with
/// the same lag.
[[nodiscard]] LagPlan read_lag_plan(const std::filesystem::path& path);
void write_lag_plan(const std::filesystem::path& path, const LagPlan& plan);
/// Header: line,mark,x,y,z,sigma. Throws InputError for a mark that repeats, a sigma that is not above zero, a place
/// beyond 10 m.
[[nodiscard]] std::vector<LagMark> read_lag_marks(const std::filesystem::path& path);

}  // namespace sc::host
