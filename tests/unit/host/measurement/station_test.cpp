// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/station.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "host/measurement/correction.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Beams straight along z from an equilateral triangle of 100 mm; r as in docs/measure.md, its origin at (50, −60,
/// −20).
TripleRecord plain_head() {
    TripleRecord head;
    head.range = {0.05, 2.0};
    const std::array<std::array<double, 2>, 3> places{{{0.0, 0.0}, {0.1, 0.0}, {0.05, 0.05 * std::sqrt(3.0)}}};
    for (std::size_t i = 0; i < 3; ++i) {
        head.rays[i].id = "L" + std::to_string(i + 1);
        head.rays[i].origin = places[i];
        head.rays[i].sigma = 1e-4;
    }
    head.reference = TripleReference{
        {{Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}}}, {0.05, -0.06, -0.02}, {0.0, 0.09}};
    for (std::size_t i = 0; i < TripleRecord::kParameters; ++i) {
        head.covariance.at[i][i] = 1e-14;
    }
    return head;
}

/// Readings of a face z = a + b·x + c·y in d, worked out here: straight beams meet it at their own x and y.
Station station_of(double a, double b, double c, int readings = 10, double noise = 0.0) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    const TripleRecord head = plain_head();
    Station station;
    station.id = "s";
    for (int k = 0; k < readings; ++k) {
        HeadReading reading;
        for (std::size_t i = 0; i < 3; ++i) {
            reading.value[i] = a + b * head.rays[i].origin[0] + c * head.rays[i].origin[1] + 1e-9 * k;
            reading.value[i] += noise * normal(random);
        }
        station.readings.push_back(reading);
    }
    return station;
}

StationProblem problem_of(const TripleRecord& head, const Station& station) {
    const auto result = measure_station(head, station, {});
    EXPECT_FALSE(result.has_value());
    if (result) {
        return StationProblem::too_few;
    }
    EXPECT_GT(result.error().text.size(), 30U);
    return result.error().problem;
}

TEST(MeasureStation, AFaceSquareToTheReferenceIsAtNinetyDegrees) {
    const auto result = measure_station(plain_head(), station_of(0.3, 0.0, 0.0), {});
    ASSERT_TRUE(result) << result.error().text;
    EXPECT_NEAR(result->angle / kDegree, 90.0, 1e-5);
    EXPECT_NEAR(result->about_z, 0.0, 1e-7);
    EXPECT_NEAR(result->distance, 0.32, 1e-7);
    EXPECT_NEAR(result->normal.x, -1.0, 1e-9);
}

TEST(MeasureStation, AFaceThatLeansOverTheHeadHasASharpAngle) {
    // Higher up (y of d is z of r) it is nearer: by tan 30° a metre, so the corner holds 60°.
    const auto result = measure_station(plain_head(), station_of(0.3, 0.0, -std::tan(30.0 * kDegree)), {});
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->angle / kDegree, 60.0, 1e-5);
    EXPECT_NEAR(result->about_y / kDegree, 60.0, 1e-5);
}

TEST(MeasureStation, YawIsRightHandedAboutTheReferencesNormal) {
    // A face whose normal −x is turned by +5° about z is deeper at −y: x = −tan 5°·y there.
    const auto result = measure_station(plain_head(), station_of(0.3, -std::tan(5.0 * kDegree), 0.0), {});
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->about_z / kDegree, 5.0, 1e-5);
    EXPECT_NEAR(result->angle / kDegree, 90.0, 1e-5);
}

TEST(MeasureStation, UncertaintyOfTheAngleIsThatOfTheTriangle) {
    // Equilateral, side L: 1.414 sigma / L for one reading (facts of the field), by ten of them over sqrt 10.
    const auto result = measure_station(plain_head(), station_of(0.3, 0.0, 0.0, 10, 1e-4), {});
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->angle_sigma.sensors, std::sqrt(2.0) * 1e-4 / 0.1 / std::sqrt(10.0), 2e-6);
    StationOptions seated;
    seated.seat.angle = 1e-3;
    EXPECT_NEAR(measure_station(plain_head(), station_of(0.3, 0.0, 0.0), seated)->angle_sigma.seat, 1e-3, 1e-6);
}

TEST(MeasureStation, AWildReadingDoesNotMoveTheEstimate) {
    Station station = station_of(0.3, 0.0, 0.0, 10, 1e-4);
    const double before = measure_station(plain_head(), station, {})->angle;
    station.readings.push_back(station.readings.front());
    station.readings.back().value[2] += 0.05;
    const auto after = measure_station(plain_head(), station, {});
    ASSERT_TRUE(after);
    EXPECT_NEAR(after->angle, before, 0.03 * kDegree);
    EXPECT_GE(after->left_out, 1U);
    EXPECT_FALSE(after->noisier);
    EXPECT_LT(after->angle_sigma.sensors, 1e-3);
}

