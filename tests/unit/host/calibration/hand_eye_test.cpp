// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/hand_eye.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = 0.017453292519943295;

/// A robot with a sensor that looks at a fixed target; quaternions only, so that nothing is shared with the estimator.
class Cell {
public:
    explicit Cell(unsigned seed) : random_(seed) {
        x_ = {turn(2.1, {0.3, -0.5, 0.8}), {0.05, -0.08, 0.11}};
        target_ = {turn(0.7, {0.1, 1.0, 0.2}), {0.8, 0.1, 0.3}};
    }
    [[nodiscard]] static Mat3 turn(double angle, const Vec3& about) {
        const double s = std::sin(0.5 * angle) / norm(about);
        return rotation_of_quaternion({std::cos(0.5 * angle), s * about.x, s * about.y, s * about.z});
    }
    Rigid<frame::F, frame::C> x_;
    Rigid<frame::B, frame::G> target_;
    double noise = 1.0;

    /// A view from above, tilted about x and y and rolled about z (radians).
    void look(double tilt_x, double tilt_y, double roll, const Vec3& aside = {}) {
        const Mat3 down = turn(std::numbers::pi, {1.0, 0.0, 0.0});
        const Mat3 r =
            turn(tilt_x, {1.0, 0.0, 0.0}) * turn(tilt_y, {0.0, 1.0, 0.0}) * turn(roll, {0.0, 0.0, 1.0}) * down;
        const Rigid<frame::G, frame::C> g_from_c{r, aside - 0.43 * (r * Vec3{0.0, 0.0, 1.0})};
        HandEyeView view{.name = std::to_string(views.size() + 1),
                         .line = static_cast<int>(views.size()) + 2,
                         .b_from_f = target_ * g_from_c * x_.inverse(),
                         .markers = {},
                         .c_from_g = {}};
        for (int k = 0; k < 12; ++k) {
            const Vec3 in_g{0.06 * (k % 4) - 0.09 + 0.0013 * ((7 * k) % 5), 0.05 * (k / 4) - 0.05, 0.005 * (k % 3)};
            const Point<frame::C> seen = g_from_c.inverse() * Point<frame::G>{in_g};
            const double s = 7.5e-6;
            view.markers.push_back({0, k + 1, seen.v + draw(s), {s, s, s}});
        }
        const Vec3 w = draw(2.6e-5);
        view.b_from_f.rotation = turn(norm(w), w + Vec3{1e-12, 0.0, 0.0}) * view.b_from_f.rotation;
        view.b_from_f.translation = view.b_from_f.translation + draw(6.7e-6);
        views.push_back(view);
    }
    void look_around(int count) {
        std::uniform_real_distribution<double> even(-1.0, 1.0);
        for (int i = 0; i < count; ++i) {
            look(0.43 * even(random_), 0.43 * even(random_), even(random_),
                 {0.03 * even(random_), 0.03 * even(random_), 0.0});
        }
    }
    std::vector<HandEyeView> views;

private:
    Vec3 draw(double sigma) {
        std::normal_distribution<double> normal;
        Vec3 out;
        out.x = sigma * noise * normal(random_);
        out.y = sigma * noise * normal(random_);
        out.z = sigma * noise * normal(random_);
        return out;
    }
    std::mt19937_64 random_;
};

double turn_error(const Mat3& a, const Mat3& b) {
    const Mat3 d = a * b.transposed();
    return norm(Vec3{d.row[2].y - d.row[1].z, d.row[0].z - d.row[2].x, d.row[1].x - d.row[0].y}) / 2.0;
}

void expect_close(const HandEyeResult& r, const Cell& cell, double factor = 1.0) {
    EXPECT_LT(turn_error(r.f_from_c.rotation, cell.x_.rotation), factor * 7e-3 * kDegree);
    EXPECT_LT(norm(r.f_from_c.translation - cell.x_.translation), factor * 50e-6);
}

