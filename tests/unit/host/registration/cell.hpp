// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "host/registration/chain.hpp"

/// A cell with a ring of markers that stand still, markers that turn with the table, and a beam that points. Rotations
/// by quaternions alone, so that nothing is shared with the estimators.

namespace sc::host::test {

constexpr double kDegree = 0.017453292519943295;

inline Mat3 turn(double angle, const Vec3& about) {
    const double s = std::sin(0.5 * angle) / norm(about);
    return rotation_of_quaternion({std::cos(0.5 * angle), s * about.x, s * about.y, s * about.z});
}

class Cell {
public:
    explicit Cell(unsigned seed, double sigma = 7.5e-6) : random_(seed), sigma_(sigma) {
        for (int k = 0; k < 16; ++k) {
            const double a = 22.5 * kDegree * k;
            still_.push_back({100 + k, {0.4 * std::cos(a), 0.4 * std::sin(a), 0.02 * (k % 5)}});
        }
        for (int k = 0; k < 9; ++k) {
            still_.push_back(
                {300 + k, {0.07 * (k % 3) - 0.07, 0.2 + 0.005 * (k % 2), 0.05 * (k / 3) + 0.02 + 0.003 * k}});
        }
        for (int k = 0; k < 8; ++k) {
            turning_.push_back({k + 1, {0.05 * (k % 3) - 0.06, 0.04 * (k / 3) - 0.05, 0.05 + 0.017 * k}});
        }
        for (const Marker& m : still_) {
            input.still.insert(m.id);
        }
        input.file = "cell.toml";
        input.pointing_file = "pointing.csv";
    }

    ChainInput input;
    Vec3 axis_at{0.01, -0.02, 0.0};
    Vec3 axis = unit({0.01, 0.02, 1.0});
    Rigid<frame::H, frame::C> h_from_ground{turn(0.4, {0.0, 0.1, 1.0}), {-0.3, -0.5, -0.4}};

    /// A view from `azimuth`; it sees the markers of the ring on its side, of the mobile target, and of the table.
    void look(double azimuth, double c_deg) {
        const Vec3 back{std::cos(azimuth) * 0.8, std::sin(azimuth) * 0.8, 0.6};
        const Vec3 x = unit({-back.y, back.x, 0.0});
        const Mat3 r = Mat3{{x, cross(-back, x), -back}}.transposed();  // columns: right, down, forward
        poses.push_back({r, 0.6 * back});
        ChainView view;
        view.seen.line = static_cast<int>(input.views.size()) + 2;
        view.seen.view = "v" + std::to_string(input.views.size() + 1);
        view.seen.turn = c_deg * kDegree;
        for (const Marker& m : still_) {
            if (m.id >= 300 || std::cos(std::atan2(m.place.y, m.place.x) - azimuth) > 0.0) {
                add(view, m.id, m.place);
            }
        }
        const double angle = c_deg * kDegree + draw(8.73e-6).x;
        for (const Marker& m : turning_) {
            add(view, m.id, axis_at + turn(angle, axis) * (m.place - axis_at));
        }
        input.views.push_back(view);
    }
    void look_around(int views, double arc_deg = 360.0) {
        for (int i = 0; i < views; ++i) {
            look(0.5 * std::sin(2.0 * i), arc_deg * i / views);
        }
    }
    /// The beam is pointed at the mobile target's markers.
    void point(double sigma = 1e-5) {
        MarkerView view;
        view.view = "h";
        for (const Marker& m : still_) {
            if (m.id >= 300) {
                const Vec3 h = (h_from_ground * Point<frame::C>{m.place}).v;
                view.markers.push_back({m.id, m.id, h + draw(sigma), {sigma, sigma, sigma}});
            }
        }
        input.pointing.push_back(view);
    }
    /// True place in h of a marker of the table at an angle.
    [[nodiscard]] Vec3 in_h(int id, double c_deg) const {
        const Vec3 zero = turning_.at(static_cast<std::size_t>(id) - 1).place;
        return (h_from_ground * Point<frame::C>{axis_at + turn(c_deg * kDegree, axis) * (zero - axis_at)}).v;
    }
    /// True place of view `i` in the frame of the first.
    [[nodiscard]] Vec3 origin(std::size_t i) const {
        return (Rigid<frame::C, frame::C>{poses[0].rotation, poses[0].translation}.inverse() *
                Point<frame::C>{poses[i].translation})
            .v;
    }
    Vec3 draw(double sigma) {
        std::normal_distribution<double> normal;
        const double x = normal(random_);
        const double y = normal(random_);
        return {sigma * x, sigma * y, sigma * normal(random_)};
    }
    static Vec3 unit(const Vec3& v) { return (1.0 / norm(v)) * v; }

    struct Marker {
        int id = 0;
        Vec3 place;
    };
    std::vector<Rigid<frame::C, frame::C>> poses;

private:
    void add(ChainView& view, int id, const Vec3& place) {
        const Vec3 seen = (poses.back().inverse() * Point<frame::C>{place}).v;
        view.seen.markers.push_back({view.seen.line, id, seen + draw(sigma_), {sigma_, sigma_, sigma_}});
    }
    std::mt19937_64 random_;
    double sigma_;
    std::vector<Marker> still_;
    std::vector<Marker> turning_;
};

}  // namespace sc::host::test
