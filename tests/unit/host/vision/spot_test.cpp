// SPDX-License-Identifier: Apache-2.0
#include "host/vision/spot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

struct Blob {
    double x;
    double y;
    double waist;
    double peak;
};

GreyImage picture_of(int width, int height, const std::vector<Blob>& blobs, double noise = 0.005,
                     double background = 0.1) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    GreyImage image{.width = width, .height = height, .full_scale = 255, .pixel = {}};
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            double light = background + noise * normal(random);
            for (const Blob& b : blobs) {
                light += b.peak *
                         std::exp(-2.0 * (std::pow(column - b.x, 2) + std::pow(row - b.y, 2)) / (b.waist * b.waist));
            }
            image.pixel.push_back(static_cast<std::uint16_t>(std::lround(255.0 * std::clamp(light, 0.0, 1.0))));
        }
    }
    return image;
}

SpotProblem problem_of(const GreyImage& image) {
    const auto spot = find_spot(image);
    EXPECT_FALSE(spot.has_value());
    if (spot) {
        return SpotProblem::wrong_count;
    }
    EXPECT_GT(spot.error().text.size(), 30U);
    return spot.error().problem;
}

TEST(FindSpot, CentreToAFewHundredthsOfAPixel) {
    for (const double peak : {0.4, 0.85, 3.0}) {
        const auto spot = find_spot(picture_of(200, 180, {{97.37, 84.81, 16.0, peak}}));
        ASSERT_TRUE(spot) << spot.error().text;
        EXPECT_NEAR(spot->x, 97.37, 0.04) << peak;
        EXPECT_NEAR(spot->y, 84.81, 0.04) << peak;
    }
}

TEST(FindSpot, RealBeamsLieWhereOthersFindThem) {
    // tests/data/laser-spots/README.md: Otsu, largest region, Canny, circle; there is no true centre.
    struct Expected {
        const char* name;
        double x, y, r;
    };
    for (const Expected& e : {Expected{"k-200mm", 580.46, 387.17, 75.9}, Expected{"k-400mm", 652.77, 394.33, 54.9},
                              Expected{"t-480mm", 330.53, 355.06, 54.7}, Expected{"TEM00_140mm", 698.31, 396.44, 39.4},
                              Expected{"t-210mm", 583.29, 328.36, 80.9}}) {
        const auto spot =
            find_spot(read_image(std::filesystem::path(SC_TEST_DATA) / "laser-spots" / (std::string(e.name) + ".png")));
        ASSERT_TRUE(spot) << e.name << ": " << spot.error().text;
        EXPECT_NEAR(spot->edge.x, e.x, 1.0) << e.name;
        EXPECT_NEAR(spot->edge.y, e.y, 1.0) << e.name;
        EXPECT_NEAR(spot->edge.radius, e.r, 1.5) << e.name;
        EXPECT_NEAR(std::hypot(spot->x - e.x, spot->y - e.y), 0.0, 6.0) << e.name;
    }
}

/// A part of a picture, with a black level of 4 % and noise of 1 % of full scale.
GreyImage part_of(const GreyImage& image, int left, int top, int right, int bottom, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, 0.01 * image.full_scale);
    GreyImage part{.width = right - left, .height = bottom - top, .full_scale = image.full_scale, .pixel = {}};
    for (int row = top; row < bottom; ++row) {
        for (int column = left; column < right; ++column) {
            const double value = 0.04 * image.full_scale + 0.96 * image.at(column, row) + normal(random);
            part.pixel.push_back(
                static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, static_cast<double>(image.full_scale)))));
        }
    }
    return part;
}

