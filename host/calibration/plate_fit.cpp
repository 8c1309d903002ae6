// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/plate_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/galvo_residual.hpp"
#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewest = 60;
constexpr double kLeastDepth = 0.5e-3;
constexpr double kFalseAlarm = 1e-4;
constexpr double kMostWrong = 0.3;  ///< share of the crosses
constexpr double kCauchy = 3.0;
constexpr int kRobustRounds = 8;
constexpr int kSteps = 25;
constexpr Eigen::Index kPose = 6;
constexpr auto kGalvo = static_cast<Eigen::Index>(GalvoModel::kParameters);
constexpr auto kMark = static_cast<Eigen::Index>(MarkWidth::kParameters);
constexpr Eigen::Index kOwn = kGalvo + kMark;  ///< scaled by their priors
constexpr auto kAll = static_cast<Eigen::Index>(PlateFit::kParameters);
using Own = Eigen::Matrix<double, kOwn, 1>;
using Vector = Eigen::Matrix<double, kAll, 1>;
using Square = Eigen::Matrix<double, kAll, kAll>;
/// As kGalvoSpread, with an offset that is given.
constexpr auto kSpread = [] {
    auto spread = kGalvoSpread;
    spread[GalvoModel::kOffsetX] = spread[GalvoModel::kOffsetZ] = 1e-8;
    return spread;
}();
/// Of ln waist, ln rayleigh, ln reach, curvature (1/m).
constexpr std::array<double, MarkWidth::kParameters> kMarkSpread{0.7, 0.7, 0.7, 0.2};

struct State {
    Motion motion;
    Own own = Own::Zero();
};

struct Seen {
    Eigen::Vector2d left;    ///< metres: measured less modelled
    Eigen::Matrix2d weight;  ///< inverse covariance
    Eigen::Matrix<double, 2, 3> by_place;
    double width_left = 0.0;
    double width_weight = 0.0;
};

double median_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

class Fit {
public:
    Fit(const std::filesystem::path& file, const std::vector<PlateSight>& sights, const PlateFitOptions& options)
        : file_(file), sights_(sights), options_(options), weight_(sights.size(), 1.0), used_(sights.size(), true) {
        nominal_.angle_scale = options.angle_scale;
        nominal_.value[GalvoModel::kOffsetX] = options.offset[0];
        nominal_.value[GalvoModel::kOffsetZ] = options.offset[1];
        nominal_.value[GalvoModel::kF1] = options.angle_scale;
        nominal_.value[GalvoModel::kExitX] = nominal_.value[GalvoModel::kExitZ] = 1.0 / options.angle_scale;
    }

    PlateFit run() {
        check();
        State state = best_start();
        for (int round = 0; round < kRobustRounds; ++round) {
            state = minimise(state, round < 3 ? 4 : kSteps);
            reweigh(state);
        }
        state = leave_out(state);
        return finish(state);
    }

private:
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

    void check() const {
        if (sights_.size() < kFewest) {
            refuse("has too few crosses", std::to_string(sights_.size()),
                   fmt::format("burn and measure {} or more, over the galvo's field", kFewest));
        }
        for (const std::size_t axis : {0U, 1U}) {
            double low = 1e9;
            double high = -1e9;
            for (const PlateSight& s : sights_) {
                low = std::min(low, s.command[axis]);
                high = std::max(high, s.command[axis]);
            }
            if (high - low < options_.residual_half) {
                refuse(fmt::format("the crosses do not span the galvo's field in {}; mm", axis == 0 ? "x" : "z"),
                       fmt::format("{:.3f}", (high - low) * 1e3),
                       fmt::format("spread them over {:.0f} mm or more", options_.residual_half * 1e3));
            }
        }
    }

