// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "boards/sim/circles/circle_picture.hpp"
#include "boards/sim/circles/circle_sets.hpp"

namespace sc::sim {
namespace {

constexpr double kFocal = 2232.0;  ///< px
constexpr double kRadius = 3.0;    ///< mm
constexpr double kApart = 18.0;    ///< mm, between markers
constexpr std::size_t kMarkers = 20;
constexpr std::size_t kCovered = 2;
constexpr std::size_t kStrangers = 3;
constexpr std::array kSteps{0.0, 5.01, 15.02};  ///< mm

double draw(Random& random, double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
}

/// Turns about x, then y, then z.
Mat3 turned(double x, double y, double z) {
    const Mat3 about_x{
        {Vec3{1.0, 0.0, 0.0}, Vec3{0.0, std::cos(x), -std::sin(x)}, Vec3{0.0, std::sin(x), std::cos(x)}}};
    const Mat3 about_y{
        {Vec3{std::cos(y), 0.0, std::sin(y)}, Vec3{0.0, 1.0, 0.0}, Vec3{-std::sin(y), 0.0, std::cos(y)}}};
    const Mat3 about_z{
        {Vec3{std::cos(z), -std::sin(z), 0.0}, Vec3{std::sin(z), std::cos(z), 0.0}, Vec3{0.0, 0.0, 1.0}}};
    return about_z * about_y * about_x;
}

void save(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    out.close();
    if (!out) {
        throw std::runtime_error(file.string() + " cannot be written");
    }
}

template <class... Values>
std::string text_of(const char* format, Values... values) {
    char text[512];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

struct Pair {
    Camera camera{.focal = kFocal, .middle_x = 699.5, .middle_y = 499.5, .width = 1400, .height = 1000};
    Mat3 rotation = turned(0.005, 0.38, -0.004);  ///< right_from_left
    Vec3 place{-200.0, 2.0, 38.0};                ///< mm
};

/// In the target's frame: y is up from the plate, towards the cameras.
std::vector<Vec3> draw_markers(Random& random) {
    std::vector<Vec3> out;
    while (out.size() < kMarkers + kStrangers) {
        const Vec3 at{draw(random, -90.0, 90.0), kSteps[out.size() % kSteps.size()], draw(random, -65.0, 65.0)};
        bool free = true;
        for (const Vec3& other : out) {
            free = free && std::hypot(at.x - other.x, at.z - other.z) > kApart;
        }
        if (free) {
            out.push_back(at);
        }
    }
    return out;
}

std::string camera_text(const char* id, const Camera& c) {
    return text_of(
        "\n[[camera]]\nid = \"%s\"\nwidth_px = %d\nheight_px = %d\nfx_px = %.6f\nfy_px = %.6f\ncx_px = %.6f\ncy_px = "
        "%.6f\nk1_k2_p1_p2_k3 = [0.0, 0.0, 0.0, 0.0, 0.0]\n",
        id, c.width, c.height, c.focal, c.focal, c.middle_x, c.middle_y);
}

void save_pair(const std::filesystem::path& file, const Pair& pair) {
    std::string text =
        "format = \"scribecell-cameras\"\nversion = 1\nid = \"pair\"\ntime = \"2026-01-01T00:00:00Z\"\nparents = []\n"
        "noise_px = 0.007\n" +
        camera_text("left", pair.camera) + camera_text("right", pair.camera) + "\n[right_from_left]\nrotation = [";
    for (const Vec3& row : pair.rotation.row) {
        text += text_of("[%.15f, %.15f, %.15f],", row.x, row.y, row.z);
    }
    text += text_of("]\ntranslation_mm = [%.9f, %.9f, %.9f]\n", pair.place.x, pair.place.y, pair.place.z);
    save(file, text);
}

}  // namespace

void write_pairs(const std::filesystem::path& folder, const SetOptions& options) {
    std::filesystem::create_directories(folder);
    Random random(options.seed);
    const Pair pair;
    save_pair(folder / "pair.toml", pair);
    const std::vector<Vec3> markers = draw_markers(random);
    std::string target = "format = \"scribecell-target\"\nversion = 1\nid = \"twenty\"\nkind = \"mobile\"\n";
    for (std::size_t k = 0; k < kMarkers; ++k) {
        target += text_of("\n[[marker]]\nid = %zu\nplace_mm = [%.6f, %.6f, %.6f]\nsigma_um = 2.0\n", k + 1,
                          markers[k].x, markers[k].y, markers[k].z);
    }
    save(folder / "target.toml", target);
    std::string truth = "scene,id,x_mm,y_mm,z_mm\n";
    for (int scene = 0; scene < options.scenes; ++scene) {
        // Its y towards the cameras, then tilted and turned.
        const Mat3 turn = turned(draw(random, -0.5, 0.5), draw(random, -0.5, 0.5), draw(random, -1.5, 1.5)) *
                          turned(-1.5707963267948966, 0.0, 0.0);
        const Vec3 middle{draw(random, -10.0, 10.0), draw(random, -10.0, 10.0), draw(random, 490.0, 540.0)};
        const Vec3 up = turn * Vec3{0.0, 1.0, 0.0};
        const auto covered = static_cast<std::size_t>(draw(random, 0.0, kMarkers - 1.0));
        std::vector<Circle> left;
        std::vector<Circle> right;
        for (std::size_t k = 0; k < markers.size(); ++k) {
            if (k < kMarkers && (k + kMarkers - covered) % kMarkers < kCovered) {
                continue;
            }
            const Vec3 at = turn * markers[k] + middle;
            left.push_back({.centre = at, .normal = up, .radius = kRadius});
            right.push_back(
                {.centre = pair.rotation * at + pair.place, .normal = pair.rotation * up, .radius = kRadius});
            truth += text_of("%d,%zu,%.7f,%.7f,%.7f\n", scene, k < kMarkers ? k + 1 : 0, at.x, at.y, at.z);
        }
        const Look look;
        const Light left_light = light_of(pair.camera, left, look);
        const Light right_light = light_of(pair.camera, right, look);
        for (int repeat = 0; repeat < options.repeats; ++repeat) {
            write_picture(folder / text_of("left_%02d_%02d.png", scene, repeat), pair.camera, left_light, look.noise,
                          random);
            write_picture(folder / text_of("right_%02d_%02d.png", scene, repeat), pair.camera, right_light, look.noise,
                          random);
        }
    }
    save(folder / "truth.csv", truth);
}

}  // namespace sc::sim
