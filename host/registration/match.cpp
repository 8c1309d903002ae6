// SPDX-License-Identifier: Apache-2.0
#include "host/registration/match.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ranges>
#include <utility>

#include <fmt/format.h>

#include "host/calibration/motion.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kLeast = 4;
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr double kFlat = 0.02;  ///< a triangle whose height is less of its longest side fixes no turn

using Places = std::vector<Eigen::Vector3d>;

Places places_of(const std::vector<SeenMarker>& markers) {
    Places out;
    for (const SeenMarker& m : markers) {
        out.push_back(to_eigen(m.place));
    }
    return out;
}

/// A numbering of b by a: partner of each b, or none.
using Numbering = std::vector<std::size_t>;

std::size_t count_of(const Numbering& n) { return n.size() - static_cast<std::size_t>(std::ranges::count(n, kNone)); }

class Matcher {
public:
    Matcher(Places a, Places b, double tolerance) : a_(std::move(a)), b_(std::move(b)), tolerance_(tolerance) {
        for (std::size_t i = 0; i < a_.size(); ++i) {
            for (std::size_t j = 0; j < a_.size(); ++j) {
                if (i != j) {
                    sides_.push_back({(a_[i] - a_[j]).norm(), i, j});
                }
            }
        }
        std::ranges::sort(sides_, {}, &Side::length);
        best_.assign(b_.size(), kNone);
        rival_ = best_;
    }

    std::expected<std::vector<MarkerMatch>, std::string> run() {
        for (std::size_t i = 0; i < b_.size(); ++i) {
            for (std::size_t j = i + 1; j < b_.size(); ++j) {
                try_side(i, j);
            }
        }
        if (count_of(best_) < kLeast) {
            return std::unexpected("no motion brings four markers together");
        }
        if (count_of(rival_) >= count_of(best_)) {
            return std::unexpected("the markers stand so regularly that two numberings fit alike");
        }
        std::vector<MarkerMatch> out;
        for (std::size_t k = 0; k < best_.size(); ++k) {
            if (best_[k] != kNone) {
                out.push_back({best_[k], k});
            }
        }
        return out;
    }

private:
    struct Side {
        double length = 0.0;
        std::size_t i = 0;
        std::size_t j = 0;
    };

    /// All sides of a as long as that of b, then a third corner, then all others.
    void try_side(std::size_t i, std::size_t j) {
        const double length = (b_[i] - b_[j]).norm();
        const double slack = 2.0 * tolerance_;
        for (auto s = std::ranges::lower_bound(sides_, length - slack, {}, &Side::length);
             s != sides_.end() && s->length <= length + slack; ++s) {
            if (best_[i] == s->i && best_[j] == s->j) {
                continue;  // already part of the best
            }
            for (std::size_t k = 0; k < b_.size(); ++k) {
                if (k == i || k == j || flat(b_[i], b_[j], b_[k])) {
                    continue;
                }
                for (std::size_t n = 0; n < a_.size(); ++n) {
                    if (n != s->i && n != s->j && alike(b_[i] - b_[k], a_[s->i] - a_[n]) &&
                        alike(b_[j] - b_[k], a_[s->j] - a_[n])) {
                        try_triple({s->i, s->j, n}, {i, j, k});
                    }
                }
            }
        }
    }
    [[nodiscard]] bool alike(const Eigen::Vector3d& u, const Eigen::Vector3d& v) const {
        return std::abs(u.norm() - v.norm()) <= 2.0 * tolerance_;
    }
    [[nodiscard]] static bool flat(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
        const double longest = std::max({(p - q).norm(), (p - r).norm(), (q - r).norm()});
        return (q - p).cross(r - p).norm() < kFlat * longest * longest;
    }

    [[nodiscard]] Numbering numbering_by(const Motion& a_from_b) const {
        Numbering out(b_.size(), kNone);
        std::vector<double> off(a_.size(), std::numeric_limits<double>::infinity());
        std::vector<std::size_t> holder(a_.size(), kNone);
        for (std::size_t k = 0; k < b_.size(); ++k) {
            const Eigen::Vector3d p = a_from_b * b_[k];
            std::size_t nearest = 0;
            for (std::size_t n = 1; n < a_.size(); ++n) {
                nearest = (a_[n] - p).squaredNorm() < (a_[nearest] - p).squaredNorm() ? n : nearest;
            }
            const double d = (a_[nearest] - p).norm();
            if (d <= tolerance_ && d < off[nearest]) {
                if (holder[nearest] != kNone) {
                    out[holder[nearest]] = kNone;
                }
                out[k] = nearest;
                off[nearest] = d;
                holder[nearest] = k;
            }
        }
        return out;
    }

