// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/board_fit.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sc::host {
namespace {

constexpr int kRobustRounds = 6;
constexpr int kCleanRounds = 5;
constexpr double kRobustReach = 4.0;      ///< standard deviations at which a point counts by a quarter
constexpr double kMedianOfTwo = 1.1774;   ///< median length of a normal vector in the plane
constexpr std::size_t kFewestPoints = 6;  ///< of a view

double median_of(std::vector<double> values) {
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// How far the middle of a circle's ellipse is seen from the circle's own, px.
Eigen::Vector2d ellipse_offset(const CameraModel& camera, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal,
                               double radius) {
    // Dual conic on the plane z = 1: R²·(I − n·nᵀ) − c·cᵀ.
    const Eigen::Matrix3d dual =
        radius * radius * (Eigen::Matrix3d::Identity() - normal * normal.transpose()) - centre * centre.transpose();
    const auto middle = project(camera, {dual(0, 2) / dual(2, 2), dual(1, 2) / dual(2, 2), 1.0});
    const auto own = project(camera, to_vec(centre));
    return middle && own ? Eigen::Vector2d((*middle)[0] - (*own)[0], (*middle)[1] - (*own)[1])
                         : Eigen::Vector2d::Zero().eval();
}

/// A sight with what it came from.
struct Source {
    const BoardPoint* point = nullptr;
    double weight = 1.0;
    bool used = true;
};

class Fitter {
public:
    Fitter(const std::vector<BoardSights>& sights, const BoardState& start, const std::vector<FixedParameters>& fixed,
           const BoardFitSettings& settings)
        : settings_(settings), state_(start), views_(sights.size()) {
        bundle_.fixed = fixed;
        std::vector<double> sigmas;
        for (const BoardSights& view : sights) {
            for (const BoardView* seen : view.seen) {
                for (std::size_t i = 0; seen != nullptr && i < seen->points.size(); ++i) {
                    if (seen->points[i].sigma > 0.0) {
                        sigmas.push_back(seen->points[i].sigma);
                    }
                }
            }
        }
        const double usual = median_of(sigmas);
        for (std::size_t v = 0; v < sights.size(); ++v) {
            views_[v].name = sights[v].name;
            for (std::size_t c = 0; c < start.cameras.size(); ++c) {
                const BoardView* seen = sights[v].seen[c];
                for (std::size_t i = 0; seen != nullptr && i < seen->points.size(); ++i) {
                    const BoardPoint& p = seen->points[i];
                    const double weight = p.sigma > 0.0 ? usual * usual / (p.sigma * p.sigma) : 1.0;
                    sources_.push_back({.point = &p, .weight = weight});
                    all_.push_back({.view = v,
                                    .camera = c,
                                    .place = to_eigen(p.place),
                                    .seen = {p.seen[0], p.seen[1]},
                                    .weight = weight});
                }
            }
        }
    }

    BoardFit run() {
        correct_circles();
        if (settings_.find_wrong) {
            robust();
        }
        for (int round = 0; round < kCleanRounds; ++round) {
            refine_used();
            correct_circles();
            if (!settings_.find_wrong || !judge()) {
                break;
            }
        }
        refine_used();
        return result();
    }

private:
    [[nodiscard]] double length(std::size_t i) const {
        const double off = std::sqrt(sources_[i].weight) * (all_[i].seen - predicted(state_, all_[i])).norm();
        return std::isfinite(off) ? off : 1e9;
    }

    void robust() {
        bundle_.sights = all_;
        for (int round = 0; round < kRobustRounds; ++round) {
            std::vector<double> lengths;
            for (std::size_t i = 0; i < all_.size(); ++i) {
                lengths.push_back(length(i));
            }
            const double noise = std::max(median_of(lengths) / kMedianOfTwo, settings_.least_noise_px);
            for (std::size_t i = 0; i < all_.size(); ++i) {
                const double reach = lengths[i] / (kRobustReach * noise);
                bundle_.sights[i].seen = all_[i].seen;
                bundle_.sights[i].weight = sources_[i].weight / std::pow(1.0 + reach * reach, 2);
            }
            refine(bundle_, state_, 12);
            correct_circles();
        }
        judge();
    }

    void correct_circles() {
        for (std::size_t i = 0; i < all_.size(); ++i) {
            const BoardPoint& p = *sources_[i].point;
            if (p.radius > 0.0) {
                Motion board = state_.boards[all_[i].view];
                if (all_[i].camera == 1) {
                    board = state_.right_from_left * board;
                }
                all_[i].seen =
                    Eigen::Vector2d(p.seen[0], p.seen[1]) -
                    ellipse_offset(state_.cameras[all_[i].camera], board * all_[i].place, board.r.col(2), p.radius);
            }
        }
    }

    void refine_used() {
        bundle_.sights.clear();
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (sources_[i].used && views_[all_[i].view].used) {
                bundle_.sights.push_back(all_[i]);
            }
        }
        chi_squared_ = refine(bundle_, state_);
    }

    /// Whether what counts has changed.
    bool judge() {
        std::vector<double> lengths;
        std::vector<double> counted;
        for (std::size_t i = 0; i < all_.size(); ++i) {
            lengths.push_back(length(i));
            if (views_[all_[i].view].used) {
                counted.push_back(lengths.back());
            }
        }
        const double noise = std::max(median_of(counted) / kMedianOfTwo, settings_.least_noise_px);
        bool changed = false;
        for (std::size_t i = 0; i < all_.size(); ++i) {
            const bool used = lengths[i] <= settings_.outlier * noise;
            changed = changed || used != sources_[i].used;
            sources_[i].used = used;
        }
        for (std::size_t v = 0; v < views_.size(); ++v) {
            changed = judge_view(v, lengths, noise) || changed;
        }
        return changed;
    }

    bool judge_view(std::size_t v, const std::vector<double>& lengths, double noise) {
        if (!views_[v].used) {
            return false;
        }
        std::array<std::size_t, 2> points{};
        std::array<std::size_t, 2> good{};
        std::array<double, 2> squares{};
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (all_[i].view == v) {
                const std::size_t c = all_[i].camera;
                ++points[c];
                good[c] += sources_[i].used ? 1U : 0U;
                squares[c] += sources_[i].used ? lengths[i] * lengths[i] : 0.0;
            }
        }
        for (std::size_t c = 0; c < 2; ++c) {
            const double n = static_cast<double>(points[c]);
            const double wrong = n > 0.0 ? 1.0 - static_cast<double>(good[c]) / n : 0.0;
            const double rms = good[c] > 0 ? std::sqrt(0.5 * squares[c] / static_cast<double>(good[c])) : 0.0;
            if (wrong > settings_.most_wrong) {
                return leave_out(v, fmt::format("{:.0f} % of its {} points do not fit", 100.0 * wrong, points[c]));
            }
            if (rms > settings_.bad_view * noise) {
                return leave_out(v,
                                 fmt::format("its residuals are {:.2f} px, those of the others {:.2f} px", rms, noise));
            }
        }
        if (good[0] + good[1] < kFewestPoints) {
            return leave_out(v,
                             fmt::format("it has {} points that fit, {} are needed", good[0] + good[1], kFewestPoints));
        }
        return false;
    }

