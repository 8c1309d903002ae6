// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/spline.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kSlope = 0.3;         ///< greatest change of the spacing with s
constexpr double kEndSlope = 0.5;      ///< spacing per distance to the run's ends
constexpr double kFirstShare = 0.95;   ///< of the tolerance, for the first choice of a spacing
constexpr double kLastShare = 0.94;    ///< of the tolerance, for the check; the rest is for what was absorbed
constexpr double kSharpenReach = 2.0;  ///< spacings
constexpr double kSharpen = 0.05;      ///< of the second difference, against the inward pull of the spline
constexpr double kFiner = 0.85;        ///< between tries of a first choice
constexpr double kSure = 1.5;          ///< times what is allowed: too much for certain
constexpr double kCloser = 0.8;        ///< after a check that failed
constexpr double kSpacingsAhead = 4.0;
constexpr std::uint32_t kVerticesAhead = 144;
constexpr std::uint32_t kVerticesBeside = 48;
/// A step that begins or ends at rest leaves the curve by h² |d2| / 128; of the tolerance it may take a 25th.
constexpr double kOffCurveAtRest = 128.0 / 25.0;
constexpr std::uint32_t kMostSteps = 8;    ///< of a cell
constexpr std::int64_t kDeferred = 7;      ///< cells that must fit beyond the one that is given out
constexpr std::int64_t kFixed = 3;         ///< knots beyond the last node given out that cannot change any more
constexpr std::uint32_t kFixedTries = 12;  ///< to fit a cell between them, which once did

/// Square of the greatest rate at which the parameter may run where the curve has this derivative.
double greatest_b(const Limits& limits, const Place& d1) noexcept {
    const double travel = length3(d1);
    double cap = travel > 0.0 ? limits.speed / travel : 1e6;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = absolute(d1[k]);
        if (d > 0.0) {
            cap = smaller(cap, limits.velocity[k] / d);
        }
    }
    return 0.9999 * cap * cap;
}

}  // namespace

void SplineBuilder::start(const Polyline& points, std::uint32_t begin, double ramp) noexcept {
    begin_ = begin;
    begin_s_ = points[begin].s;
    end_seen_ = has_end_ = done_ = complete_ = false;
    seen_ = begin + 1;
    final_ = begin;
    spaced_ = begin;
    sight_ = horizon_ = begin;
    segment_ = hint_ = checked_hint_ = given_hint_ = begin;
    knot_[0] = begin_s_ + ramp;
    knots_ = 1;
    controls_ = drafts_ = checked_ = given_ = 0;
}

void SplineBuilder::set_end(std::uint32_t end, double ramp) noexcept {
    end_ = end;
    has_end_ = true;
    end_ramp_ = ramp;
}

std::uint32_t SplineBuilder::oldest_point() const noexcept {
    const std::uint32_t used = given_hint_ < hint_ ? given_hint_ : hint_;
    const std::uint32_t margin = 2 * kVerticesBeside;
    return used < begin_ + margin ? begin_ : used - margin;
}

/// Looks for the next corner (true when it is found), and moves on the points that no stub before one can reach.
bool SplineBuilder::see(const Polyline& points, const Limits& limits) noexcept {
    while (!end_seen_ && seen_ < points.known()) {
        if (points[seen_].corner) {
            end_seen_ = true;
            return true;
        }
        ++seen_;
    }
    if (has_end_) {
        final_ = end_;
        return false;
    }
    const std::uint32_t last = end_seen_ ? seen_ : seen_ - 1;
    while (final_ + 1 < last &&
           (points[last].s - points[final_ + 1].s > limits.stub || last - final_ - 1 > Polyline::kStubPoints)) {
        ++final_;
    }
    return false;
}

/// Moves `cursor` to the first point that is `distance` beyond s or `count` beyond `from`, or the run's end. False if
/// that is not known yet.
bool SplineBuilder::ready_to(const Polyline& points, std::uint32_t from, double s, double distance, std::uint32_t count,
                             std::uint32_t& cursor) const noexcept {
    while (true) {
        if (cursor > final_) {
            return false;
        }
        if ((has_end_ && cursor == end_) || points[cursor].s - s >= distance || cursor >= from + count) {
            return true;
        }
        if (cursor == final_) {
            return false;
        }
        ++cursor;
    }
}

double SplineBuilder::knot(std::int64_t i) const noexcept {
    if (i < 0) {
        return knot_[0] + (knot_[1] - knot_[0]) * static_cast<double>(i);
    }
    const std::int64_t last = knots_ - 1;
    const double end = knot_[static_cast<std::size_t>(last) % kKept];
    if (i > last) {
        return end + (end - knot_[static_cast<std::size_t>(last - 1) % kKept]) * static_cast<double>(i - last);
    }
    return knot_[static_cast<std::size_t>(i) % kKept];
}

