// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/lag_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/calibration/lag_curve.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewestMarks = 200;
constexpr double kMostPlacementSigma = 2.5e-6;
constexpr double kMostNoise = 20e-6;
constexpr double kMostNoiseRatio = 5.0;
/// Width of the Cauchy weight, in standard deviations.
constexpr double kCauchy = 3.0;
constexpr double kNotBelieved = 6.0;
constexpr int kRounds = 8;
constexpr int kSteps = 25;
constexpr double kStep = 5e-6;     ///< s, of the servo's equation
constexpr double kBefore = 3e-3;   ///< s before the line's first mark at which its equation is started, at rest in it
constexpr double kAfter = 0.5e-3;  ///< s behind its last
/// Marks within this of either end are left out: the beam may still gather speed there.
constexpr double kEnds = 0.3e-3;  ///< s
/// Unknowns: latency, frequency and damping as shifts of their scales; then the affine image of x and of z.
constexpr Eigen::Index kN = 9;
constexpr double kLatencyScale = 1e-6;
constexpr double kReach = 10e-3;  ///< m: where a unit of the image's slopes moves a mark by a micrometre
constexpr double kImageScale = 1e-6;
using Vector = Eigen::Matrix<double, kN, 1>;
using Square = Eigen::Matrix<double, kN, kN>;
using Pair = std::array<double, 2>;

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Latency T, a = 2 damping / ω and b = 1 / ω².
struct Servo {
    double latency = 0.0;
    double a = 0.0;
    double b = 0.0;
};
struct Lag {
    double latency = 0.0;
    double frequency = 0.0;
    double damping = 0.0;
    [[nodiscard]] Servo servo() const {
        const double omega = 2.0 * kPi * frequency;
        return omega > 0.0 ? Servo{latency, 2.0 * damping / omega, 1.0 / (omega * omega)} : Servo{latency, 0.0, 0.0};
    }
};

/// A line with its marks, and the path's derivatives over time on the grid that the equation is solved on.
class Line {
public:
    Line(const LagLine& line, const std::vector<LagMark>& marks) : curve_(line), speed_(line.speed) {
        for (const LagMark& mark : marks) {
            const double s = mark.mark * line.pitch;
            if (s > curve_.length() + line.pitch) {
                throw std::domain_error(
                    fmt::format("mark {} of line {} lies beyond its end; number the marks of each line as they were "
                                "burnt, from 0",
                                mark.mark, line.no));
            }
            const double t = s / speed_;
            if (t > kEnds && t < curve_.length() / speed_ - kEnds) {
                marks_.push_back({t, {mark.place.x - line.anchor.x, mark.place.z - line.anchor.z}, mark.sigma});
            }
        }
        const double span = kBefore + curve_.length() / speed_ + kAfter;
        const auto steps = static_cast<std::size_t>(std::ceil(span / kStep));
        for (std::size_t i = 0; i <= 2 * steps; ++i) {
            const LagCurve::Point p = curve_.at((0.5 * kStep * static_cast<double>(i) - kBefore) * speed_);
            first_.push_back({speed_ * p.tangent[0], speed_ * p.tangent[1]});
            second_.push_back({speed_ * speed_ * p.curvature[0], speed_ * speed_ * p.curvature[1]});
        }
    }

    struct Mark {
        double t = 0.0;
        Pair place{};
        double sigma = 0.0;
    };
    [[nodiscard]] const std::vector<Mark>& marks() const { return marks_; }

    /// Where each mark lies for this servo, when the controller was told `told`.
    [[nodiscard]] std::vector<Pair> places(const Servo& is, const Servo& told) const {
        const std::vector<State> error = solve(is, told);
        const double shift = (told.latency - told.a) - (is.latency - is.a);
        std::vector<Pair> out;
        out.reserve(marks_.size());
        for (const Mark& mark : marks_) {
            const double t = mark.t + shift;
            Pair place = curve_.at(t * speed_).place;
            const double at = (t + kBefore) / kStep;
            const double low = std::clamp(std::floor(at), 0.0, static_cast<double>(error.size() - 2));
            const double u = at - low;
            const auto i = static_cast<std::size_t>(low);
            for (std::size_t k = 0; k < 2; ++k) {
                place[k] += hermite(error[i].e[k], error[i].de[k], error[i + 1].e[k], error[i + 1].de[k], u);
            }
            out.push_back(place);
        }
        return out;
    }

private:
    struct State {
        Pair e{};
        Pair de{};
    };
    static double hermite(double p, double dp, double q, double dq, double u) {
        const double w = 1.0 - u;
        return (1.0 + 2.0 * u) * w * w * p + u * u * (3.0 - 2.0 * u) * q + kStep * u * w * (w * dp - u * dq);
    }

