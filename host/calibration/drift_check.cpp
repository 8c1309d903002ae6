// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/drift_check.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {

namespace {

constexpr double kRare = 1e-3;
constexpr double kRareMarker = 1e-4;
constexpr double kSeen = 4.9;  ///< sigmas at which a test of 1 in 1000 sees in 95 of 100 cases

double chance_of(double chi_squared, double k) {
    const double part = 2.0 / (9.0 * k);
    return 0.5 * std::erfc((std::cbrt(chi_squared / k) - (1.0 - part)) / std::sqrt(2.0 * part));
}

/// One marker of one view, in the stored frame.
struct Sight {
    std::size_t view = 0;
    std::size_t marker = 0;  ///< of the stored ones
    Eigen::Vector3d then;
    Eigen::Vector3d now;
    Eigen::Vector3d from_sensor;  ///< from the sensor to the marker
    Eigen::Vector3d from_flange;
    Eigen::Matrix3d noise;
};

Eigen::Vector3d sigma_of(const SeenMarker& marker, double otherwise) {
    const Eigen::Vector3d stated = to_eigen(marker.sigma);
    return stated.maxCoeff() > 0.0 ? stated : Eigen::Vector3d::Constant(otherwise);
}

Motion flange_of(const DriftView& view) {
    return view.b_from_f ? Motion{to_eigen(view.b_from_f->rotation), to_eigen(view.b_from_f->translation)} : Motion{};
}

class Drift {
public:
    Drift(const std::filesystem::path& file, const std::vector<SeenMarker>& stored, const std::vector<DriftView>& views,
          const std::optional<Rigid<frame::F, frame::C>>& f_from_c, const DriftOptions& options)
        : stored_(stored), views_(views), options_(options) {
        by_robot_ = std::ranges::any_of(views, [](const DriftView& view) { return view.b_from_f.has_value(); });
        if (by_robot_ && !f_from_c) {
            throw InputError({.file = file.string(),
                              .problem = "robot poses need the place of the sensor on the flange",
                              .value = "f_from_c",
                              .action = "name a calibration set that has it"});
        }
        if (by_robot_) {
            x_ = {to_eigen(f_from_c->rotation), to_eigen(f_from_c->translation)};
        }
        collect();
        const auto common = static_cast<std::size_t>(std::ranges::count(used_, true));
        if (common < 3) {
            throw InputError({.file = file.string(),
                              .problem = "fewer than three stored markers were seen",
                              .value = std::to_string(common),
                              .action = "check the ids, or see more of the target"});
        }
        if (options_.target_moved) {
            follow_target();
        }
        build_covariance();
    }

    DriftResult run() {
        DriftResult out;
        const Eigen::MatrixXd base = options_.target_moved ? by_target() : Eigen::MatrixXd(residual_.size(), 0);
        add(out, DriftCause::nothing, base, Eigen::MatrixXd(residual_.size(), 0));
        if (!options_.target_moved) {
            add(out, DriftCause::target, base, by_target());
        }
        if (by_robot_ && views_.size() > 1) {
            add(out, DriftCause::sensor, base, by_sensor());
        }
        add(out, DriftCause::scale, base, by_scale());
        judge(out);
        return out;
    }

private:
    void collect() {
        std::map<int, std::size_t> index;
        for (std::size_t i = 0; i < stored_.size(); ++i) {
            index[stored_[i].id] = i;
        }
        used_.assign(stored_.size(), false);
        for (std::size_t v = 0; v < views_.size(); ++v) {
            const Motion flange = flange_of(views_[v]);
            const Motion sensor = flange * x_;
            for (const SeenMarker& marker : views_[v].markers) {
                const auto found = index.find(marker.id);
                if (found == index.end()) {
                    continue;
                }
                used_[found->second] = true;
                const Eigen::Vector3d now = sensor * to_eigen(marker.place);
                const Eigen::Vector3d sigma = sigma_of(marker, options_.marker);
                sights_.push_back({.view = v,
                                   .marker = found->second,
                                   .then = to_eigen(stored_[found->second].place),
                                   .now = now,
                                   .from_sensor = now - sensor.t,
                                   .from_flange = now - flange.t,
                                   .noise = sensor.r * sigma.cwiseAbs2().asDiagonal() * sensor.r.transpose()});
                middle_ += now;
            }
        }
        middle_ /= std::max<double>(1.0, static_cast<double>(sights_.size()));
    }

