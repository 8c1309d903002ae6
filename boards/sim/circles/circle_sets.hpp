// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sc::sim {

struct SetOptions {
    int scenes = 24;   ///< each with places of its own
    int repeats = 50;  ///< pictures of a scene, noise of their own
    std::uint64_t seed = 1;
};

/// One marker a picture, semi-axes 20 and 14 px, at a random place within its pixel and a random direction of tilt:
/// single_SS_RR.png, camera.csv, truth.csv. Light rises by up to 10 grey values over 100 px. Throws std::runtime_error.
void write_singles(const std::filesystem::path& folder, const SetOptions& options);

/// Five markers of radius 5 mm, some 500 mm away on a plane tilted by 45°: board_SS_RR.png, camera.csv, truth.csv.
void write_boards(const std::filesystem::path& folder, const SetOptions& options);

/// A target of 20 markers of radius 3 mm on three steps, some 500 mm before a pair of cameras, two of its markers
/// covered and three strangers about it: left_SS_RR.png, right_SS_RR.png, pair.toml (scribecell-cameras), target.toml
/// (scribecell-target), truth.csv (scene, id, place in the left camera's frame; strangers have id 0).
void write_pairs(const std::filesystem::path& folder, const SetOptions& options);

}  // namespace sc::sim
