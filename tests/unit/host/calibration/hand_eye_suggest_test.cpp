// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/hand_eye_suggest.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

Mat3 turn(const Vec3& w) {
    const double angle = norm(w);
    const double s = angle > 0.0 ? std::sin(0.5 * angle) / angle : 0.0;
    return rotation_of_quaternion({std::cos(0.5 * angle), s * w.x, s * w.y, s * w.z});
}

const Rigid<frame::F, frame::C> kX{turn({0.4, -0.9, 1.1}), {0.05, -0.08, 0.11}};

std::vector<Vec3> markers() {
    std::vector<Vec3> out;
    for (int k = 0; k < 12; ++k) {
        out.push_back({0.8 + 0.06 * (k % 4), 0.1 + 0.05 * (k / 4), 0.3 + 0.005 * (k % 3)});
    }
    return out;
}

/// What the sensor sees of the target from a flange pose, without noise.
HandEyeView seen_from(const Rigid<frame::B, frame::F>& flange) {
    HandEyeView view;
    view.b_from_f = flange;
    const auto c_from_b = (flange * kX).inverse();
    int id = 1;
    for (const Vec3& p : markers()) {
        view.markers.push_back({0, id++, (c_from_b * Point<frame::B>{p}).v, {}});
    }
    return view;
}

/// Little tilt about one axis: the other is known badly.
std::vector<HandEyeView> poor_views() {
    std::vector<HandEyeView> out;
    for (int v = 0; v < 6; ++v) {
        const Mat3 r = turn({0.15 * (v - 2.5) / 2.5, 0.01 * (v % 2), 0.03 * v}) * turn({3.1, 0.0, 0.0});
        const Rigid<frame::B, frame::C> sensor{r, Vec3{0.89, 0.15, 0.3} - 0.43 * (r * Vec3{0.0, 0.0, 1.0})};
        out.push_back(seen_from(sensor * kX.inverse()));
    }
    return out;
}

/// Root of the largest variance, turns by an arm of 0.25 m: about the flange's zero, not the sensor as the ranking has
/// it.
double worst(const Covariance<6>& c) {
    double most = 0.0;
    for (std::size_t i = 0; i < 6; ++i) {
        most = std::max(most, c.at[i][i] * (i < 3 ? 0.0625 : 1.0));
    }
    return std::sqrt(most);
}

TEST(HandEyeSuggest, BeatsRandomPoses) {
    const std::vector<HandEyeView> views = poor_views();
    const Suggestion suggestion = suggest_poses(views, kX, {.count = 3});
    ASSERT_EQ(suggestion.poses.size(), 3U);
    EXPECT_LT(suggestion.poses[0].criterion, 0.8 * suggestion.random_criterion);
    EXPECT_LT(suggestion.poses[1].criterion, suggestion.poses[0].criterion);
    EXPECT_LT(suggestion.poses[2].criterion, suggestion.poses[1].criterion);
    std::vector<HandEyeView> followed = views;
    followed.push_back(seen_from(suggestion.poses[0].b_from_f));
    const double now = worst(expected_covariance(views, kX, {}));
    const double then = worst(expected_covariance(followed, kX, {}));
    EXPECT_LT(then, now);
    // Views drawn around the given ones by the same reach.
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    std::vector<double> drawn;
    const Vec3 middle{0.89, 0.15, 0.305};
    for (int i = 0; i < 60; ++i) {
        const Rigid<frame::B, frame::F>& flange = views[static_cast<std::size_t>(i) % views.size()].b_from_f;
        const Mat3 r = turn({0.2 * even(random), 0.2 * even(random), 0.2 * even(random)});
        std::vector<HandEyeView> more = views;
        more.push_back(seen_from({r * flange.rotation, middle + r * (flange.translation - middle)}));
        drawn.push_back(worst(expected_covariance(more, kX, {})));
    }
    std::ranges::sort(drawn);
    EXPECT_LT(then, drawn[drawn.size() / 2]) << "better than most random ones";
}

TEST(HandEyeSuggest, StaysWithinReach) {
    const std::vector<HandEyeView> views = poor_views();
    Vec3 least{1e9, 1e9, 1e9};
    Vec3 most{-1e9, -1e9, -1e9};
    for (const HandEyeView& view : views) {
        const Vec3& t = view.b_from_f.translation;
        least = {std::min(least.x, t.x), std::min(least.y, t.y), std::min(least.z, t.z)};
        most = {std::max(most.x, t.x), std::max(most.y, t.y), std::max(most.z, t.z)};
    }
    for (const SuggestCriterion criterion : {SuggestCriterion::worst, SuggestCriterion::volume}) {
        const Suggestion s = suggest_poses(views, kX, {.count = 5, .reach = 0.02, .criterion = criterion});
        for (const SuggestedPose& pose : s.poses) {
            for (std::size_t i = 0; i < 3; ++i) {
                EXPECT_GE(pose.b_from_f.translation[i], least[i] - 0.0201);
                EXPECT_LE(pose.b_from_f.translation[i], most[i] + 0.0201);
            }
            EXPECT_LT(orthogonality_error(pose.b_from_f.rotation), 1e-12);
        }
        EXPECT_LT(s.poses.back().criterion, s.criterion);
    }
    std::vector<HandEyeView> blind = views;
    for (HandEyeView& view : blind) {
        view.markers.resize(2);
    }
    EXPECT_THROW(static_cast<void>(suggest_poses(blind, kX, {})), InputError);
}

/// The bound is that of calibrate_hand_eye's own covariance.
TEST(HandEyeSuggest, ExpectsWhatTheCalibrationStates) {
    std::mt19937_64 random(8);
    std::normal_distribution<double> one(0.0, 1.0);
    std::vector<HandEyeView> views;
    for (int v = 0; v < 10; ++v) {
        const Mat3 r = turn({0.4 * std::cos(2.0 * v), 0.4 * std::sin(2.0 * v), 0.5 * v - 2.0}) * turn({3.1, 0.0, 0.0});
        const Rigid<frame::B, frame::C> sensor{r, Vec3{0.89, 0.15, 0.3} - 0.43 * (r * Vec3{0.0, 0.0, 1.0})};
        views.push_back(seen_from(sensor * kX.inverse()));
        views.back().name = std::to_string(v + 1);
        for (SeenMarker& marker : views.back().markers) {
            marker.place = marker.place + 7.5e-6 * Vec3{one(random), one(random), one(random)};
        }
        HandEyeView& view = views.back();
        view.b_from_f.rotation = turn(2.6e-5 * Vec3{one(random), one(random), one(random)}) * view.b_from_f.rotation;
        view.b_from_f.translation = view.b_from_f.translation + 6.7e-6 * Vec3{one(random), one(random), one(random)};
    }
    const HandEyeResult result = calibrate_hand_eye("views.csv", views);
    const Covariance<6> expected = expected_covariance(views, result.f_from_c, {});
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(std::sqrt(expected.at[i][i]), std::sqrt(result.covariance.at[i][i]),
                    0.02 * std::sqrt(result.covariance.at[i][i]))
            << i;
    }
}

}  // namespace
}  // namespace sc::host
