// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/uncertainty.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/bench/allowance_workload.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host::test {
namespace {

double of(const Uncertainty& uncertainty, const std::string& name) {
    for (const UncertaintySource& source : uncertainty.lines) {
        if (source.name == name) {
            return source.sigma;
        }
    }
    return -1.0;
}

TEST(Uncertainty, CarriesTheCalibrationToThePart) {
    const DistanceField field(box_mesh({-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01}));
    Inspection inspection;
    CalibrationSet set;
    TransformRecord record;
    record.id = "h_from_c";
    record.translation = {0.3, 0.0, 0.0};
    for (std::size_t i = 3; i < 6; ++i) {
        record.covariance.at[i][i] = 25e-12;
    }
    set.transforms = {record};
    EXPECT_NEAR(of(uncertainty_of(inspection, field, &set), "h_from_c"), 5e-6, 1e-15);
    // A turn of 20 urad about z moves a place 0.3 m away by 6 um along y alone.
    record.covariance = {};
    record.covariance.at[2][2] = 400e-12;
    set.transforms = {record};
    EXPECT_NEAR(of(uncertainty_of(inspection, field, &set), "h_from_c"), 6e-6 / std::sqrt(3.0), 1e-15);
    EXPECT_LT(of(uncertainty_of(inspection, field, nullptr), "h_from_c"), 0.0);
}

TEST(Uncertainty, PlacementIsWhatFitsScatterBy) {
    // Boxes scanned anew each time: the fit's error in its least held motion is about what is said of it.
    const TriangleMesh box = box_mesh({-0.02, -0.015, -0.01}, {0.02, 0.015, 0.01});
    const DistanceField field(box);
    double squares = 0.0;
    double said = 0.0;
    constexpr int kScans = 24;
    for (int scan = 0; scan < kScans; ++scan) {
        const std::vector<Vec3> places = places_off(box, 4000, 0.0, 0.0, 3e-5, static_cast<unsigned>(100 + scan));
        Inspection inspection;
        inspection.fit = fit_to_mesh(field, places, {});
        const auto& t = inspection.fit.w_from_c.translation;
        squares += std::max({t.x * t.x, t.y * t.y, t.z * t.z});
        said += std::pow(of(uncertainty_of(inspection, field, nullptr), "placement"), 2);
    }
    EXPECT_LT(std::sqrt(squares / said), 1.5) << "no motion is held worse than said";
    EXPECT_GT(std::sqrt(squares / said), 0.2);
    const std::vector<UncertaintySource> sources{{"a", 3e-6, ""}, {"b", 4e-6, ""}};
    EXPECT_NEAR(expanded(sources), 1e-5, 1e-18);
}

}  // namespace
}  // namespace sc::host::test
