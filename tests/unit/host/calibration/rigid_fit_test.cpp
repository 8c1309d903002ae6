// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/rigid_fit.hpp"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

Mat3 turn(double angle, const Vec3& about) {
    const double s = std::sin(0.5 * angle) / norm(about);
    return rotation_of_quaternion({std::cos(0.5 * angle), s * about.x, s * about.y, s * about.z});
}

/// Markers in two frames, with noise of their own along each axis.
struct Pair {
    std::vector<SeenMarker> to;
    std::vector<SeenMarker> from;
    Mat3 rotation = turn(2.2, {0.4, -0.3, 0.9});
    Vec3 translation{0.2, -0.4, 0.7};

    explicit Pair(unsigned seed, int count = 12, const Vec3& to_sigma = {1e-5, 2.5e-6, 1e-5},
                  const Vec3& from_sigma = {7.5e-6, 7.5e-6, 1.5e-5}) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> even(-0.1, 0.1);
        std::normal_distribution<double> normal;
        for (int k = 0; k < count; ++k) {
            const double x = even(random);
            const double y = even(random);
            const Vec3 place{x, y, 0.005 * (k % 3)};
            const auto noisy = [&](const Vec3& p, const Vec3& s) {
                const double a = s.x * normal(random);
                const double b = s.y * normal(random);
                return p + Vec3{a, b, s.z * normal(random)};
            };
            from.push_back({k + 2, k + 1, noisy(place, from_sigma), from_sigma});
            to.push_back({k + 2, k + 1, noisy(rotation * place + translation, to_sigma), to_sigma});
        }
    }
};

std::string refusal(const std::function<void()>& work) {
    try {
        work();
    } catch (const InputError& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST(RigidFit, WithoutNoiseItIsExact) {
    Pair pair(1, 5, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
    const RigidFit fit = fit_rigid("h.csv", pair.to, pair.from);
    EXPECT_LT(norm(fit.translation - pair.translation), 1e-12);
    for (std::size_t r = 0; r < 3; ++r) {
        EXPECT_LT(norm(fit.rotation.row[r] - pair.rotation.row[r]), 1e-12);
    }
    EXPECT_LT(fit.rms, 1e-12);
}

TEST(RigidFit, CovarianceHoldsAndChiSquaredIsThatOfTheFreedom) {
    double inside = 0.0;
    double chi = 0.0;
    constexpr int kSets = 200;
    for (unsigned seed = 1; seed <= kSets; ++seed) {
        Pair pair(seed);
        const RigidFit fit = fit_rigid("h.csv", pair.to, pair.from, {.find_wrong = false});
        chi += fit.chi_squared / fit.freedom / kSets;
        // δt of T = Exp(ξ)·T̂ is ξ_t + ξ_r × t; the place where t is steadiest is the markers' middle: look there.
        const Vec3 at = fit.rotation * Vec3{0.0, 0.0, 0.005} + fit.translation;
        const Vec3 off = pair.rotation * Vec3{0.0, 0.0, 0.005} + pair.translation - at;
        const auto& c = fit.covariance.at;
        // x of the place: ξ_tx + ξ_ry·z − ξ_rz·y
        const double j[6] = {0.0, at.z, -at.y, 1.0, 0.0, 0.0};
        double variance = 0.0;
        for (std::size_t a = 0; a < 6; ++a) {
            for (std::size_t b = 0; b < 6; ++b) {
                variance += j[a] * c[a][b] * j[b];
            }
        }
        inside += std::abs(off.x) < 1.96 * std::sqrt(variance) ? 1.0 : 0.0;
    }
    EXPECT_GT(inside / kSets, 0.90);
    EXPECT_LT(inside / kSets, 0.99);
    EXPECT_NEAR(chi, 1.0, 0.05);
}

TEST(RigidFit, WrongMarkersAreLeftOutAndTheRestFits) {
    Pair pair(3);
    pair.from[2].place = pair.from[2].place + Vec3{1e-3, 0.0, 0.0};
    pair.to[7].place = pair.to[7].place + Vec3{0.0, 0.0, -4e-3};
    const RigidFit fit = fit_rigid("h.csv", pair.to, pair.from);
    for (const RigidMarker& m : fit.markers) {
        EXPECT_EQ(m.used, m.id != 3 && m.id != 8) << m.id;
    }
    EXPECT_EQ(fit.freedom, 24.0);
}

TEST(RigidFit, IdsOfOneCloudAloneCountForNothing) {
    Pair pair(4);
    pair.to.push_back({99, 99, {5.0, 5.0, 5.0}, {}});
    std::swap(pair.from[0], pair.from[5]);
    EXPECT_EQ(fit_rigid("h.csv", pair.to, pair.from).markers.size(), 12U);
}

TEST(RigidFit, WhatCannotSupportATransformIsRefused) {
    Pair pair(5);
    pair.to.resize(2);
    EXPECT_NE(refusal([&] { (void)fit_rigid("h.csv", pair.to, pair.from); }).find("h.csv: has fewer than three"),
              std::string::npos);
    std::vector<SeenMarker> line;
    for (int k = 0; k < 5; ++k) {
        line.push_back({0, k, {0.0, 0.1 * k, 0.0}, {}});
    }
    const std::string text = refusal([&] { (void)fit_rigid("h.csv", line, line); });
    EXPECT_NE(text.find("line"), std::string::npos) << text;
    EXPECT_NE(text.find("1.00, 0.00)"), std::string::npos) << text;
    Pair shuffled(6);
    for (std::size_t k = 0; k < shuffled.to.size(); ++k) {
        shuffled.to[k].id = static_cast<int>((5 * k + 3) % 12) + 1;
    }
    EXPECT_NE(refusal([&] { (void)fit_rigid("h.csv", shuffled.to, shuffled.from); }).find("transform"),
              std::string::npos);
    Pair loose(7, 4, {0.05, 0.05, 0.05}, {0.05, 0.05, 0.05});
    EXPECT_NE(refusal([&] { (void)fit_rigid("h.csv", loose.to, loose.from, {.find_wrong = false}); }).find("1 sigma"),
              std::string::npos);
}

TEST(RigidFit, DataThatScatterMoreThanStatedRaiseTheUncertainty) {
    Pair pair(8, 20);
    const RigidFit stated = fit_rigid("h.csv", pair.to, pair.from, {.find_wrong = false});
    for (auto* cloud : {&pair.to, &pair.from}) {
        for (SeenMarker& m : *cloud) {
            m.sigma = 0.2 * m.sigma;
        }
    }
    const RigidFit raised = fit_rigid("h.csv", pair.to, pair.from, {.find_wrong = false});
    EXPECT_EQ(stated.raised, 1.0);
    EXPECT_NEAR(raised.raised, 5.0, 1.0);
}

}  // namespace
}  // namespace sc::host
