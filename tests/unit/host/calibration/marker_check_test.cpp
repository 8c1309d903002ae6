// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/marker_check.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

constexpr double kSigma = 7.5e-6;

/// Views of one body of markers, each from elsewhere.
std::vector<MarkerView> views_of(int count, int markers, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> even(-0.1, 0.1);
    std::vector<Vec3> body;
    for (int k = 0; k < markers; ++k) {
        const double x = even(random);
        const double y = even(random);
        body.push_back({x, y, 0.3 * even(random)});
    }
    std::vector<MarkerView> out;
    for (int i = 0; i < count; ++i) {
        MarkerView view;
        view.line = i + 2;
        view.view = std::to_string(i + 1);
        const double w = normal(random);
        const double x = normal(random);
        const double y = normal(random);
        const Mat3 r = rotation_of_quaternion({w, x, y, normal(random)});
        for (int k = 0; k < markers; ++k) {
            const double a = kSigma * normal(random);
            const double b = kSigma * normal(random);
            const Vec3 seen = r * body[static_cast<std::size_t>(k)] + Vec3{0.1, 0.2, 0.4};
            view.markers.push_back({i + 2, k + 1, seen + Vec3{a, b, kSigma * normal(random)}, {}});
        }
        out.push_back(view);
    }
    return out;
}

TEST(MarkerCheck, SoundViewsStayAsTheyAre) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        auto views = views_of(8, 12, seed);
        EXPECT_TRUE(check_markers(views, kSigma).empty()) << seed;
        EXPECT_EQ(views[3].markers.size(), 12U);
    }
}

TEST(MarkerCheck, SwappedNumbersArePutRight) {
    auto views = views_of(6, 10, 2);
    const Vec3 second = views[2].markers[1].place;
    std::swap(views[2].markers[1].id, views[2].markers[6].id);
    const auto found = check_markers(views, kSigma);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, MarkerFinding::Kind::swapped);
    EXPECT_EQ(found[0].view, "3");
    EXPECT_EQ(std::min(found[0].id, found[0].other), 2);
    EXPECT_EQ(std::max(found[0].id, found[0].other), 7);
    EXPECT_NE(found[0].text().find("3"), std::string::npos);
    const auto at = std::ranges::find(views[2].markers, 2, &SeenMarker::id);
    ASSERT_NE(at, views[2].markers.end());
    EXPECT_EQ(norm(at->place - second), 0.0);
    EXPECT_TRUE(check_markers(views, kSigma).empty());
}

TEST(MarkerCheck, AWrongNumberAndAWrongPlaceAreToldApart) {
    auto views = views_of(6, 10, 3);
    views[1].markers.erase(views[1].markers.begin() + 4);  // 5 is hidden,
    views[1].markers[7].id = 5;                            // and 9 is called 5
    views[4].markers[0].place = views[4].markers[0].place + Vec3{3e-3, 0.0, 0.0};
    const auto found = check_markers(views, kSigma);
    ASSERT_EQ(found.size(), 2U);
    for (const MarkerFinding& f : found) {
        if (f.view == "2") {
            EXPECT_EQ(f.kind, MarkerFinding::Kind::misnumbered);
            EXPECT_EQ(f.id, 5);
            EXPECT_EQ(f.other, 9);
        } else {
            EXPECT_EQ(f.kind, MarkerFinding::Kind::wrong);
            EXPECT_EQ(f.view, "5");
            EXPECT_EQ(f.id, 1);
        }
    }
    EXPECT_EQ(views[4].markers.size(), 9U);
}

TEST(MarkerCheck, TwoViewsCannotTellWhichIsWrong) {
    auto views = views_of(2, 8, 4);
    views[0].markers[2].place = views[0].markers[2].place + Vec3{5e-3, 0.0, 0.0};
    EXPECT_TRUE(check_markers(views, kSigma).empty());
    EXPECT_EQ(views[0].markers.size(), 8U);
}

TEST(MarkerCheck, StatedNoiseCounts) {
    auto views = views_of(6, 10, 5);
    views[3].markers[4].place = views[3].markers[4].place + Vec3{4e-4, 0.0, 0.0};
    for (MarkerView& view : views) {
        for (SeenMarker& m : view.markers) {
            m.sigma = {1e-3, 1e-3, 1e-3};
        }
    }
    EXPECT_TRUE(check_markers(views, kSigma).empty());
}

}  // namespace
}  // namespace sc::host