    /// The stored places go along with a target that was put down again, so that what is left is small.
    void follow_target() {
        std::vector<PlacePair> pairs;
        for (const Sight& s : sights_) {
            pairs.push_back({.to = s.now, .from = s.then});
        }
        const Motion moved = fit_motion(pairs);
        for (Sight& s : sights_) {
            s.then = moved * s.then;
        }
    }

    [[nodiscard]] Eigen::Index rows() const { return 3 * static_cast<Eigen::Index>(sights_.size()); }

    void build_covariance() {
        Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(rows(), rows());
        residual_.resize(rows());
        const double turn = by_robot_ ? options_.robot_turn * options_.robot_turn : 0.0;
        const double place = by_robot_ ? options_.robot_place * options_.robot_place : 0.0;
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const Sight& a = sights_[i];
            const auto at = 3 * static_cast<Eigen::Index>(i);
            residual_.segment<3>(at) = a.now - a.then;
            for (std::size_t j = 0; j < sights_.size(); ++j) {
                const Sight& b = sights_[j];
                Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();
                if (a.marker == b.marker) {
                    const SeenMarker& stored = stored_[a.marker];
                    shared += sigma_of(stored, options_.marker).cwiseAbs2().asDiagonal();
                }
                // A robot pose moves all markers of its view; those of the stored places, taken to be as many, moved
                // all.
                const Eigen::Matrix3d of_robot =
                    turn * skew(a.from_flange) * skew(b.from_flange).transpose() + place * Eigen::Matrix3d::Identity();
                shared += ((a.view == b.view ? 1.0 : 0.0) + 1.0 / static_cast<double>(views_.size())) * of_robot;
                if (i == j) {
                    shared += a.noise;
                }
                covariance.block<3, 3>(at, 3 * static_cast<Eigen::Index>(j)) = shared;
            }
        }
        whitener_.compute(covariance);
    }

