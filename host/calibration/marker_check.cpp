// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/marker_check.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sc::host {
namespace {

constexpr double kLimit = 6.0;  ///< sigmas of a distance
constexpr std::size_t kLeastViews = 3;

using Pair = std::pair<int, int>;
Pair pair_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The body's distances, as most views see them.
class Body {
public:
    Body(const std::vector<MarkerView>& views, double sigma) : sigma_(sigma) {
        std::map<Pair, std::vector<double>> seen;
        for (const MarkerView& view : views) {
            for (std::size_t i = 0; i < view.markers.size(); ++i) {
                for (std::size_t j = 0; j < i; ++j) {
                    const SeenMarker& a = view.markers[i];
                    const SeenMarker& b = view.markers[j];
                    seen[pair_of(a.id, b.id)].push_back(norm(a.place - b.place));
                }
            }
        }
        std::vector<double> off;
        for (const auto& [pair, values] : seen) {
            if (values.size() < kLeastViews) {
                continue;
            }
            const double middle = median(values);
            distance_[pair] = middle;
            for (const double v : values) {
                off.push_back(std::abs(v - middle));
            }
        }
        if (!off.empty()) {
            scatter_ = 1.4826 * median(off);
        }
    }
    /// Whether marker `a` taken for number `id` stands right to `b`; nothing where that distance is not known.
    [[nodiscard]] std::optional<bool> fits(const SeenMarker& a, int id, const SeenMarker& b) const {
        const auto at = distance_.find(pair_of(id, b.id));
        if (at == distance_.end() || id == b.id) {
            return std::nullopt;
        }
        const double stated = std::sqrt(variance(a) + variance(b));
        return std::abs(norm(a.place - b.place) - at->second) <= kLimit * std::max(stated, scatter_);
    }
    [[nodiscard]] std::vector<int> ids() const {
        std::vector<int> out;
        for (const auto& entry : distance_) {
            out.push_back(entry.first.first);
            out.push_back(entry.first.second);
        }
        std::ranges::sort(out);
        out.erase(std::unique(out.begin(), out.end()), out.end());
        return out;
    }

private:
    [[nodiscard]] double variance(const SeenMarker& m) const {
        const double most = std::max({m.sigma.x, m.sigma.y, m.sigma.z});
        return most > 0.0 ? most * most : sigma_ * sigma_;
    }

    double sigma_;
    double scatter_ = 0.0;
    std::map<Pair, double> distance_;
};

/// How many of the others a marker stands wrong to, and of how many.
std::pair<int, int> wrong_of(const Body& body, const SeenMarker& marker, int id,
                             const std::vector<SeenMarker>& others) {
    int wrong = 0;
    int known = 0;
    for (const SeenMarker& other : others) {
        if (&other == &marker) {
            continue;
        }
        if (const auto fits = body.fits(marker, id, other)) {
            ++known;
            wrong += *fits ? 0 : 1;
        }
    }
    return {wrong, known};
}

/// Takes out of `markers`, the worst first, what stands wrong to more than a quarter of the rest.
std::vector<SeenMarker> take_suspects(const Body& body, std::vector<SeenMarker>& markers) {
    std::vector<SeenMarker> suspects;
    while (markers.size() > 2) {
        std::size_t worst = 0;
        int most = 0;
        for (std::size_t i = 0; i < markers.size(); ++i) {
            const auto [wrong, known] = wrong_of(body, markers[i], markers[i].id, markers);
            if (4 * wrong > known && wrong > most) {
                worst = i;
                most = wrong;
            }
        }
        if (most == 0) {
            break;
        }
        suspects.push_back(markers[worst]);
        markers.erase(markers.begin() + static_cast<std::ptrdiff_t>(worst));
    }
    return suspects;
}

/// The number under which the marker stands right to all that are left.
std::optional<int> true_id(const Body& body, const SeenMarker& marker, const std::vector<SeenMarker>& right) {
    for (const int id : body.ids()) {
        if (std::ranges::find(right, id, &SeenMarker::id) != right.end()) {
            continue;
        }
        const auto [wrong, known] = wrong_of(body, marker, id, right);
        if (known >= 3 && wrong == 0) {
            return id;
        }
    }
    return std::nullopt;
}

void check_view(const Body& body, MarkerView& view, std::vector<MarkerFinding>& findings) {
    std::vector<SeenMarker> right = view.markers;
    std::map<int, int> renamed;
    std::vector<MarkerFinding> here;
    for (const SeenMarker& suspect : take_suspects(body, right)) {
        const auto id = true_id(body, suspect, right);
        MarkerFinding finding{.view = view.view, .line = suspect.line, .id = suspect.id};
        if (id) {
            SeenMarker put_right = suspect;
            put_right.id = *id;
            right.push_back(put_right);
            if (*id == suspect.id) {
                continue;
            }
            finding.kind = MarkerFinding::Kind::misnumbered;
            finding.other = *id;
            renamed[suspect.id] = *id;
        }
        here.push_back(finding);
    }
    for (const MarkerFinding& finding : here) {
        const auto back = renamed.find(finding.other);
        if (finding.kind == MarkerFinding::Kind::misnumbered && back != renamed.end() && back->second == finding.id) {
            if (finding.id < finding.other) {
                findings.push_back(finding);
                findings.back().kind = MarkerFinding::Kind::swapped;
            }
        } else {
            findings.push_back(finding);
        }
    }
    view.markers = std::move(right);
}

}  // namespace

std::string MarkerFinding::text() const {
    switch (kind) {
        case Kind::swapped: return fmt::format("view {}: markers {} and {} are swapped; put right", view, id, other);
        case Kind::misnumbered:
            return fmt::format("view {}: what is called marker {} is {}; put right", view, id, other);
        case Kind::wrong: return fmt::format("view {}: marker {} fits no marker of the target; left out", view, id);
    }
    return {};
}

std::vector<MarkerFinding> check_markers(std::vector<MarkerView>& views, double sigma) {
    std::vector<MarkerFinding> findings;
    if (views.size() < kLeastViews) {
        return findings;
    }
    const Body body(views, sigma);
    for (MarkerView& view : views) {
        check_view(body, view, findings);
    }
    return findings;
}

}  // namespace sc::host
