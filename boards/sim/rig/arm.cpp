// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/arm.hpp"

#include <cmath>
#include <utility>

namespace sc::sim {
namespace {

constexpr double kStep = 1e-6;
constexpr int kRounds = 60;
constexpr double kThere = 1e-10;

using Six = std::array<double, 6>;

/// Turn and shift from `now` to `goal`.
Six off(const Pose& goal, const Pose& now) {
    const Mat3 d = goal.rotation * now.rotation.transposed();
    const Vec3 axial{d.row[2].y - d.row[1].z, d.row[0].z - d.row[2].x, d.row[1].x - d.row[0].y};
    const Vec3 place = goal.place - now.place;
    // Near a half turn this points the right way, if too short: enough to walk along.
    return {0.5 * axial.x, 0.5 * axial.y, 0.5 * axial.z, place.x, place.y, place.z};
}

/// Solves m x = b by elimination with pivots.
Six solve(std::array<Six, 6> m, Six b) {
    for (std::size_t p = 0; p < 6; ++p) {
        std::size_t best = p;
        for (std::size_t r = p + 1; r < 6; ++r) {
            best = std::abs(m[r][p]) > std::abs(m[best][p]) ? r : best;
        }
        std::swap(m[p], m[best]);
        std::swap(b[p], b[best]);
        for (std::size_t r = p + 1; r < 6; ++r) {
            const double factor = m[r][p] / m[p][p];
            for (std::size_t c = p; c < 6; ++c) {
                m[r][c] -= factor * m[p][c];
            }
            b[r] -= factor * b[p];
        }
    }
    for (std::size_t p = 6; p-- > 0;) {
        for (std::size_t c = p + 1; c < 6; ++c) {
            b[p] -= m[p][c] * b[c];
        }
        b[p] /= m[p][p];
    }
    return b;
}

double size_of(const Six& v) {
    double sum = 0.0;
    for (const double x : v) {
        sum += x * x;
    }
    return std::sqrt(sum);
}

}  // namespace

Pose Arm::at(const Joints& joints) const {
    Pose out{Mat3::identity(), {}};
    for (std::size_t i = 0; i < 6; ++i) {
        const Link& l = link[i];
        out = out * Pose{turn_about({0.0, 0.0, joints[i] + l.theta}), {0.0, 0.0, l.d}} *
              Pose{turn_about({l.alpha, 0.0, 0.0}), {l.a, 0.0, 0.0}};
    }
    return out;
}

std::optional<Joints> Arm::reach(const Pose& b_from_f, const Joints& start) const {
    Joints now = start;
    double damping = 1e-3;
    Six error = off(b_from_f, at(now));
    for (int round = 0; round < kRounds; ++round) {
        if (size_of(error) < kThere) {
            return now;
        }
        std::array<Six, 6> columns{};  // d pose / d joint
        for (std::size_t j = 0; j < 6; ++j) {
            Joints stepped = now;
            stepped[j] += kStep;
            const Six moved = off(at(stepped), at(now));
            for (std::size_t i = 0; i < 6; ++i) {
                columns[j][i] = moved[i] / kStep;
            }
        }
        std::array<Six, 6> normal{};
        Six right{};
        for (std::size_t r = 0; r < 6; ++r) {
            for (std::size_t i = 0; i < 6; ++i) {
                right[r] += columns[r][i] * error[i];
                for (std::size_t c = 0; c < 6; ++c) {
                    normal[r][c] += columns[r][i] * columns[c][i];
                }
            }
            normal[r][r] += damping;
        }
        const Six step = solve(normal, right);
        Joints next = now;
        for (std::size_t j = 0; j < 6; ++j) {
            next[j] += step[j];
        }
        const Six then = off(b_from_f, at(next));
        if (size_of(then) < size_of(error)) {
            now = next;
            error = then;
            damping *= 0.1;
        } else {
            damping = damping * 10.0 + 1e-9;
        }
    }
    return std::nullopt;
}

Arm nominal_arm() {
    constexpr double kQuarter = 90.0 * kDegree;
    return {{Arm::Link{0.0, 0.45, 0.15, -kQuarter}, Arm::Link{-kQuarter, 0.0, 0.65, 0.0},
             Arm::Link{0.0, 0.0, 0.115, -kQuarter}, Arm::Link{0.0, 0.70, 0.0, kQuarter},
             Arm::Link{0.0, 0.0, 0.0, -kQuarter}, Arm::Link{0.0, 0.085, 0.0, 0.0}}};
}

Arm with_errors(Arm arm, double length, double angle, Random& random) {
    for (Arm::Link& l : arm.link) {
        l.theta += angle * normal_draw(random);
        l.d += length * normal_draw(random);
        l.a += length * normal_draw(random);
        l.alpha += angle * normal_draw(random);
    }
    return arm;
}

}  // namespace sc::sim