    template <class Jacobian>
    [[nodiscard]] Eigen::MatrixXd stacked(Eigen::Index columns, const Jacobian& of) const {
        Eigen::MatrixXd out(rows(), columns);
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            out.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = of(sights_[i]);
        }
        return out;
    }
    [[nodiscard]] Eigen::MatrixXd by_target() const {
        return stacked(6, [this](const Sight& s) {
            Eigen::Matrix<double, 3, 6> j;
            j << -skew(s.now - middle_), Eigen::Matrix3d::Identity();
            return j;
        });
    }
    /// A motion of the sensor in the flange's axes, about the sensor.
    [[nodiscard]] Eigen::MatrixXd by_sensor() const {
        return stacked(6, [this](const Sight& s) {
            const Eigen::Matrix3d r = flange_of(views_[s.view]).r;
            Eigen::Matrix<double, 3, 6> j;
            j << -skew(s.from_sensor) * r, r;
            return j;
        });
    }
    [[nodiscard]] Eigen::MatrixXd by_scale() const {
        return stacked(1, [this](const Sight& s) -> Eigen::Vector3d {
            return by_robot_ ? s.from_sensor : Eigen::Vector3d(s.now - middle_);
        });
    }

    /// `base` is fitted too and counts for nothing.
    void add(DriftResult& out, DriftCause cause, const Eigen::MatrixXd& base, const Eigen::MatrixXd& own) {
        const Eigen::VectorXd target = whitener_.matrixL().solve(residual_);
        DriftHypothesis h{.cause = cause, .parameters = static_cast<int>(own.cols())};
        if (base.cols() + own.cols() == 0) {
            h.chi_squared = target.squaredNorm();
            left_.push_back(residual_);
            out.hypotheses.push_back(h);
            return;
        }
        Eigen::MatrixXd design(rows(), base.cols() + own.cols());
        design.leftCols(base.cols()) = base;
        design.rightCols(own.cols()) = own;
        const Eigen::MatrixXd white = whitener_.matrixL().solve(design);
        const Eigen::VectorXd step = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(white).solve(target);
        const Eigen::VectorXd left = target - white * step;
        h.chi_squared = left.squaredNorm();
        if (own.cols() > 0) {
            const Eigen::VectorXd mine = step.tail(own.cols());
            const Eigen::MatrixXd normal = white.transpose() * white;
            const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
            const Eigen::MatrixXd spread = scale.asDiagonal() *
                                           Eigen::MatrixXd(scale.asDiagonal() * normal * scale.asDiagonal())
                                               .completeOrthogonalDecomposition()
                                               .pseudoInverse() *
                                           scale.asDiagonal();
            measure(h, own, mine, spread.bottomRightCorner(own.cols(), own.cols()));
        }
        left_.push_back(residual_ - design * step);
        out.hypotheses.push_back(h);
    }

    void measure(DriftHypothesis& h, const Eigen::MatrixXd& own, const Eigen::VectorXd& step,
                 const Eigen::MatrixXd& spread) const {
        if (own.cols() == 6) {
            h.turn = step.head<3>().norm();
            h.place = step.tail<3>().norm();
        } else {
            h.scale = step(0);
        }
        for (std::size_t i = 0; i < sights_.size(); ++i) {
            const auto j = own.middleRows<3>(3 * static_cast<Eigen::Index>(i));
            const double moved = (j * step).norm();
            if (moved >= h.largest) {
                h.largest = moved;
                h.sigma = std::sqrt(std::max(0.0, (j * spread * j.transpose()).eval().diagonal().maxCoeff()));
            }
        }
    }

    void judge(DriftResult& out) {
        const DriftHypothesis& nothing = out.hypotheses.front();
        out.freedom = static_cast<double>(rows()) - (options_.target_moved ? 6.0 : 0.0);
        out.chance = chance_of(nothing.chi_squared, std::max(1.0, out.freedom));
        std::size_t best = 0;
        const double each = std::log(static_cast<double>(rows()));
        const auto cost = [&](std::size_t i) {
            return out.hypotheses[i].chi_squared + each * out.hypotheses[i].parameters;
        };
        for (std::size_t i = 1; i < out.hypotheses.size(); ++i) {
            const DriftHypothesis& h = out.hypotheses[i];
            const double gain = nothing.chi_squared - h.chi_squared;
            if (chance_of(gain, h.parameters) < kRare && cost(i) < cost(best)) {
                best = i;
            }
            if (h.cause == DriftCause::target) {
                out.seen_from = kSeen * h.sigma;
            }
        }
        const DriftHypothesis& suspect = out.hypotheses[best];
        out.suspect = suspect.cause;
        name_markers(out, best);
        const bool alone =
            std::ranges::any_of(out.markers, [](const DriftMarker& marker) { return marker.moved_alone; });
        const bool moved = best > 0 && suspect.largest > options_.limit;
        out.drifted = moved || alone;
        const std::string_view name = suspect_of(suspect.cause, by_robot_);
        if (moved) {
            out.text =
                fmt::format("drifted: {} is suspect, markers are off by up to {:.1f} um (1 sigma {:.1f}, limit {:.1f})",
                            name, 1e6 * suspect.largest, 1e6 * suspect.sigma, 1e6 * options_.limit);
        } else if (best > 0) {
            out.text = fmt::format("ok: {} seems to have moved markers by {:.1f} um, within the limit of {:.1f} um",
                                   name, 1e6 * suspect.largest, 1e6 * options_.limit);
        } else {
            out.text =
                fmt::format("ok: nothing has moved that could be seen (chance of such residuals {:.2g})", out.chance);
        }
        if (alone) {
            out.text = (moved ? out.text + "; " : std::string("drifted: ")) + "single markers of the target have moved";
        }
        if (out.seen_from > options_.limit) {
            out.notes.push_back(
                fmt::format("a drift is seen from {:.1f} um on only, more than the limit: see more "
                            "markers, or from more views",
                            1e6 * out.seen_from));
        }
        if (by_robot_ && views_.size() < 2) {
            out.notes.emplace_back("one view cannot tell a moved sensor from a moved target: see it from two or more");
        }
    }

    void name_markers(DriftResult& out, std::size_t best) {
        for (std::size_t m = 0; m < stored_.size(); ++m) {
            if (!used_[m]) {
                continue;
            }
            DriftMarker marker;
            marker.id = stored_[m].id;
            Eigen::Vector3d off = Eigen::Vector3d::Zero();
            Eigen::Vector3d left = Eigen::Vector3d::Zero();
            Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
            Eigen::Matrix3d robot = Eigen::Matrix3d::Zero();
            double count = 0.0;
            for (std::size_t i = 0; i < sights_.size(); ++i) {
                if (sights_[i].marker == m) {
                    const auto at = 3 * static_cast<Eigen::Index>(i);
                    off += residual_.segment<3>(at);
                    left += left_[best].segment<3>(at);
                    noise += sights_[i].noise;
                    const Eigen::Matrix3d arm = options_.robot_turn * skew(sights_[i].from_flange);
                    robot += arm * arm.transpose() +
                             options_.robot_place * options_.robot_place * Eigen::Matrix3d::Identity();
                    count += 1.0;
                }
            }
            off /= count;
            left /= count;
            Eigen::Matrix3d spread = noise / (count * count);
            if (by_robot_) {
                // Of the views, and of as many that the stored places came from.
                spread += 2.0 * robot / (count * count);
            }
            spread += sigma_of(stored_[m], options_.marker).cwiseAbs2().asDiagonal();
            marker.off = to_vec(off);
            marker.chance = chance_of(left.dot(spread.ldlt().solve(left)), 3.0);
            marker.moved_alone =
                marker.chance < kRareMarker / static_cast<double>(stored_.size()) && left.norm() > options_.limit;
            out.markers.push_back(marker);
        }
    }

    const std::vector<SeenMarker>& stored_;
    const std::vector<DriftView>& views_;
    DriftOptions options_;
    bool by_robot_ = false;
    Motion x_;
    std::vector<Sight> sights_;
    std::vector<bool> used_;
    Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
    Eigen::VectorXd residual_;
    Eigen::LLT<Eigen::MatrixXd> whitener_;
    std::vector<Eigen::VectorXd> left_;
};

}  // namespace