    [[nodiscard]] GalvoModel galvo_of(const Own& own) const {
        GalvoModel model = nominal_;
        for (std::size_t i = 0; i < GalvoModel::kParameters; ++i) {
            model.value[i] += own(static_cast<Eigen::Index>(i)) * kSpread[i];
        }
        return model;
    }
    [[nodiscard]] static MarkWidth mark_of(const Own& own) {
        MarkWidth mark;
        mark.waist *= std::exp(own(kGalvo) * kMarkSpread[0]);
        mark.rayleigh *= std::exp(own(kGalvo + 1) * kMarkSpread[1]);
        mark.reach *= std::exp(own(kGalvo + 2) * kMarkSpread[2]);
        mark.curvature = own(kGalvo + 3) * kMarkSpread[3];
        return mark;
    }

    /// The galvo taken for an ideal one, the surface for being in focus.
    [[nodiscard]] State start() const {
        std::vector<PlacePair> pairs;
        for (const PlateSight& s : sights_) {
            const FieldPlace at = nominal_.land(s.command, 0.0);
            pairs.push_back({to_eigen(s.anchor) + Eigen::Vector3d(at[0], 0.0, at[1]), to_eigen(s.place), 1.0});
        }
        // Wrong crosses pull it: the farther half is left out once.
        State state{fit_motion(pairs), Own::Zero()};
        std::vector<double> off;
        for (const PlacePair& pair : pairs) {
            off.push_back((pair.to - state.motion * pair.from).norm());
        }
        const double limit = 3.0 * median_of(off);
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            pairs[i].weight = off[i] > limit ? 1e-6 : 1.0;
        }
        state.motion = fit_motion(pairs);
        return state;
    }

    /// A mark that nearly vanishes off focus is as wide as one that does not: the widths have a minimum for each.
    [[nodiscard]] State best_start() const {
        const State common = start();
        State best;
        double least = 0.0;
        for (const double reach : {0.0, 0.7, -0.7}) {
            State state = common;
            state.own(kGalvo + 2) = reach;
            state = minimise(state, kSteps);
            const double now = cost(state);
            if (reach == 0.0 || now < least) {
                best = state;
                least = now;
            }
        }
        return best;
    }

    struct Modelled {
        FieldPlace place{};
        double width = 0.0;
    };
    [[nodiscard]] static Modelled model(const GalvoModel& galvo, const MarkWidth& mark, const FieldPlace& command,
                                        double depth) {
        const FieldPlace flat = galvo.land(command, 0.0);
        return {galvo.land(command, depth), mark.at(depth - mark.curvature * (flat[0] * flat[0] + flat[1] * flat[1]))};
    }

    [[nodiscard]] Seen see(const State& state, const GalvoModel& galvo, const MarkWidth& mark, std::size_t i) const {
        const PlateSight& s = sights_[i];
        const Eigen::Vector3d p = state.motion * to_eigen(s.place);
        const double depth = p.y() - s.anchor.y;
        const Modelled m = model(galvo, mark, s.command, depth);
        const FieldPlace at0 = galvo.land(s.command, 0.0);
        const FieldPlace at1 = galvo.land(s.command, 1.0);
        Seen seen;
        seen.left = {p.x() - s.anchor.x - m.place[0], p.z() - s.anchor.z - m.place[1]};
        seen.by_place << 1.0, at0[0] - at1[0], 0.0, 0.0, at0[1] - at1[1], 1.0;
        const Eigen::Matrix<double, 2, 3> from_c = seen.by_place * state.motion.r;
        seen.weight = (from_c * to_eigen(s.sigma).cwiseAbs2().asDiagonal() * from_c.transpose()).inverse() * weight_[i];
        if (s.width > 0.0) {
            seen.width_left = s.width - m.width;
            seen.width_weight = weight_[i] / (s.width_sigma * s.width_sigma);
        }
        return seen;
    }

    [[nodiscard]] double cost(const State& state) const {
        const GalvoModel galvo = galvo_of(state.own);
        const MarkWidth mark = mark_of(state.own);
        double sum = state.own.squaredNorm();
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            if (used_[i]) {
                const Seen seen = see(state, galvo, mark, i);
                sum += seen.left.dot(seen.weight * seen.left) + seen.width_weight * seen.width_left * seen.width_left;
            }
        }
        return sum;
    }

    [[nodiscard]] Eigen::Vector3d middle(const State& state) const {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double weights = 0.0;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const double w = used_[i] ? weight_[i] : 0.0;
            sum += w * (state.motion * to_eigen(sights_[i].place));
            weights += w;
        }
        return sum / weights;
    }

    /// Normal equations about the middle of the crosses: turn, place, then the scaled own unknowns.
    [[nodiscard]] Square normal(const State& state, Vector* gradient = nullptr) const {
        constexpr double kStep = 1e-5;
        const Eigen::Vector3d centre = middle(state);
        const GalvoModel galvo = galvo_of(state.own);
        const MarkWidth mark = mark_of(state.own);
        std::array<GalvoModel, static_cast<std::size_t>(kOwn)> more_galvo;
        std::array<GalvoModel, static_cast<std::size_t>(kOwn)> less_galvo;
        std::array<MarkWidth, static_cast<std::size_t>(kOwn)> more_mark;
        std::array<MarkWidth, static_cast<std::size_t>(kOwn)> less_mark;
        for (Eigen::Index k = 0; k < kOwn; ++k) {
            Own more = state.own;
            Own less = state.own;
            more(k) += kStep;
            less(k) -= kStep;
            const auto at = static_cast<std::size_t>(k);
            more_galvo[at] = galvo_of(more);
            less_galvo[at] = galvo_of(less);
            more_mark[at] = mark_of(more);
            less_mark[at] = mark_of(less);
        }
        Square out = Square::Zero();
        out.diagonal().tail<kOwn>().setOnes();
        if (gradient != nullptr) {
            gradient->setZero();
            gradient->tail<kOwn>() = -state.own;
        }
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            if (!used_[i]) {
                continue;
            }
            const PlateSight& s = sights_[i];
            const Seen seen = see(state, galvo, mark, i);
            const Eigen::Vector3d p = state.motion * to_eigen(s.place);
            const double depth = p.y() - s.anchor.y;
            Eigen::Matrix<double, 3, kPose> moved;
            moved << -skew(p - centre), Eigen::Matrix3d::Identity();
            // Of modelled less measured: what the residual loses by a step.
            Eigen::Matrix<double, 3, kAll> j;
            j.setZero();
            j.topLeftCorner<2, kPose>() = -seen.by_place * moved;
            const bool wide = s.width > 0.0;
            if (wide) {
                const double slope = (model(galvo, mark, s.command, depth + 1e-6).width -
                                      model(galvo, mark, s.command, depth - 1e-6).width) /
                                     2e-6;
                j.row(2).head<kPose>() = slope * moved.row(1);
            }
            for (Eigen::Index k = 0; k < kOwn; ++k) {
                const auto at = static_cast<std::size_t>(k);
                if (k >= kGalvo && !wide) {
                    continue;
                }
                const Modelled a = model(more_galvo[at], more_mark[at], s.command, depth);
                const Modelled b = model(less_galvo[at], less_mark[at], s.command, depth);
                j(0, kPose + k) = (a.place[0] - b.place[0]) / (2.0 * kStep);
                j(1, kPose + k) = (a.place[1] - b.place[1]) / (2.0 * kStep);
                j(2, kPose + k) = wide ? (a.width - b.width) / (2.0 * kStep) : 0.0;
            }
            Eigen::Matrix3d weight = Eigen::Matrix3d::Zero();
            weight.topLeftCorner<2, 2>() = seen.weight;
            weight(2, 2) = seen.width_weight;
            const Eigen::Matrix<double, kAll, 3> jw = j.transpose() * weight;
            out.noalias() += jw * j;
            if (gradient != nullptr) {
                *gradient += jw * Eigen::Vector3d(seen.left.x(), seen.left.y(), seen.width_left);
            }
        }
        return out;
    }

    [[nodiscard]] State moved(const State& state, const Vector& step) const {
        const Eigen::Vector3d centre = middle(state);
        const Eigen::Matrix3d turn = exp_turn(step.head<3>());
        State next;
        next.motion.r = turn * state.motion.r;
        next.motion.t = turn * (state.motion.t - centre) + centre + step.segment<3>(3);
        next.own = state.own + step.tail<kOwn>();
        return next;
    }

    [[nodiscard]] State minimise(State state, int steps) const {
        double damping = 1e-6;
        double now = cost(state);
        for (int i = 0; i < steps; ++i) {
            Vector gradient;
            Square n = normal(state, &gradient);
            n.diagonal() *= 1.0 + damping;
            const Vector scale = n.diagonal().cwiseSqrt().cwiseInverse();
            const Square scaled = scale.asDiagonal() * n * scale.asDiagonal();
            const Vector step = scale.asDiagonal() * scaled.ldlt().solve(Vector(scale.asDiagonal() * gradient));
            const State next = moved(state, step);
            const double then = cost(next);
            if (then < now) {
                const bool settled = now - then < 1e-9 * now;
                state = next;
                now = then;
                damping = std::max(1e-12, damping * 0.1);
                if (settled) {
                    break;
                }
            } else if (damping > 1e6) {
                break;
            } else {
                damping = std::max(1e-6, damping * 10.0);
            }
        }
        return state;
    }

    /// Chi-squared of each cross' place, unweighted.
    [[nodiscard]] std::vector<double> surprises(const State& state) const {
        const GalvoModel galvo = galvo_of(state.own);
        const MarkWidth mark = mark_of(state.own);
        std::vector<double> out;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const Seen seen = see(state, galvo, mark, i);
            out.push_back(seen.left.dot(seen.weight * seen.left) / weight_[i]);
        }
        return out;
    }
    /// How much more than stated the data scatter, by the median of 2 degrees of freedom.
    [[nodiscard]] static double noise_ratio(const std::vector<double>& surprise) {
        return std::max(1.0, median_of(surprise) / (2.0 * std::numbers::ln2));
    }

    void reweigh(const State& state) {
        const std::vector<double> surprise = surprises(state);
        const double ratio = noise_ratio(surprise);
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            weight_[i] = options_.find_wrong ? 1.0 / (1.0 + surprise[i] / (ratio * kCauchy * kCauchy)) : 1.0;
        }
    }

    [[nodiscard]] State leave_out(State state) {
        for (int round = 0; round < 3; ++round) {
            const std::vector<double> surprise = surprises(state);
            const double limit =
                noise_ratio(surprise) * chi_squared_limit(2.0, kFalseAlarm / static_cast<double>(sights_.size()));
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < sights_.size(); ++i) {
                used_[i] = !options_.find_wrong || surprise[i] <= limit;
                wrong += used_[i] ? 0U : 1U;
                weight_[i] = 1.0;
            }
            if (static_cast<double>(wrong) > kMostWrong * static_cast<double>(sights_.size())) {
                refuse("most crosses do not match the plan", fmt::format("{} of {}", wrong, sights_.size()),
                       "check numbers, signs and units of the measured places");
            }
            state = minimise(state, kSteps);
        }
        return state;
    }

    PlateFit finish(const State& state) {
        PlateFit fit;
        fit.galvo = galvo_of(state.own);
        fit.mark = mark_of(state.own);
        fit.rotation = to_mat(state.motion.r);
        fit.translation = to_vec(state.motion.t);
        const Eigen::Vector3d centre = middle(state);
        fit.middle = to_vec(centre);
        check_depth(state);
        sum_up(state, fit);
        spread(state, centre, fit);
        if (options_.residual_grid) {
            add_grid(state, fit);
        }
        return fit;
    }

    void check_depth(const State& state) const {
        double low = 1e9;
        double high = -1e9;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const double depth = (state.motion * to_eigen(sights_[i].place)).y() - sights_[i].anchor.y;
            low = used_[i] ? std::min(low, depth) : low;
            high = used_[i] ? std::max(high, depth) : high;
        }
        if (high - low < kLeastDepth) {
            refuse("the crosses do not span depths; mm", fmt::format("{:.3f}", (high - low) * 1e3),
                   fmt::format("burn them at depths {:.1f} mm apart or more, or how the beam leans is blind",
                               kLeastDepth * 1e3));
        }
    }

    void sum_up(const State& state, PlateFit& fit) const {
        const std::vector<double> surprise = surprises(state);
        double squares = 0.0;
        double count = 0.0;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const Seen seen = see(state, fit.galvo, fit.mark, i);
            fit.crosses.push_back(
                {sights_[i].number, used_[i], {seen.left.x(), seen.left.y()}, seen.width_left, surprise[i]});
            if (used_[i]) {
                squares += seen.left.squaredNorm();
                count += 2.0;
                fit.chi_squared += surprise[i] + seen.width_weight * seen.width_left * seen.width_left;
                fit.widths += sights_[i].width > 0.0 ? 1U : 0U;
            }
        }
        fit.ray_rms = fit.rms = std::sqrt(squares / count);
        fit.freedom = count + static_cast<double>(fit.widths) - static_cast<double>(kAll);
        if (fit.chi_squared > chi_squared_limit(fit.freedom, 1e-3)) {
            fit.raised = std::sqrt(fit.chi_squared / fit.freedom);
        }
    }

    void spread(const State& state, const Eigen::Vector3d& centre, PlateFit& fit) const {
        Square n = normal(state);
        const Vector scale = n.diagonal().cwiseSqrt().cwiseInverse();
        const Square scaled = scale.asDiagonal() * n * scale.asDiagonal();
        Square c = scale.asDiagonal() * scaled.ldlt().solve(Square::Identity()) * scale.asDiagonal();
        c = (0.5 * fit.raised * fit.raised * (c + c.transpose())).eval();
        refuse_blind(c, centre, fit);
        // To SI, and from the middle of the crosses to h's origin: t changes by δ − w × middle.
        Square to_si = Square::Identity();
        to_si.block<3, 3>(3, 0) = skew(centre);
        for (Eigen::Index k = 0; k < kGalvo; ++k) {
            to_si(kPose + k, kPose + k) = kSpread[static_cast<std::size_t>(k)];
        }
        const std::array<double, 4> mark{fit.mark.waist, fit.mark.rayleigh, fit.mark.reach, 1.0};
        for (std::size_t k = 0; k < MarkWidth::kParameters; ++k) {
            const Eigen::Index at = kPose + kGalvo + static_cast<Eigen::Index>(k);
            to_si(at, at) = kMarkSpread[k] * mark[k];
        }
        const Square si = to_si * c * to_si.transpose();
        const auto put = [&si](auto& covariance, Eigen::Index from) {
            for (std::size_t i = 0; i < covariance.at.size(); ++i) {
                for (std::size_t j = 0; j < covariance.at.size(); ++j) {
                    const auto a = from + static_cast<Eigen::Index>(i);
                    const auto b = from + static_cast<Eigen::Index>(j);
                    covariance.at[i][j] = 0.5 * (si(a, b) + si(b, a));
                }
            }
        };
        put(fit.joint, 0);
        put(fit.of_transform, 0);
        put(fit.of_galvo, kPose);
        fit.field_sigma = field_sigma(state.own, c.block<kGalvo, kGalvo>(kPose, kPose));
    }

    void refuse_blind(const Square& c, const Eigen::Vector3d& /*centre*/, PlateFit& fit) const {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turn(Eigen::Matrix3d(c.topLeftCorner<3, 3>()));
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> place(Eigen::Matrix3d(c.block<3, 3>(3, 3)));
        fit.turn_sigma = std::sqrt(turn.eigenvalues()[2]);
        fit.place_sigma = std::sqrt(place.eigenvalues()[2]);
        fit.focus_sigma = std::sqrt(c(4, 4));
        const auto text = [](const Eigen::Vector3d& u) {
            return fmt::format("({:.2f}, {:.2f}, {:.2f})", u[0], u[1], u[2]);
        };
        if (!(fit.place_sigma <= options_.most_place)) {
            refuse(fmt::format("the crosses do not show where c lies along a direction of h (1 sigma: {:.3g} mm)",
                               fit.place_sigma * 1e3),
                   text(place.eigenvectors().col(2)),
                   "measure the widths of their strokes over depths on both sides of the focus: they alone show y");
        }
        if (!(fit.turn_sigma <= options_.most_turn)) {
            refuse(fmt::format("the crosses do not show the turn about a direction of h (1 sigma: {:.3g} mrad)",
                               fit.turn_sigma * 1e3),
                   text(turn.eigenvectors().col(2)), "burn them on steps or a tilted plate, so that y varies");
        }
    }

    [[nodiscard]] double field_sigma(const Own& own, const Eigen::Matrix<double, kGalvo, kGalvo>& c) const {
        constexpr double kStep = 1e-5;
        double worst = 0.0;
        for (int i = -4; i <= 4; ++i) {
            for (int j = -4; j <= 4; ++j) {
                Eigen::Matrix<double, 2, kGalvo> slope;
                for (Eigen::Index k = 0; k < kGalvo; ++k) {
                    Own more = own;
                    Own less = own;
                    more(k) += kStep;
                    less(k) -= kStep;
                    const FieldPlace a = galvo_of(more).land({i * 0.0138, j * 0.0138}, 0.0);
                    const FieldPlace b = galvo_of(less).land({i * 0.0138, j * 0.0138}, 0.0);
                    slope(0, k) = (a[0] - b[0]) / (2.0 * kStep);
                    slope(1, k) = (a[1] - b[1]) / (2.0 * kStep);
                }
                const Eigen::Matrix2d spread = slope * c * slope.transpose();
                worst = std::max({worst, spread(0, 0), spread(1, 1)});
            }
        }
        return std::sqrt(worst);
    }

    void add_grid(const State& state, PlateFit& fit) const {
        std::vector<ResidualSample> samples;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            if (used_[i]) {
                samples.push_back({sights_[i].command, fit.crosses[i].residual, 1.0});
            }
        }
        fit.grid_freedom = fit_residual_grid(fit.galvo, samples, options_.residual_half, options_.residual_side);
        double squares = 0.0;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const Seen seen = see(state, fit.galvo, fit.mark, i);
            fit.crosses[i].residual = {seen.left.x(), seen.left.y()};
            squares += used_[i] ? seen.left.squaredNorm() : 0.0;
        }
        fit.rms = std::sqrt(squares / (2.0 * static_cast<double>(samples.size())));
    }

    std::filesystem::path file_;
    const std::vector<PlateSight>& sights_;
    const PlateFitOptions& options_;
    GalvoModel nominal_;
    std::vector<double> weight_;
    std::vector<bool> used_;
};

}  // namespace

double MarkWidth::at(double depth) const {
    constexpr double kLeast = 0.02;  // where the mark is about to vanish, the square root has no slope
    const double square = waist * waist * (1.0 + depth * depth / (rayleigh * rayleigh));
    return std::sqrt(2.0 * square * std::max(std::log(reach * reach / square), kLeast));
}

std::vector<int> PlateFit::wrong() const {
    std::vector<int> out;
    for (const PlateCrossFit& cross : crosses) {
        if (!cross.used) {
            out.push_back(cross.number);
        }
    }
    return out;
}

GalvoFit PlateFit::galvo_fit() const {
    GalvoFit out;
    out.model = galvo;
    out.covariance = of_galvo;
    out.ray_rms = ray_rms;
    out.rms = rms;
    out.sigma = rms;
    out.field_sigma = field_sigma;
    out.grid_freedom = grid_freedom;
    out.outliers = wrong();
    return out;
}

PlateFit fit_plate_crosses(const std::filesystem::path& file, const std::vector<PlateSight>& sights,
                           const PlateFitOptions& options) {
    return Fit(file, sights, options).run();
}

}  // namespace sc::host
