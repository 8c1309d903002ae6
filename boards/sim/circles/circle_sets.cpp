// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/circles/circle_sets.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <string>

#include "boards/sim/circles/circle_picture.hpp"

namespace sc::sim {
namespace {

constexpr double kDistance = 500.0;  ///< mm
constexpr double kFocal = 2232.0;    ///< px
constexpr double kMostRise = 10.0;   ///< grey values over 100 px

double draw(Random& random, double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
}

std::string name_of(const char* kind, int scene, int repeat) {
    char text[64];
    std::snprintf(text, sizeof text, "%s_%02d_%02d.png", kind, scene, repeat);
    return text;
}

Vec3 tilted(double tilt, double heading) {
    return {std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt)};
}

/// The middle of the ellipse that a circle is seen as: of its dual conic H·diag(1, 1, −1)·Hᵀ.
std::array<double, 2> ellipse_middle(const Circle& circle, const Camera& camera) {
    const Vec3 aside = std::abs(circle.normal.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    Vec3 u = cross(circle.normal, aside);
    u = (circle.radius / norm(u)) * u;
    const Vec3 v = cross(circle.normal, u);
    const auto seen = [&](const Vec3& p) {
        return Vec3{camera.focal * p.x + camera.middle_x * p.z, camera.focal * p.y + camera.middle_y * p.z, p.z};
    };
    const Vec3 a = seen(u);
    const Vec3 b = seen(v);
    const Vec3 c = seen(circle.centre);
    const double w = a.z * a.z + b.z * b.z - c.z * c.z;
    return {(a.x * a.z + b.x * b.z - c.x * c.z) / w, (a.y * a.z + b.y * b.z - c.y * c.z) / w};
}

/// Truth and camera of one set.
class SetFiles {
public:
    SetFiles(const std::filesystem::path& folder, const Camera& camera) : folder_(folder) {
        std::filesystem::create_directories(folder);
        save("camera.csv", "focal_px,middle_x_px,middle_y_px\n" + std::to_string(camera.focal) + "," +
                               std::to_string(camera.middle_x) + "," + std::to_string(camera.middle_y) + "\n");
    }
    void add(const std::string& picture, int scene, const Circle& circle, const Camera& camera) {
        const auto ellipse = ellipse_middle(circle, camera);
        const auto centre = seen_at(circle.centre, camera);
        char text[256];
        std::snprintf(text, sizeof text, "%s,%d,%.6f,%.6f,%.6f,%.6f\n", picture.c_str(), scene, ellipse[0], ellipse[1],
                      centre[0], centre[1]);
        truth_ += text;
    }
    void finish() const { save("truth.csv", truth_); }

private:
    void save(const char* name, const std::string& text) const {
        std::ofstream out(folder_ / name);
        out << text;
        out.close();
        if (!out) {
            throw std::runtime_error((folder_ / name).string() + " cannot be written");
        }
    }
    std::filesystem::path folder_;
    std::string truth_ = "picture,scene,ellipse_x_px,ellipse_y_px,centre_x_px,centre_y_px\n";
};

/// What a scene shows, and how often it is taken.
struct Scene {
    const char* kind = "";
    int number = 0;
    int repeats = 0;
    std::vector<Circle> circles;
};

void write_scene(const std::filesystem::path& folder, const Scene& scene, const Camera& camera, Random& random,
                 SetFiles& files) {
    Look look;
    look.rise = draw(random, 0.0, kMostRise);
    look.rise_heading = draw(random, 0.0, 2.0 * std::numbers::pi);
    const Light light = light_of(camera, scene.circles, look);
    for (int repeat = 0; repeat < scene.repeats; ++repeat) {
        const std::string name = name_of(scene.kind, scene.number, repeat);
        write_picture(folder / name, camera, light, look.noise, random);
        for (const Circle& circle : scene.circles) {
            files.add(name, scene.number, circle, camera);
        }
    }
}

}  // namespace

void write_singles(const std::filesystem::path& folder, const SetOptions& options) {
    constexpr double kMajorPx = 20.0;
    constexpr double kRatio = 0.7;
    Random random(options.seed);
    const Camera camera{.focal = kFocal, .middle_x = 40.0, .middle_y = 40.0, .width = 80, .height = 80};
    SetFiles files(folder, camera);
    for (int scene = 0; scene < options.scenes; ++scene) {
        const double scale = kDistance / kFocal;
        const Circle circle{.centre = {draw(random, -0.5, 0.5) * scale, draw(random, -0.5, 0.5) * scale, kDistance},
                            .normal = tilted(std::acos(kRatio), draw(random, 0.0, 2.0 * std::numbers::pi)),
                            .radius = kMajorPx * scale};
        write_scene(folder, {"single", scene, options.repeats, {circle}}, camera, random, files);
    }
    files.finish();
}

void write_boards(const std::filesystem::path& folder, const SetOptions& options) {
    constexpr double kTilt = std::numbers::pi / 4.0;
    constexpr double kRadius = 5.0;
    constexpr double kReach = 42.0;  // mm, of the outer circles from the middle one
    Random random(options.seed);
    const Camera camera{.focal = kFocal, .middle_x = 239.5, .middle_y = 239.5, .width = 480, .height = 480};
    SetFiles files(folder, camera);
    for (int scene = 0; scene < options.scenes; ++scene) {
        const double heading = draw(random, 0.0, 2.0 * std::numbers::pi);
        const double turn = draw(random, 0.0, 2.0 * std::numbers::pi);
        const Vec3 normal = tilted(kTilt, heading);
        const Vec3 across{-std::sin(heading), std::cos(heading), 0.0};
        const Vec3 along = cross(normal, across);
        const Vec3 middle{draw(random, -3.0, 3.0), draw(random, -3.0, 3.0), kDistance};
        std::vector<Circle> circles{{.centre = middle, .normal = normal, .radius = kRadius}};
        for (int k = 0; k < 4; ++k) {
            const double angle = turn + 0.5 * std::numbers::pi * k;
            circles.push_back(
                {.centre = middle + (kReach * std::cos(angle)) * along + (kReach * std::sin(angle)) * across,
                 .normal = normal,
                 .radius = kRadius});
        }
        write_scene(folder, {"board", scene, options.repeats, circles}, camera, random, files);
    }
    files.finish();
}

}  // namespace sc::sim
