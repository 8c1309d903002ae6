// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/timing.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kRounding = 1e-11;  ///< of a bound on u
constexpr std::uint32_t kMostCuts = 64;
constexpr double kLeastShare = 0.15;  ///< of the guess, below which b is not let fall

/// The next state must lie in `set`: each edge of it as a row in the state of this node.
void add_set_rows(const StoredPolygon& set, double h, Rows& rows) noexcept {
    for (std::uint32_t i = 0; i < set.count; ++i) {
        const std::uint32_t k = i + 1 == set.count ? 0 : i + 1;
        const double nb = set.c[k] - set.c[i];
        const double nc = set.b[i] - set.b[k];
        if (nb == 0.0 && nc == 0.0) {
            continue;
        }
        const double d = nb * set.b[i] + nc * set.c[i];
        rows.add({nb, nb * h + nc, h * (0.5 * nb * h + nc), d});
    }
}

/// Jerk of axis k at x behind the node: |q''' b + 3/2 q'' c + 1/2 q' u| ≤ J (3/2 − b / 2 b̂) / √b̂ at that place.
void add_jerk_rows(const Node& node, std::size_t k, double x, double guess, double jerk, Rows& rows) noexcept {
    const double d3 = node.d3[k];
    const double d2 = node.d2[k] + x * d3;
    const double d1 = node.d1[k] + x * (node.d2[k] + 0.5 * x * d3);
    // b and c at x in terms of b, c, u at the node.
    const double row_c = d3 * x + 1.5 * d2;
    const double row_u = 0.5 * d3 * x * x + 1.5 * d2 * x + 0.5 * d1;
    const double right = jerk / square_root(guess);
    const double slope = 0.5 * right / guess;
    const double slope_u = 0.5 * slope * x * x;
    rows.add({slope + d3, slope * x + row_c, slope_u + row_u, 1.5 * right});
    rows.add({slope - d3, slope * x - row_c, slope_u - row_u, 1.5 * right});
}

void fill(const Limits& limits, const Node& node, const Node& next, Rows& rows) noexcept {
    rows.clear();
    add_set_rows(next.set, node.h, rows);
    // The middle Bernstein coefficient of b over the cell: with it b stays above zero between the nodes too.
    rows.add({-1.0, -0.5 * node.h, 0.0, -kLeastShare * smaller(node.guess, next.guess)});
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        if (node.d1[k] == 0.0 && node.d2[k] == 0.0 && node.d3[k] == 0.0) {
            continue;
        }
        const double jerk = limits.jerk[k] * kJerkShare * node.share * (1.0 + node.slack);
        add_jerk_rows(node, k, 0.0, node.guess, jerk, rows);
        add_jerk_rows(node, k, 0.5 * node.h, 0.5 * (node.guess + next.guess), jerk, rows);
        add_jerk_rows(node, k, node.h, next.guess, jerk, rows);
    }
}

Bound bound_of(const Row& row) noexcept {
    const double r = 1.0 / row.u;
    return {row.r * r, -row.b * r, -row.c * r};
}

