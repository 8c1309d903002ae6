// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/plate_fit.hpp"

#include <cmath>
#include <random>
#include <string>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "host/calibration/motion.hpp"
#include "host/calibration/rigid_fit.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

struct Cell {
    Motion h_from_c{exp_turn({1.9, -0.7, 0.4}), {-0.31, 0.42, -0.18}};
    GalvoModel galvo;
    MarkWidth mark{.waist = 16e-6, .rayleigh = 0.6e-3, .reach = 2.5e-4, .curvature = 0.05};
    double sigma = 7.5e-6;
    double width_sigma = 3e-6;
    std::vector<double> steps{-0.03, 0.0, 0.03};  ///< y of the faces about −210 mm
    double tilt = 3e-3;                           ///< of the faces, radians
};

Cell workshop() {
    Cell cell;
    cell.galvo.value = {35e-6,   -22e-6, 1.003, 0.998, 1.5e-3, 0.4e-3, 0.1598, -0.9e-3,
                        -0.0195, -0.006, 5.3,   5.9,   4.0,    2e-4,   -1.5e-4};
    return cell;
}

double draw(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    return normal(random);
}

/// Crosses on faces side by side, each burnt from two places of the axes and at three depths.
std::vector<PlateSight> burn(const Cell& cell, unsigned seed, int across = 4, int up = 7) {
    std::mt19937_64 random(seed);
    std::vector<PlateSight> out;
    for (std::size_t face = 0; face < cell.steps.size(); ++face) {
        const double middle = -0.29 + 0.08 * static_cast<double>(face);
        for (const double side : {1.0, -1.0}) {
            for (const double depth : {-1.5e-3, 0.0, 1.5e-3}) {
                const Vec3 anchor{middle + side * 0.027, -0.21 + cell.steps[face] - depth, -0.25};
                for (int j = 0; j < up; ++j) {
                    for (int i = 0; i < across; ++i) {
                        const FieldPlace command{side * -0.054 * i / (across - 1), -0.05 + 0.1 * j / (up - 1)};
                        Eigen::Vector3d at;
                        FieldPlace landed{};
                        double deep = depth;
                        for (int k = 0; k < 5; ++k) {
                            landed = cell.galvo.land(command, deep);
                            at = {anchor.x + landed[0], 0.0, anchor.z + landed[1]};
                            at.y() = -0.21 + cell.steps[face] + cell.tilt * (at.x() - middle);
                            deep = at.y() - anchor.y;
                        }
                        const FieldPlace flat = cell.galvo.land(command, 0.0);
                        PlateSight s;
                        s.number = static_cast<int>(out.size()) + 1;
                        s.command = command;
                        s.anchor = anchor;
                        s.place = to_vec(cell.h_from_c.inverse() * at +
                                         cell.sigma * Eigen::Vector3d(draw(random), draw(random), draw(random)));
                        s.sigma = {cell.sigma, cell.sigma, cell.sigma};
                        if (cell.width_sigma > 0.0) {
                            s.width =
                                cell.mark.at(deep - cell.mark.curvature * (flat[0] * flat[0] + flat[1] * flat[1])) +
                                cell.width_sigma * draw(random);
                            s.width_sigma = cell.width_sigma;
                        }
                        out.push_back(s);
                    }
                }
            }
        }
    }
    return out;
}

/// h is where the axes are, as in `Cell`.
PlateFitOptions rays() { return {.residual_grid = false, .offset = {35e-6, -22e-6}}; }

/// ξ with truth = Exp(ξ)·fit.
Eigen::Matrix<double, 6, 1> error_of(const PlateFit& fit, const Motion& truth) {
    const Eigen::Matrix3d turn = truth.r * to_eigen(fit.rotation).transpose();
    Eigen::Matrix<double, 6, 1> out;
    out << log_turn(turn), truth.t - turn * to_eigen(fit.translation);
    return out;
}

double off_at(const PlateFit& fit, const Motion& truth, const Eigen::Vector3d& place) {
    const Motion fitted{to_eigen(fit.rotation), to_eigen(fit.translation)};
    return (fitted * (truth.inverse() * place) - place).norm();
}

