// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/timing.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kRounding = 1e-11;     ///< of a bound on u
constexpr double kLevel = 1e-13;        ///< a factor of u that is but rounding
constexpr double kLeastShare = 0.15;    ///< of the guess, below which b is not let fall
constexpr std::uint32_t kMostCuts = 6;  ///< of the next set, to where there is a u at all
constexpr double kLeastPart = 0.02;     ///< of an edge, that a change of the limit is away from its ends
constexpr double kCapSlack = 1.0 + 1e-9;
constexpr double kSteepest = 20.0;  ///< c, per greatest acceleration

/// b·B + c·C + u·U ≤ R
struct Row {
    double b = 0.0;
    double c = 0.0;
    double u = 0.0;
    double r = 0.0;
};

/// Jerk at x behind the node: |q''' b + 3/2 q'' c + 1/2 q' u| ≤ J (3/2 − b / 2 b̂) / √b̂ at that place. The rows are in
/// terms of the state at `origin`, 0 or h; `take` gets each.
template <class Take>
void jerk_rows(const Limits& limits, const Node& node, const Node& next, double origin, const Take& take) noexcept {
    const double share = kJerkShare * node.share * (1.0 + node.slack);
    // In the middle too, where a check found the jerk too large.
    const int step = node.share != 1.0 ? 1 : 2;
    for (int i = 0; i < 3; i += step) {
        const double x = 0.5 * i * node.h;
        const double y = x - origin;
        const double guess = i == 0 ? node.guess : (i == 1 ? 0.5 * (node.guess + next.guess) : next.guess);
        const double right_share = share / square_root(guess);
        const double slope_share = 0.5 * right_share / guess;
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            const double d3 = node.d3[k];
            if (node.d1[k] == 0.0 && node.d2[k] == 0.0 && d3 == 0.0) {
                continue;
            }
            const double d2 = node.d2[k] + x * d3;
            const double d1 = node.d1[k] + x * (node.d2[k] + 0.5 * x * d3);
            const double row_c = d3 * y + 1.5 * d2;
            const double row_u = y * (0.5 * d3 * y + 1.5 * d2) + 0.5 * d1;
            const double right = 1.5 * limits.jerk[k] * right_share;
            const double slope = limits.jerk[k] * slope_share;
            const double slope_c = slope * y;
            const double slope_u = 0.5 * slope_c * y;
            take(Row{slope + d3, slope_c + row_c, slope_u + row_u, right});
            take(Row{slope - d3, slope_c - row_c, slope_u - row_u, right});
        }
    }
}

void add_bound(const Row& row, Workspace& workspace) noexcept {
    const double r = 1.0 / row.u;
    Bounds& bounds = row.u > 0.0 ? workspace.above : workspace.below;
    bounds.each[bounds.count++] = {row.r * r, -row.b * r, -row.c * r};
}

/// Bounds on u for c at the node, whatever the curve, so that there are some at all.
void start_bounds(const Limits& limits, double h, bool from_next, Workspace& workspace) noexcept {
    double fastest = 0.0;
    for (const double a : limits.acceleration) {
        fastest = larger(fastest, a);
    }
    const double r = 1.0 / h;
    const double steepest = kSteepest * fastest * r;
    workspace.above.each[0] = {steepest, 0.0, from_next ? r : -r};
    workspace.below.each[0] = {-steepest, 0.0, from_next ? r : -r};
    workspace.above.count = workspace.below.count = 1;
}

/// Greatest and least u at a corner, and which bounds they are.
void find_range(const Workspace& workspace, Workspace::Corner& corner) noexcept {
    const double b = corner.b;
    const double c = corner.c;
    double high = workspace.above.each[0].at(b, c);
    std::uint32_t above = 0;
    for (std::uint32_t k = 1; k < workspace.above.count; ++k) {
        const double u = workspace.above.each[k].at(b, c);
        if (u < high) {
            high = u;
            above = k;
        }
    }
    double low = workspace.below.each[0].at(b, c);
    std::uint32_t below = 0;
    for (std::uint32_t k = 1; k < workspace.below.count; ++k) {
        const double u = workspace.below.each[k].at(b, c);
        if (u > low) {
            low = u;
            below = k;
        }
    }
    corner.high = high;
    corner.low = low;
    corner.above = static_cast<std::uint8_t>(above);
    corner.below = static_cast<std::uint8_t>(below);
    corner.known = true;
}

