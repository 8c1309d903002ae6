// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sc::sim {

/// A pair of cameras that look at a flat board from many poses. Pixels, 1 sigma.
struct StereoSetOptions {
    std::uint64_t seed = 1;
    int sets = 1;
    int views = 12;
    double noise_px = 0.1;
    double tilt = 0.6;      ///< radians, either way about x and y
    int swapped_views = 0;  ///< in which two points of the left picture have each other's name
};

/// DIR/set_0001/left.csv and right.csv (board points), sights.csv (places seen by both cameras, to be triangulated) and
/// so on, all with noise; DIR/truth.csv: a row a set with the true cameras, right_from_left, the swapped points and the
/// bound of the sights' places (rms of a coordinate, µm, calibration included); DIR/places.csv: the sights' true places
/// in the left camera's frame. Throws std::runtime_error.
void write_stereo_sets(const std::filesystem::path& folder, const StereoSetOptions& options);

}  // namespace sc::sim