std::string refusal(const Cell& cell) {
    try {
        static_cast<void>(calibrate_hand_eye("poses.csv", cell.views));
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), "poses.csv");
        EXPECT_FALSE(error.action().empty());
        return error.what();
    }
    return {};
}

TEST(HandEye, FindsTheSensorWithinItsUncertainty) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        Cell cell(seed);
        cell.look_around(15);
        const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
        expect_close(r, cell);
        EXPECT_TRUE(r.bad_poses.empty());
        EXPECT_TRUE(r.markers.empty());
        EXPECT_LT(r.place_sigma, 30e-6);
        EXPECT_NEAR(r.chi_squared / r.freedom, 1.0, 0.25);
        EXPECT_NEAR(r.robot_ratio, 1.0, 0.35);
    }
}

TEST(HandEye, IsExactWithoutNoise) {
    Cell cell(1);
    cell.noise = 0.0;
    cell.look_around(8);
    const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
    EXPECT_LT(turn_error(r.f_from_c.rotation, cell.x_.rotation), 1e-9);
    EXPECT_LT(norm(r.f_from_c.translation - cell.x_.translation), 1e-9);
}

TEST(HandEye, SensorTurnedByHalfATurnIsAsGood) {
    for (const Vec3& about : {Vec3{1.0, 0.0, 0.0}, Vec3{0.6, 0.8, 0.0}, Vec3{0.0, 0.0, 1.0}}) {
        for (const double angle : {180.0, 179.999, 180.001, 0.0}) {
            Cell cell(3);
            cell.x_.rotation = Cell::turn(angle * kDegree, about);
            cell.look_around(15);
            expect_close(calibrate_hand_eye("poses.csv", cell.views), cell);
        }
    }
}

TEST(HandEye, MotionsOfHalfATurnAreAsGood) {
    Cell cell(4);
    for (int i = 0; i < 12; ++i) {
        cell.look(0.3 * std::sin(i), 0.3 * std::cos(1.7 * i), i % 2 == 0 ? 0.0 : std::numbers::pi);
    }
    expect_close(calibrate_hand_eye("poses.csv", cell.views), cell);
}

TEST(HandEye, NamesOneBadPose) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        Cell cell(seed);
        cell.look_around(15);
        HandEyeView& bad = cell.views[seed * 2];
        bad.b_from_f.translation = bad.b_from_f.translation + Vec3{6e-4, -6e-4, 5e-4};
        bad.b_from_f.rotation = Cell::turn(0.2 * kDegree, {1.0, 2.0, -1.0}) * bad.b_from_f.rotation;
        const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
        EXPECT_EQ(r.bad_poses, std::vector<std::string>{bad.name});
        expect_close(r, cell);
        EXPECT_NEAR(r.views[seed * 2].place_off, 1e-3, 3e-4);
    }
}

TEST(HandEye, NamesAPoseThatIsFarOff) {
    Cell cell(2);
    cell.look_around(10);
    cell.views[4].b_from_f.rotation = Cell::turn(40.0 * kDegree, {1.0, 2.0, -1.0}) * cell.views[4].b_from_f.rotation;
    cell.views[7].b_from_f.translation.x += 0.1;
    HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
    std::ranges::sort(r.bad_poses);
    EXPECT_EQ(r.bad_poses, (std::vector<std::string>{"5", "8"}));
    expect_close(r, cell);
}

TEST(HandEye, PutsSwappedAndMisnumberedMarkersRight) {
    Cell cell(6);
    cell.look_around(15);
    for (const std::size_t i : {1U, 4U, 5U, 9U, 12U}) {
        std::swap(cell.views[i].markers[i % 12].id, cell.views[i].markers[(i + 5) % 12].id);
    }
    cell.views[2].markers[3].place = cell.views[2].markers[3].place + Vec3{0.0, 2e-3, 0.0};
    const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
    ASSERT_EQ(r.markers.size(), 6U);
    int swapped = 0;
    for (const MarkerFinding& m : r.markers) {
        swapped += m.kind == MarkerFinding::Kind::swapped ? 1 : 0;
        if (m.kind == MarkerFinding::Kind::wrong) {
            EXPECT_EQ(m.view, "3");
            EXPECT_EQ(m.id, 4);
        }
    }
    EXPECT_EQ(swapped, 5);
    EXPECT_TRUE(r.bad_poses.empty());
    expect_close(r, cell);
}