/// Keeps the states for which some u fulfils all rows. The difference of the greatest lower and the least upper bound
/// is convex, so it is enough to look at the vertices: one that has no u is cut off by the pair of rows that leaves
/// none (written without divisions). Cost: each vertex once, and a cut for each edge of the result.
void eliminate(Workspace& workspace) noexcept {
    const Rows& rows = workspace.rows;
    auto& upper = workspace.upper;
    auto& lower = workspace.lower;
    Polygon& set = workspace.set;
    for (std::uint32_t i = 0; i < rows.above_count; ++i) {
        upper[i] = bound_of(rows.above[i]);
    }
    for (std::uint32_t i = 0; i < rows.below_count; ++i) {
        lower[i] = bound_of(rows.below[i]);
    }
    // Rounding may leave slivers to be cut for ever: past this number they are left to forward_step.
    std::uint32_t cuts = 0;
    for (std::uint32_t i = 0; i < set.count && cuts < kMostCuts;) {
        if (set.seen[i]) {
            ++i;
            continue;
        }
        const double b = set.b[i];
        const double c = set.c[i];
        std::uint32_t least = 0;
        double high = 0.0;
        for (std::uint32_t k = 0; k < rows.above_count; ++k) {
            const double u = upper[k].at(b, c);
            if (k == 0 || u < high) {
                high = u;
                least = k;
            }
        }
        std::uint32_t most = 0;
        double low = 0.0;
        for (std::uint32_t k = 0; k < rows.below_count; ++k) {
            const double u = lower[k].at(b, c);
            if (k == 0 || u > low) {
                low = u;
                most = k;
            }
        }
        set.seen[i] = true;
        if (rows.above_count == 0 || rows.below_count == 0 ||
            low - high <= kRounding * (absolute(low) + absolute(high))) {
            ++i;
            continue;
        }
        const Row& a = rows.above[least];
        const Row& z = rows.below[most];
        set.clip(a.u * z.b - z.u * a.b, a.u * z.c - z.u * a.c, a.u * z.r - z.u * a.r);
        ++cuts;
        i = 0;
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
    set.b[0] = kLeast * b * (1.0 - kThin);
    set.b[1] = kLeast * b * (1.0 + kThin);
    set.b[2] = b;
    set.b[3] = b * (1.0 - kThin);
    set.c[0] = set.c[1] = kLeast * c;
    set.c[2] = c * (1.0 - kThin);
    set.c[3] = c;
    double area = 0.0;
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t k = (i + 1) % 4;
        area += set.b[i] * set.c[k] - set.b[k] * set.c[i];
    }
    if (area < 0.0) {
        const double b1 = set.b[1];
        const double c1 = set.c[1];
        set.b[1] = set.b[3];
        set.c[1] = set.c[3];
        set.b[3] = b1;
        set.c[3] = c1;
    }
    return set;
}

void clip_state(const Limits& limits, const Node& node, Polygon& set) noexcept {
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        if (node.d1[k] == 0.0 && node.d2[k] == 0.0) {
            continue;
        }
        const double most = limits.acceleration[k] * kAccelerationShare * node.room * (1.0 + 0.15 * node.slack);
        set.clip(node.d2[k], 0.5 * node.d1[k], most);
        set.clip(-node.d2[k], -0.5 * node.d1[k], most);
    }
}

bool backward_step(const Limits& limits, Node& node, const Node& next, Workspace& workspace) noexcept {
    Rows& rows = workspace.rows;
    fill(limits, node, next, rows);
    double fastest = 0.0;
    for (const double a : limits.acceleration) {
        fastest = larger(fastest, a);
    }
    Polygon& set = workspace.set;
    set.box(node.cap, 20.0 * fastest);
    set.clip(-1.0, 0.0, -kLeastShare * node.guess);
    clip_state(limits, node, set);
    for (std::uint32_t i = 0; i < rows.level_count; ++i) {
        set.clip(rows.level[i].b, rows.level[i].c, rows.level[i].r);
    }
    eliminate(workspace);
    set.simplify(StoredPolygon::kCapacity);
    node.set.store(set);
    return set.count >= 3;
}

bool forward_step(const Limits& limits, const Node& node, Node& next, Workspace& workspace) noexcept {
    Rows& rows = workspace.rows;
    fill(limits, node, next, rows);
    const double b = node.trial_b;
    const double c = node.trial_c;
    const auto bound = [&](const Row& row) noexcept { return (row.r - row.b * b - row.c * c) / row.u; };
    double high = 0.0;
    for (std::uint32_t i = 0; i < rows.above_count; ++i) {
        const double u = bound(rows.above[i]);
        high = i == 0 ? u : smaller(high, u);
    }
    double low = high;
    for (std::uint32_t i = 0; i < rows.below_count; ++i) {
        const double u = bound(rows.below[i]);
        low = i == 0 ? u : larger(low, u);
    }
    // Rounding and dropped vertices leave states a little outside: then the least violation.
    const double u = low > high ? 0.5 * (low + high) : high;
    next.trial_b = b + node.h * (c + 0.5 * node.h * u);
    next.trial_c = c + node.h * u;
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
