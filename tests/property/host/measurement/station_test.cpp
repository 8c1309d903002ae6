// SPDX-License-Identifier: Apache-2.0
// What must hold for any head, any plane and any readings. The readings are worked out here, by the meeting of a line
// and a plane, and share nothing with the code that takes them apart.
#include "host/measurement/station.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "host/measurement/correction.hpp"
#include "host/measurement/head_model.hpp"
#include "host/measurement/location.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// In thousandths, so that shrinking has a grid to go along.
double real(double least, double most) {
    const int k = *rc::gen::inRange(0, 1001);
    return least + (most - least) * k / 1000.0;
}

TripleRecord any_head() {
    TripleRecord head;
    head.range = {0.01, 10.0};
    const double side = real(0.03, 0.2);
    const std::array<std::array<double, 2>, 3> corner{
        {{0.0, 0.0}, {side, 0.0}, {0.5 * side, 0.5 * std::numbers::sqrt3 * side}}};
    for (std::size_t i = 0; i < 3; ++i) {
        TripleRay& ray = head.rays[i];
        ray.id = "L" + std::to_string(i + 1);
        ray.origin = {corner[i][0] + real(-2e-3, 2e-3), corner[i][1] + real(-2e-3, 2e-3)};
        ray.tilt = {real(-0.01, 0.01), real(-0.01, 0.01)};
        ray.zero = real(-1e-3, 1e-3);
        ray.gain = real(-5e-3, 5e-3);
        ray.sigma = 1e-4;
    }
    head.reference = TripleReference{
        {{Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}}}, {0.05, -0.06, -0.02}, {0.0, 0.09}};
    for (std::size_t i = 0; i < TripleRecord::kParameters; ++i) {
        head.covariance.at[i][i] = 1e-14;
    }
    return head;
}

/// z = a + b x + c y in d.
struct Face {
    double a;
    double b;
    double c;
};

Face any_face() {
    const double a = real(0.2, 0.6);
    const double b = real(-0.5, 0.5);
    const double c = real(-0.5, 0.5);
    return {a, b, c};
}

/// What a perfect sensor of this ray says of the face.
double reading_of(const TripleRay& ray, const Face& face) {
    // (ox, oy, 0) + s·(tx, ty, 1)/|…| meets z = a + b x + c y.
    const double length = std::sqrt(1.0 + ray.tilt[0] * ray.tilt[0] + ray.tilt[1] * ray.tilt[1]);
    const double z = (face.a + face.b * ray.origin[0] + face.c * ray.origin[1]) /
                     (1.0 - face.b * ray.tilt[0] - face.c * ray.tilt[1]);
    return z * length / (1.0 + ray.gain) + ray.zero;
}

Station station_of(const TripleRecord& head, const Face& face, double noise, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Station station;
    station.id = "s";
    for (int k = 0; k < 10; ++k) {
        HeadReading reading;
        for (std::size_t i = 0; i < 3; ++i) {
            reading.value[i] = reading_of(head.rays[i], face) + noise * normal(random);
        }
        station.readings.push_back(reading);
    }
    return station;
}

/// Normal of the face in r, towards the head: d's x, y, z are r's y, z, x.
Vec3 normal_in_r(const Face& face) {
    const double n = std::sqrt(1.0 + face.b * face.b + face.c * face.c);
    return {-1.0 / n, face.b / n, face.c / n};
}

RC_GTEST_PROP(MeasureStation, FindsThePlaneOfAnyHeadWithoutNoise, ()) {
    const TripleRecord head = any_head();
    const Face face = any_face();
    const auto result = measure_station(head, station_of(head, face, 1e-9, 1), {});
    RC_ASSERT(result.has_value());
    const Vec3 n = normal_in_r(face);
    RC_ASSERT(norm(result->normal - n) < 1e-6);
    RC_ASSERT(std::abs(result->angle - (std::numbers::pi - std::acos(n.z))) < 1e-6);
    // The distance, at (y, z) = (0, 0.09) of r, which is x = 0.05, y = 0.03 of d, from z = −0.02.
    RC_ASSERT(std::abs(result->distance - (face.a + face.b * 0.05 + face.c * 0.03 + 0.02)) < 1e-7);
}

RC_GTEST_PROP(MeasureStation, TheOrderOfReadingsDoesNotMatter, ()) {
    const TripleRecord head = any_head();
    Station station = station_of(head, any_face(), 1e-4, *rc::gen::inRange<std::uint64_t>(1, 1'000'000));
    const auto one = measure_station(head, station, {});
    std::mt19937_64 random(*rc::gen::inRange<std::uint64_t>(1, 1'000'000));
    std::shuffle(station.readings.begin(), station.readings.end(), random);
    const auto other = measure_station(head, station, {});
    RC_ASSERT(one.has_value() && other.has_value());
    RC_ASSERT(std::abs(one->angle - other->angle) < 1e-12);
    RC_ASSERT(std::abs(one->distance - other->distance) < 1e-12);
}

