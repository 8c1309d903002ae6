// SPDX-License-Identifier: Apache-2.0
#include "host/vision/board.hpp"

#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "host/formats/csv.hpp"

namespace sc::host {
namespace {

using Point = std::array<double, 2>;

/// Where the board's place (in squares) is seen: a slanted plane.
Point seen_at(double u, double v) {
    const double w = 1.0 + 0.012 * u + 0.02 * v;
    return {70.0 + (33.0 * u + 4.0 * v) / w, 60.0 + (-3.0 * u + 31.0 * v) / w};
}

/// A chessboard of 9x6 inner corners with its first corner at (0, 0), integrated over pixels; optionally upside down.
GreyImage chessboard(bool half_turned, double noise) {
    GreyImage image{.width = 420, .height = 300, .full_scale = 255, .pixel = {}};
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal;
    constexpr int kFine = 5;
    for (int row = 0; row < image.height; ++row) {
        for (int column = 0; column < image.width; ++column) {
            double sum = 0.0;
            for (int i = 0; i < kFine * kFine; ++i) {
                const double x = column + (i % kFine + 0.5) / kFine - 0.5;
                const double y = row + (i / kFine + 0.5) / kFine - 0.5;
                // The plane's inverse by two rounds of Newton's method from the middle.
                double u = 4.0;
                double v = 2.5;
                for (int round = 0; round < 8; ++round) {
                    const Point at = seen_at(u, v);
                    const Point by_u = seen_at(u + 1e-5, v);
                    const Point by_v = seen_at(u, v + 1e-5);
                    const double a = (by_u[0] - at[0]) * 1e5;
                    const double b = (by_v[0] - at[0]) * 1e5;
                    const double c = (by_u[1] - at[1]) * 1e5;
                    const double d = (by_v[1] - at[1]) * 1e5;
                    const double det = a * d - b * c;
                    u += (d * (x - at[0]) - b * (y - at[1])) / det;
                    v += (a * (y - at[1]) - c * (x - at[0])) / det;
                }
                const bool on_board = u > -1.0 && v > -1.0 && u < 9.0 && v < 6.0;
                // The square between the first four corners is dark; seen from the other end the colours change places.
                const bool dark = (static_cast<int>(std::floor(u)) + static_cast<int>(std::floor(v))) % 2 == 0;
                sum += on_board && dark != half_turned ? 0.15 : 0.8;
            }
            const double light = sum / (kFine * kFine) + noise * normal(random);
            image.pixel.push_back(static_cast<std::uint16_t>(std::lround(255.0 * std::clamp(light, 0.0, 1.0))));
        }
    }
    return image;
}

TEST(Board, FindsEachCornerOfAChessboardToAFewHundredthsOfAPixel) {
    for (const bool half_turned : {false, true}) {
        const auto found = find_chessboard(chessboard(half_turned, 0.01), {.columns = 9, .rows = 6});
        ASSERT_TRUE(found) << found.error();
        ASSERT_EQ(found->corners.size(), 54U);
        EXPECT_TRUE(found->first_is_sure);
        double squares = 0.0;
        for (const BoardCorner& c : found->corners) {
            const Point truth = half_turned ? seen_at(8 - c.column, 5 - c.row) : seen_at(c.column, c.row);
            squares += std::pow(c.x - truth[0], 2) + std::pow(c.y - truth[1], 2);
        }
        EXPECT_LT(std::sqrt(squares / 108.0), 0.05) << half_turned;
    }
}

TEST(Board, RefusesAnotherBoardAndAPictureWithoutOne) {
    const GreyImage image = chessboard(false, 0.01);
    const auto other = find_chessboard(image, {.columns = 11, .rows = 7});
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().find("11x7"), std::string::npos) << other.error();
    EXPECT_FALSE(find_chessboard(GreyImage{.width = 64, .height = 64, .pixel = std::vector<std::uint16_t>(4096, 90)},
                                 {.columns = 9, .rows = 6}));
}

TEST(Board, RealDotsHaveTheOrderThatTheBigDotSays) {
    const std::string folder = std::string(SC_TEST_DATA) + "/circle-grid/";
    const CsvTable csv = CsvTable::read(folder + "centres_px.csv");
    for (const char* view : {"0", "5"}) {
        const auto found = find_dot_grid(read_image(folder + view + ".png"), {.columns = 10, .rows = 10});
        ASSERT_TRUE(found) << found.error();
        EXPECT_TRUE(found->first_is_sure);
        EXPECT_GE(found->corners.size(), 95U);
        std::map<std::pair<int, int>, Point> known;
        for (std::size_t i = 0; i < csv.size(); ++i) {
            if (csv.text(i, csv.column("view")) == view) {
                known[{csv.integer(i, csv.column("row")), csv.integer(i, csv.column("col"))}] = {
                    csv.number(i, csv.column("u_px")), csv.number(i, csv.column("v_px"))};
            }
        }
        // There the big dot is in row 9, column 0; the rows run the other way, so a quarter turn lies between.
        for (const BoardCorner& c : found->corners) {
            const Point& at = known.at({9 - c.column, c.row});
            EXPECT_LT(std::hypot(c.x - at[0], c.y - at[1]), 1.2) << view << " " << c.column << " " << c.row;
        }
    }
}

TEST(Lattice, GrowsOverHolesAndStrangersAndRefusesASquareThatIsNotWhole) {
    std::vector<Point> points;
    for (int row = 0; row < 5; ++row) {
        for (int column = 0; column < 7; ++column) {
            if (!(row == 2 && column == 3)) {
                points.push_back({100.0 + 30.0 * column + 3.0 * row, 80.0 + 28.0 * row - 2.0 * column});
            }
        }
    }
    points.push_back({115.0, 94.0});
    points.push_back({400.0, 300.0});
    const auto grid = find_grid(points, {.columns = 7, .rows = 5});
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->size(), 34U);
    EXPECT_FALSE(find_grid(points, {.columns = 6, .rows = 5}));  // two places for it
    EXPECT_FALSE(find_grid(points, {.columns = 8, .rows = 5}));
}

}  // namespace
}  // namespace sc::host