std::string refusal_of(const std::vector<PlateSight>& sights, const PlateFitOptions& options = {}) {
    try {
        static_cast<void>(fit_plate_crosses("seen.csv", sights, options));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(PlateFit, FindsTransformGalvoAndMarkExactlyWithoutNoise) {
    Cell cell = workshop();
    cell.sigma = 1e-8;
    cell.width_sigma = 1e-8;
    const PlateFit fit = fit_plate_crosses("seen.csv", burn(cell, 1), rays());
    EXPECT_LT(off_at(fit, cell.h_from_c, {-0.25, -0.21, -0.25}), 0.2e-6);
    EXPECT_NEAR(fit.mark.curvature, 0.05, 1e-3);
    EXPECT_NEAR(fit.mark.rayleigh, 0.6e-3, 3e-6);
    for (const FieldPlace& c : {FieldPlace{0.05, 0.05}, FieldPlace{-0.05, 0.02}, FieldPlace{0.0, 0.0}}) {
        EXPECT_NEAR(fit.galvo.land(c, 0.0)[0], cell.galvo.land(c, 0.0)[0], 0.3e-6);
        EXPECT_NEAR(fit.galvo.land(c, 0.0)[1], cell.galvo.land(c, 0.0)[1], 0.3e-6);
    }
}

TEST(PlateFit, ItsCovarianceHoldsAndTheTwoTogetherBeatThemApart) {
    const Cell cell = workshop();
    constexpr int kSets = 8;
    double sum = 0.0;
    double together = 0.0;
    double apart = 0.0;
    const Eigen::Vector3d part(-0.25, -0.32, -0.36);
    for (int set = 0; set < kSets; ++set) {
        const auto sights = burn(cell, 100U + static_cast<unsigned>(set));
        const PlateFit fit = fit_plate_crosses("seen.csv", sights, rays());
        const Eigen::Matrix<double, 6, 1> error = error_of(fit, cell.h_from_c);
        Eigen::Matrix<double, 6, 6> c;
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) {
                c(i, j) = fit.of_transform.at[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
                EXPECT_EQ(c(i, j), fit.joint.at[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
            }
        }
        sum += error.dot(c.ldlt().solve(error));
        together += std::pow(off_at(fit, cell.h_from_c, part), 2);
        // Apart: the transform from the same crosses, the galvo taken as an ideal one in focus.
        std::vector<SeenMarker> to;
        std::vector<SeenMarker> from;
        for (const PlateSight& s : sights) {
            const FieldPlace at = GalvoModel{}.land(s.command, 0.0);
            to.push_back({0, s.number, {s.anchor.x + at[0], s.anchor.y, s.anchor.z + at[1]}, {3e-4, 1e-3, 3e-4}});
            from.push_back({0, s.number, s.place, s.sigma});
        }
        const RigidFit rigid = fit_rigid("seen.csv", to, from, {.find_wrong = false});
        PlateFit other;
        other.rotation = rigid.rotation;
        other.translation = rigid.translation;
        apart += std::pow(off_at(other, cell.h_from_c, part), 2);
    }
    // 72 degrees of freedom: 6 ± 4 sigma of the mean.
    EXPECT_NEAR(sum / kSets, 6.0, 4.0 * std::sqrt(12.0 / kSets));
    EXPECT_LT(std::sqrt(together / kSets), 15e-6);
    EXPECT_GT(std::sqrt(apart / kSets), 5.0 * std::sqrt(together / kSets));
}

TEST(PlateFit, NamesWrongCrosses) {
    auto sights = burn(workshop(), 5);
    sights[40].place.x += 0.4e-3;
    std::swap(sights[100].place, sights[101].place);
    const PlateFit fit = fit_plate_crosses("seen.csv", sights);
    EXPECT_EQ(fit.wrong(), (std::vector<int>{41, 101, 102}));
}

TEST(PlateFit, StepsShowTheTurn) {
    Cell cell = workshop();
    const double stepped = fit_plate_crosses("seen.csv", burn(cell, 2), rays()).turn_sigma;
    cell.steps = {0.0, 0.0, 0.0};
    PlateFitOptions options = rays();
    options.most_turn = 1.0;
    EXPECT_GT(fit_plate_crosses("seen.csv", burn(cell, 2), options).turn_sigma, 1.1 * stepped);
}

TEST(PlateFit, RefusesWhatIsBlindAndNamesTheDirection) {
    Cell cell = workshop();
    cell.width_sigma = 0.0;
    EXPECT_NE(refusal_of(burn(cell, 2)).find("1.00, "), std::string::npos) << refusal_of(burn(cell, 2));
    EXPECT_NE(refusal_of(burn(cell, 2)).find("alone show y"), std::string::npos);
    auto few = burn(workshop(), 2);
    few.resize(50);
    EXPECT_NE(refusal_of(few).find("few crosses"), std::string::npos);
}

}  // namespace
}  // namespace sc::host
