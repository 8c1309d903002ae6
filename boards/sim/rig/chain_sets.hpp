// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sc::sim {

/// A whole cell to be calibrated: a sensor on a robot, a turntable, reference markers that stand still, a mobile target
/// that the beam points at, a tilted board of markers for the axis, and a workpiece of 400 × 400 × 300 mm with nine
/// markers on each of four faces. Metres, radians, 1 sigma.
struct ChainSetOptions {
    enum class References : std::uint8_t {
        ring,    ///< 24 markers around the table, of which a view sees the 12 on its side
        corner,  ///< a corner target of 80 mm: the same 5 markers in each view (the paper's set-up)
    };
    std::uint64_t seed = 1;
    int sets = 1;
    References references = References::ring;
    int mobile = 30;          ///< markers of the mobile target
    int angles = 24;          ///< of the table, with the board
    double pointing = 10e-6;  ///< across the beam (x and z of h), besides the axes'
    double sensor = 7.5e-6;
    double axes = 2.5e-6;
    double table = 8.73e-6;  ///< 0.5 mdeg
    double robot_place = 6.7e-6;
    double robot_turn = 2.618e-5;  ///< 1.5 mdeg
    double dh_length = 0.0;        ///< errors of the arm's parameters
    double dh_angle = 0.0;
    int wrong = 0;             ///< sightings that are somewhere else by 1 to 5 mm
    int swapped = 0;           ///< views in which two markers that stand still have each other's number
    double wrong_angle = 0.0;  ///< one angle of the board's views is read so far off
    bool clouds = false;       ///< a cloud of the workpiece for each of its views
};

/// DIR/set_0001/scan_set.toml, references.toml and mobile.toml (targets, nominal), pointing.csv (places in h),
/// marks.csv (a row a marker of the workpiece: where axes truly stand when the beam meets it with its face before the
/// laser, and what a person who points at it would read), and wrong.csv (view, id of what is wrong). DIR/truth.csv: a
/// row a set with the true h_from_c (c is the frame of the first view) and axis in h. Throws std::runtime_error.
void write_chain_sets(const std::filesystem::path& folder, const ChainSetOptions& options);

}  // namespace sc::sim
