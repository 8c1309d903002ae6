// SPDX-License-Identifier: Apache-2.0
#include "host/vision/camera.hpp"

#include <cmath>

namespace sc::host {
namespace {

constexpr int kRounds = 50;
constexpr double kAtRestPx = 1e-9;
constexpr double kLeastSlope = 1e-3;  ///< of the distortion: nearer to 0 it folds over

/// The distorted place on the plane z = 1, with its derivatives by the true one.
struct Bent {
    double x = 0.0;
    double y = 0.0;
    std::array<std::array<double, 2>, 2> slope{};
};

Bent bend(const CameraModel& camera, double x, double y) {
    const auto& [k1, k2, p1, p2, k3] = camera.distortion;
    const double r2 = x * x + y * y;
    const double s = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double ds = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);  // by r²
    Bent out;
    out.x = x * s + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    out.y = y * s + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    const double mixed = 2.0 * x * y * ds + 2.0 * p1 * x + 2.0 * p2 * y;
    out.slope = {{{s + 2.0 * x * x * ds + 2.0 * p1 * y + 6.0 * p2 * x, mixed},
                  {mixed, s + 2.0 * y * y * ds + 6.0 * p1 * y + 2.0 * p2 * x}}};
    return out;
}

double determinant(const std::array<std::array<double, 2>, 2>& m) { return m[0][0] * m[1][1] - m[0][1] * m[1][0]; }

}  // namespace

std::optional<Pixel> project(const CameraModel& camera, const Vec3& place) {
    if (!(place.z > 0.0)) {
        return std::nullopt;
    }
    const Bent bent = bend(camera, place.x / place.z, place.y / place.z);
    return Pixel{camera.focal_x * bent.x + camera.middle_x, camera.focal_y * bent.y + camera.middle_y};
}

std::optional<Projection> project_with_slopes(const CameraModel& camera, const Vec3& place) {
    if (!(place.z > 0.0)) {
        return std::nullopt;
    }
    const double x = place.x / place.z;
    const double y = place.y / place.z;
    const double r2 = x * x + y * y;
    const Bent bent = bend(camera, x, y);
    const double f[2] = {camera.focal_x, camera.focal_y};
    Projection out;
    out.at = {f[0] * bent.x + camera.middle_x, f[1] * bent.y + camera.middle_y};
    for (std::size_t i = 0; i < 2; ++i) {
        const double by_x = f[i] * bent.slope[i][0] / place.z;
        const double by_y = f[i] * bent.slope[i][1] / place.z;
        out.by_place[i] = {by_x, by_y, -(by_x * x + by_y * y)};
    }
    out.by_camera[0] = {bent.x,
                        0.0,
                        1.0,
                        0.0,
                        f[0] * x * r2,
                        f[0] * x * r2 * r2,
                        f[0] * 2 * x * y,
                        f[0] * (r2 + 2.0 * x * x),
                        f[0] * x * r2 * r2 * r2};
    out.by_camera[1] = {0.0,
                        bent.y,
                        0.0,
                        1.0,
                        f[1] * y * r2,
                        f[1] * y * r2 * r2,
                        f[1] * (r2 + 2.0 * y * y),
                        f[1] * 2 * x * y,
                        f[1] * y * r2 * r2 * r2};
    return out;
}

std::optional<Ray> undistorted(const CameraModel& camera, const Pixel& at) {
    const double to_x = (at[0] - camera.middle_x) / camera.focal_x;
    const double to_y = (at[1] - camera.middle_y) / camera.focal_y;
    Ray out{.x = to_x, .y = to_y};
    // From the middle outwards in steps that Newton's method can follow: strong distortion may fold over further out.
    constexpr int kWays = 4;
    double x = 0.0;
    double y = 0.0;
    for (int way = 1; way <= kWays; ++way) {
        const double share = static_cast<double>(way) / kWays;
        for (int round = 0; round < kRounds; ++round) {
            const Bent bent = bend(camera, x, y);
            const double d = determinant(bent.slope);
            const double off_x = share * to_x - bent.x;
            const double off_y = share * to_y - bent.y;
            out.residual = std::hypot(camera.focal_x * off_x, camera.focal_y * off_y);
            if (!(d > kLeastSlope) || !std::isfinite(out.residual)) {
                return std::nullopt;
            }
            if (out.residual < kAtRestPx) {
                break;
            }
            x += (bent.slope[1][1] * off_x - bent.slope[0][1] * off_y) / d;
            y += (bent.slope[0][0] * off_y - bent.slope[1][0] * off_x) / d;
        }
    }
    if (!(out.residual < kAtRestPx * 100.0)) {
        return std::nullopt;
    }
    const Bent bent = bend(camera, x, y);
    const double d = determinant(bent.slope);
    out.x = x;
    out.y = y;
    out.by_pixel = {{{bent.slope[1][1] / d / camera.focal_x, -bent.slope[0][1] / d / camera.focal_y},
                     {-bent.slope[1][0] / d / camera.focal_x, bent.slope[0][0] / d / camera.focal_y}}};
    return out;
}

}  // namespace sc::host