/// Spacing that the second difference about vertex j allows, at most as much as its neighbours plus the slope.
void SplineBuilder::space_vertex(Polyline& points, const Limits& limits, std::uint32_t j,
                                 std::uint32_t sight) const noexcept {
    const bool ends = has_end_ && sight == end_;
    const double s = points[j].s;
    double most = limits.longest_cell;
    if (!ends) {
        most = smaller(most, (points[sight].s - s) * (1.0 / 3.0));
    }
    const std::uint32_t low = j < begin_ + kVerticesBeside ? begin_ : j - kVerticesBeside;
    if (low > begin_) {
        most = smaller(most, (s - points[low].s) * (1.0 / 3.0));
    }
    // Deviation at x of the curve with knots h apart, one of them at x: B-spline weights 1 4 1 of sharpened points.
    std::array<std::uint32_t, 7> hint;
    hint.fill(j);
    const auto deviation = [&](double x, double h) noexcept {
        const auto pair = [&](std::size_t n) noexcept {
            const double d = h * static_cast<double>(n);
            return plus(points.at(x - d, low, sight, hint[2 * n - 1]), points.at(x + d, low, sight, hint[2 * n]));
        };
        const Place on = points.at(x, low, sight, hint[0]);
        const Place one = along(pair(1), -2.0, on);
        const Place two = along(pair(2), -2.0, on);
        const Place three = along(pair(3), -2.0, on);
        const Place smooth = times(1.0 / 6.0, one);
        const Place sharp = along(along(plus(one, three), 4.0, two), -2.0, one);
        return length(along(smooth, -kSharpen / 6.0, sharp));
    };
    const double allowed = kFirstShare * limits.tolerance;
    double h = most;
    if (j > begin_) {
        h = smaller(most, points[j - 1].spacing + kSlope * (s - points[j - 1].s));
    }
    const double least = larger(0.5 * limits.tolerance, 1e-7);
    // At the vertex, and in the middle of a long segment behind it.
    const double next = j < sight ? points[j + 1].s - s : 0.0;
    while (h > least) {
        double off = deviation(s, h);
        if (!(off > allowed) && next > 0.3 * h) {
            off = deviation(s + 0.5 * next, h);
        }
        if (!(off > allowed)) {
            break;
        }
        // It goes with the square at most: tries that cannot do are left out.
        do {
            h *= kFiner;
            off *= kFiner * kFiner;
        } while (off > kSure * allowed && h > least);
    }
    points[j].spacing = larger(h, smaller(least, most));
}

void SplineBuilder::smooth_back(Polyline& points, std::uint32_t from) const noexcept {
    for (std::uint32_t i = from; i > begin_ && i > points.first(); --i) {
        const double most = points[i].spacing + kSlope * (points[i].s - points[i - 1].s);
        if (points[i - 1].spacing <= most) {
            break;
        }
        points[i - 1].spacing = most;
    }
}

/// Distance from the knot at s, in segment i, to the next.
double SplineBuilder::spacing_at(const Polyline& points, const Limits& limits, double s, std::uint32_t i,
                                 bool near_end) const noexcept {
    const Vertex& a = points[i];
    const Vertex& b = points[i + 1];
    const double from = s - a.s;
    const double to = b.s - s;
    double h = smaller(a.spacing + kSlope * from, b.spacing + kSlope * to);
    // Long cells only where nothing changes: a braking length away from both ends of a long segment.
    const double calm = smaller(from, to) - limits.window;
    h = smaller(h, limits.longest_cell + (calm > 0.0 ? kSlope * calm : 0.0));
    h = smaller(h, kEndSlope * (s - begin_s_));
    if (!near_end) {
        return h;
    }
    const double rest = points[end_].s - end_ramp_ - s;
    h = smaller(h, kEndSlope * (points[end_].s - s));
    // The last cells share what is left; three at least, so that each end has control points of its own.
    std::int64_t cells = rest <= 1.3 * h ? 1 : (rest <= 2.3 * h ? 2 : 3);
    if (cells == 3 && rest > 3.3 * h) {
        return h;
    }
    if (cells < 4 - knots_) {
        cells = 4 - knots_;
    }
    return cells == 1 ? rest : rest / static_cast<double>(cells);
}

void SplineBuilder::make_control(const Polyline& points) noexcept {
    const std::int64_t m = controls_ - 1;
    const double g = (knot(m - 1) + knot(m) + knot(m + 1)) * (1.0 / 3.0);
    // Three points on the line of a stub make the first node and the last continue the ramps.
    const bool ends = complete_ && m >= knots_ - 2;
    if (m <= 1 || ends) {
        const std::uint32_t i = ends ? end_ - 1 : begin_;
        std::uint32_t on_stub = i;
        control(m) = points.at(g, i, i + 1, on_stub);
        ++controls_;
        return;
    }
    const std::uint32_t high = has_end_ ? end_ : final_;
    const Place on = points.at(g, begin_, high, hint_);
    const double reach = kSharpenReach * 0.5 * (knot(m + 1) - knot(m - 1));
    std::uint32_t before = hint_;
    std::uint32_t after = hint_;
    const Place sum = plus(points.at(g - reach, begin_, high, before), points.at(g + reach, begin_, high, after));
    control(m) = along(on, -kSharpen, along(sum, -2.0, on));
    ++controls_;
}

