// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/drift_check.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

/// A fixed target, and a sensor on a robot that looks at it; quaternions only.
class Cell {
public:
    explicit Cell(std::uint64_t seed) : random_(seed) {
        x = {turn({0.3, 1.2, -0.4}), {0.06, -0.03, 0.12}};
        for (int k = 0; k < 12; ++k) {
            places.push_back({0.8 + 0.06 * (k % 4), 0.1 + 0.05 * (k / 4), 0.3 + 0.005 * (k % 3)});
        }
    }
    static Mat3 turn(const Vec3& w) {
        const double angle = norm(w);
        const double s = angle > 0.0 ? std::sin(0.5 * angle) / angle : 0.0;
        return rotation_of_quaternion({std::cos(0.5 * angle), s * w.x, s * w.y, s * w.z});
    }
    Rigid<frame::F, frame::C> x;  ///< where the sensor truly sits
    std::vector<Vec3> places;     ///< markers in b, now
    double scale = 1.0;           ///< of the sensor
    std::vector<DriftView> views(int count) {
        std::vector<DriftView> out;
        for (int v = 0; v < count; ++v) {
            const Mat3 down =
                turn({3.14159, 0.0, 0.0}) * turn({0.25 * std::cos(1.9 * v), 0.25 * std::sin(1.9 * v), 0.8 * v});
            const Rigid<frame::B, frame::C> sensor{down, Vec3{0.89, 0.15, 0.3} - 0.43 * (down * Vec3{0.0, 0.0, 1.0})};
            const Rigid<frame::B, frame::F> flange = sensor * x.inverse();
            DriftView view{.name = std::to_string(v), .b_from_f = flange, .markers = {}};
            const auto c_from_b = sensor.inverse();
            for (std::size_t k = 0; k < places.size(); ++k) {
                const Vec3 in_c = scale * (c_from_b * Point<frame::B>{places[k]}).v;
                view.markers.push_back({0, static_cast<int>(k) + 1, in_c + draw(7.5e-6), {}});
            }
            view.b_from_f->rotation = turn(draw(2.6e-5)) * view.b_from_f->rotation;
            view.b_from_f->translation = view.b_from_f->translation + draw(6.7e-6);
            out.push_back(view);
        }
        return out;
    }
    Vec3 draw(double sigma) {
        std::normal_distribution<double> one(0.0, sigma);
        const double a = one(random_);
        const double b = one(random_);
        return {a, b, one(random_)};
    }

private:
    std::mt19937_64 random_;
};

struct Stored {
    std::vector<SeenMarker> markers;
    Rigid<frame::F, frame::C> x;
};
Stored store(Cell& cell) { return {places_to_store(cell.views(12), cell.x), cell.x}; }

TEST(DriftCheck, SeesNothingWhereNothingMoved) {
    int drifted = 0;
    int moved = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        Cell cell(seed);
        const Stored stored = store(cell);
        const DriftResult result = check_drift("seen.csv", stored.markers, cell.views(4), stored.x);
        drifted += result.drifted ? 1 : 0;
        moved += result.suspect == DriftCause::nothing ? 0 : 1;
        EXPECT_EQ(result.markers.size(), 12U);
    }
    EXPECT_EQ(drifted, 0);
    EXPECT_LE(moved, 2) << "three tests of 1 in 1000";
}

TEST(DriftCheck, NamesWhatHasMoved) {
    int right_target = 0;
    int right_sensor = 0;
    int right_scale = 0;
    constexpr int kRuns = 20;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
        Cell target(seed);
        Stored stored = store(target);
        for (Vec3& p : target.places) {
            p = p + Vec3{40e-6, -30e-6, 20e-6};
        }
        DriftResult result = check_drift("seen.csv", stored.markers, target.views(4), stored.x);
        EXPECT_TRUE(result.drifted);
        right_target += result.suspect == DriftCause::target ? 1 : 0;
        EXPECT_NEAR(result.hypotheses[1].place, 54e-6, 20e-6);

        Cell sensor(seed + 100);
        stored = store(sensor);
        sensor.x.translation = sensor.x.translation + Vec3{0.0, 50e-6, 30e-6};
        sensor.x.rotation = Cell::turn({2e-4, 0.0, 0.0}) * sensor.x.rotation;
        result = check_drift("seen.csv", stored.markers, sensor.views(5), stored.x);
        EXPECT_TRUE(result.drifted);
        right_sensor += result.suspect == DriftCause::sensor ? 1 : 0;

        Cell warm(seed + 200);
        stored = store(warm);
        warm.scale = 1.0 + 150e-6;
        result = check_drift("seen.csv", stored.markers, warm.views(5), stored.x);
        EXPECT_TRUE(result.drifted);
        right_scale += result.suspect == DriftCause::scale ? 1 : 0;
    }
    EXPECT_GE(right_target, kRuns - 1);
    EXPECT_GE(right_sensor, kRuns - 1);
    EXPECT_GE(right_scale, kRuns - 1);
}

TEST(DriftCheck, NamesASingleMarker) {
    Cell cell(7);
    const Stored stored = store(cell);
    cell.places[4] = cell.places[4] + Vec3{0.0, 0.0, 120e-6};
    const DriftResult result = check_drift("seen.csv", stored.markers, cell.views(4), stored.x);
    EXPECT_TRUE(result.drifted);
    for (const DriftMarker& marker : result.markers) {
        EXPECT_EQ(marker.moved_alone, marker.id == 5) << marker.id;
    }
}

TEST(DriftCheck, ATargetMayBePutDownAgain) {
    Cell cell(9);
    const Stored stored = store(cell);
    for (Vec3& p : cell.places) {
        p = Cell::turn({0.0, 0.0, 0.01}) * p + Vec3{1e-3, 0.0, 0.0};
    }
    const DriftResult result = check_drift("seen.csv", stored.markers, cell.views(4), stored.x, {.target_moved = true});
    EXPECT_FALSE(result.drifted) << result.text;
}

TEST(DriftCheck, OneCloudInOneFrame) {
    Cell cell(11);
    std::vector<SeenMarker> stored;
    DriftView view;
    for (int k = 0; k < 12; ++k) {
        const Vec3 p = cell.places[static_cast<std::size_t>(k)];
        stored.push_back({0, k + 1, p + cell.draw(7.5e-6), {}});
        view.markers.push_back({0, k + 1, p + cell.draw(7.5e-6) + Vec3{0.0, 35e-6, 0.0}, {}});
    }
    EXPECT_TRUE(check_drift("seen.csv", stored, {view}, std::nullopt, {.limit = 20e-6}).drifted);
    const DriftResult within = check_drift("seen.csv", stored, {view}, std::nullopt, {.limit = 80e-6});
    EXPECT_FALSE(within.drifted);
    EXPECT_EQ(within.suspect, DriftCause::target) << "it has moved all the same";
    view.markers.resize(2);
    EXPECT_THROW(static_cast<void>(check_drift("seen.csv", stored, {view}, std::nullopt)), InputError);
    view.b_from_f = Rigid<frame::B, frame::F>{};
    EXPECT_THROW(static_cast<void>(check_drift("seen.csv", stored, {view}, std::nullopt)), InputError);
}

}  // namespace
}  // namespace sc::host
