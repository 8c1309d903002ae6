// SPDX-License-Identifier: Apache-2.0
#include "host/vision/marker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/csv.hpp"

namespace sc::host {
namespace {

constexpr int kFine = 6;

using Shape = std::function<bool(double, double)>;  ///< true inside, px about the middle

/// A picture of one dark shape on bright, integrated over pixels, smoothed by a lens of 0.7 px.
GreyImage picture_of(int size, double x, double y, const Shape& inside, double noise = 0.01, double bright = 0.8,
                     double dark = 0.15) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    std::vector<double> cover;
    for (int row = 0; row < size; ++row) {
        for (int column = 0; column < size; ++column) {
            double sum = 0.0;
            for (int i = 0; i < kFine * kFine; ++i) {
                const double px = column + (i % kFine + 0.5) / kFine - 0.5;
                const double py = row + (i / kFine + 0.5) / kFine - 0.5;
                sum += inside(px - x, py - y) ? 1.0 : 0.0;
            }
            cover.push_back(sum / (kFine * kFine));
        }
    }
    const std::array kernel{0.23, 0.54, 0.23};
    const auto at = [&](int column, int row) {
        return cover[static_cast<std::size_t>(std::clamp(row, 0, size - 1) * size + std::clamp(column, 0, size - 1))];
    };
    GreyImage image{.width = size, .height = size, .full_scale = 255, .pixel = {}};
    for (int row = 0; row < size; ++row) {
        for (int column = 0; column < size; ++column) {
            double sum = 0.0;
            for (int i = -1; i <= 1; ++i) {
                for (int j = -1; j <= 1; ++j) {
                    sum += kernel[static_cast<std::size_t>(i + 1)] * kernel[static_cast<std::size_t>(j + 1)] *
                           at(column + j, row + i);
                }
            }
            const double light = bright + (dark - bright) * sum + noise * normal(random);
            image.pixel.push_back(static_cast<std::uint16_t>(std::lround(255.0 * std::clamp(light, 0.0, 1.0))));
        }
    }
    return image;
}

Shape ellipse(double major, double minor, double angle) {
    return [=](double x, double y) {
        const double u = (x * std::cos(angle) + y * std::sin(angle)) / major;
        const double v = (y * std::cos(angle) - x * std::sin(angle)) / minor;
        return u * u + v * v < 1.0;
    };
}

MarkerProblem problem_of(const GreyImage& image) {
    const MarkersFound found = find_markers(image);
    EXPECT_TRUE(found.markers.empty());
    EXPECT_EQ(found.refused.size(), 1U);
    if (found.refused.size() != 1) {
        return MarkerProblem::faint;
    }
    EXPECT_GT(found.refused.front().text.size(), 40U);
    return found.refused.front().problem;
}

TEST(FindMarkers, EllipseToAHundredthOfAPixel) {
    for (const bool dark : {true, false}) {
        for (const double angle : {0.0, 0.6, -1.3}) {
            const MarkersFound found = find_markers(
                picture_of(80, 39.37, 41.81, ellipse(20.0, 14.0, angle), 0.01, dark ? 0.8 : 0.15, dark ? 0.15 : 0.8));
            ASSERT_EQ(found.markers.size(), 1U);
            EXPECT_TRUE(found.refused.empty());
            const Marker& m = found.markers.front();
            EXPECT_NEAR(m.ellipse.x, 39.37, 0.03);
            EXPECT_NEAR(m.ellipse.y, 41.81, 0.03);
            EXPECT_NEAR(m.ellipse.major, 20.0, 0.15);
            EXPECT_NEAR(m.ellipse.minor, 14.0, 0.15);
            EXPECT_NEAR(std::remainder(m.ellipse.angle - angle, std::numbers::pi), 0.0, 0.01);
            EXPECT_EQ(m.dark, dark);
            EXPECT_GT(m.sigma, 0.002);
            EXPECT_LT(m.sigma, 0.02);
        }
    }
}

TEST(FindMarkers, StatedSigmaGrowsAsTheNoise) {
    const auto sigma = [](double noise) {
        const auto found = find_markers(picture_of(80, 40.2, 39.6, ellipse(18.0, 15.0, 0.4), noise));
        EXPECT_EQ(found.markers.size(), 1U);
        return found.markers.empty() ? 0.0 : found.markers.front().sigma;
    };
    EXPECT_NEAR(sigma(0.04) / sigma(0.01), 4.0, 0.6);
}

TEST(FindMarkers, RefusesWithTheReason) {
    const Shape disc = ellipse(18.0, 18.0, 0.0);
    EXPECT_EQ(problem_of(picture_of(80, 20.0, 40.0, disc)), MarkerProblem::cut);
    EXPECT_EQ(problem_of(picture_of(80, 40.2, 39.8, ellipse(1.8, 1.8, 0.0))), MarkerProblem::small);
    EXPECT_EQ(problem_of(picture_of(120, 60.0, 60.0, ellipse(40.0, 5.0, 0.3))), MarkerProblem::oblique);
    EXPECT_EQ(problem_of(picture_of(80, 40.0, 40.0,
                                    [](double x, double y) { return std::max(std::abs(x), std::abs(y)) < 17.0; })),
              MarkerProblem::not_ellipse);
    // A bar as bright as the ground over a side of the disc. A short chord may be taken for a part that is missing or
    // for another shape; it must not give a centre.
    for (const double chord : {13.0, 15.0}) {
        const MarkerProblem problem = problem_of(
            picture_of(80, 40.0, 40.0, [&disc, chord](double x, double y) { return disc(x, y) && x < chord; }));
        EXPECT_TRUE(problem == MarkerProblem::occluded || problem == MarkerProblem::not_ellipse) << chord;
    }
    EXPECT_EQ(problem_of(picture_of(80, 40.0, 40.0, disc, 0.01, 2.6, 0.2)), MarkerProblem::saturated);
}

TEST(FindMarkers, AShortChordNeverMovesTheCentre) {
    const Shape disc = ellipse(18.0, 18.0, 0.0);
    for (const double chord : {15.5, 16.0, 16.5, 17.0}) {
        const MarkersFound found = find_markers(
            picture_of(80, 40.0, 40.0, [&disc, chord](double x, double y) { return disc(x, y) && x < chord; }));
        for (const Marker& m : found.markers) {
            EXPECT_LT(std::hypot(m.ellipse.x - 40.0, m.ellipse.y - 40.0), 0.15) << chord;
        }
        EXPECT_EQ(found.markers.size() + found.refused.size(), 1U) << chord;
    }
}

TEST(FindMarkers, NothingWhereThereIsNothing) {
    const MarkersFound found = find_markers(picture_of(80, 40.0, 40.0, [](double, double) { return false; }));
    EXPECT_TRUE(found.markers.empty());
    EXPECT_TRUE(found.refused.empty());
}

TEST(FindMarkers, SeveralInOnePictureInOrder) {
    const MarkersFound found = find_markers(picture_of(160, 80.0, 80.0, [](double x, double y) {
        return std::hypot(x + 40.0, y + 40.0) < 12.0 || std::hypot(x - 40.0, y + 30.0) < 15.0 ||
               std::hypot(x, y - 40.0) < 9.0;
    }));
    ASSERT_EQ(found.markers.size(), 3U);
    EXPECT_NEAR(found.markers[0].ellipse.x, 40.0, 0.05);
    EXPECT_NEAR(found.markers[1].ellipse.x, 120.0, 0.05);
    EXPECT_NEAR(found.markers[2].ellipse.x, 80.0, 0.05);
}

TEST(FindMarkers, RealDotsLieWhereOthersFindThem) {
    const std::filesystem::path folder = std::filesystem::path(SC_TEST_DATA) / "circle-grid";
    const CsvTable csv = CsvTable::read(folder / "centres_px.csv");
    for (const int view : {0, 5}) {
        const MarkersFound found = find_markers(read_image(folder / (std::to_string(view) + ".png")));
        std::vector<double> off;
        int missing = 0;
        for (std::size_t row = 0; row < csv.size(); ++row) {
            if (csv.integer(row, csv.column("view")) != view) {
                continue;
            }
            double least = 1e9;
            for (const Marker& m : found.markers) {
                least = std::min(least, std::hypot(m.ellipse.x - csv.number(row, csv.column("u_px")),
                                                   m.ellipse.y - csv.number(row, csv.column("v_px"))));
            }
            if (least < 2.0) {
                off.push_back(least);
            } else {
                ++missing;
            }
        }
        EXPECT_LE(missing, 2) << view;
        ASSERT_FALSE(off.empty());
        std::sort(off.begin(), off.end());
        EXPECT_LT(off[off.size() / 2], 0.15) << view;
        EXPECT_LT(off.back(), 1.0) << view;
    }
}

TEST(Overlay, ShowsEachEllipseAndRefusal) {
    const GreyImage image = picture_of(80, 40.0, 40.0, ellipse(18.0, 15.0, 0.2));
    const MarkersFound found = find_markers(image);
    const std::string svg = svg_of(overlay_of(image, found));
    EXPECT_NE(svg.find("<circle cx=\"40.0\""), std::string::npos);
    const GreyImage cut = picture_of(80, 20.0, 40.0, ellipse(18.0, 18.0, 0.0));
    EXPECT_NE(svg_of(overlay_of(cut, find_markers(cut))).find(">cut<"), std::string::npos);
}

}  // namespace
}  // namespace sc::host