std::string_view name_of(DriftCause cause) noexcept {
    switch (cause) {
        case DriftCause::nothing: return "nothing";
        case DriftCause::target: return "target";
        case DriftCause::sensor: return "sensor";
        case DriftCause::scale: return "scale";
    }
    return "";
}

std::string_view suspect_of(DriftCause cause, bool by_robot) noexcept {
    switch (cause) {
        case DriftCause::nothing: return "nothing";
        case DriftCause::target:
            return by_robot ? "b_from_g (the target, or the robot's base)"
                            : "the target or the sensor's mounting (h_from_c)";
        case DriftCause::sensor: return "f_from_c (the sensor on the flange)";
        case DriftCause::scale: return "the sensor's scale";
    }
    return "";
}

DriftResult check_drift(const std::filesystem::path& file, const std::vector<SeenMarker>& stored,
                        const std::vector<DriftView>& views, const std::optional<Rigid<frame::F, frame::C>>& f_from_c,
                        const DriftOptions& options) {
    return Drift(file, stored, views, f_from_c, options).run();
}

std::vector<SeenMarker> places_to_store(const std::vector<DriftView>& views,
                                        const std::optional<Rigid<frame::F, frame::C>>& f_from_c,
                                        const DriftOptions& options) {
    struct Sum {
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
        Eigen::Vector3d variance = Eigen::Vector3d::Zero();
        double count = 0.0;
    };
    std::map<int, Sum> sums;
    const Motion x = f_from_c ? Motion{to_eigen(f_from_c->rotation), to_eigen(f_from_c->translation)} : Motion{};
    for (const DriftView& view : views) {
        const Motion flange = flange_of(view);
        const Motion sensor = view.b_from_f ? flange * x : Motion{};
        for (const SeenMarker& marker : view.markers) {
            Sum& sum = sums[marker.id];
            const Eigen::Vector3d place = sensor * to_eigen(marker.place);
            const Eigen::Vector3d sigma = sigma_of(marker, options.marker);
            Eigen::Vector3d variance = (sensor.r * sigma.cwiseAbs2().asDiagonal() * sensor.r.transpose()).diagonal();
            if (view.b_from_f) {
                const double arm = options.robot_turn * (place - flange.t).norm();
                variance.array() += options.robot_place * options.robot_place + 0.5 * arm * arm;
            }
            sum.place += place;
            sum.variance += variance;
            sum.count += 1.0;
        }
    }
    std::vector<SeenMarker> out;
    for (const auto& [id, sum] : sums) {
        out.push_back({.line = 0,
                       .id = id,
                       .place = to_vec(sum.place / sum.count),
                       .sigma = to_vec((sum.variance / (sum.count * sum.count)).cwiseSqrt())});
    }
    return out;
}

}  // namespace sc::host