/// Node i from the control points beside it.
void SplineBuilder::make_node() noexcept {
    const std::int64_t i = drafts_;
    const double tm = knot(i - 1);
    const double t = knot(i);
    const double tp = knot(i + 1);
    const Place& a = control(i - 1);
    const Place& b = control(i);
    const Place& c = control(i + 1);
    const Place before = times(3.0 / (tp - knot(i - 2)), minus(b, a));
    const Place after = times(3.0 / (knot(i + 2) - tm), minus(c, b));
    const double h0 = t - tm;
    const double h1 = tp - t;
    const double left = h1 * h1 / ((h0 + h1) * (tp - knot(i - 2)));
    const double right = h0 * h0 / ((h0 + h1) * (knot(i + 2) - tm));
    Draft& made = draft(i);
    made.p = along(along(b, left, minus(a, b)), right, minus(c, b));
    made.d1 = along(before, h0 / (h0 + h1), minus(after, before));
    made.d2 = times(2.0 / (h0 + h1), minus(after, before));
    ++drafts_;
}

/// Deviation at the same s from the polyline, at all its vertices in the cell and between.
bool SplineBuilder::fits(const Polyline& points, const Limits& limits, std::int64_t cell) noexcept {
    const double s0 = knot(cell);
    const double h = knot(cell + 1) - s0;
    const Draft& from = draft(cell);
    const Draft& to = draft(cell + 1);
    const Place d3 = times(1.0 / h, minus(to.d2, from.d2));
    const std::uint32_t high = has_end_ ? end_ : final_;
    const double most = kLastShare * limits.tolerance;
    const auto near = [&](double x, const Place& on) noexcept {
        const Place p = along(along(along(from.p, x, from.d1), 0.5 * x * x, from.d2), x * x * x * (1.0 / 6.0), d3);
        const Place off = minus(p, on);
        return dot(off, off) <= most * most;
    };
    for (int k = 0; k < 4; ++k) {
        const double x = 0.25 * h * k;
        if (!near(x, points.at(s0 + x, begin_, high, checked_hint_))) {
            return false;
        }
    }
    std::uint32_t i = checked_hint_;
    while (i > begin_ && points[i].s > s0) {
        --i;
    }
    for (; i <= high && points[i].s < s0 + h; ++i) {
        if (points[i].s > s0 && !near(points[i].s - s0, points[i].p)) {
            return false;
        }
    }
    return true;
}

/// Closer knots about a cell that does not fit, and back to before it.
void SplineBuilder::set_closer(Polyline& points, std::int64_t cell) noexcept {
    const double from = knot(cell - 2);
    const double to = knot(cell + 3);
    std::uint32_t i = checked_hint_;
    while (i > begin_ && i > points.first() && points[i].s > from) {
        --i;
    }
    for (; i < spaced_ && points[i].s <= to; ++i) {
        points[i].spacing *= kCloser;
        smooth_back(points, i);
    }
    for (; i < spaced_ && i > begin_; ++i) {
        points[i].spacing =
            smaller(points[i].spacing, points[i - 1].spacing + kSlope * (points[i].s - points[i - 1].s));
    }
    std::int64_t kept = cell > 2 ? cell - 2 : 0;
    if (given_ > 0 && kept < given_ + kFixed) {
        kept = given_ + kFixed;
    }
    knots_ = kept + 1;
    complete_ = false;
    const auto back_to = [](std::int64_t& count, std::int64_t most) { count = count < most ? count : most; };
    back_to(controls_, kept > 0 ? kept + 1 : 0);
    back_to(drafts_, kept > 0 ? kept - 1 : 0);
    back_to(checked_, kept > 1 ? kept - 2 : 0);
    const double s = knot_[static_cast<std::size_t>(kept) % kKept];
    while (segment_ > begin_ && points[segment_].s > s) {
        --segment_;
    }
}

bool SplineBuilder::is_certain(std::int64_t cell) const noexcept {
    const std::int64_t last = knots_ - 1;
    return complete_ ? checked_ == last && cell <= last : cell + kDeferred < checked_;
}

