// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/lag_fit.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kFrame = 10e-6;
constexpr double kTick = 0.5e-6;

struct Mirrors {
    double latency = 160e-6;
    double frequency = 2000.0;
    double damping = 0.75;
};

/// Place of a line at a distance, walked in steps of 0.1 µm: shares nothing with the fit's curve.
class Walk {
public:
    explicit Walk(const LagLine& line) : line_(line) {
        double u = 0.0;
        while (u < line.run + 1e-4) {
            along_.push_back(u);
            const double slope = line.amplitude > 0.0 ? line.amplitude * wave() * std::cos(wave() * u) : 0.0;
            u += kStep / std::sqrt(1.0 + slope * slope);
        }
    }
    [[nodiscard]] double length() const { return kStep * static_cast<double>(along_.size() - 1); }
    [[nodiscard]] std::array<double, 2> at(double s) const {
        const std::size_t run = line_.along_x ? 0 : 1;
        std::array<double, 2> place = line_.start;
        const double slope = line_.amplitude * wave();
        double u = s / std::sqrt(1.0 + slope * slope);
        double swing = slope * u;
        if (s > 0.0) {
            const double index = std::min(s / kStep, static_cast<double>(along_.size() - 2));
            const auto i = static_cast<std::size_t>(index);
            u = along_[i] + (s / kStep - static_cast<double>(i)) * (along_[i + 1] - along_[i]);
            swing = line_.amplitude * std::sin(wave() * u);
        }
        place[run] += line_.way * u;
        place[1 - run] += swing;
        return place;
    }

private:
    static constexpr double kStep = 1e-7;
    [[nodiscard]] double wave() const { return line_.wavelength > 0.0 ? kTwoPi / line_.wavelength : 0.0; }
    LagLine line_;
    std::vector<double> along_;
};

/// Frames each 10 µs that lead by what the controller was told, held, delayed, and a servo stepped each 0.5 µs.
std::vector<LagMark> burn(const LagPlan& plan, const Mirrors& is, double sigma, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const double told_omega = kTwoPi * plan.told.natural_frequency.si();
    const double a0 = 2.0 * plan.told.damping / told_omega;
    const double b0 = 1.0 / (told_omega * told_omega) - kFrame * kFrame / 24.0;
    const double fire = static_cast<double>(plan.told.latency_ns) * 1e-9 - a0;
    const double omega = kTwoPi * is.frequency;
    const double delay = is.latency - 0.5 * kFrame - 2.0 * is.damping / omega;
    std::vector<LagMark> marks;
    for (const LagLine& line : plan.lines) {
        const Walk walk(line);
        const auto path = [&](double t) { return walk.at(t * line.speed); };
        const auto word = [&](double t, std::size_t k) {
            const double h = 2e-6;
            const double before = path(t - h)[k];
            const double here = path(t)[k];
            const double after = path(t + h)[k];
            return here + a0 * (after - before) / (2.0 * h) + b0 * (after - 2.0 * here + before) / (h * h);
        };
        const double begin = -3e-3;
        const auto ticks = static_cast<std::size_t>((walk.length() / line.speed - begin + 0.3e-3) / kTick);
        std::array<std::vector<double>, 2> stood;
        for (std::size_t k = 0; k < 2; ++k) {
            double place = path(begin)[k];
            double speed = (path(begin + 1e-6)[k] - place) / 1e-6;
            double frame = -1e9;
            double held = place;
            for (std::size_t i = 0; i < ticks; ++i) {
                stood[k].push_back(place);
                const double arrives = begin + kTick * static_cast<double>(i) - delay;
                const double now = std::floor((arrives - begin) / kFrame);
                if (now != frame) {
                    frame = now;
                    held = word(begin + now * kFrame, k);
                }
                const double pull = omega * omega * (held - place) - 2.0 * is.damping * omega * speed;
                speed += kTick * pull;
                place += kTick * speed;
            }
        }
        for (int mark = 0; mark * line.pitch <= walk.length(); ++mark) {
            const double at = (mark * line.pitch / line.speed + fire - begin) / kTick;
            const auto i = static_cast<std::size_t>(at);
            if (i + 1 >= ticks) {
                break;
            }
            const double u = at - static_cast<double>(i);
            LagMark seen{line.no, mark, line.anchor, std::max(sigma, 0.1e-6)};
            seen.place.x += (1.0 - u) * stood[0][i] + u * stood[0][i + 1] + 12e-6;
            seen.place.z += (1.0 - u) * stood[1][i] + u * stood[1][i + 1] - 7e-6;
            seen.place.x += sigma * normal(random);
            seen.place.z += sigma * normal(random);
            marks.push_back(seen);
        }
    }
    return marks;
}

LagPlan plan_of(bool sines) {
    const MachineConfig machine = reference_machine();
    LagPlan plan;
    plan.told = lag_of(machine.galvo);
    double across = 0.0;
    const auto add = [&](bool along_x, int way, double speed, double amplitude, double wavelength) {
        LagLine line;
        line.no = static_cast<int>(plan.lines.size()) + 1;
        line.along_x = along_x;
        line.way = way;
        line.run = 10e-3;
        line.start[along_x ? 0 : 1] = -5e-3 * way;
        line.start[along_x ? 1 : 0] = across += 1e-3;
        line.amplitude = amplitude;
        line.wavelength = wavelength;
        line.speed = speed;
        line.pitch = 100e-6;
        line.anchor = {-0.2, -0.2, -0.2};
        plan.lines.push_back(line);
    };
    for (const bool along_x : {true, false}) {
        for (const int way : {1, -1}) {
            add(along_x, way, 2.0, 0.0, 0.0);
            if (sines) {
                add(along_x, way, 1.5, 230e-6, 1.875e-3);
                add(along_x, way, 1.5, 105e-6, 1.25e-3);
                add(along_x, way, 1.5, 59e-6, 0.9375e-3);
            }
        }
    }
    return plan;
}

