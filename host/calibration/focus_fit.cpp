// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/focus_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewest = 7;
constexpr double kSpread = 0.7;      ///< of the logarithms of waist, rayleigh and reach
constexpr double kMostSigma = 1e-4;  ///< metres
constexpr double kUnit = 1e-4;       ///< metres: y of the focus is counted in these
constexpr int kSteps = 60;
using Vector = Eigen::Vector4d;  ///< y, then the scaled logarithms
using Square = Eigen::Matrix4d;

MarkWidth mark_of(const Vector& x) {
    MarkWidth mark;
    mark.waist *= std::exp(x(1) * kSpread);
    mark.rayleigh *= std::exp(x(2) * kSpread);
    mark.reach *= std::exp(x(3) * kSpread);
    return mark;
}

class Fit {
public:
    Fit(const std::filesystem::path& file, const std::vector<Rung>& rungs)
        : file_(file), rungs_(rungs), used_(rungs.size(), true) {}

    FocusFit run() {
        if (rungs_.size() < kFewest) {
            refuse("has too few rungs", std::to_string(rungs_.size()), fmt::format("burn {} or more", kFewest));
        }
        for (const Rung& rung : rungs_) {
            middle_ += rung.y / static_cast<double>(rungs_.size());
        }
        Vector x = best_start();
        for (;;) {
            x = minimise(x);
            const std::size_t worst = worst_rung(x);
            if (worst == rungs_.size()) {
                return finish(x);
            }
            used_[worst] = false;
        }
    }

private:
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }
    [[nodiscard]] double focus(const Vector& x) const { return middle_ + x(0) * kUnit; }
    [[nodiscard]] double left(const Vector& x, std::size_t i) const {
        // The surface stands at the focus' y: it is nearer to the head by that less the axes' y.
        return (rungs_[i].width - mark_of(x).at(focus(x) - rungs_[i].y)) / rungs_[i].sigma;
    }
    [[nodiscard]] double cost(const Vector& x) const {
        double sum = x.tail<3>().squaredNorm();
        for (std::size_t i = 0; i < rungs_.size(); ++i) {
            sum += used_[i] ? left(x, i) * left(x, i) : 0.0;
        }
        return sum;
    }
    /// From several places of the focus and reaches: the curve is no parabola far from it, and a mark that nearly
    /// vanishes is as wide as one that does not.
    [[nodiscard]] Vector best_start() const {
        const auto [low, high] = std::ranges::minmax(rungs_, {}, &Rung::y);
        Vector best = Vector::Zero();
        bool first = true;
        for (const double reach : {0.0, 0.7, -0.7}) {
            for (int k = 0; k <= 10; ++k) {
                Vector x = Vector::Zero();
                x(0) = (low.y + (high.y - low.y) * 0.1 * k - middle_) / kUnit;
                x(3) = reach;
                x = minimise(x);
                if (first || cost(x) < cost(best)) {
                    best = x;
                }
                first = false;
            }
        }
        return best;
    }
    [[nodiscard]] Square normal(const Vector& x, Vector* gradient = nullptr) const {
        Square out = Square::Zero();
        out.diagonal().tail<3>().setOnes();
        if (gradient != nullptr) {
            *gradient << 0.0, -x.tail<3>();
        }
        for (std::size_t i = 0; i < rungs_.size(); ++i) {
            if (!used_[i]) {
                continue;
            }
            Vector slope;
            for (int k = 0; k < 4; ++k) {
                Vector more = x;
                Vector less = x;
                more(k) += 1e-5;
                less(k) -= 1e-5;
                slope(k) = -(left(more, i) - left(less, i)) / 2e-5;
            }
            out += slope * slope.transpose();
            if (gradient != nullptr) {
                *gradient += slope * left(x, i);
            }
        }
        return out;
    }
    [[nodiscard]] Vector minimise(Vector x) const {
        double damping = 1e-3;
        double now = cost(x);
        for (int i = 0; i < kSteps && damping < 1e8; ++i) {
            Vector gradient;
            Square n = normal(x, &gradient);
            n.diagonal() += damping * (n.diagonal() + Vector::Constant(1e-9));
            const Vector next = x + n.ldlt().solve(gradient);
            const double then = cost(next);
            if (then < now) {
                const bool settled = now - then < 1e-10 * (1.0 + now);
                x = next;
                now = then;
                damping = std::max(1e-12, 0.1 * damping);
                if (settled) {
                    break;
                }
            } else {
                damping *= 10.0;
            }
        }
        return x;
    }
    [[nodiscard]] std::size_t worst_rung(const Vector& x) const {
        std::size_t worst = rungs_.size();
        double most = std::sqrt(chi_squared_limit(2.0, 1e-4 / static_cast<double>(rungs_.size())));
        for (std::size_t i = 0; i < rungs_.size(); ++i) {
            if (used_[i] && std::abs(left(x, i)) > most) {
                most = std::abs(left(x, i));
                worst = i;
            }
        }
        return static_cast<std::size_t>(std::ranges::count(used_, true)) > kFewest ? worst : rungs_.size();
    }
    [[nodiscard]] FocusFit finish(const Vector& x) const {
        FocusFit out;
        out.y = focus(x);
        out.mark = mark_of(x);
        double squares = 0.0;
        double chi = 0.0;
        double below = 0.0;
        double above = 0.0;
        for (std::size_t i = 0; i < rungs_.size(); ++i) {
            if (!used_[i]) {
                out.wrong.push_back(rungs_[i].line);
                continue;
            }
            ++out.rungs;
            squares += std::pow(left(x, i) * rungs_[i].sigma, 2);
            chi += left(x, i) * left(x, i);
            below = std::max(below, out.y - rungs_[i].y);
            above = std::max(above, rungs_[i].y - out.y);
        }
        out.rms = std::sqrt(squares / static_cast<double>(out.rungs));
        const double raised = std::max(1.0, chi / std::max(1.0, static_cast<double>(out.rungs) - 4.0));
        const Square covariance = raised * normal(x).inverse();
        out.sigma = std::sqrt(covariance(0, 0)) * kUnit;
        out.waist_sigma = std::sqrt(covariance(1, 1)) * kSpread * out.mark.waist;
        out.rayleigh_sigma = std::sqrt(covariance(2, 2)) * kSpread * out.mark.rayleigh;
        if (!(out.sigma <= kMostSigma)) {
            refuse("the widths do not show where the focus is along y (1 sigma; mm)",
                   fmt::format("{:.3f}", out.sigma * 1e3),
                   "reach further to both sides of the focus, or measure better");
        }
        if (!(std::min(below, above) > 0.5 * out.mark.rayleigh)) {
            refuse("the ladder ends before or at the focus; y of the focus, mm", fmt::format("{:.3f}", out.y * 1e3),
                   "burn rungs on both sides of it");
        }
        return out;
    }

    std::filesystem::path file_;
    const std::vector<Rung>& rungs_;
    std::vector<bool> used_;
    double middle_ = 0.0;
};

}  // namespace

FocusFit fit_focus(const std::filesystem::path& file, const std::vector<Rung>& rungs) { return Fit(file, rungs).run(); }

}  // namespace sc::host