    bool leave_out(std::size_t v, std::string why) {
        views_[v].used = false;
        views_[v].why = std::move(why);
        return true;
    }

    BoardFit result() {
        BoardFit out{
            .state = state_, .covariance = {}, .chi_squared = chi_squared_, .views = views_, .wrong = {}, .points = {}};
        double unknowns = 0.0;
        for (const FixedParameters& fixed : bundle_.fixed) {
            unknowns += static_cast<double>(std::ranges::count(fixed, false));
        }
        unknowns += state_.cameras.size() > 1 ? 6.0 : 0.0;
        for (const ViewFit& view : views_) {
            unknowns += view.used ? 6.0 : 0.0;
        }
        out.freedom = 2.0 * static_cast<double>(bundle_.sights.size()) - unknowns;
        out.noise = out.freedom > 0.0 ? std::sqrt(chi_squared_ / out.freedom) : 0.0;
        const auto spread = spread_of(bundle_, state_);
        out.covariance = out.noise * out.noise * spread.common;
        for (std::size_t v = 0; v < views_.size(); ++v) {
            finish_view(out.views[v], v, out.noise * out.noise * spread.own[v]);
        }
        finish_points(out);
        return out;
    }

    void finish_view(ViewFit& view, std::size_t v, const BoardSystem::ViewMatrix& covariance) const {
        const Motion& board = state_.boards[v];
        view.rotation = to_mat(board.r);
        view.translation = to_vec(board.t);
        for (std::size_t k = 0; k < 6; ++k) {
            const auto i = static_cast<Eigen::Index>(k);
            view.sigma[k] = view.used ? std::sqrt(std::max(covariance(i, i), 0.0)) : 0.0;
        }
        view.tilt = std::acos(std::min(std::abs(board.r(2, 2)), 1.0));
        std::array<double, 2> squares{};
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (all_[i].view == v && sources_[i].used) {
                const double off = (all_[i].seen - predicted(state_, all_[i])).norm();
                squares[all_[i].camera] += off * off;
                ++view.points[all_[i].camera];
            }
        }
        for (std::size_t c = 0; c < 2; ++c) {
            view.rms[c] = view.points[c] > 0 ? std::sqrt(0.5 * squares[c] / static_cast<double>(view.points[c])) : 0.0;
        }
    }

    void finish_points(BoardFit& out) const {
        for (std::size_t i = 0; i < all_.size(); ++i) {
            const BoardPoint& p = *sources_[i].point;
            const Eigen::Vector2d off = all_[i].seen - predicted(state_, all_[i]);
            out.points.push_back({.view = all_[i].view,
                                  .camera = all_[i].camera,
                                  .column = p.column,
                                  .row = p.row,
                                  .used = sources_[i].used && views_[all_[i].view].used,
                                  .seen = p.seen,
                                  .off = {off[0], off[1]}});
            if (!sources_[i].used && views_[all_[i].view].used) {
                out.wrong.push_back({.view = views_[all_[i].view].name,
                                     .camera = all_[i].camera,
                                     .column = p.column,
                                     .row = p.row,
                                     .line = p.line,
                                     .off = off.norm(),
                                     .swapped = partner_of(i, out.noise)});
            }
        }
    }

    /// The other wrong point of the picture that lies where this one belongs, and the other way round.
    [[nodiscard]] std::optional<std::array<int, 2>> partner_of(std::size_t i, double noise) const {
        const double limit = settings_.outlier * std::max(noise, settings_.least_noise_px);
        for (std::size_t j = 0; j < all_.size(); ++j) {
            if (j != i && !sources_[j].used && all_[j].view == all_[i].view && all_[j].camera == all_[i].camera &&
                (all_[i].seen - predicted(state_, all_[j])).norm() < limit &&
                (all_[j].seen - predicted(state_, all_[i])).norm() < limit) {
                return std::array{sources_[j].point->column, sources_[j].point->row};
            }
        }
        return std::nullopt;
    }

    BoardFitSettings settings_;
    BoardState state_;
    std::vector<ViewFit> views_;
    BoardBundle bundle_;
    std::vector<BoardSight> all_;
    std::vector<Source> sources_;
    double chi_squared_ = 0.0;
};

}  // namespace

