// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/frame_polynomial.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "shared/machine/machine.hpp"

namespace sc::laser {
namespace {

using trajectory::Quintic;

/// A mirror's piece: centimetres, 2 m/s, 8000 m/s², 8e7 m/s³ and a little of what is above.
Quintic piece(std::mt19937_64& random, bool cubic) {
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    return {0.05 * one(random),
            2.0 * one(random),
            4000.0 * one(random),
            1.3e7 * one(random),
            cubic ? 0.0 : 1e10 * one(random),
            cubic ? 0.0 : 1e13 * one(random)};
}

template <std::size_t kDegree>
double worst_over_a_tick(bool cubic, double rate) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> begins(0.0, 2e-3);
    const double step = 1e-5 * rate;
    double worst = 0.0;
    for (int i = 0; i < 2'000; ++i) {
        const Quintic q = piece(random, cubic);
        const double begin = begins(random);
        FrameValues<kDegree> values(over_frames<kDegree>(q, begin, step));
        for (int k = 0; k < 100; ++k) {
            worst = std::max(worst, std::abs(values.value() - trajectory::value(q, begin + k * step)));
            values.next();
        }
    }
    return worst;
}

TEST(FramePolynomial, FramesAreThePiecesPlacesToAPicometre) {
    EXPECT_LT(worst_over_a_tick<5>(false, 1.0), 1e-12);
    EXPECT_LT(worst_over_a_tick<5>(true, 1.0), 1e-12);
    EXPECT_LT(worst_over_a_tick<3>(true, 1.0), 1e-12);
    EXPECT_LT(worst_over_a_tick<5>(false, 0.3), 1e-12);
}

/// What a second-order servo makes of the led places, integrated in steps of 0.1 µs, is the places themselves.
TEST(FramePolynomial, AServoFedWithTheLedPlacesFollowsThePlaces) {
    GalvoConfig galvo;
    galvo.natural_frequency = Frequency::from_si(2000.0);
    galvo.damping = 0.75;
    const GalvoLead lead = galvo_lead(galvo, 0);
    const double omega = 2.0 * 3.14159265358979324 * 2000.0;
    EXPECT_NEAR(lead.per_velocity, 1.5 / omega, 1e-15);
    EXPECT_NEAR(lead.per_acceleration, 1.0 / (omega * omega), 1e-18);
    const Quintic q{0.001, 1.2, 3500.0, -1.1e7, 4e9, -6e11};
    constexpr double kFrame = 1e-5;
    const auto place = over_frames<5>(q, 0.0, kFrame);
    const auto fed = led<5>(place, lead.per_velocity / kFrame, lead.per_acceleration / (kFrame * kFrame));
    constexpr double kStep = 1e-7;
    double x = q[0];
    double v = q[1];
    const auto force = [&](double t, double at, double speed) {
        return omega * omega * (value<5>(fed, t / kFrame) - at) - 1.5 * omega * speed;
    };
    for (int i = 0; i < 10'000; ++i) {
        const double t = kStep * i;
        const double half_x = x + 0.5 * kStep * v;
        const double half_v = v + 0.5 * kStep * force(t, x, v);
        x += kStep * half_v;
        v += kStep * force(t + 0.5 * kStep, half_x, half_v);
        ASSERT_NEAR(x, trajectory::value(q, t + kStep), 2e-10) << i;
    }
    EXPECT_GT(std::abs(value<5>(fed, 50.0) - value<5>(place, 50.0)), 1e-4) << "a lead of hundreds of micrometres";
}

TEST(FramePolynomial, StandsExactlyAtRateZero) {
    const Quintic q{0.01, 1.5, -300.0, 1e6, 2e8, -3e11};
    FrameValues<5> values(over_frames<5>(q, 1e-3, 0.0));
    const double first = values.value();
    EXPECT_NEAR(first, trajectory::value(q, 1e-3), 1e-15);
    for (int k = 0; k < 100; ++k) {
        ASSERT_EQ(values.value(), first);
        values.next();
    }
}

}  // namespace
}  // namespace sc::laser