TEST(MeasureStation, ExchangedIdsAreNamed) {
    Station station = station_of(0.3, 0.1, 0.0);
    station.sensors = {"L2", "L1", "L3"};
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::swapped_sensors);
    station.sensors = {"L1", "L2", "X9"};
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::wrong_sensors);
    station.sensors = {"L1", "L2", "L3"};
    EXPECT_TRUE(measure_station(plain_head(), station, {}));
}

/// The same face from a head that is tilted by `tilt` about y of d, seven readings.
void add_tilted(Station& station, double tilt, double a, double b, double c) {
    const TripleRecord head = plain_head();
    for (int k = 0; k < 7; ++k) {
        HeadReading reading;
        reading.pose.tilt = {0.0, tilt, 0.0};
        for (std::size_t i = 0; i < 3; ++i) {
            // Rotation about y: (x, y, 0) to (x cos, y, −x sin), the beam to (sin, 0, cos).
            const double x = head.rays[i].origin[0];
            const double y = head.rays[i].origin[1];
            const double ox = x * std::cos(tilt);
            const double oz = -x * std::sin(tilt);
            reading.value[i] = (a + b * ox + c * y - oz) / (std::cos(tilt) - b * std::sin(tilt)) + 1e-9 * k;
        }
        station.readings.push_back(reading);
    }
}

TEST(MeasureStation, ATiltedHeadMakesThePlaneRedundantAndFindsExchangedSensors) {
    Station station = station_of(0.3, 0.2, -0.1);
    add_tilted(station, 5.0 * kDegree, 0.3, 0.2, -0.1);
    const auto one = measure_station(plain_head(), station_of(0.3, 0.2, -0.1), {});
    const auto two = measure_station(plain_head(), station, {});
    ASSERT_TRUE(two) << two.error().text;
    EXPECT_NEAR(two->angle, one->angle, 1e-6);
    EXPECT_FALSE(one->misfit.has_value());
    ASSERT_TRUE(two->misfit.has_value());
    EXPECT_LT(two->angle_sigma.sensors, 0.8 * one->angle_sigma.sensors);
    for (HeadReading& reading : station.readings) {
        std::swap(reading.value[0], reading.value[1]);
    }
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::swapped_sensors);
}

TEST(MeasureStation, AKnownStationFindsExchangedSensors) {
    const KnownPose known{.station = "s",
                          .angle = 60.0 * kDegree,
                          .angle_sigma = 1e-4,
                          .yaw = 5.0 * kDegree,
                          .yaw_sigma = 1e-4,
                          .distance = {},
                          .distance_sigma = 0.0};
    // From yaw 5° and angle 60°: the face's slopes in d.
    const Vec3 n = normal_of(60.0 * kDegree, 5.0 * kDegree);
    Station station = station_of(0.3, -n.y / n.x, -n.z / n.x);
    EXPECT_FALSE(check_station(plain_head(), station, known, {}));
    for (HeadReading& reading : station.readings) {
        std::swap(reading.value[0], reading.value[2]);
    }
    const auto refusal = check_station(plain_head(), station, known, {});
    ASSERT_TRUE(refusal);
    EXPECT_EQ(refusal->problem, StationProblem::swapped_sensors);
    EXPECT_NE(refusal->text.find("L1"), std::string::npos);
}

TEST(MeasureStation, RefusesWithAReasonOfItsOwn) {
    TripleRecord head = plain_head();
    head.reference.reset();
    EXPECT_EQ(problem_of(head, station_of(0.3, 0.0, 0.0)), StationProblem::missing_reference);

    head = plain_head();
    head.rays[2].origin = {0.05, 1e-3};
    EXPECT_EQ(problem_of(head, station_of(0.3, 0.0, 0.0)), StationProblem::collinear);

    Station station = station_of(0.3, 0.0, 0.0);
    for (HeadReading& reading : station.readings) {
        reading.age = 1.5;
    }
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::stale);

    station = station_of(0.3, 0.0, 0.0);
    for (HeadReading& reading : station.readings) {
        reading.fault = "no echo";
    }
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::sensor_fault);

    EXPECT_EQ(problem_of(plain_head(), station_of(0.3, 0.0, 0.0, 2)), StationProblem::too_few);
    EXPECT_EQ(problem_of(plain_head(), station_of(5.0, 0.0, 0.0)), StationProblem::out_of_range);
    EXPECT_EQ(problem_of(plain_head(), station_of(0.6, 0.0, -4.0)), StationProblem::grazing);

    station = station_of(0.3, 0.0, 0.0, 10, 1e-4);
    for (HeadReading& reading : station.readings) {
        reading.value[1] = 0.3;
    }
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::stuck);
}