/// Nodes of a cell that is certain: it is cut into steps for the timing.
void SplineBuilder::give_out(const Polyline& points, const Limits& limits, Ring<Node>& nodes) noexcept {
    const Draft& from = draft(given_);
    if (complete_ && given_ == knots_ - 1) {
        give_node(limits, {}, knot(given_), from, points[end_ - 1].item, nodes);
        nodes[nodes.end() - 1].last = true;
        done_ = true;
        return;
    }
    const double h = knot(given_ + 1) - knot(given_);
    const Place d3 = times(1.0 / h, minus(draft(given_ + 1).d2, from.d2));
    // Cells on calm straights are longer than others and stay whole.
    std::uint32_t steps = 1;
    if (h <= limits.longest_cell * 1.0001) {
        while (steps < kMostSteps && h > limits.longest_step * steps) {
            ++steps;
        }
    }
    // In a tight bend too, so that a plan can come to rest on the curve.
    const double bend = larger(length(from.d2), length(draft(given_ + 1).d2));
    while (steps < kMostSteps && h * h * bend > kOffCurveAtRest * limits.tolerance * (steps * steps)) {
        ++steps;
    }
    const double step = h / steps;
    for (std::uint32_t i = 0; i < steps; ++i) {
        const double x = step * i;
        Draft at;
        at.p = along(along(along(from.p, x, from.d1), 0.5 * x * x, from.d2), x * x * x * (1.0 / 6.0), d3);
        at.d1 = along(along(from.d1, x, from.d2), 0.5 * x * x, d3);
        at.d2 = along(from.d2, x, d3);
        (void)points.at(knot(given_) + x, points.first(), has_end_ ? end_ : final_, given_hint_);
        give_node(limits, d3, knot(given_) + x, at, points[given_hint_].item, nodes);
        nodes[nodes.end() - 1].h = step;
    }
    ++given_;
    tries_ = 0;
}

/// Appends a node; its greatest b is that of the node itself and of the middles of the steps on both sides.
void SplineBuilder::give_node(const Limits& limits, const Place& d3, double s, const Draft& at, std::uint32_t item,
                              Ring<Node>& nodes) noexcept {
    const bool first = given_ == 0 && nodes.size() == 0;
    Node& node = nodes.push();
    node = {};
    node.s = s;
    node.p = at.p;
    node.d1 = at.d1;
    node.d2 = at.d2;
    node.d3 = d3;
    node.item = item;
    node.cap = greatest_b(limits, at.d1);
    if (!first) {
        // In a bend the parameter runs unevenly between knots.
        Node& before = nodes[nodes.end() - 2];
        const double x = 0.5 * before.h;
        const double middle = greatest_b(limits, along(along(before.d1, x, before.d2), 0.5 * x * x, before.d3));
        node.cap = smaller(node.cap, middle);
        before.cap = smaller(before.cap, middle);
    }
}

bool SplineBuilder::step(Polyline& points, const Limits& limits, Ring<Node>& nodes) noexcept {
    if (done_ || nodes.free() < kLag) {
        return false;
    }
    if (see(points, limits)) {
        return true;
    }
    if (is_certain(given_)) {
        give_out(points, limits, nodes);
        return true;
    }
    if (checked_ + 1 < drafts_ && checked_ + 1 < knots_) {
        if (fits(points, limits, checked_)) {
            ++checked_;
        } else if (given_ > 0 && checked_ < given_ + kFixed && ++tries_ > kFixedTries) {
            ++checked_;
        } else {
            set_closer(points, checked_);
        }
        return true;
    }
    if (!complete_) {
        const double s = knot_[static_cast<std::size_t>(knots_ - 1) % kKept];
        while (segment_ + 1 < final_ && points[segment_ + 1].s <= s) {
            ++segment_;
        }
        if (segment_ >= final_ || points[segment_ + 1].s <= s ||
            !ready_to(points, segment_, s, kSpacingsAhead * limits.longest_cell, kVerticesAhead, horizon_)) {
            return false;
        }
        if (spaced_ <= horizon_) {
            if (!ready_to(points, spaced_, points[spaced_].s, 3.0 * limits.longest_cell, kVerticesBeside, sight_)) {
                return false;
            }
            space_vertex(points, limits, spaced_, sight_);
            smooth_back(points, spaced_);
            ++spaced_;
            return true;
        }
        const bool near_end = has_end_ && horizon_ == end_;
        const double h = spacing_at(points, limits, s, segment_, near_end);
        complete_ = near_end && h >= points[end_].s - end_ramp_ - s;
        knot_[static_cast<std::size_t>(knots_) % kKept] = s + h;
        ++knots_;
    }
    const std::int64_t last = knots_ - 1;
    if (last < 1) {
        return true;
    }
    while (controls_ <= (complete_ ? last + 2 : last)) {
        make_control(points);
    }
    while (drafts_ + 2 <= (complete_ ? last + 2 : last)) {
        make_node();
    }
    return true;
}

}  // namespace sc::trajectory