RC_GTEST_PROP(MeasureStation, ErrorsLieWithinTheUncertainty, ()) {
    const TripleRecord head = any_head();
    const Face face = any_face();
    const auto result =
        measure_station(head, station_of(head, face, 1e-4, *rc::gen::inRange<std::uint64_t>(1, 1'000'000)), {});
    RC_ASSERT(result.has_value());
    const double truth = std::numbers::pi - std::acos(normal_in_r(face).z);
    // Six standard deviations: no run of this test sees them.
    RC_ASSERT(std::abs(result->angle - truth) < 6.0 * result->angle_sigma.total());
}

RC_GTEST_PROP(MeasureStation, MoreOfTheSameReadingsNeverMakeItLessCertain, ()) {
    const TripleRecord head = any_head();
    const Face face = any_face();
    const std::uint64_t seed = *rc::gen::inRange<std::uint64_t>(1, 1'000'000);
    Station station = station_of(head, face, 5e-5, seed);
    const auto ten = measure_station(head, station, {});
    const Station more = station_of(head, face, 5e-5, seed + 1);
    station.readings.insert(station.readings.end(), more.readings.begin(), more.readings.end());
    const auto twenty = measure_station(head, station, {});
    RC_ASSERT(ten.has_value() && twenty.has_value());
    RC_ASSERT(twenty->angle_sigma.sensors < ten->angle_sigma.sensors);
}

RC_GTEST_PROP(MeasureStation, AnythingIsRefusedOrHasFiniteFigures, ()) {
    const TripleRecord head = any_head();
    Station station;
    station.id = "s";
    const int rows = *rc::gen::inRange(1, 8);
    for (int k = 0; k < rows; ++k) {
        HeadReading reading;
        for (double& value : reading.value) {
            value = real(-1.0, 12.0);
        }
        station.readings.push_back(reading);
    }
    const auto result = measure_station(head, station, {});
    if (!result) {
        RC_ASSERT(!result.error().text.empty());
        return;
    }
    RC_ASSERT(std::isfinite(result->angle) && std::isfinite(result->distance) && std::isfinite(result->about_z));
    RC_ASSERT(std::isfinite(result->angle_sigma.total()) && result->angle_sigma.total() > 0.0);
}

RC_GTEST_PROP(Locate, StaysWithinItsReadingsAndMovesWithThem, ()) {
    std::vector<double> readings;
    const int n = *rc::gen::inRange(1, 30);
    for (int k = 0; k < n; ++k) {
        readings.push_back(0.3 + real(-1e-3, 1e-3));
    }
    for (const Estimator estimator : {Estimator::median, Estimator::mean}) {
        const Location one = locate(readings, 1e-4, estimator);
        RC_ASSERT(one.value >= *std::min_element(readings.begin(), readings.end()) - 1e-12);
        RC_ASSERT(one.value <= *std::max_element(readings.begin(), readings.end()) + 1e-12);
        RC_ASSERT(one.used + one.left_out == readings.size());
        std::vector<double> moved = readings;
        for (double& value : moved) {
            value += 0.125;
        }
        RC_ASSERT(std::abs(locate(moved, 1e-4, estimator).value - one.value - 0.125) < 1e-9);
    }
}

RC_GTEST_PROP(Correction, ItsTurnsBringAnyFaceOntoAnyTarget, ()) {
    const TripleRecord head = any_head();
    const auto result = measure_station(head, station_of(head, any_face(), 1e-9, 1), {});
    RC_ASSERT(result.has_value());
    StationTarget target;
    target.same = false;
    target.angle = real(60.0, 120.0) * kDegree;
    target.yaw = real(-20.0, 20.0) * kDegree;
    target.distance = real(0.2, 0.5);
    const Correction correction = correction_of(*result, target, default_station_job());
    // Spherical angles add up: about z first, then about y of the target's yaw.
    const Vec3 wanted = normal_of(target.angle, target.yaw);
    RC_ASSERT(norm(normal_of(result->angle + correction.turn_y, result->about_z + correction.turn_z) - wanted) < 1e-9);
    RC_ASSERT(std::abs(std::cos(correction.off_angle) - dot(result->normal, wanted)) < 1e-9);
}

}  // namespace
}  // namespace sc::host