TEST(FindSpot, RealBeamsStayWhereTheyAreUnderCropAndNoise) {
    for (const char* name : {"t-210mm", "TEM00_140mm"}) {
        const GreyImage image =
            read_image(std::filesystem::path(SC_TEST_DATA) / "laser-spots" / (std::string(name) + ".png"));
        const auto whole = find_spot(image);
        ASSERT_TRUE(whole) << name;
        for (const double room : {3.6, 5.0}) {
            const int left = std::max(0, static_cast<int>(whole->x - room * whole->radius));
            const int bottom = std::min(image.height, static_cast<int>(whole->y + room * whole->radius));
            const auto part = find_spot(part_of(image, left, 0, image.width, bottom, 7));
            ASSERT_TRUE(part) << name;
            EXPECT_TRUE(part->by_surface);
            EXPECT_LT(std::hypot(part->x + left - whole->x, part->y - whole->y), 0.2) << name << " " << room;
        }
    }
}

TEST(FindSpot, RefusesWhatBreaksTheThreshold) {
    EXPECT_EQ(problem_of(picture_of(200, 200, {})), SpotProblem::flat);
    EXPECT_EQ(problem_of(picture_of(200, 200, {{1.0, 100.0, 16.0, 0.8}})), SpotProblem::cut);
    EXPECT_EQ(problem_of(picture_of(200, 200, {{60.0, 100.0, 16.0, 0.8}, {140.0, 100.0, 16.0, 0.8}})),
              SpotProblem::several);
    EXPECT_EQ(problem_of(picture_of(200, 200, {{100.0, 100.0, 2.0, 0.8}})), SpotProblem::small);
}

TEST(FindDots, AllOfThemDarkOnBright) {
    std::vector<Blob> none;
    GreyImage image = picture_of(300, 200, none, 0.005, 0.7);
    std::vector<std::array<double, 2>> places;
    for (int k = 0; k < 6; ++k) {
        places.push_back({50.3 + 80.0 * (k % 3), 60.7 + 75.0 * (k / 3)});
        for (int row = 0; row < 200; ++row) {
            for (int column = 0; column < 300; ++column) {
                const double out = std::hypot(column - places.back()[0], row - places.back()[1]) - 15.0;
                const double cover = std::clamp(0.5 - out / 2.0, 0.0, 1.0);
                auto& p = image.pixel[static_cast<std::size_t>(row * 300 + column)];
                p = static_cast<std::uint16_t>(std::lround(p * (1.0 - cover) + 25.0 * cover));
            }
        }
    }
    const auto dots = find_dots(image, 6);
    ASSERT_TRUE(dots) << dots.error().text;
    for (const auto& place : places) {
        double nearest = 1e9;
        for (const Spot& dot : *dots) {
            nearest = std::min(nearest, std::hypot(dot.x - place[0], dot.y - place[1]));
        }
        EXPECT_LT(nearest, 0.05);
    }
    const auto missing = find_dots(image, 7);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().problem, SpotProblem::wrong_count);
}

TEST(ReadImage, RefusesWhatIsNoPicture) {
    const auto folder = std::filesystem::temp_directory_path() / "scribecell-no-picture";
    std::filesystem::create_directories(folder);
    const auto refused = [&](const std::string& name, const std::string& bytes) {
        std::ofstream(folder / name, std::ios::binary) << bytes;
        EXPECT_THROW(static_cast<void>(read_image(folder / name)), InputError) << name;
    };
    refused("text.png", "station,d1_mm\n");
    refused("cut.png", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
    refused("cut.jpg", "\xff\xd8\xff\xe0 and no more");
    refused("short.pgm", "P5\n20 20\n255\nabc");
    refused("huge.pgm", "P5\n2000000 2000000\n255\n");
    EXPECT_THROW(static_cast<void>(read_image(folder / "none.png")), InputError);
    std::filesystem::remove_all(folder);
}

TEST(ReadImage, WhatIsWrittenReadsBack) {
    const auto file = std::filesystem::temp_directory_path() / "scribecell-round-trip.png";
    GreyImage image{.width = 3, .height = 2, .full_scale = 65535, .pixel = {0, 1, 300, 40000, 65535, 7}};
    write_png(file, image);
    const GreyImage back = read_image(file);
    EXPECT_EQ(back.pixel, image.pixel);
    EXPECT_EQ(back.full_scale, 65535);
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace sc::host
