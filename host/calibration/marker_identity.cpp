// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/marker_identity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "host/calibration/motion.hpp"

namespace sc::host {
namespace {

constexpr double kSigmas = 5.0;
constexpr std::size_t kMostPairs = 60;  ///< of places from which motions are tried
constexpr std::size_t kMostThirds = 4;  ///< places a pair is completed with
constexpr double kLeastSine = 0.15;     ///< of a triple: nearly on a line says nothing of the turn

using Order = std::vector<std::optional<std::size_t>>;  ///< marker of the target for each place

struct Hypothesis {
    Order order;
    std::size_t count = 0;
    double squares = 0.0;
    Motion motion;
};

class Identifier {
public:
    Identifier(const Target& target, const std::vector<PlacedMarker>& places, const IdentityOptions& options) {
        double target_sigma = 0.0;
        for (const TargetMarker& m : target.markers) {
            markers_.push_back(to_eigen(m.place));
            target_sigma = std::max(target_sigma, m.sigma);
        }
        for (const PlacedMarker& p : places) {
            places_.push_back(to_eigen(p.place));
            limits_.push_back(options.tolerance + kSigmas * (p.sigma + target_sigma));
        }
    }

    void run() {
        for (const auto& [a, b] : pairs()) {
            const double length = (places_[a] - places_[b]).norm();
            const double room = limits_[a] + limits_[b];
            for (std::size_t p = 0; p < markers_.size(); ++p) {
                for (std::size_t q = 0; q < markers_.size(); ++q) {
                    if (p != q && std::abs((markers_[p] - markers_[q]).norm() - length) < room) {
                        complete({a, b}, {p, q});
                    }
                }
            }
        }
    }

    [[nodiscard]] const Hypothesis& best() const { return best_; }
    /// Another order that fits as many.
    [[nodiscard]] const std::optional<Hypothesis>& rival() const { return rival_; }
    [[nodiscard]] const std::vector<Eigen::Vector3d>& places() const { return places_; }

private:
    using Two = std::array<std::size_t, 2>;

    /// The longest first: they tell the turn best.
    [[nodiscard]] std::vector<Two> pairs() const {
        std::vector<Two> out;
        for (std::size_t a = 0; a < places_.size(); ++a) {
            for (std::size_t b = a + 1; b < places_.size(); ++b) {
                out.push_back({a, b});
            }
        }
        const auto length = [&](const Two& two) { return -(places_[two[0]] - places_[two[1]]).norm(); };
        std::ranges::sort(out, {}, length);
        // Every place must come up, or a false one that is far away would be in all pairs.
        std::vector<std::size_t> used(places_.size(), 0);
        std::vector<Two> spread;
        for (std::size_t most = 1; most <= places_.size() && spread.size() < kMostPairs; ++most) {
            for (const Two& two : out) {
                if (spread.size() < kMostPairs && used[two[0]] < most && used[two[1]] < most &&
                    std::ranges::find(spread, two) == spread.end()) {
                    ++used[two[0]];
                    ++used[two[1]];
                    spread.push_back(two);
                }
            }
        }
        return spread;
    }

    void complete(const Two& seen, const Two& known) {
        std::size_t thirds = 0;
        for (std::size_t c = 0; c < places_.size() && thirds < kMostThirds; ++c) {
            if (c == seen[0] || c == seen[1]) {
                continue;
            }
            const Eigen::Vector3d u = places_[seen[1]] - places_[seen[0]];
            const Eigen::Vector3d v = places_[c] - places_[seen[0]];
            if (u.cross(v).norm() < kLeastSine * u.norm() * v.norm()) {
                continue;
            }
            bool found = false;
            for (std::size_t r = 0; r < markers_.size(); ++r) {
                if (r != known[0] && r != known[1] && alike(c, r, seen[0], known[0]) &&
                    alike(c, r, seen[1], known[1])) {
                    found = true;
                    const std::array three{PlacePair{.to = places_[seen[0]], .from = markers_[known[0]]},
                                           PlacePair{.to = places_[seen[1]], .from = markers_[known[1]]},
                                           PlacePair{.to = places_[c], .from = markers_[r]}};
                    judge(fit_motion(three));
                }
            }
            thirds += found ? 1U : 0U;
        }
    }

