// SPDX-License-Identifier: Apache-2.0
#include "host/path/arc_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

namespace sc::host {

namespace {

constexpr std::size_t kFewest = 4;  ///< pieces that one arc replaces
constexpr int kRounds = 3;          ///< of moving the arc to the middle of its points
constexpr double kWidest = 100.0;   ///< metres; the controller takes no wider arc

/// Of the points between the ends: how far they lie outside the circle at most, and inside.
struct Spread {
    double outside = 0.0;
    double inside = 0.0;
};

/// The arc stays as near to all pieces as it must: points near it, in order, and no piece a chord that bulges too far.
std::optional<Spread> spread_of(std::span<const Piece> run, const Circle& circle, double allowed) {
    Spread spread;
    const double radius = circle.radius();
    const Vec3 normal = (1.0 / (radius * radius)) * cross(circle.first, circle.second);
    double before = 0.0;
    bool good = true;
    for (const Piece& piece : run) {
        const Vec3 off = piece.to - circle.centre;
        const double out = std::hypot(dot(off, circle.first), dot(off, circle.second)) / radius - radius;
        spread.outside = std::max(spread.outside, out);
        spread.inside = std::min(spread.inside, out);
        double phi = std::atan2(dot(off, circle.second), dot(off, circle.first));
        phi = &piece == &run.back() ? circle.angle : (phi < 0.0 ? phi + 2.0 * std::numbers::pi : phi);
        const double sagitta = radius * (1.0 - std::cos(0.5 * (phi - before)));
        good = good && phi > before && phi <= circle.angle && std::hypot(out, dot(off, normal)) <= allowed &&
               std::abs(out) + sagitta <= allowed;
        before = phi;
    }
    return good ? std::optional(spread) : std::nullopt;
}

std::optional<Circle> arc_for(std::span<const Piece> run, double allowed) {
    const Vec3 from = run.front().from;
    const Vec3 to = run.back().to;
    const Vec3 chord = to - from;
    const double square = dot(chord, chord);
    Vec3 bulge{};
    for (const Piece& piece : run.first(run.size() - 1)) {
        const Vec3 off = piece.to - from;
        const Vec3 across = square > 0.0 ? off - (dot(off, chord) / square) * chord : off;
        bulge = dot(across, across) > dot(bulge, bulge) ? across : bulge;
    }
    const double height = norm(bulge);
    if (!(square > 0.0) || !(height > 0.0) || height > 0.5 * std::sqrt(square) * (1.0 + 1e-9)) {
        return std::nullopt;  // straight, or more than half a turn
    }
    double at = height;
    for (int round = 0; round < kRounds; ++round) {
        const auto circle = circle_through(from, from + 0.5 * chord + (at / height) * bulge, to);
        if (!circle || circle->radius() > kWidest) {
            return std::nullopt;
        }
        if (spread_of(run, *circle, allowed)) {
            return circle;
        }
        const auto spread = spread_of(run, *circle, 1.0);
        if (!spread) {
            return std::nullopt;
        }
        at += 0.5 * (spread->outside + spread->inside);
    }
    return std::nullopt;
}

/// Straight pieces from `first` on, at most.
std::size_t straight_from(std::span<const Piece> pieces) {
    const auto arc = std::ranges::find_if(pieces, [](const Piece& piece) { return piece.circle.has_value(); });
    return static_cast<std::size_t>(arc - pieces.begin());
}

/// The longest run from the beginning that an arc can replace, found by doubling and halving.
std::size_t longest_run(std::span<const Piece> pieces, double allowed) {
    const auto fits = [&](std::size_t count) { return arc_for(pieces.first(count), allowed).has_value(); };
    if (pieces.size() < kFewest || !fits(kFewest)) {
        return 0;
    }
    std::size_t good = kFewest;
    std::size_t bad = 2 * good;
    while (bad <= pieces.size() && fits(bad)) {
        good = bad;
        bad *= 2;
    }
    bad = std::min(bad, pieces.size() + 1);
    while (bad - good > 1) {
        const std::size_t middle = good + (bad - good) / 2;
        (fits(middle) ? good : bad) = middle;
    }
    return good;
}

}  // namespace

std::vector<Piece> fit_arcs(const std::vector<Piece>& pieces, double allowed) {
    std::vector<Piece> out;
    std::size_t straight = 0;
    for (std::size_t i = 0; i < pieces.size();) {
        const std::span<const Piece> rest = std::span(pieces).subspan(i);
        straight = straight > 0 ? straight : straight_from(rest);
        const std::size_t count = longest_run(rest.first(straight), allowed);
        if (count == 0) {
            out.push_back(pieces[i]);
        } else {
            const std::span<const Piece> run = rest.first(count);
            out.push_back({run.front().from, run.back().to, arc_for(run, allowed), run.back().line});
        }
        const std::size_t taken = std::max<std::size_t>(count, 1);
        i += taken;
        straight -= std::min(straight, taken);
    }
    return out;
}

}  // namespace sc::host