    /// e + a e' + b e'' = (a0 − a) c' + (b0 − b) c'' by Runge and Kutta; a servo as fast as that has b = 0 nowhere.
    [[nodiscard]] std::vector<State> solve(const Servo& is, const Servo& told) const {
        const double da = told.a - is.a;
        const double db = told.b - is.b;
        std::vector<State> out(first_.size() / 2 + 1);
        for (std::size_t k = 0; k < 2; ++k) {
            double e = da * first_[0][k];
            double v = 0.0;
            out[0].e[k] = e;
            for (std::size_t i = 0; i + 1 < out.size(); ++i) {
                const auto force = [&](std::size_t half) {
                    return da * first_[2 * i + half][k] + db * second_[2 * i + half][k];
                };
                const auto pull = [&](double f, double place, double speed) {
                    return (f - place - is.a * speed) / is.b;
                };
                const double f0 = force(0);
                const double f1 = force(1);
                const double f2 = force(2);
                const double h = kStep;
                const double a1 = pull(f0, e, v);
                const double a2 = pull(f1, e + 0.5 * h * v, v + 0.5 * h * a1);
                const double a3 = pull(f1, e + 0.5 * h * v + 0.25 * h * h * a1, v + 0.5 * h * a2);
                const double a4 = pull(f2, e + h * v + 0.5 * h * h * a2, v + h * a3);
                e += h * v + h * h * (a1 + a2 + a3) / 6.0;
                v += h * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0;
                out[i + 1].e[k] = e;
                out[i + 1].de[k] = v;
            }
        }
        return out;
    }

    LagCurve curve_;
    double speed_;
    std::vector<Mark> marks_;
    std::vector<Pair> first_;   ///< dc/dt each half step
    std::vector<Pair> second_;  ///< d²c/dt²
};

class Fit {
public:
    Fit(const LagPlan& plan, const std::vector<LagMark>& marks, const MachineConfig& machine) : machine_(machine) {
        told_ = {static_cast<double>(plan.told.latency_ns) * 1e-9, plan.told.natural_frequency.si(), plan.told.damping};
        start_ = told_.frequency > 0.0 ? told_ : Lag{told_.latency, 2000.0, 0.7};
        std::map<int, std::vector<LagMark>> by_line;
        for (const LagLine& line : plan.lines) {
            by_line[line.no] = {};
        }
        for (const LagMark& mark : marks) {
            const auto found = by_line.find(mark.line);
            if (found == by_line.end()) {
                throw std::domain_error(
                    fmt::format("line {} is not in the plan; number the lines as it does", mark.line));
            }
            found->second.push_back(mark);
        }
        for (const LagLine& line : plan.lines) {
            lines_.emplace_back(line, by_line[line.no]);
            seen_.insert(seen_.end(), lines_.back().marks().begin(), lines_.back().marks().end());
        }
        if (seen_.size() < kFewestMarks) {
            throw std::domain_error(
                fmt::format("{} marks lie where the beam had its speed, fewer than {}; measure more of each line",
                            seen_.size(), kFewestMarks));
        }
        weight_.assign(seen_.size(), 1.0);
    }

    LagFit run() {
        Vector x = Vector::Zero();
        for (int round = 0; round < kRounds; ++round) {
            x = minimise(x);
            reweigh(residuals(x));
        }
        x = minimise(x);
        const auto left = residuals(x);
        LagFit fit;
        const Lag lag = lag_of_unknowns(x);
        fit.lag = {std::llround(lag.latency * 1e9), Frequency::from_si(lag.frequency), lag.damping};
        fit.marks = seen_.size();
        fit.sigma = noise_;
        double sum = 0.0;
        double weights = 0.0;
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            const double size = std::hypot(left[i][0], left[i][1]);
            fit.outliers += size > kNotBelieved * scale(i) ? 1U : 0U;
            sum += weight_[i] * size * size;
            weights += 2.0 * weight_[i];
        }
        fit.rms = std::sqrt(sum / weights);
        cover(x, fit);
        return fit;
    }

    [[nodiscard]] double stated_sigma() const {
        std::vector<double> all;
        for (const Line::Mark& mark : seen_) {
            all.push_back(mark.sigma);
        }
        return median(std::move(all));
    }

