// SPDX-License-Identifier: Apache-2.0
// Poses that tests/golden/measure/work_by_hand.py has worked out with vectors alone.
#include "host/measurement/station.hpp"

#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(GoldenMeasure, AnglesAndDistancesAreThoseWorkedByHand) {
    std::ifstream in(std::string(SC_SOURCE_DIR) + "/tests/golden/measure/golden.json");
    const auto cases = nlohmann::json::parse(in);
    ASSERT_EQ(cases.size(), 12U);
    for (const auto& c : cases) {
        TripleRecord head;
        head.range = {0.05, 2.0};
        Station station;
        station.id = "golden";
        station.readings.resize(3);
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& ray = c["rays"][i];
            head.rays[i] = {
                .id = "L" + std::to_string(i),
                .origin = {ray["origin_mm"][0].get<double>() / 1e3, ray["origin_mm"][1].get<double>() / 1e3},
                .tilt = {ray["tilt"][0].get<double>(), ray["tilt"][1].get<double>()},
                .zero = ray["zero_mm"].get<double>() / 1e3,
                .gain = ray["gain"].get<double>(),
                .sigma = 1e-4};
            for (HeadReading& reading : station.readings) {
                reading.value[i] = c["readings_mm"][i].get<double>() / 1e3;
            }
        }
        TripleReference reference;
        std::array<Vec3, 3> axes;
        for (std::size_t i = 0; i < 3; ++i) {
            axes[i] = {c["axes_of_r"][i][0].get<double>(), c["axes_of_r"][i][1].get<double>(),
                       c["axes_of_r"][i][2].get<double>()};
        }
        reference.rotation = Mat3{axes}.transposed();
        reference.translation =
            1e-3 * Vec3{c["seat_mm"][0].get<double>(), c["seat_mm"][1].get<double>(), c["seat_mm"][2].get<double>()};
        reference.at = {c["at_mm"][0].get<double>() / 1e3, c["at_mm"][1].get<double>() / 1e3};
        head.reference = reference;
        for (std::size_t i = 0; i < TripleRecord::kParameters; ++i) {
            head.covariance.at[i][i] = 1e-12;
        }
        for (const Estimator estimator : {Estimator::median, Estimator::mean}) {
            StationOptions options;
            options.estimator = estimator;
            const auto result = measure_station(head, station, options);
            ASSERT_TRUE(result) << result.error().text;
            EXPECT_NEAR(result->angle / kDegree, c["angle_deg"].get<double>(), 1e-7);
            EXPECT_NEAR(result->about_z / kDegree, c["about_z_deg"].get<double>(), 1e-7);
            EXPECT_NEAR(result->distance * 1e3, c["distance_mm"].get<double>(), 1e-7);
        }
    }
}

}  // namespace
}  // namespace sc::host
