// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "host/calibration/galvo_fit.hpp"
#include "host/calibration/galvo_model.hpp"

namespace sc::host {
namespace {

using Model = GalvoModel;

/// A head as a workshop has it: nothing is nominal.
Model workshop_head() {
    Model model;
    model.value = {35e-6,   -22e-6, 1.003, 0.998, 1.5e-3, 0.4e-3, 0.1598, -0.9e-3,
                   -0.0195, -0.006, 5.3,   5.9,   4.0,    2e-4,   -1.5e-4};
    return model;
}

/// Something that the ray model has not: 4 µm, over some 70 mm.
FieldPlace ripple(const FieldPlace& c) {
    return {4e-6 * std::sin(90.0 * c[0] + 0.6) * std::cos(90.0 * c[1]), -4e-6 * std::cos(90.0 * c[0])};
}

std::vector<CrossObservation> crosses(const Model& truth, double sigma, unsigned seed, bool with_ripple = false,
                                      double depth = 1.5e-3) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<CrossObservation> out;
    for (const double d : {-depth, 0.0, depth}) {
        for (int j = -7; j <= 7; ++j) {
            for (int i = -7; i <= 7; ++i) {
                const FieldPlace c{i * 0.0083, j * 0.0083};
                FieldPlace at = truth.land(c, d);
                const FieldPlace more = with_ripple ? ripple(c) : FieldPlace{};
                at = {at[0] + more[0] + sigma * normal(random), at[1] + more[1] + sigma * normal(random)};
                out.push_back({static_cast<int>(out.size()) + 1, c, at, d, std::max(sigma, 1e-7)});
            }
        }
    }
    return out;
}

/// Largest distance between a fitted model and the truth over the field.
double worst(const Model& fitted, const Model& truth, bool with_ripple = false) {
    double most = 0.0;
    for (double x = -0.055; x <= 0.0551; x += 0.005) {
        for (double z = -0.055; z <= 0.0551; z += 0.005) {
            for (const double d : {-1e-3, 0.0, 1e-3}) {
                const FieldPlace a = fitted.land({x, z}, d);
                const FieldPlace b = truth.land({x, z}, d);
                const FieldPlace more = with_ripple ? ripple({x, z}) : FieldPlace{};
                most = std::max(most, std::hypot(a[0] - b[0] - more[0], a[1] - b[1] - more[1]));
            }
        }
    }
    return most;
}

TEST(GalvoModel, HasTheKnownDistortionOfATwoMirrorHead) {
    const Model ideal;
    for (const auto& [degrees, x, z] : {std::tuple{20.0, 56.962, 53.527}, std::tuple{10.0, 28.066, 27.640}}) {
        const double c = 0.160 * degrees * M_PI / 180.0;
        EXPECT_NEAR(ideal.land({c, c}, 0.0)[0] * 1e3, x, 5e-4);
        EXPECT_NEAR(ideal.land({c, c}, 0.0)[1] * 1e3, z, 5e-4);
    }
}

TEST(GalvoModel, LandsFurtherInOnASurfaceNearerToTheHead) {
    const Model ideal;
    EXPECT_NEAR(ideal.land({0.016, 0.0}, 1e-3)[0], 0.016 - 1e-4, 1e-9);
    EXPECT_NEAR(ideal.land({0.016, 0.0}, -1e-3)[0], 0.016 + 1e-4, 1e-9);
}

TEST(GalvoModel, CommandForIsTheInverse) {
    const Model model = workshop_head();
    for (double x = -0.060; x <= 0.0601; x += 0.01) {
        for (double z = -0.060; z <= 0.0601; z += 0.01) {
            const FieldPlace back = model.land(model.command_for({x, z}), 0.0);
            ASSERT_NEAR(back[0], x, 1e-9);
            ASSERT_NEAR(back[1], z, 1e-9);
        }
    }
    EXPECT_THROW(static_cast<void>(model.command_for({0.6, 0.6})), std::domain_error);
}

TEST(GalvoModel, ItsFieldIsSoundAndHoldsTheInverse) {
    const Model model = workshop_head();
    const GalvoField field = model.field();
    EXPECT_TRUE(sound(field));
    const double cell = 2.0 * field.half / static_cast<double>(GalvoField::kCells);
    double most = 0.0;
    for (double x = -0.0549; x < 0.055; x += 0.0033) {
        for (double z = -0.0549; z < 0.055; z += 0.0033) {
            const auto cx = static_cast<std::size_t>((x + field.half) / cell);
            const auto cz = static_cast<std::size_t>((z + field.half) / cell);
            const auto wx = spline_weights((x + field.half) / cell - static_cast<double>(cx)).value;
            const auto wz = spline_weights((z + field.half) / cell - static_cast<double>(cz)).value;
            FieldPlace got{};
            for (std::size_t j = 0; j < 4; ++j) {
                for (std::size_t i = 0; i < 4; ++i) {
                    const std::size_t node = 2 * ((cz + j) * GalvoField::kSide + cx + i);
                    got[0] += wz[j] * wx[i] * field.node[node];
                    got[1] += wz[j] * wx[i] * field.node[node + 1];
                }
            }
            const FieldPlace exact = model.command_for({x, z});
            most = std::max(most, std::hypot(got[0] - exact[0], got[1] - exact[1]));
        }
    }
    // f2 t² makes a kink at the centre, which no spline follows.
    EXPECT_LT(most, 0.1e-6);
}

TEST(GalvoModel, GoesThroughItsRecord) {
    Model model = workshop_head();
    model.residual_half = 0.06;
    model.residual_side = 4;
    model.residual.assign(16, {1e-6, -2e-6});
    EXPECT_EQ(Model::from(model.record()), model);
}

TEST(GalvoFit, FindsTheHeadWithoutNoise) {
    const Model truth = workshop_head();
    const GalvoFit fit = fit_galvo(crosses(truth, 0.0, 1));
    EXPECT_LT(worst(fit.model, truth), 0.3e-6);
    EXPECT_TRUE(fit.outliers.empty());
}

TEST(GalvoFit, ItsStatedErrorIsItsError) {
    const Model truth = workshop_head();
    double squares = 0.0;
    int over = 0;
    int terms = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
        const GalvoFit fit = fit_galvo(crosses(truth, 7.5e-6, seed), {.residual_grid = false});
        EXPECT_NEAR(fit.sigma, 7.5e-6, 1e-6);
        EXPECT_LT(worst(fit.model, truth), 5.0 * fit.field_sigma);
        for (std::size_t i = 0; i < Model::kParameters; ++i) {
            const double off = (fit.model.value[i] - truth.value[i]) / std::sqrt(fit.covariance.at[i][i]);
            squares += off * off;
            over += std::abs(off) > 3.5 ? 1 : 0;
            ++terms;
        }
    }
    EXPECT_EQ(over, 0);
    EXPECT_LT(squares / terms, 2.0);
    EXPECT_GT(squares / terms, 0.3);
}