private:
    [[nodiscard]] Lag lag_of_unknowns(const Vector& x) const {
        return {start_.latency + kLatencyScale * x(0), start_.frequency * std::exp(0.01 * x(1)),
                start_.damping * std::exp(0.01 * x(2))};
    }
    /// Of all marks, without the affine image.
    [[nodiscard]] std::vector<Pair> places(const Vector& x) const {
        const Servo is = lag_of_unknowns(x).servo();
        const Servo told = told_.servo();
        std::vector<Pair> out;
        out.reserve(seen_.size());
        for (const Line& line : lines_) {
            const std::vector<Pair> of_line = line.places(is, told);
            out.insert(out.end(), of_line.begin(), of_line.end());
        }
        return out;
    }
    [[nodiscard]] std::vector<Pair> residuals(const Vector& x) const {
        std::vector<Pair> out = places(x);
        for (std::size_t i = 0; i < out.size(); ++i) {
            const Pair p = out[i];
            const Pair& seen = seen_[i].place;
            out[i] = {seen[0] - p[0] - kImageScale * (x(3) + (x(4) * p[0] + x(5) * p[1]) / kReach),
                      seen[1] - p[1] - kImageScale * (x(6) + (x(7) * p[0] + x(8) * p[1]) / kReach)};
        }
        return out;
    }
    [[nodiscard]] double scale(std::size_t i) const { return std::max(seen_[i].sigma, noise_); }
    void reweigh(const std::vector<Pair>& left) {
        std::vector<double> sizes;
        for (const Pair& r : left) {
            sizes.push_back(std::abs(r[0]));
            sizes.push_back(std::abs(r[1]));
        }
        noise_ = 1.4826 * median(std::move(sizes));
        for (std::size_t i = 0; i < left.size(); ++i) {
            const double distance = std::hypot(left[i][0], left[i][1]) / (kCauchy * scale(i));
            weight_[i] = 1.0 / (1.0 + distance * distance);
        }
    }
    [[nodiscard]] double cost(const std::vector<Pair>& left) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const double s = scale(i);
            sum += weight_[i] * (left[i][0] * left[i][0] + left[i][1] * left[i][1]) / (s * s);
        }
        return sum;
    }
    void normal(const Vector& x, Square& square, Vector& gradient) const {
        const std::vector<Pair> at = places(x);
        const std::vector<Pair> left = residuals(x);
        std::array<std::vector<Pair>, 3> more;
        std::array<std::vector<Pair>, 3> less;
        constexpr double kSmall = 1e-2;
        for (std::size_t k = 0; k < 3; ++k) {
            Vector there = x;
            there(static_cast<Eigen::Index>(k)) += kSmall;
            more[k] = places(there);
            there(static_cast<Eigen::Index>(k)) -= 2.0 * kSmall;
            less[k] = places(there);
        }
        square.setZero();
        gradient.setZero();
        for (std::size_t i = 0; i < at.size(); ++i) {
            const double w = weight_[i] / (scale(i) * scale(i));
            for (std::size_t c = 0; c < 2; ++c) {
                Vector row = Vector::Zero();
                for (std::size_t k = 0; k < 3; ++k) {
                    row(static_cast<Eigen::Index>(k)) = (more[k][i][c] - less[k][i][c]) / (2.0 * kSmall);
                }
                const Eigen::Index first = c == 0 ? 3 : 6;
                row(first) = kImageScale;
                row(first + 1) = kImageScale * at[i][0] / kReach;
                row(first + 2) = kImageScale * at[i][1] / kReach;
                square += w * row * row.transpose();
                gradient += w * left[i][c] * row;
            }
        }
    }
    [[nodiscard]] Vector minimise(Vector x) const {
        double stiff = 1e-3;
        double best = cost(residuals(x));
        for (int step = 0; step < kSteps; ++step) {
            Square square;
            Vector gradient;
            normal(x, square, gradient);
            bool better = false;
            for (int attempt = 0; attempt < 8 && !better; ++attempt) {
                Square held = square;
                held.diagonal() *= 1.0 + stiff;
                const Vector move = held.ldlt().solve(gradient);
                // A servo is within a factor of some two; a step beyond is none.
                const Vector there = x + move;
                const bool sane = there.allFinite() && std::abs(there(1)) < 120.0 && std::abs(there(2)) < 150.0;
                const double now = sane ? cost(residuals(there)) : best;
                better = sane && now < best;
                if (better) {
                    const bool done = best - now < 1e-9 * best;
                    x = there;
                    best = now;
                    stiff = std::max(stiff * 0.1, 1e-12);
                    if (done) {
                        return x;
                    }
                } else {
                    stiff *= 10.0;
                }
            }
            if (!better) {
                return x;
            }
        }
        return x;
    }
    /// Covariances of latency, frequency and damping, and of what they do to a pulse. A lag that is wrong by small
    /// amounts moves the beam by −dT · speed + (db − a da) · acceleration: the logarithm of its transfer function.
    void cover(const Vector& x, LagFit& fit) const {
        Square square;
        Vector gradient;
        normal(x, square, gradient);
        const Square inverse = square.ldlt().solve(Square::Identity());
        if (!inverse.allFinite() || !(inverse.diagonal().minCoeff() > 0.0)) {
            throw std::domain_error(
                "the lines do not show the lag at all; burn straight lines and sines, there and back");
        }
        const Lag lag = lag_of_unknowns(x);
        const std::array<double, 3> scale{kLatencyScale, 0.01 * lag.frequency, 0.01 * lag.damping};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                fit.covariance.at[i][j] =
                    scale[i] * scale[j] * inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
            }
        }
        const Servo servo = lag.servo();
        // db/df = −2 b / f, da/df = −a / f, da/dζ = a / ζ.
        const Eigen::Vector3d by_speed{1.0, 0.0, 0.0};
        const Eigen::Vector3d by_acceleration{0.0, (-2.0 * servo.b + servo.a * servo.a) / lag.frequency,
                                              -servo.a * servo.a / lag.damping};
        Eigen::Matrix3d covariance;
        for (Eigen::Index i = 0; i < 3; ++i) {
            for (Eigen::Index j = 0; j < 3; ++j) {
                covariance(i, j) = fit.covariance.at[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
            }
        }
        const double speed = machine_.galvo.speed.si();
        const double acceleration = machine_.galvo.acceleration.si();
        const double shift = speed * std::sqrt(by_speed.dot(covariance * by_speed));
        const double bend = acceleration * std::sqrt(by_acceleration.dot(covariance * by_acceleration));
        fit.placement_sigma = std::hypot(shift, bend);
    }

    MachineConfig machine_;
    Lag told_;
    Lag start_;
    std::vector<Line> lines_;
    std::vector<Line::Mark> seen_;  ///< of all lines
    std::vector<double> weight_;
    double noise_ = 0.0;
};

}  // namespace

