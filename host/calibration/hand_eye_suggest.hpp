// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "host/calibration/hand_eye.hpp"

/// Which further robot poses would tell most about where the sensor sits. Each view adds information to X = f_from_c
/// and the markers' places once its own true robot pose is eliminated: with r = marker in c less predicted, J over (X,
/// markers), K over the pose, W = 1/σ² and P the pose's own weights,
///     I = Jᵀ W J − Jᵀ W K (Kᵀ W K + P)⁻¹ Kᵀ W J.
/// Candidates are the given poses, turned about the target and shifted within the given ones' reach; the best is taken,
/// then the best beside it, and so on. Host only; some 0.1 s for five of 400 candidates with twelve markers.

namespace sc::host {

enum class SuggestCriterion : std::uint8_t {
    worst,   ///< the largest variance: of turns, times an arm of 0.25 m, and places
    volume,  ///< the determinant of the covariance of X ("D-optimal")
};

struct SuggestOptions {
    int count = 3;
    int candidates = 400;
    double turn = 0.35;   ///< radians (20 degrees): most about the target, beside a given pose
    double reach = 0.05;  ///< metres: beyond the box of the given flange places
    std::uint64_t seed = 1;
    SuggestCriterion criterion = SuggestCriterion::worst;
    HandEyeNoise noise{};
};

struct SuggestedPose {
    Rigid<frame::B, frame::F> b_from_f;
    double turn_sigma = 0.0;   ///< radians: of X in its worst direction, with this view and those before it
    double place_sigma = 0.0;  ///< metres
    double criterion = 0.0;    ///< metres: root of the criterion's variance
};

struct Suggestion {
    double turn_sigma = 0.0;  ///< as the views stand
    double place_sigma = 0.0;
    double criterion = 0.0;
    double random_criterion = 0.0;     ///< median over the candidates, of one more view
    std::vector<SuggestedPose> poses;  ///< in the order of use
};

/// `views` as they were calibrated; `f_from_c` the result. Throws InputError for fewer than three markers in all.
[[nodiscard]] Suggestion suggest_poses(const std::vector<HandEyeView>& views, const Rigid<frame::F, frame::C>& f_from_c,
                                       const SuggestOptions& options);

/// Covariance of X, ξ about f's zero, that these views allow with this noise; markers and true poses unknown.
[[nodiscard]] Covariance<6> expected_covariance(const std::vector<HandEyeView>& views,
                                                const Rigid<frame::F, frame::C>& f_from_c, const HandEyeNoise& noise);

}  // namespace sc::host
