// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/marker_check.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"

/// The axis of a turntable from markers that stand on it, seen at known angles: one fit over all markers and angles, so
/// that an arc of 90 degrees is enough (circles through each marker are 2.5 times worse there). Unknown are the axis,
/// the place of each marker, and what each angle was truly; everything counts by its noise. Host only, some
/// milliseconds.

namespace sc::host {

struct TurntableOptions {
    double sigma = 7.5e-6;      ///< metres, of a coordinate that states none
    double table = 8.73e-6;     ///< radians, of an angle (0.5 mdeg)
    bool fit_noise = false;     ///< one factor for all noise from the data
    bool find_wrong = true;     ///< markers and angles
    double most_turn = 8.7e-3;  ///< radians of the direction: more uncertainty than that is refused
    double most_place = 5e-3;   ///< metres, of the axis beside the markers' middle
};
struct TurntableView {
    std::string name;
    double turn = 0.0;      ///< radians, as read
    double turn_off = 0.0;  ///< what fits less what was read
    bool used = true;
    double rms = 0.0;  ///< metres, each coordinate of its markers
};
struct TurntableFit {
    Vec3 point;                  ///< of the axis, beside the middle of the markers
    Vec3 direction;              ///< unit; angles count counter-clockwise seen against it
    std::array<Vec3, 2> across;  ///< what the covariance counts along
    Covariance<4> covariance;    ///< of the point along `across`, then of the direction's turn towards `across`
    std::vector<TurntableView> views;
    std::vector<MarkerFinding> markers;
    std::vector<std::string> notes;
    double radius = 0.0;  ///< metres, rms of the markers
    double arc = 0.0;     ///< radians between the outermost angles
    double rms = 0.0;     ///< metres, each coordinate
    double chi_squared = 0.0;
    double freedom = 0.0;
    double noise_ratio = 1.0;                          ///< found over stated
    [[nodiscard]] double turn_sigma() const noexcept;  ///< in the worst direction
    [[nodiscard]] double place_sigma() const noexcept;
};

/// Throws InputError (with `file`) for views without angles, angles that hardly differ, and data that leave direction
/// or place more uncertain than the options allow.
[[nodiscard]] TurntableFit fit_turntable(const std::filesystem::path& file, std::vector<MarkerView> views,
                                         const TurntableOptions& options = {});

/// The same from poses of a target on the table, with `sigma` for its place and `turn_sigma` (radians) for its
/// rotation.
[[nodiscard]] TurntableFit fit_turntable_poses(const std::filesystem::path& file, const std::vector<NamedPose>& poses,
                                               double turn_sigma, const TurntableOptions& options = {});

}  // namespace sc::host
