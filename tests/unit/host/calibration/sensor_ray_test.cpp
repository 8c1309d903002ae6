// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "host/calibration/sensor_ray_fit.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr Vec3 kOrigin{30.15e-3, 0.0, -0.18e-3};
constexpr double kZero = 0.12521;

Vec3 beam() {
    const Vec3 d{0.7e-3, -1.0, -0.5e-3};
    return (1.0 / norm(d)) * d;
}

std::vector<KnownPlane> planes_of(const std::vector<std::array<double, 2>>& slopes) {
    std::vector<KnownPlane> out;
    for (const auto& [x, z] : slopes) {
        const Vec3 up{-x, 1.0, -z};
        KnownPlane plane;
        plane.id = static_cast<int>(out.size()) + 1;
        plane.normal = (1.0 / norm(up)) * up;
        plane.distance = dot(plane.normal, Vec3{-0.3 + 0.05 * plane.id, -0.25, -0.26});
        plane.sigma = 2e-6;
        out.push_back(plane);
    }
    return out;
}

std::vector<RangeReading> scan(const std::vector<KnownPlane>& planes, double sigma, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<RangeReading> out;
    for (const KnownPlane& plane : planes) {
        const double off = plane.sigma * normal(random);
        for (int i = 0; i < 12; ++i) {
            RangeReading r;
            r.plane = plane.id;
            r.carrier = {-0.33 + 0.05 * plane.id + 0.008 * (i % 3), -0.266 + 0.016 * (i / 4), -0.27 + 0.007 * (i % 4)};
            const Vec3 from = r.carrier + kOrigin;
            const double range = (plane.distance + off - dot(plane.normal, from)) / dot(plane.normal, beam());
            r.reading = range + kZero + sigma * normal(random);
            r.sigma = sigma;
            r.line = static_cast<int>(out.size()) + 2;
            out.push_back(r);
        }
    }
    return out;
}

std::string refusal_of(const std::vector<KnownPlane>& planes) {
    try {
        static_cast<void>(fit_sensor_ray("readings.csv", planes, scan(planes, 5e-6, 1), 0.0));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

const std::vector<std::array<double, 2>> kRoof{{0.0, 0.0}, {0.5, 0.0}, {-0.5, 0.0}, {0.0, 0.5}, {0.0, -0.5}};

TEST(SensorRay, FindsOriginDirectionAndZeroAndItsCovarianceHolds) {
    auto planes = planes_of(kRoof);
    for (KnownPlane& plane : planes) {
        plane.sigma = 1e-9;
    }
    constexpr int kSets = 60;
    std::array<double, 5> sum{};
    for (unsigned seed = 0; seed < kSets; ++seed) {
        const SensorRayFit fit = fit_sensor_ray("readings.csv", planes, scan(planes, 5e-6, seed), 0.0);
        const std::array<double, 5> off{fit.origin.x - kOrigin.x, fit.origin.z - kOrigin.z, fit.direction.x - beam().x,
                                        fit.direction.z - beam().z, fit.zero - kZero};
        for (std::size_t i = 0; i < 5; ++i) {
            sum[i] += off[i] * off[i] / fit.covariance.at[i][i] / kSets;
        }
        EXPECT_NEAR(fit.rms, 5e-6, 2e-6);
    }
    for (const double s : sum) {
        EXPECT_NEAR(s, 1.0, 4.0 * std::sqrt(2.0 / kSets));
    }
}

TEST(SensorRay, WhatReadingsHaveInCommonIsInTheCovariance) {
    auto planes = planes_of(kRoof);
    for (KnownPlane& plane : planes) {
        plane.sigma = 1e-9;
    }
    constexpr double kCommon = 20e-6;
    constexpr int kSets = 60;
    double stated = 0.0;
    double forgotten = 0.0;
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0.0, kCommon);
    for (unsigned seed = 0; seed < kSets; ++seed) {
        auto readings = scan(planes, 5e-6, seed);
        std::array<double, 8> off{};
        for (double& o : off) {
            o = normal(random);
        }
        for (RangeReading& r : readings) {
            r.reading += off.at(static_cast<std::size_t>(r.plane));
            r.group = r.plane;
            r.common = kCommon;
        }
        const SensorRayFit fit = fit_sensor_ray("readings.csv", planes, readings, 0.0);
        const double z = fit.origin.z - kOrigin.z;
        stated += z * z / fit.covariance.at[1][1] / kSets;
        for (RangeReading& r : readings) {
            r.common = 0.0;
        }
        const SensorRayFit blind = fit_sensor_ray("readings.csv", planes, readings, 0.0);
        forgotten += std::pow(blind.origin.z - kOrigin.z, 2) / blind.covariance.at[1][1] / kSets;
    }
    EXPECT_NEAR(stated, 1.0, 4.0 * std::sqrt(2.0 / kSets));
    EXPECT_GT(forgotten, 3.0) << "as if each reading were new";
}

TEST(SensorRay, NamesAWrongReading) {
    const auto planes = planes_of(kRoof);
    auto readings = scan(planes, 5e-6, 2);
    readings[17].reading += 0.4e-3;
    const SensorRayFit fit = fit_sensor_ray("readings.csv", planes, readings, 0.0);
    EXPECT_EQ(fit.wrong, std::vector<int>{19});
}

TEST(SensorRay, RefusesWhatIsBlindAndNamesIt) {
    EXPECT_NE(refusal_of(planes_of({{0.0, 0.0}})).find("the planes do not show"), std::string::npos);
    const std::string no_z = refusal_of(planes_of({{0.0, 0.0}, {0.5, 0.0}, {-0.5, 0.0}}));
    EXPECT_NE(no_z.find(" z"), std::string::npos) << no_z;
    const std::string no_x = refusal_of(planes_of({{0.0, 0.0}, {0.0, 0.5}, {0.0, -0.5}}));
    EXPECT_NE(no_x.find(" x"), std::string::npos) << no_x;
}

TEST(KnownPlane, IsThatOfItsPoints) {
    const KnownPlane plane =
        fit_known_plane(3, {{0.0, 1.0, 0.0}, {1.0, 1.5, 0.0}, {0.0, 1.0, 1.0}, {1.0, 1.5, 1.0}}, 1e-6, {0.0, 1.0, 0.0});
    EXPECT_NEAR(plane.normal.x / plane.normal.y, -0.5, 1e-12);
    EXPECT_NEAR(dot(plane.normal, {0.0, 1.0, 0.0}), plane.distance, 1e-12);
    EXPECT_THROW(static_cast<void>(fit_known_plane(1, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 1e-6, {0, 1, 0})),
                 std::domain_error);
}

}  // namespace
}  // namespace sc::host
