// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sc::sim {

/// A stepped mobile target, seen by a sensor (frame c) and pointed at by the beam (frame h).
struct RigidSetOptions {
    std::uint64_t seed = 1;
    int sets = 1;
    int markers = 12;
    double pointing = 10e-6;  ///< metres, across the beam (x and z of h), besides the axes' 2.5 µm
    double sensor = 7.5e-6;   ///< twice that in depth (z of c)
    int wrong = 0;            ///< markers that are somewhere else by 1 to 5 mm
};
/// DIR/set_0001/c.csv and h.csv; DIR/truth.csv: h_from_c and the bound of the error on a face of 400 × 300 mm (µm rms
/// over its corners). Throws std::runtime_error.
void write_rigid_sets(const std::filesystem::path& folder, const RigidSetOptions& options);

/// Markers on a board, tilted by 60 degrees, on a turntable before a sensor.
struct AxisSetOptions {
    std::uint64_t seed = 1;
    int sets = 1;
    int markers = 10;
    int angles = 12;
    double arc = 6.283185307179586;  ///< radians, from the first angle to the last (a full turn: one step less)
    double sensor = 7.5e-6;
    double table = 8.73e-6;  ///< radians (0.5 mdeg)
};
/// DIR/set_0001/markers.csv; DIR/truth.csv: a point of the axis, its direction, the height above that point at which
/// the error is taken (200 mm above the board) and the bound of the distance there (µm rms). Throws std::runtime_error.
void write_axis_sets(const std::filesystem::path& folder, const AxisSetOptions& options);

}  // namespace sc::sim