TEST(GalvoFit, BelievesNoCrossThatLiesElsewhere) {
    const Model truth = workshop_head();
    auto data = crosses(truth, 7.5e-6, 3);
    for (const std::size_t i : {10U, 100U, 333U, 500U}) {
        data[i].landed[0] += 0.4e-3;
        data[i].landed[1] -= 0.2e-3;
    }
    const GalvoFit fit = fit_galvo(data);
    EXPECT_EQ(fit.outliers, (std::vector<int>{11, 101, 334, 501}));
    EXPECT_LT(worst(fit.model, truth), 10e-6);
}

TEST(GalvoFit, TheResidualGridTakesWhatTheRaysCannot) {
    const Model truth = workshop_head();
    const auto data = crosses(truth, 0.5e-6, 4, true);
    const GalvoFit with = fit_galvo(data);
    const GalvoFit without = fit_galvo(data, {.residual_grid = false});
    EXPECT_LT(worst(with.model, truth, true), 2e-6);
    EXPECT_GT(worst(without.model, truth, true), 4e-6);
    EXPECT_GT(with.grid_freedom, 10.0);
}

TEST(GalvoFit, DoesNotDependOnTheOrderOfTheCrosses) {
    auto data = crosses(workshop_head(), 7.5e-6, 5);
    const GalvoFit fit = fit_galvo(data);
    std::reverse(data.begin(), data.end());
    EXPECT_LT(worst(fit_galvo(data).model, fit.model), 1e-9);
}

TEST(GalvoFit, RefusesWhatCannotSupportIt) {
    const Model truth = workshop_head();
    const auto good = crosses(truth, 7.5e-6, 6);
    const auto refuses = [](const std::vector<CrossObservation>& data, const char* word) {
        try {
            static_cast<void>(fit_galvo(data));
            ADD_FAILURE() << "was fitted: " << word;
        } catch (const std::domain_error& error) {
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
        }
    };
    refuses({good.begin(), good.begin() + 59}, "too few");
    refuses(crosses(truth, 7.5e-6, 6, false, 0.2e-3), "depth");
    auto narrow = good;
    std::erase_if(narrow, [](const auto& c) { return std::abs(c.command[0]) > 0.025; });
    refuses(narrow, "in x");
    auto exchanged = good;
    for (auto& cross : exchanged) {
        std::swap(cross.landed[0], cross.landed[1]);
    }
    refuses(exchanged, "numbers, signs and units");
    auto sparse = crosses(truth, 60e-6, 7);
    std::erase_if(sparse, [](const auto& c) { return c.number % 8 != 0; });
    refuses(sparse, "in the field");
}

TEST(GalvoFit, ItsLinearRecordIsTheModelAtTheCentre) {
    const GalvoFit fit = fit_galvo(crosses(workshop_head(), 1e-6, 8));
    const GalvoRecord record = linear_record(fit);
    const FieldPlace at = fit.model.land({1e-3, -2e-3}, 0.0);
    EXPECT_NEAR(record.offset[0] + record.matrix[0] * 1e-3 - record.matrix[1] * 2e-3, at[0], 0.5e-6);
    EXPECT_NEAR(record.offset[1] + record.matrix[2] * 1e-3 - record.matrix[3] * 2e-3, at[1], 0.5e-6);
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_GT(record.covariance.at[i][i], 0.0);
    }
}

}  // namespace
}  // namespace sc::host
