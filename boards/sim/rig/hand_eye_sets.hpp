// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sc::sim {

/// A sensor on a robot's flange that looks at a fixed target from many poses. Metres, radians, 1 sigma.
struct HandEyeSetOptions {
    std::uint64_t seed = 1;
    int sets = 1;
    int views = 15;
    int markers = 12;
    double tilt = 0.436;  ///< either way about x and y (25 degrees)
    double roll = 1.047;  ///< either way (60 degrees)
    double marker_sigma = 7.5e-6;
    double depth_factor = 1.0;  ///< noise along the sensor's z is so many times larger
    double robot_place = 6.7e-6;
    double robot_turn = 2.618e-5;  ///< 1.5 mdeg
    double bad_place = 0.0;        ///< one pose is so far off
    double bad_turn = 0.0;
    int swapped_views = 0;  ///< in which two markers have each other's number
};

/// DIR/set_0001/robot.csv and target.csv and so on; DIR/truth.csv: a row a set with the true f_from_c, the bounds (rms
/// of the rotation vector, mdeg; of the place, µm), the bad pose and the swapped markers. Throws std::runtime_error.
void write_hand_eye_sets(const std::filesystem::path& folder, const HandEyeSetOptions& options);

}  // namespace sc::sim
