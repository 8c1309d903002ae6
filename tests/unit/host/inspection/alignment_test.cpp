// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/alignment.hpp"

#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/scan.hpp"
#include "tests/bench/allowance_workload.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host {
namespace {

const DistanceField& finished() {
    static const DistanceField field(read_mesh(test::casting("finished.stl")).mesh);
    return field;
}
const std::vector<Vec3>& scan() {
    static const std::vector<Vec3> points = [] {
        std::vector<Vec3> out;
        const std::vector<Vec3> all = read_scan(test::casting("scan.ply")).cloud.points;
        for (std::size_t i = 0; i < all.size(); i += 10) {
            out.push_back(all[i]);
        }
        return out;
    }();
    return points;
}
/// Of the scan, from the file that comes with it.
Placement true_placement() {
    std::ifstream in(test::casting("truth_pose.txt"));
    std::string line;
    Rigid<frame::C, frame::W> c_from_w;
    for (int row = 0; row < 3;) {
        if (!std::getline(in, line) || line.starts_with("#")) {
            if (!in) {
                break;
            }
            continue;
        }
        std::istringstream text(line);
        double t = 0.0;
        auto& r = c_from_w.rotation.row[static_cast<std::size_t>(row)];
        text >> r.x >> r.y >> r.z >> t;
        (row == 0 ? c_from_w.translation.x : (row == 1 ? c_from_w.translation.y : c_from_w.translation.z)) = t / 1e3;
        ++row;
    }
    return c_from_w.inverse();
}
/// Largest distance between what two placements make of the part's corners.
double apart(const Placement& a, const Placement& b) {
    double worst = 0.0;
    const auto back = b.inverse();
    for (const Vec3& v : finished().mesh().vertices) {
        const Vec3 c = back.rotation * v + back.translation;
        worst = std::max(worst, norm(a.rotation * c + a.translation - v));
    }
    return worst;
}

TEST(Fit, FindsTheExactPlaceUnderWhiteNoise) {
    const auto places = test::places_off(finished().mesh(), 200000, 0.0, 0.0, 2e-5, 1);
    const Placement start{turn_by({0.05, -0.05, 0.05}), {6e-3, -5e-3, 6e-3}};  // 5 degrees, 10 mm
    const Fit fit = fit_to_mesh(finished(), places, start);
    EXPECT_LT(apart(fit.w_from_c, {}), 2e-6);
    EXPECT_NEAR(fit.sigma, 2e-5, 4e-6);
    EXPECT_GT(fit.stiffness, 1e-3);
}

TEST(Fit, RejectsAndCountsWhatDoesNotBelong) {
    auto places = test::places_off(finished().mesh(), 20000, 0.0, 0.0, 1e-5, 2);
    const auto outliers = test::places_off(finished().mesh(), 4000, 1e-3, 5e-3, 0.0, 3);
    places.insert(places.end(), outliers.begin(), outliers.end());
    const Fit fit = fit_to_mesh(finished(), places, {turn_by({0.02, 0.0, -0.02}), {1e-3, 1e-3, 1e-3}});
    EXPECT_LT(apart(fit.w_from_c, {}), 5e-6);
    EXPECT_NEAR(static_cast<double>(fit.rejected), 4000.0, 60.0);
}

TEST(Fit, RefusesACloudThatIsNowhereNear) {
    const std::vector<Vec3> far(1000, Vec3{5.0, 5.0, 5.0});
    EXPECT_THROW(static_cast<void>(fit_to_mesh(finished(), far, {})), InspectionError);
}

TEST(GlobalStart, FindsTheCastingInItsScan) {
    const GlobalStart start = global_start(finished(), scan());
    EXPECT_LT(apart(start.w_from_c, true_placement()), 1e-3);
    EXPECT_GT(start.second, 1.2 * start.score);
    const Fit fit = fit_to_mesh(finished(), scan(), start.w_from_c);
    EXPECT_LT(apart(fit.w_from_c, true_placement()), 5e-5) << "stock on a fifth of the surface notwithstanding";
}

TEST(GlobalStart, FindsItFromAnyPose) {
    const auto places = test::places_off(finished().mesh(), 20000, 0.0, 0.0, 5e-5, 4);
    std::mt19937_64 random(5);
    std::normal_distribution<double> white(0.0, 1.0);
    for (int i = 0; i < 4; ++i) {
        const Vec3 way{white(random), white(random), white(random)};
        const Placement pose{turn_by((3.1 * std::abs(std::sin(i + 1.0)) / norm(way)) * way), 0.3 * way};
        const GlobalStart start = global_start(finished(), placed(pose, places));
        const Placement whole{start.w_from_c.rotation * pose.rotation,
                              start.w_from_c.rotation * pose.translation + start.w_from_c.translation};
        EXPECT_LT(apart(whole, {}), 2e-4) << i;
    }
}

std::vector<ReferencePoint> references() { return read_part(test::casting("part.toml")).reference_points; }

TEST(References, PutTheirPlacesOntoTheirPlanes) {
    const ReferenceAlignment alignment = align_by_references(references(), scan(), true_placement());
    ASSERT_EQ(alignment.references.size(), 6U);
    for (const ReferenceUse& use : alignment.references) {
        EXPECT_LT(std::abs(use.offset), 1e-7) << use.id;
        EXPECT_GE(use.points, 5U) << use.id;
    }
    EXPECT_LT(apart(alignment.w_from_c, true_placement()), 3e-4) << "texture of 0.1 mm at each point";
}

TEST(References, RefuseWhatCannotFixThePart) {
    auto few = references();
    few.pop_back();
    EXPECT_THROW(static_cast<void>(align_by_references(few, scan(), true_placement())), InspectionError);
    auto twice = references();
    twice.back() = twice.front();
    twice.back().id = "again";
    EXPECT_THROW(static_cast<void>(align_by_references(twice, scan(), true_placement())), InspectionError);
    auto missing = references();
    missing.front().point.v = {0.5, 0.5, 0.5};
    try {
        static_cast<void>(align_by_references(missing, scan(), true_placement()));
        ADD_FAILURE();
    } catch (const InspectionError& error) {
        EXPECT_NE(std::string(error.what()).find("P1"), std::string::npos) << error.what();
    }
}

TEST(Coverage, IsOneOfAWholeScanAndHalfOfHalf) {
    const auto places = test::places_off(finished().mesh(), 60000, 0.0, 0.0, 0.0, 6);
    EXPECT_GT(coverage(finished(), places, {}, 2e-3), 0.99);
    std::vector<Vec3> half;
    for (const Vec3& p : places) {
        if (p.z > 0.0) {
            half.push_back(p);
        }
    }
    EXPECT_NEAR(coverage(finished(), half, {}, 2e-3), 0.5, 0.2);
}

}  // namespace
}  // namespace sc::host