    [[nodiscard]] bool alike(std::size_t a, std::size_t p, std::size_t b, std::size_t q) const {
        return std::abs((places_[a] - places_[b]).norm() - (markers_[p] - markers_[q]).norm()) <
               limits_[a] + limits_[b];
    }

    /// Every place at its nearest marker; fitted again to those within the limit.
    void judge(Motion motion) {
        Hypothesis now;
        for (int round = 0; round < 2; ++round) {
            now = order_of(motion, round == 0 ? 3.0 : 1.0);
            if (now.count < 3) {
                return;
            }
            std::vector<PlacePair> pairs;
            for (std::size_t i = 0; i < places_.size(); ++i) {
                if (now.order[i]) {
                    pairs.push_back({.to = places_[i], .from = markers_[*now.order[i]]});
                }
            }
            motion = fit_motion(pairs);
        }
        now = order_of(motion, 1.0);
        if (now.count > best_.count || (now.count == best_.count && now.squares < best_.squares)) {
            std::swap(now, best_);
        }
        // `now` is the lesser of the two.
        if (rival_ && rival_->count < best_.count) {
            rival_.reset();
        }
        if (now.count == best_.count && now.order != best_.order) {
            rival_ = std::move(now);
        }
    }

    [[nodiscard]] Hypothesis order_of(const Motion& motion, double room) const {
        Hypothesis out{.order = Order(places_.size()), .count = 0, .squares = 0.0, .motion = motion};
        std::vector<bool> taken(markers_.size(), false);
        for (std::size_t i = 0; i < places_.size(); ++i) {
            double least = room * limits_[i];
            std::size_t nearest = markers_.size();
            for (std::size_t k = 0; k < markers_.size(); ++k) {
                const double far = (motion * markers_[k] - places_[i]).norm();
                if (far < least && !taken[k]) {
                    least = far;
                    nearest = k;
                }
            }
            if (nearest < markers_.size()) {
                taken[nearest] = true;
                out.order[i] = nearest;
                out.squares += least * least;
                ++out.count;
            }
        }
        return out;
    }

    std::vector<Eigen::Vector3d> markers_;
    std::vector<Eigen::Vector3d> places_;
    std::vector<double> limits_;
    Hypothesis best_;
    std::optional<Hypothesis> rival_;
};

/// A place that two orders call differently.
std::string difference(const Target& target, const Order& a, const Order& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] && b[i] && a[i] != b[i]) {
            return fmt::format("marker {} may as well be marker {}", target.markers[*a[i]].id,
                               target.markers[*b[i]].id);
        }
    }
    return "other places are taken for markers";
}

}  // namespace

std::expected<MarkerIdentity, std::string> identify_markers(const Target& target,
                                                            const std::vector<PlacedMarker>& places,
                                                            const IdentityOptions& options) {
    Identifier identifier(target, places, options);
    identifier.run();
    const Hypothesis& best = identifier.best();
    if (best.count < std::max<std::size_t>(options.fewest, 3)) {
        return std::unexpected(fmt::format(
            "the target is not recognised: {} of {} places fit its {} markers, {} are needed; see whether it is this "
            "target ({}), its unit is right and enough of it is in view",
            best.count, places.size(), target.markers.size(), options.fewest, target.id));
    }
    if (identifier.rival()) {
        return std::unexpected(fmt::format(
            "the order of the markers is ambiguous: {} places fit in two ways, {}; the layout looks the same when "
            "turned: use a target without symmetry, or show more of it",
            best.count, difference(target, best.order, identifier.rival()->order)));
    }
    MarkerIdentity out;
    std::set<int> seen;
    std::vector<PlacePair> pairs;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto& marker = best.order[i];
        out.ids.push_back(marker ? std::optional(target.markers[*marker].id) : std::nullopt);
        if (marker) {
            seen.insert(target.markers[*marker].id);
            pairs.push_back({.to = identifier.places()[i], .from = to_eigen(target.markers[*marker].place)});
        }
    }
    for (const TargetMarker& m : target.markers) {
        if (!seen.contains(m.id)) {
            out.missing.push_back(m.id);
        }
    }
    const Motion motion = fit_motion(pairs);
    double squares = 0.0;
    for (const PlacePair& p : pairs) {
        squares += (p.to - motion * p.from).squaredNorm();
    }
    out.rotation = to_mat(motion.r);
    out.translation = to_vec(motion.t);
    out.rms = std::sqrt(squares / static_cast<double>(pairs.size()));
    return out;
}

}  // namespace sc::host