/// The corners of the next set, without those for which there is no u: cut off by the two bounds that leave none, or
/// dropped.
void find_corners(Workspace& workspace) noexcept {
    std::uint32_t cuts = 0;
    Workspace::Corners& corners = workspace.corners;
    for (std::uint32_t i = 0; i < corners.count;) {
        Workspace::Corner& corner = corners.each[i];
        if (corner.known) {
            ++i;
            continue;
        }
        find_range(workspace, corner);
        if (corner.low - corner.high <= kRounding * (absolute(corner.low) + absolute(corner.high))) {
            ++i;
            continue;
        }
        if (cuts == kMostCuts || corners.count == Workspace::Corners::kCapacity) {
            --corners.count;
            for (std::uint32_t k = i; k < corners.count; ++k) {
                corners.move(k, k + 1);
            }
            continue;
        }
        ++cuts;
        const Bound& high = workspace.above.each[corner.above];
        const Bound& low = workspace.below.each[corner.below];
        corner.high = corner.low = 0.5 * (corner.high + corner.low);
        if (cut(corners, low.by_b - high.by_b, low.by_c - high.by_c, high.constant - low.constant)) {
            i = 0;
        }
    }
}

/// Ends of the ranges of u as states of this node, in coordinates in which u moves along the second alone: b + h c / 2
/// and c. In the order of the corners.
template <bool kHigh>
void fill_chain(Workspace& workspace, double h) noexcept {
    Workspace::Chain& chain = workspace.points;
    chain.count = 0;
    const auto put = [&](const State& next, double u) noexcept {
        chain.at[chain.count++] = {next.b - 0.5 * h * next.c, next.c - h * u};
    };
    const std::uint32_t count = workspace.corners.count;
    // Room for what changes of the limit add.
    auto spare = static_cast<std::uint32_t>(chain.at.size()) - count;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Workspace::Corner& a = workspace.corners.each[i];
        const Workspace::Corner& z = workspace.corners.each[i + 1 == count ? 0 : i + 1];
        put(a, kHigh ? a.low : a.high);
        const std::uint32_t from = kHigh ? a.below : a.above;
        const std::uint32_t to = kHigh ? z.below : z.above;
        if (from == to || spare == 0) {
            continue;
        }
        const Bounds& bounds = kHigh ? workspace.below : workspace.above;
        const double start = bounds.each[to].at(a.b, a.c) - (kHigh ? a.low : a.high);
        const double end = (kHigh ? z.low : z.high) - bounds.each[from].at(z.b, z.c);
        const double t = start / (start - end);
        if (!(t > kLeastPart && t < 1.0 - kLeastPart)) {
            continue;
        }
        const State on{a.b + t * (z.b - a.b), a.c + t * (z.c - a.c)};
        double u = bounds.each[0].at(on.b, on.c);
        for (std::uint32_t k = 1; k < bounds.count; ++k) {
            const double other = bounds.each[k].at(on.b, on.c);
            u = kHigh ? larger(u, other) : smaller(u, other);
        }
        put(on, u);
        --spare;
    }
}

/// Leaves of the points their convex side, from the least first coordinate to the greatest.
template <bool kHigh>
void make_hull(Workspace& workspace) noexcept {
    const Workspace::Chain& points = workspace.points;
    auto& hull = workspace.hull.at;
    const std::uint32_t count = points.count;
    std::uint32_t f = 0;
    for (std::uint32_t i = 1; i < count; ++i) {
        f = points.at[i].b < points.at[f].b ? i : f;
    }
    // The points go up and down once: merged from the lowest on, both ways.
    std::uint32_t g = f == 0 ? count - 1 : f - 1;
    std::uint32_t n = 0;
    for (std::uint32_t taken = 0; taken < count; ++taken) {
        State p;
        if (points.at[f].b <= points.at[g].b) {
            p = points.at[f];
            f = f + 1 == count ? 0 : f + 1;
        } else {
            p = points.at[g];
            g = g == 0 ? count - 1 : g - 1;
        }
        if (n > 0 && !(p.b > hull[n - 1].b)) {
            if (kHigh ? p.c <= hull[n - 1].c : p.c >= hull[n - 1].c) {
                continue;
            }
            --n;
        }
        while (n > 1) {
            const State& y = hull[n - 1];
            const State& x = hull[n - 2];
            const double turn = (y.b - x.b) * (p.c - x.c) - (y.c - x.c) * (p.b - x.b);
            if (kHigh ? turn < 0.0 : turn > 0.0) {
                break;
            }
            --n;
        }
        hull[n++] = p;
    }
    workspace.hull.count = n;
}

/// Both sides of the hull of all that leads to the corners.
void make_set(Workspace& workspace, double h) noexcept {
    Polygon& set = workspace.set;
    const Workspace::Chain& hull = workspace.hull;
    set.count = 0;
    const auto put = [&](const State& p) noexcept { set.put(set.count++, {p.b - 0.5 * h * p.c, p.c}); };
    fill_chain<false>(workspace, h);
    make_hull<false>(workspace);
    for (std::uint32_t i = 0; i < hull.count; ++i) {
        put(hull.at[i]);
    }
    const State first = hull.at[0];
    const State last = hull.at[hull.count - 1];
    fill_chain<true>(workspace, h);
    make_hull<true>(workspace);
    const auto same = [](const State& a, const State& z) noexcept { return a.b == z.b && a.c == z.c; };
    for (std::uint32_t i = hull.count; i-- > 0;) {
        if (!(i == 0 && same(hull.at[i], first)) && !(i + 1 == hull.count && same(hull.at[i], last))) {
            put(hull.at[i]);
        }
    }
}

}  // namespace