LagFit fit_lag(const LagPlan& plan, const std::vector<LagMark>& marks, const MachineConfig& machine) {
    Fit fit(plan, marks, machine);
    const LagFit found = fit.run();
    const double stated = fit.stated_sigma();
    if (found.sigma > kMostNoise && found.sigma > kMostNoiseRatio * stated) {
        throw std::domain_error(
            fmt::format("the marks scatter by {:.1f} um about the best lag, {:.1f} um are stated; check that plan and "
                        "measurement belong together, and the field correction that was in force",
                        found.sigma * 1e6, stated * 1e6));
    }
    if (!(found.placement_sigma <= kMostPlacementSigma)) {
        throw std::domain_error(
            fmt::format("at full speed and acceleration a pulse would be known to {:.1f} um only, {:.1f} um are asked; "
                        "measure more marks, on sines of several frequencies and on straight lines, there and back",
                        found.placement_sigma * 1e6, kMostPlacementSigma * 1e6));
    }
    if (const int fault = fault_of(found.lag, machine.galvo, machine.galvo_period_ns); fault != 0) {
        constexpr std::array<const char*, 4> kWhat{"latency", "natural frequency", "damping",
                                                   "latency (it does not hold the servo's lag)"};
        throw std::domain_error(
            fmt::format("no controller of this machine takes this {}: latency {:.1f} us, natural frequency {:.0f} Hz, "
                        "damping {:.2f}; "
                        "check that plan and measurement belong together, or correct the machine's configuration",
                        kWhat.at(static_cast<std::size_t>(fault - 1)), static_cast<double>(found.lag.latency_ns) * 1e-3,
                        found.lag.natural_frequency.si(), found.lag.damping));
    }
    return found;
}

}  // namespace sc::host