std::string refusal(const LagPlan& plan, const std::vector<LagMark>& marks) {
    try {
        static_cast<void>(fit_lag(plan, marks, reference_machine()));
    } catch (const std::domain_error& error) {
        return error.what();
    }
    return "";
}

TEST(LagFit, FindsMirrorsThatAreOtherThanTold) {
    const LagPlan plan = plan_of(true);
    for (const Mirrors& is : {Mirrors{}, Mirrors{144e-6, 2400.0, 0.6}, Mirrors{205e-6, 1600.0, 0.9}}) {
        const LagFit exact = fit_lag(plan, burn(plan, is, 0.0, 1), reference_machine());
        EXPECT_NEAR(static_cast<double>(exact.lag.latency_ns), is.latency * 1e9, 300.0);
        EXPECT_NEAR(exact.lag.natural_frequency.si(), is.frequency, 0.01 * is.frequency);
        EXPECT_NEAR(exact.lag.damping, is.damping, 0.005);
        const LagFit fit = fit_lag(plan, burn(plan, is, 7.5e-6, 2), reference_machine());
        EXPECT_NEAR(fit.sigma, 7.5e-6, 0.5e-6);
        EXPECT_LT(fit.placement_sigma, 1.5e-6);
        const auto sigma = [&](std::size_t i) { return std::sqrt(fit.covariance.at[i][i]); };
        EXPECT_NEAR(static_cast<double>(fit.lag.latency_ns) * 1e-9, is.latency, 4.0 * sigma(0) + 0.3e-6);
        EXPECT_NEAR(fit.lag.natural_frequency.si(), is.frequency, 4.0 * sigma(1) + 0.01 * is.frequency);
        EXPECT_NEAR(fit.lag.damping, is.damping, 4.0 * sigma(2) + 0.005);
    }
}

TEST(LagFit, ItsCovarianceIsTheScatterOfRepeatedPlates) {
    const LagPlan plan = plan_of(true);
    const std::vector<LagMark> exact = burn(plan, {}, 0.0, 1);
    std::array<double, 3> sum{};
    constexpr int kPlates = 8;
    LagFit last;
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    const LagFit centre = fit_lag(plan, exact, reference_machine());
    for (int i = 0; i < kPlates; ++i) {
        std::vector<LagMark> marks = exact;
        for (LagMark& mark : marks) {
            mark.sigma = 7.5e-6;
            mark.place.x += 7.5e-6 * normal(random);
            mark.place.z += 7.5e-6 * normal(random);
        }
        last = fit_lag(plan, marks, reference_machine());
        const double t = static_cast<double>(last.lag.latency_ns - centre.lag.latency_ns) * 1e-9;
        const double f = (last.lag.natural_frequency - centre.lag.natural_frequency).si();
        const double d = last.lag.damping - centre.lag.damping;
        sum[0] += t * t;
        sum[1] += f * f;
        sum[2] += d * d;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const double ratio = std::sqrt(sum[i] / kPlates / last.covariance.at[i][i]);
        EXPECT_GT(ratio, 0.5) << i;
        EXPECT_LT(ratio, 1.7) << i;
    }
}

TEST(LagFit, MarksThatBelongElsewhereAreNotBelieved) {
    const LagPlan plan = plan_of(true);
    std::vector<LagMark> marks = burn(plan, {176e-6, 1600.0, 0.75}, 7.5e-6, 4);
    for (std::size_t i = 5; i < marks.size(); i += 50) {
        marks[i].place.x += 300e-6;
    }
    const LagFit fit = fit_lag(plan, marks, reference_machine());
    EXPECT_NEAR(static_cast<double>(fit.lag.latency_ns), 176e3, 800.0);
    EXPECT_NEAR(fit.lag.natural_frequency.si(), 1600.0, 60.0);
    EXPECT_GE(fit.outliers, 10U);
}

TEST(LagFit, RefusesWhatCannotSupportIt) {
    const LagPlan straight = plan_of(false);
    EXPECT_NE(refusal(straight, burn(straight, {}, 7.5e-6, 1)), "") << "straight lines say nothing of the servo";
    const LagPlan plan = plan_of(true);
    std::vector<LagMark> marks = burn(plan, {}, 7.5e-6, 1);
    EXPECT_NE(refusal(plan, {marks.begin(), marks.begin() + 150}).find("fewer than 200"), std::string::npos);
    std::vector<LagMark> noisy = marks;
    for (std::size_t i = 0; i < noisy.size(); ++i) {
        noisy[i].place.x += 150e-6 * std::sin(static_cast<double>(i * i % 97));
        noisy[i].place.z += 150e-6 * std::sin(static_cast<double>(i * i % 101));
    }
    EXPECT_NE(refusal(plan, noisy).find("scatter"), std::string::npos);
    marks[0].line = 99;
    EXPECT_NE(refusal(plan, marks).find("line 99"), std::string::npos);
    marks[0].line = 1;
    marks[0].mark = 5000;
    EXPECT_NE(refusal(plan, marks).find("beyond its end"), std::string::npos);
}

TEST(LagFit, RefusesALagThatNoControllerTakes) {
    const LagPlan plan = plan_of(true);
    EXPECT_NE(refusal(plan, burn(plan, {400e-6, 2000.0, 0.75}, 1e-6, 1)).find("latency"), std::string::npos);
}

}  // namespace
}  // namespace sc::host