Polygon ramp_set(double length, double jerk, bool slowing) noexcept {
    constexpr double kThin = 1e-5;
    constexpr double kLeast = 0.05;
    const double t = cube_root(6.0 * length / jerk);
    const double b = 9.0 * length * length / (t * t);
    const double c = (slowing ? -12.0 : 12.0) * length / (t * t);
    Polygon set;
    set.count = 4;
    set.put(0, {kLeast * b * (1.0 - kThin), kLeast * c});
    set.put(2, {b, c * (1.0 - kThin)});
    // Which way round it is.
    set.put(slowing ? 3 : 1, {kLeast * b * (1.0 + kThin), kLeast * c});
    set.put(slowing ? 1 : 3, {b * (1.0 - kThin), c});
    return set;
}

void clip_state(const Limits& limits, const Node& node, Polygon& set) noexcept {
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        if (node.d1[k] == 0.0 && node.d2[k] == 0.0) {
            continue;
        }
        const double most = limits.acceleration[k] * kAccelerationShare * node.room * (1.0 + 0.15 * node.slack);
        set.clip_both(node.d2[k], 0.5 * node.d1[k], most);
    }
}

bool backward_step(const Limits& limits, Node& node, const Node& next, Workspace& workspace) noexcept {
    const double h = node.h;
    node.set.count = 0;
    Workspace::Corners& corners = workspace.corners;
    corners.count = next.set.count;
    for (std::uint32_t i = 0; i < next.set.count; ++i) {
        corners.put(i, {next.set.b[i], next.set.c[i]});
    }
    start_bounds(limits, h, true, workspace);
    jerk_rows(limits, node, next, h, [&](const Row& row) noexcept {
        if (!(absolute(row.u) > kLevel * h * (absolute(row.c) + h * absolute(row.b)))) {
            if (corners.count < Workspace::Corners::kCapacity) {
                (void)cut(corners, row.b, row.c, row.r);
            }
            return;
        }
        add_bound(row, workspace);
    });
    find_corners(workspace);
    if (corners.count < 3) {
        return false;
    }
    make_set(workspace, h);
    Polygon& set = workspace.set;
    set.clip(1.0, 0.0, node.cap);
    set.clip(-1.0, 0.0, -kLeastShare * node.guess);
    // The middle Bernstein coefficient of b over the cell: with it b stays above zero between the nodes too.
    set.clip(-1.0, -0.5 * h, -kLeastShare * smaller(node.guess, next.guess));
    // And below the greatest, which it would pass on a rise that the next node takes back.
    set.clip(1.0, 0.5 * h, larger(node.cap, next.cap) * kCapSlack);
    clip_state(limits, node, set);
    const State in_force{node.b, node.c};
    set.simplify(StoredPolygon::kCapacity, node.slack > 0.0 ? &in_force : nullptr);
    node.set.store(set);
    return set.count >= 3;
}

bool forward_step(const Limits& limits, const Node& node, Node& next, Workspace& workspace) noexcept {
    const double h = node.h;
    start_bounds(limits, h, false, workspace);
    const auto take = [&](const Row& row) noexcept {
        if (row.u != 0.0) {
            add_bound(row, workspace);
        }
    };
    // Each edge of the next set, in terms of the state of this node.
    const StoredPolygon& set = next.set;
    for (std::uint32_t i = 0; i < set.count; ++i) {
        const std::uint32_t k = i + 1 == set.count ? 0 : i + 1;
        const double nb = set.c[k] - set.c[i];
        const double nc = set.b[i] - set.b[k];
        take({nb, nb * h + nc, h * (0.5 * nb * h + nc), nb * set.b[i] + nc * set.c[i]});
    }
    jerk_rows(limits, node, next, 0.0, take);
    Workspace::Corner& range = workspace.corners.each[0];
    range.b = node.trial_b;
    range.c = node.trial_c;
    find_range(workspace, range);
    // Rounding leaves states a little outside: then the least violation.
    const double u = range.low > range.high ? 0.5 * (range.low + range.high) : range.high;
    next.trial_b = range.b + h * (range.c + 0.5 * h * u);
    next.trial_c = range.c + h * u;
    return next.trial_b > 0.0 && next.trial_b < 1e12 && absolute(next.trial_c) < 1e12;
}

double reach(const StoredPolygon& set, double b, double c) noexcept {
    double most = 1.0;
    for (std::uint32_t i = 0; i < set.count; ++i) {
        const std::uint32_t k = i + 1 == set.count ? 0 : i + 1;
        const double nb = set.c[k] - set.c[i];
        const double nc = set.b[i] - set.b[k];
        const double d = nb * set.b[i] + nc * set.c[i];
        const double q = nb * b + nc * c;
        if (q > 0.0) {
            most = smaller(most, d / q);
        }
    }
    return most;
}

}  // namespace sc::trajectory