std::string WrongPoint::text() const {
    const std::string where = line > 0 ? fmt::format(" (line {})", line) : "";
    const std::string of =
        fmt::format("view {}{}, point column {} row {}{}", view, camera == 1 ? " right" : "", column, row, where);
    return swapped ? fmt::format("{} has changed places with column {} row {}", of, (*swapped)[0], (*swapped)[1])
                   : fmt::format("{} lies {:.2f} px off", of, off);
}

BoardFit fit_boards(const std::vector<BoardSights>& sights, const BoardState& start,
                    const std::vector<FixedParameters>& fixed, const BoardFitSettings& settings) {
    return Fitter(sights, start, fixed, settings).run();
}

std::optional<Motion> pose_by_homography(const BoardView& view, const CameraModel& camera) {
    std::vector<PlanePair> pairs;
    for (const BoardPoint& p : view.points) {
        if (const auto ray = undistorted(camera, p.seen)) {
            pairs.push_back({.board = {p.place.x, p.place.y}, .seen = {ray->x, ray->y}});
        }
    }
    const auto homography = robust_homography(pairs);
    return homography ? std::optional(motion_of(*homography)) : std::nullopt;
}

double rms_of(const BoardFit& fit, std::size_t camera) {
    double squares = 0.0;
    double count = 0.0;
    for (const PointFit& p : fit.points) {
        if (p.used && p.camera == camera) {
            squares += p.off[0] * p.off[0] + p.off[1] * p.off[1];
            count += 2.0;
        }
    }
    return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

}  // namespace sc::host
