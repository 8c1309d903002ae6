// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/calibration/marker_check.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"
#include "shared/geometry/frames.hpp"

/// Hand-eye calibration, A X = X B: where the 3-D sensor sits on the robot's flange (X = f_from_c), from robot poses
/// and what the sensor saw of one fixed target. A closed form (rotation from axial vectors of all pairs of motions,
/// then translation by least squares) starts a maximum-likelihood fit: unknown are X, the true robot pose of each view
/// (its reading has noise) and the place of each marker in the robot's base. Everything is weighted by its noise, so
/// the covariance is that of the inverse Hessian. (shared facts: plain point fits with an exact robot are worse than
/// the closed form.) Host only; a fit of 15 views of 12 markers takes some 2 ms.

namespace sc::host {

struct HandEyeView {
    std::string name;
    int line = 0;  ///< of the file of robot poses
    Rigid<frame::B, frame::F> b_from_f;
    std::vector<SeenMarker> markers;                    ///< in c
    std::optional<Rigid<frame::C, frame::G>> c_from_g;  ///< where the target came as a pose: `markers` follow from it
};

/// Noise, 1 sigma.
struct HandEyeNoise {
    double robot_place = 6.7e-6;  ///< metres, each axis of a robot pose
    double robot_turn = 2.6e-5;   ///< radians, about each axis (1.5 mdeg)
    double marker = 7.5e-6;       ///< metres, of a marker's coordinate where the file states none
    double pose_turn = 2.6e-5;    ///< radians, of a target given as poses; `marker` is then its place's
    bool fit = false;             ///< estimate how much larger or smaller all of these are (variance components)
};

struct HandEyeOptions {
    HandEyeNoise noise;
    bool find_wrong = true;       ///< look for bad poses and markers
    bool try_conventions = true;  ///< look whether poses are given the other way round
    double most_turn = 8.7e-3;    ///< radians (0.5 degrees): more uncertainty than that is refused
    double most_place = 5e-3;     ///< metres
};

/// A robot pose and how it fits.
struct HandEyeViewResult {
    std::string name;
    bool used = true;
    double place_off = 0.0;   ///< metres, from what the robot says to what fits
    double turn_off = 0.0;    ///< radians
    double surprise = 0.0;    ///< chi-squared of that, 6 degrees of freedom
    double marker_rms = 0.0;  ///< metres, each coordinate
    std::size_t markers = 0;
};

struct HandEyeResult {
    Rigid<frame::F, frame::C> f_from_c;
    Covariance<6> covariance;  ///< as in TransformRecord: of ξ in Exp(ξ)·f_from_c
    Covariance<6> by_value;    ///< the same of rotation vector and t themselves: δt is not −[t]× turned
    std::vector<HandEyeViewResult> views;
    std::vector<MarkerFinding> markers;  ///< swapped, misnumbered, wrong
    std::vector<std::string> bad_poses;  ///< names of views left out
    std::vector<std::string> notes;      ///< conventions, views alike, noise that does not fit
    bool robot_inverted = false;         ///< poses fit as f_from_b alone
    bool target_inverted = false;        ///< target poses fit as g_from_c alone
    double chi_squared = 0.0;
    double freedom = 0.0;
    double robot_ratio = 1.0;  ///< noise found over noise stated
    double marker_ratio = 1.0;
    double scatter_rms = 0.0;  ///< metres: the target's place in the robot's base, view to view, with poses as read
    double turn_sigma = 0.0;   ///< radians, in the least certain direction
    double place_sigma = 0.0;  ///< metres
    Vec3 least_turn;           ///< those directions, in f
    Vec3 least_place;
};

/// Throws InputError (with `file`) for fewer than three views with three markers or more, poses that turn about one
/// axis only or not at all (the blind direction is named), and a list of poses that fits when shifted by a row.
[[nodiscard]] HandEyeResult calibrate_hand_eye(const std::filesystem::path& file, std::vector<HandEyeView> views,
                                               const HandEyeOptions& options = {});

/// How to bring robot poses and sightings together.
struct PairingOptions {
    double time_offset = 0.0;  ///< seconds, added to the time of the target's file
    std::size_t views = 50;    ///< of streams: as many are picked, slow and diverse
};
/// Views by name, or streams by time: the robot's pose is interpolated. Throws InputError for views that have no
/// partner (named), and for files of which one has times and the other names.
[[nodiscard]] std::vector<HandEyeView> pair_views(const PoseFile& robot, const MarkerFile& target);
[[nodiscard]] std::vector<HandEyeView> pair_views(const PoseFile& robot, const PoseFile& target,
                                                  const PairingOptions& options = {});

}  // namespace sc::host
