// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/error_predictor.hpp"

#include <cstddef>

namespace sc::motion {
namespace {

constexpr double kTwoPi = 6.2831853071795862;
constexpr int kRounds = 400;
using Square = std::array<std::array<double, 3>, 3>;

Square times(const Square& a, const Square& b) noexcept {
    Square out{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    return out;
}

Square transposed(const Square& a) noexcept {
    Square out{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            out[i][j] = a[j][i];
        }
    }
    return out;
}

}  // namespace

ErrorPredictor::ErrorPredictor(const Design& design) noexcept {
    const double t = design.sample_s;
    const double omega = kTwoPi * design.bandwidth_hz;
    const double omega2 = omega * omega;
    swing2_ = 0.6 * omega2;
    const double jerk = 0.5 * design.amplitude * design.amplitude * omega2 * omega2 * omega2 * (4.0 / 175.0) /
                        (design.bandwidth_hz * t);
    const double noise = design.grid * design.grid * (1.0 / 12.0);
    const Way way = way_of(t);
    const Square step{
        {{1.0, way.once, way.twice}, {0.0, way.cosine, way.once}, {0.0, -swing2_ * way.once, way.cosine}}};
    const Square back = transposed(step);
    const std::array<double, 3> drive{t * t * t * (1.0 / 6.0), 0.5 * t * t, t};
    const double a = design.amplitude * design.amplitude;
    Square p{{{a, 0.0, 0.0}, {0.0, a * omega2, 0.0}, {0.0, 0.0, a * omega2 * omega2}}};
    for (int round = 0; round < kRounds; ++round) {
        p = times(times(step, p), back);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                p[i][j] += drive[i] * drive[j] * jerk;
            }
        }
        const double scale = 1.0 / (p[0][0] + noise);
        const std::array<double, 3> row = p[0];
        for (std::size_t i = 0; i < 3; ++i) {
            gain_[i] = p[i][0] * scale;
        }
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                p[i][j] -= gain_[i] * row[j];
            }
        }
    }
}

void ErrorPredictor::sample(double error, double elapsed_s) noexcept {
    const Way way = way_of(elapsed_s);
    const double place = state_[0] + (way.once * state_[1] + way.twice * state_[2]);
    const double speed = way.cosine * state_[1] + way.once * state_[2];
    const double acceleration = way.cosine * state_[2] - swing2_ * (way.once * state_[1]);
    const double more = error - place;
    state_ = {place + gain_[0] * more, speed + gain_[1] * more, acceleration + gain_[2] * more};
}

}  // namespace sc::motion