TEST(HandEye, RefusesMotionsThatDoNotShowTheSensor) {
    Cell straight(7);
    for (int i = 0; i < 8; ++i) {
        straight.look(0.1, 0.2, 0.3, {0.01 * i, 0.02 * (i % 3), 0.0});
    }
    EXPECT_NE(refusal(straight).find("without turning"), std::string::npos) << refusal(straight);
    Cell one_axis(7);
    for (int i = 0; i < 8; ++i) {
        one_axis.look(0.0, 0.0, 0.3 * i, {0.01 * i, 0.02 * (i % 3), 0.0});
    }
    EXPECT_NE(refusal(one_axis).find("one axis"), std::string::npos) << refusal(one_axis);
    // The direction that is named is that of the axis in the flange.
    const Vec3 blind = one_axis.x_.rotation * Vec3{0.0, 0.0, 1.0};
    const std::string text = refusal(one_axis);
    const auto digits = [](double v) { return std::to_string(std::abs(v)).substr(0, 3); };
    EXPECT_NE(text.find(digits(blind.x)), std::string::npos) << text << blind.x;
    EXPECT_NE(text.find(digits(blind.z)), std::string::npos) << text << blind.z;
    Cell two(7);
    two.look_around(2);
    EXPECT_NE(refusal(two).find("too few views"), std::string::npos);
}

TEST(HandEye, NearlyPlanarMotionSaysHowUncertainItIs) {
    Cell cell(8);
    for (int i = 0; i < 15; ++i) {
        cell.look(0.009 * std::sin(3.0 * i), 0.009 * std::cos(5.0 * i), 0.14 * (i - 7));
    }
    const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
    EXPECT_GT(r.place_sigma, 1e-4);
    EXPECT_LT(norm(r.f_from_c.translation - cell.x_.translation), 4.0 * r.place_sigma);
}

TEST(HandEye, NoticesPosesThatAreInverted) {
    Cell cell(9);
    cell.look_around(12);
    for (HandEyeView& view : cell.views) {
        const auto back = view.b_from_f.inverse();
        view.b_from_f = {back.rotation, back.translation};
    }
    const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views);
    EXPECT_TRUE(r.robot_inverted);
    ASSERT_FALSE(r.notes.empty());
    EXPECT_NE(r.notes[0].find("inverted"), std::string::npos);
    expect_close(r, cell);
}

TEST(HandEye, NoticesAListThatIsShifted) {
    Cell cell(10);
    cell.look_around(12);
    for (std::size_t i = 0; i + 1 < cell.views.size(); ++i) {
        cell.views[i].markers = cell.views[i + 1].markers;
    }
    cell.views.pop_back();
    EXPECT_NE(refusal(cell).find("1 row after"), std::string::npos) << refusal(cell);
}

TEST(HandEye, NoiseThatIsNotStatedComesFromTheData) {
    Cell cell(11);
    cell.noise = 8.0;
    cell.look_around(25);
    HandEyeOptions options;
    options.noise.fit = true;
    const HandEyeResult r = calibrate_hand_eye("poses.csv", cell.views, options);
    EXPECT_NEAR(r.robot_ratio, 8.0, 2.5);
    EXPECT_NEAR(r.marker_ratio, 8.0, 1.0);
    EXPECT_TRUE(r.bad_poses.empty());
    expect_close(r, cell, 8.0);
}

}  // namespace
}  // namespace sc::host
