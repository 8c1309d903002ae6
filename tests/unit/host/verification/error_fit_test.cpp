// SPDX-License-Identifier: Apache-2.0
#include "host/verification/error_fit.hpp"

#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

struct TrueErrors {
    Vec3 offset;
    double rotation = 0.0;
    double squareness_xz = 0.0;
    double squareness_yz = 0.0;
    double tilt_yx = 0.0;
    double scale_x = 0.0;
    double scale_z = 0.0;
};

std::vector<ErrorSample> samples(const TrueErrors& e, double noise, unsigned seed, int count = 36) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> x(-0.35, -0.15);
    std::uniform_real_distribution<double> z(-0.445, -0.26);
    std::normal_distribution<double> scatter(0.0, 1.0);
    std::vector<ErrorSample> list;
    for (int i = 0; i < count; ++i) {
        const Vec3 p{x(random), -0.3, z(random)};
        const Vec3 error{e.offset.x + e.scale_x * p.x + (e.squareness_xz - e.rotation) * p.z,
                         e.offset.y + e.tilt_yx * p.x + e.squareness_yz * p.z,
                         e.offset.z + e.rotation * p.x + e.scale_z * p.z};
        const Vec3 n{noise * scatter(random), noise * scatter(random), noise * scatter(random)};
        list.push_back({p, p + error + n});
    }
    return list;
}

std::map<std::string_view, FoundError> by_name(const ErrorFit& fit) {
    std::map<std::string_view, FoundError> out;
    for (const FoundError& error : fit.errors) {
        out[error.name] = error;
    }
    return out;
}

TEST(ErrorFit, FindsEveryErrorWithoutNoise) {
    const TrueErrors truth{{50e-6, -7e-6, 11e-6}, 0.03e-3, 0.1e-3, -0.05e-3, 0.02e-3, 12e-6, -9e-6};
    const ErrorFit fit = fit_errors(samples(truth, 0.0, 1));
    auto found = by_name(fit);
    EXPECT_NEAR(found["offset_x"].value, 50.0, 1e-6);
    EXPECT_NEAR(found["offset_y"].value, -7.0, 1e-6);
    EXPECT_NEAR(found["offset_z"].value, 11.0, 1e-6);
    EXPECT_NEAR(found["rotation"].value, 0.03, 1e-9);
    EXPECT_NEAR(found["squareness_xz"].value, 0.1, 1e-9);
    EXPECT_NEAR(found["squareness_yz"].value, -0.05, 1e-9);
    EXPECT_NEAR(found["tilt_yx"].value, 0.02, 1e-9);
    EXPECT_NEAR(found["scale_x"].value, 12.0, 1e-6);
    EXPECT_NEAR(found["scale_z"].value, -9.0, 1e-6);
    EXPECT_LT(fit.rms_um, 1e-6);
}

TEST(ErrorFit, SigmaIsWhatTheScatterOfManyFitsShows) {
    const TrueErrors truth{{50e-6, 0.0, 0.0}, 0.0, 0.1e-3, 0.0, 0.0, 0.0, 0.0};
    std::map<std::string_view, double> squares;
    std::map<std::string_view, double> sigma;
    const std::map<std::string_view, double> expected{{"offset_x", 50.0}, {"squareness_xz", 0.1}, {"scale_z", 0.0}};
    constexpr unsigned kTrials = 300;
    for (unsigned seed = 1; seed <= kTrials; ++seed) {
        auto found = by_name(fit_errors(samples(truth, 2e-6, seed)));
        for (const auto& [name, value] : expected) {
            squares[name] += std::pow(found[name].value - value, 2) / kTrials;
            sigma[name] += std::pow(found[name].sigma, 2) / kTrials;
        }
    }
    for (const auto& [name, value] : expected) {
        EXPECT_NEAR(std::sqrt(squares[name] / sigma[name]), 1.0, 0.15) << name;
    }
}

TEST(ErrorFit, FewSamplesShowOffsetsAlone) {
    const TrueErrors truth{{50e-6, 0.0, -3e-6}, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    const ErrorFit fit = fit_errors(samples(truth, 0.0, 1, 3));
    auto found = by_name(fit);
    EXPECT_EQ(fit.errors.size(), 3U);
    EXPECT_NEAR(found["offset_x"].value, 50.0, 1e-6);
    EXPECT_NEAR(found["offset_z"].value, -3.0, 1e-6);
}

TEST(ErrorFit, SamplesOnOneHeightShowOffsetsAlone) {
    std::vector<ErrorSample> list;
    for (int i = 0; i < 10; ++i) {
        const Vec3 p{-0.3 + 0.01 * i, -0.3, -0.4 + 1e-4 * i};
        list.push_back({p, p + Vec3{1e-6, 0.0, 0.0}});
    }
    EXPECT_EQ(fit_errors(list).errors.size(), 3U);
}

TEST(ErrorFit, NoSamplesShowNothing) { EXPECT_TRUE(fit_errors({}).errors.empty()); }

TEST(ErrorFit, OneSampleIsItsOwnOffset) {
    const ErrorFit fit = fit_errors(samples({{5e-6, 0.0, 0.0}, 0, 0, 0, 0, 0, 0}, 0.0, 1, 1));
    ASSERT_EQ(fit.errors.size(), 3U);
    EXPECT_NEAR(fit.errors[0].value, 5.0, 1e-6);
    EXPECT_EQ(fit.worst_um, 0.0);
}

}  // namespace
}  // namespace sc::host