TEST(MeasureStation, NoPlaneFitsAFaceThatMovedBetweenPoses) {
    Station station = station_of(0.3, 0.2, -0.1);
    add_tilted(station, 5.0 * kDegree, 0.31, -0.1, 0.2);
    EXPECT_EQ(problem_of(plain_head(), station), StationProblem::inconsistent);
}

TEST(Correction, TurnsAndShiftBringTheFaceToItsTarget) {
    StationJob job;
    job.angle_tolerance = 0.1 * kDegree;
    job.distance_tolerance = 5e-4;
    job.screws = {{"a", {0.0, 0.03}, 1e-3}, {"b", {-0.05, 0.12}, 1e-3}, {"c", {0.05, 0.12}, 1e-3}};
    const StationTarget target{.same = false, .angle = 85.0 * kDegree, .yaw = 2.0 * kDegree, .distance = 0.31};
    const auto result = measure_station(plain_head(), station_of(0.3, 0.05, -0.2), {});
    ASSERT_TRUE(result);
    const Correction correction = correction_of(*result, target, job);
    EXPECT_EQ(correction.verdict, Verdict::adjust);
    // Turned as it says, the normal is the target's: yaw and angle add up.
    const Vec3 turned = normal_of(result->angle + correction.turn_y, result->about_z + correction.turn_z);
    EXPECT_NEAR(norm(turned - normal_of(target.angle, target.yaw)), 0.0, 1e-12);
    // The three screws' travels move the measured face onto the target's.
    for (std::size_t i = 0; i < 3; ++i) {
        const auto x_of = [&](const Vec3& n, double distance) {
            return distance -
                   (n.y * (job.screws[i].place[0] - result->at[0]) + n.z * (job.screws[i].place[1] - result->at[1])) /
                       n.x;
        };
        EXPECT_NEAR(x_of(result->normal, result->distance) - correction.screws[i].travel,
                    x_of(normal_of(target.angle, target.yaw), target.distance), 1e-12);
        EXPECT_NEAR(correction.screws[i].turns, correction.screws[i].travel / 1e-3, 1e-9);
    }
    const StationTarget here{
        .same = false, .angle = result->angle, .yaw = result->about_z, .distance = result->distance};
    EXPECT_EQ(correction_of(*result, here, job).verdict, Verdict::good);
}

TEST(Locate, MedianVarianceIsThatOfManyDraws) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (const std::size_t n : {3U, 4U, 10U, 11U, 25U}) {
        double squares = 0.0;
        constexpr int kTrials = 20'000;
        for (int t = 0; t < kTrials; ++t) {
            std::vector<double> values(n);
            for (double& v : values) {
                v = normal(random);
            }
            squares += std::pow(locate(values, 1.0, Estimator::median).value, 2);
        }
        EXPECT_NEAR(squares / kTrials / median_variance(n), 1.0, 0.05) << n;
    }
}

TEST(Stations, GarbledRowsAreRefusedWithTheirLine) {
    const auto message = [](const std::string& text) {
        try {
            static_cast<void>(parse_stations("r.csv", text));
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(message("station,d1_mm,d2_mm,d3_mm\ns,300.1,2x.1,300\n").find("r.csv:2"), std::string::npos);
    EXPECT_NE(message("station,d1_mm,d2_mm,d3_mm\ns,300.1,300\n").find("r.csv:2"), std::string::npos);
    EXPECT_NE(message("station,d1_mm,d2_mm\ns,300.1,300\n").find("d3_mm"), std::string::npos);
    EXPECT_NE(message("station,d1_mm,d2_mm,d3_mm\ns,300.1,nan,300\n").find("r.csv:2"), std::string::npos);
    EXPECT_NE(message("station,d1_mm,d2_mm,d3_mm,sensors\ns,1,2,3,A B\n").find("three ids"), std::string::npos);
    EXPECT_NE(message("station,d1_mm,d2_mm,d3_mm,age_ms\ns,1,2,3,-5\n").find("age_ms"), std::string::npos);
}

}  // namespace
}  // namespace sc::host