    void try_triple(const std::array<std::size_t, 3>& in_a, const std::array<std::size_t, 3>& in_b) {
        std::array<PlacePair, 3> three;
        for (std::size_t i = 0; i < 3; ++i) {
            three[i] = {a_[in_a[i]], b_[in_b[i]], 1.0};
        }
        Numbering now = numbering_by(fit_motion(three));
        if (count_of(now) < 3) {
            return;
        }
        std::vector<PlacePair> all;  // once more with all of them: three close together turn the rest too far
        for (std::size_t k = 0; k < now.size(); ++k) {
            if (now[k] != kNone) {
                all.push_back({a_[now[k]], b_[k], 1.0});
            }
        }
        now = numbering_by(fit_motion(all));
        if (now == best_) {
            return;
        }
        if (count_of(now) > count_of(best_)) {
            std::swap(now, best_);
        }
        // A rival numbers some marker otherwise; a part of the best is none.
        const bool other = std::ranges::any_of(std::views::iota(std::size_t{0}, now.size()),
                                               [&](std::size_t k) { return now[k] != kNone && now[k] != best_[k]; });
        if (other && count_of(now) > count_of(rival_)) {
            rival_ = now;
        }
    }

    Places a_;
    Places b_;
    double tolerance_;
    std::vector<Side> sides_;
    Numbering best_;
    Numbering rival_;
};

std::vector<PlacePair> pairs_of(const std::vector<SeenMarker>& a, const std::vector<SeenMarker>& b) {
    std::vector<PlacePair> out;
    for (const SeenMarker& m : a) {
        const auto other = std::ranges::find(b, m.id, &SeenMarker::id);
        if (other != b.end()) {
            out.push_back({to_eigen(m.place), to_eigen(other->place), 1.0});
        }
    }
    return out;
}

double rms_of(const std::vector<PlacePair>& pairs) {
    const Motion motion = fit_motion(pairs);
    double sum = 0.0;
    for (const PlacePair& p : pairs) {
        sum += (p.to - motion * p.from).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(pairs.size()));
}

}  // namespace

std::expected<std::vector<MarkerMatch>, std::string> match_by_distances(const std::vector<SeenMarker>& a,
                                                                        const std::vector<SeenMarker>& b,
                                                                        double tolerance) {
    if (a.size() < kLeast || b.size() < kLeast) {
        return std::unexpected(fmt::format("fewer than four markers ({} and {})", a.size(), b.size()));
    }
    return Matcher(places_of(a), places_of(b), tolerance).run();
}

std::string misfit_reason(const std::vector<SeenMarker>& a, const std::vector<SeenMarker>& b) {
    std::vector<PlacePair> pairs = pairs_of(a, b);
    if (pairs.size() < kLeast) {
        return {};
    }
    std::vector<double> ratios;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const double from = (pairs[i].from - pairs[j].from).norm();
            if (from > 0.0) {
                ratios.push_back((pairs[i].to - pairs[j].to).norm() / from);
            }
        }
    }
    if (ratios.empty()) {
        return {};
    }
    std::ranges::sort(ratios);
    const double ratio = ratios[ratios.size() / 2];
    // All distances larger alike: not what wrong markers do.
    const double spread = ratios[3 * ratios.size() / 4] / ratios[ratios.size() / 4];
    struct Unit {
        const char* name;
        double ratio;
    };
    constexpr std::array kUnits{Unit{"mm for m", 1000.0},   Unit{"m for mm", 1e-3},
                                Unit{"mm for inch", 25.4},  Unit{"inch for mm", 1.0 / 25.4},
                                Unit{"m for inch", 0.0254}, Unit{"inch for m", 1.0 / 0.0254},
                                Unit{"mm for cm", 10.0},    Unit{"cm for mm", 0.1}};
    if (std::abs(ratio - 1.0) > 0.02 && spread < 1.01) {
        for (const Unit& u : kUnits) {
            if (std::abs(ratio / u.ratio - 1.0) < 0.01) {
                return fmt::format("their units differ: distances are {:.5g} times as long ({})", ratio, u.name);
            }
        }
        return fmt::format("their units or scales differ: distances are {:.5g} times as long", ratio);
    }
    const double proper = rms_of(pairs);
    for (PlacePair& p : pairs) {
        p.from[2] = -p.from[2];
    }
    if (rms_of(pairs) < 0.05 * proper && proper > 1e-3) {
        return "one of their frames is left-handed: they fit as mirror images alone";
    }
    return {};
}

}  // namespace sc::host
