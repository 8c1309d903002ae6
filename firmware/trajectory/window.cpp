// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/window.hpp"

#include "firmware/trajectory/place.hpp"
#include "firmware/trajectory/spline.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kCommitShare = 0.3;          ///< of a window, to be written before the next plan at least
constexpr double kTrustShare = 0.25;          ///< of a plan in force, whose speeds are the guess for the next
constexpr double kGuessShare = 1.0;           ///< of the acceleration, for the first guess
constexpr double kRampShare = 0.7;            ///< of the limits, for a ramp on a curve
constexpr double kMost = 1.002;               ///< excess that is accepted
constexpr double kOffCurve = 0.05;            ///< of the tolerance
constexpr double kOffCurveAtRest = 0.045;     ///< the same, for the choice of a place of rest
constexpr double kWayIn = 1e6;                ///< weight of a way in to rest that is off the curve
constexpr std::uint32_t kRestsLookedAt = 48;  ///< nodes
constexpr std::uint32_t kRestsAUnit = 12;
constexpr double kMostSpeed = 1.001;     ///< it is looked at in a few places of a cell only
constexpr double kLeastLowering = 0.97;  ///< of the greatest speed of a cell, squared, at a time
constexpr double kLevelLate = 0.8;       ///< the same, if trials leave the curve again and again
constexpr std::uint32_t kLateTry = 5;
constexpr double kLevel = 0.65;           ///< of the guess beside it, at least
constexpr double kLeastGuess = 1e-14;     ///< of the greatest b
constexpr double kSlack = 0.012;          ///< near the start of a plan that begins moving
constexpr double kContinueShare = 0.1;    ///< of a window, if the plan in force goes on
constexpr std::uint32_t kMostParts = 16;  ///< of a cell passed from rest to rest
constexpr double kChordShare = 0.05;      ///< of the tolerance, for their chords
constexpr std::uint32_t kTries = 3;
constexpr double kLittleStretch = 1.05;      ///< rather than more tries
constexpr std::uint32_t kGuessesAtOnce = 8;  ///< cells
constexpr std::uint32_t kTriesFromRest = 8;

/// Greatest tangential acceleration at a node.
double acceleration_at(const Limits& limits, const Node& node) noexcept {
    double found = 1e12;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = absolute(node.d1[k]);
        if (d > 0.0) {
            found = smaller(found, limits.acceleration[k] / d);
        }
    }
    return found;
}

/// Jerk of a ramp to or from rest that covers the whole cell from `a` to `z`.
double ramp_jerk(const Limits& limits, const Node& a, const Node& z) noexcept {
    double jerk = 1e12;
    double acceleration = 1e12;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = larger(absolute(a.d1[k]), absolute(z.d1[k]));
        if (d > 0.0) {
            jerk = smaller(jerk, kRampShare * limits.jerk[k] / d);
            acceleration = smaller(acceleration, kRampShare * limits.acceleration[k] / d);
        }
    }
    const double h = a.h;
    jerk = smaller(jerk, acceleration * square_root(acceleration / (6.0 * h)));
    const double t = 3.0 * h / square_root(kRampShare * smaller(a.cap, z.cap));
    return smaller(jerk, 6.0 * h / (t * t * t));
}

/// How far the quintic of a ramp from rest leaves the cell; `d2` is at the rest, and `h` leads away from it.
/// s = h τ³ there, of which the quintic misses τ³ (1 − τ)³ times 1 of τ⁶ and 13.9 of τ⁹ in the middle.
double off_curve_at_rest(const Node& cell, const Place& d2, double h) noexcept {
    return h * h * length(along(times(1.0 / 128.0, d2), 13.9 / 384.0 * h, cell.d3));
}

/// Speed that the curve itself allows, for the guess.
double curve_cap(const Limits& limits, const Node& node) noexcept {
    double cap = node.cap;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d2 = absolute(node.d2[k]);
        if (d2 * cap > limits.acceleration[k]) {
            cap = limits.acceleration[k] / d2;
        }
        const double d3 = absolute(node.d3[k]);
        if (d3 * d3 * cap * cap * cap > limits.jerk[k] * limits.jerk[k]) {
            const double r = cube_root(limits.jerk[k] / d3);
            cap = r * r;
        }
    }
    return cap;
}

}  // namespace

void WindowPlanner::start(const Ring<Node>& nodes, const Place& corner, const Joint& joint, double ramp,
                          std::uint32_t item) noexcept {
    begin_ = {corner, joint, ramp};
    item_ = item;
    base_ = looked_ = nodes.end();
    done_ = false;
    fresh_ = resting_ = true;
    in_force_ = false;
    crawling_ = false;
    start_share_ = target_share_ = 1.0;
    stage_ = Stage::wait;
}

void WindowPlanner::set_end(const Place& corner, const Joint& joint, double ramp) noexcept {
    end_ = {corner, joint, ramp};
}

std::uint32_t WindowPlanner::step(const Limits& limits, Ring<Node>& nodes, TrajectoryWriter& writer) noexcept {
    switch (stage_) {
        case Stage::wait:
            if (done_ || !find_window(limits, nodes)) {
                return 0;
            }
            return begin_plan(limits, nodes);
        case Stage::guess_up: guess_up(limits, nodes); return 1;
        case Stage::guess_down: guess_down(limits, nodes); return 1;
        case Stage::backward: backward(limits, nodes); return kUnitsBackward;
        case Stage::forward: forward(limits, nodes); return 1;
        case Stage::check: check(limits, nodes); return kUnitsCheck;
        case Stage::write:
            if (writer.pieces().free() < kPiecesAtOnce) {
                return 0;
            }
            write(limits, nodes, writer);
            return 1;
    }
    return 0;
}

/// The window reaches as far as the look-ahead, the memory or the run.
bool WindowPlanner::find_window(const Limits& limits, const Ring<Node>& nodes) noexcept {
    const std::uint32_t most = nodes.capacity() - 2 * SplineBuilder::kLag;
    // Nodes that were too near to an earlier base are so now.
    looked_ = looked_ < base_ ? base_ : looked_;
    for (; looked_ < nodes.end(); ++looked_) {
        const std::uint32_t w = looked_;
        const Node& node = nodes[w];
        if (node.last || (w > base_ + 2 && (node.s - nodes[base_].s >= limits.window || w - base_ >= most))) {
            window_ = w;
            to_end_ = node.last;
            return true;
        }
    }
    return false;
}

/// Draws the window's end in to where quintics follow the curve to rest there, and from it. Units of work.
std::uint32_t WindowPlanner::choose_rest(const Limits& limits, const Ring<Node>& nodes) noexcept {
    const double most = kOffCurveAtRest * limits.tolerance;
    double least = 1e12;
    std::uint32_t best = window_;
    std::uint32_t n = 0;
    for (; n < kRestsLookedAt && window_ - n > base_ + 2; ++n) {
        const std::uint32_t w = window_ - n;
        const Node& before = nodes[w - 1];
        const double in = off_curve_at_rest(before, along(before.d2, before.h, before.d3), -before.h);
        const double out = off_curve_at_rest(nodes[w], nodes[w].d2, nodes[w].h);
        // The way in is planned each time, the way out only if no later plan goes on.
        const double off = in > most ? kWayIn * in : larger(in, out);
        if (off < least) {
            least = off;
            best = w;
        }
        if (off <= most) {
            break;
        }
    }
    window_ = best;
    return n / kRestsAUnit;
}

std::uint32_t WindowPlanner::begin_plan(const Limits& limits, Ring<Node>& nodes) noexcept {
    std::uint32_t units = 1;
    if (to_end_ && in_force_ && force_to_end_) {
        // Nothing new: the plan in force already ends the run.
        commit_ = force_target_;
        cursor_ = base_;
        stage_ = Stage::write;
        return units;
    }
    if (!to_end_) {
        units += choose_rest(limits, nodes);
    }
    target_ = to_end_ ? window_ : window_ - 1;
    if (target_ <= base_) {
        give_up(nodes);
        return units;
    }
    tries_ = 0;
    strayed_ = false;
    target_length_ = to_end_ ? end_.ramp : nodes[target_].h;
    target_jerk_ = target_share_ * (to_end_ ? end_.joint.jerk : ramp_jerk(limits, nodes[target_], nodes[window_]));
    if (resting_) {
        start_length_ = fresh_ ? begin_.ramp : nodes[base_ - 1].h;
        start_jerk_ = fresh_ ? begin_.joint.jerk : start_share_ * ramp_jerk(limits, nodes[base_ - 1], nodes[base_]);
    }
    begin_guess();
    return units;
}

namespace {

/// b at the end of a ramp from rest.
double rest_b(double length, double jerk) noexcept {
    const double t = cube_root(6.0 * length / jerk);
    return 9.0 * length * length / (t * t);
}

}  // namespace

/// First guess of b: what speed and acceleration allow; near the start the plan in force.
void WindowPlanner::begin_guess() noexcept {
    cursor_ = base_;
    stage_ = Stage::guess_up;
}

void WindowPlanner::guess_up(const Limits& limits, Ring<Node>& nodes) noexcept {
    if (cursor_ == base_) {
        guess_ = resting_ ? rest_b(start_length_, start_jerk_) : nodes[base_].b;
    }
    for (std::uint32_t n = 0; n < kGuessesAtOnce; ++n) {
        Node& node = nodes[cursor_];
        node.guess = smaller(guess_, curve_cap(limits, node));
        node.slack = 0.0;
        guess_ = node.guess + 2.0 * kGuessShare * acceleration_at(limits, node) * node.h;
        if (cursor_ == target_) {
            guess_ = rest_b(target_length_, target_jerk_);
            stage_ = Stage::guess_down;
            return;
        }
        ++cursor_;
    }
}

void WindowPlanner::guess_down(const Limits& limits, Ring<Node>& nodes) noexcept {
    for (std::uint32_t n = 0; n < kGuessesAtOnce; ++n) {
        Node& node = nodes[cursor_];
        node.guess = larger(smaller(node.guess, guess_), kLeastGuess * node.cap);
        if (cursor_ == base_) {
            trust_plan_in_force(nodes);
            return;
        }
        --cursor_;
        guess_ = node.guess + 2.0 * kGuessShare * acceleration_at(limits, node) * nodes[cursor_].h;
    }
}

void WindowPlanner::trust_plan_in_force(Ring<Node>& nodes) noexcept {
    if (in_force_ && !resting_) {
        const double trusted = nodes[base_].s + kTrustShare * (nodes[force_target_].s - nodes[base_].s);
        for (std::uint32_t i = base_; i != force_target_ + 1; ++i) {
            Node& node = nodes[i];
            node.guess = node.s <= trusted ? node.b : larger(node.guess, node.b);
            node.slack = node.s <= trusted ? kSlack : 0.0;
        }
    }
    // After a try that had no states everywhere.
    for (std::uint32_t i = base_; tries_ > 0 && i != target_ + 1; ++i) {
        nodes[i].guess *= 1.0 / (1.0 + tries_);
    }
    cursor_ = target_;
    stage_ = Stage::backward;
}

void WindowPlanner::backward(const Limits& limits, Ring<Node>& nodes) noexcept {
    if (cursor_ == target_) {
        nodes[target_].set.store(ramp_set(target_length_, target_jerk_, true));
        ++counts_.passes;
    } else if (!backward_step(limits, nodes[cursor_], nodes[cursor_ + 1], workspace_)) {
        sound_ = false;
        again(limits, nodes);
        return;
    }
    if (cursor_ == base_) {
        begin_forward(nodes);
        return;
    }
    --cursor_;
}

void WindowPlanner::begin_forward(Ring<Node>& nodes) noexcept {
    Node& node = nodes[base_];
    if (resting_) {
        const double t = cube_root(6.0 * start_length_ / start_jerk_);
        const double b = 9.0 * start_length_ * start_length_ / (t * t);
        const double c = 12.0 * start_length_ / (t * t);
        const double share = larger(reach(node.set, b, c), 1e-3);
        node.trial_b = share * b;
        node.trial_c = share * c;
    } else {
        node.trial_b = node.b;
        node.trial_c = node.c;
    }
    cursor_ = base_;
    stage_ = Stage::forward;
}

void WindowPlanner::forward(const Limits& limits, Ring<Node>& nodes) noexcept {
    if (!forward_step(limits, nodes[cursor_], nodes[cursor_ + 1], workspace_)) {
        sound_ = false;
        again(limits, nodes);
        return;
    }
    ++cursor_;
    if (cursor_ != target_) {
        return;
    }
    // Onto the line of the ramp exactly.
    Node& node = nodes[target_];
    node.trial_c = -node.trial_b / (0.75 * target_length_);
    sound_ = good_ = true;
    crooked_ = false;
    worst_ = 1.0;
    cursor_ = base_;
    stage_ = Stage::check;
}

// Two states in, three results out, each one number.
// NOLINTNEXTLINE(readability-function-size): a struct would only name them twice
double WindowPlanner::note(const Limits& limits, const Node& from, const Node& to, double b0, double c0, double b1,
                           double c1, double& share, double& room0, double& room1) noexcept {
    const CellMotion motion = cell_motion(from, to, b0, c0, b1, c1);
    const Excess e = excess(limits, limits.speed, motion);
    if (!(off_curve(from, motion, b0, c0, b1, c1) <= kOffCurve * limits.tolerance)) {
        good_ = false;
        crooked_ = strayed_ = true;
    }
    if (e.jerk > kMost) {
        good_ = false;
        share *= larger(0.5, 0.997 / e.jerk);
        worst_ = larger(worst_, cube_root(e.jerk));
    }
    if (e.acceleration > kMost) {
        good_ = false;
        const double factor = larger(0.5, 0.998 / e.acceleration);
        room0 *= factor;
        room1 *= factor;
        worst_ = larger(worst_, square_root(e.acceleration));
    }
    if (e.speed > kMostSpeed) {
        good_ = false;
        room0 *= 0.99;
        room1 *= 0.99;
        worst_ = larger(worst_, e.speed);
    }
    return e.jerk <= kMost && e.acceleration <= kMost ? e.speed : 0.0;
}

void WindowPlanner::check(const Limits& limits, Ring<Node>& nodes) noexcept {
    Node& node = nodes[cursor_];
    if (cursor_ != target_) {
        Node& next = nodes[cursor_ + 1];
        const double speed = note(limits, node, next, node.trial_b, node.trial_c, next.trial_b, next.trial_c,
                                  node.share, node.room, next.room);
        if (speed > kMostSpeed) {
            // Between two nodes whose own speeds are within it.
            const double lower = larger(kLeastLowering, (0.9999 / speed) * (0.9999 / speed));
            next.cap *= lower;
            node.cap *= cursor_ != base_ || resting_ ? lower : 1.0;
        }
        ++cursor_;
        return;
    }
    double ignored = 1.0;
    if (resting_ && !fresh_) {
        const Node& base = nodes[base_];
        (void)note(limits, nodes[base_ - 1], base, 0.0, 0.0, base.trial_b, base.trial_c, start_share_, ignored,
                   ignored);
        start_jerk_ = start_share_ * ramp_jerk(limits, nodes[base_ - 1], base);
    }
    if (to_end_) {
        // The ramp at the run's end may be one that another run overlaps: exactly within its jerk.
        const double v = square_root(node.trial_b);
        const double a = 0.5 * absolute(node.trial_c);
        const double jerk = 0.5 * a * a / v;
        if (!(jerk <= kMost * end_.joint.jerk)) {
            good_ = false;
            const double ratio = jerk / end_.joint.jerk;
            target_share_ *= larger(0.5, 0.99 / ratio);
            worst_ = larger(worst_, cube_root(ratio));
        }
        target_jerk_ = target_share_ * end_.joint.jerk;
    } else {
        (void)note(limits, node, nodes[window_], node.trial_b, node.trial_c, 0.0, 0.0, target_share_, ignored, ignored);
        target_jerk_ = target_share_ * ramp_jerk(limits, node, nodes[window_]);
    }
    judge(limits, nodes);
}

void WindowPlanner::judge(const Limits& limits, Ring<Node>& nodes) noexcept {
    const bool first_from_rest = resting_ && tries_ == 0;
    if (good_ && !first_from_rest) {
        accept(limits, nodes, 1.0);
        return;
    }
    again(limits, nodes);
}

/// No guess far below those on both sides of it, so that no trial all but stops between them; and, after a trial of the
/// plan that left the curve, on one side.
void WindowPlanner::level_guess(Ring<Node>& nodes) const noexcept {
    const double share = strayed_ && tries_ >= kLateTry ? kLevelLate : kLevel;
    double level = 0.0;
    for (std::uint32_t i = base_; i != target_ + 1; ++i) {
        level = larger(nodes[i].guess, share * level);
        nodes[i].trial_b = level;
    }
    level = 0.0;
    for (std::uint32_t i = target_ + 1; i-- != base_;) {
        Node& node = nodes[i];
        level = larger(node.guess, share * level);
        if (node.slack == 0.0) {
            node.guess = strayed_ ? larger(node.trial_b, level) : smaller(node.trial_b, level);
        }
    }
}

/// Another try about the last one's speeds, or none.
void WindowPlanner::again(const Limits& limits, Ring<Node>& nodes) noexcept {
    ++tries_;
    const bool last = tries_ >= (resting_ ? kTriesFromRest : kTries);
    if (last || (resting_ && tries_ > kTries)) {
        if (resting_ && sound_ && !crooked_ && worst_ < (last ? 1e3 : kLittleStretch)) {
            ++counts_.stretched;
            accept(limits, nodes, worst_ * 1.0001);
            return;
        }
        if (last) {
            give_up(nodes);
            return;
        }
    }
    if (sound_) {
        for (std::uint32_t i = base_; i != target_ + 1; ++i) {
            Node& node = nodes[i];
            node.guess = larger(node.trial_b, kLeastGuess * node.cap);
        }
        level_guess(nodes);
    } else {
        begin_guess();
        return;
    }
    cursor_ = target_;
    stage_ = Stage::backward;
}

void WindowPlanner::accept(const Limits& limits, Ring<Node>& nodes, double stretch) noexcept {
    const double slower = 1.0 / (stretch * stretch);
    for (std::uint32_t i = base_; i != target_ + 1; ++i) {
        Node& node = nodes[i];
        node.b = node.trial_b * slower;
        node.c = node.trial_c * slower;
    }
    ++counts_.plans;
    in_force_ = true;
    force_target_ = target_;
    force_window_ = window_;
    force_to_end_ = to_end_;
    start_share_ = target_share_ = 1.0;
    const double length = nodes[window_].s - nodes[base_].s;
    commit_to(nodes, larger(kCommitShare * length, length - limits.near_rest));
}

/// No plan: the one in force goes on, or one cell is passed from rest to rest.
void WindowPlanner::give_up(Ring<Node>& nodes) noexcept {
    start_share_ = target_share_ = 1.0;
    if (in_force_ && !resting_) {
        ++counts_.continued;
        commit_to(nodes, kContinueShare * (nodes[window_].s - nodes[base_].s));
        return;
    }
    crawling_ = true;
    stage_ = Stage::write;
}

void WindowPlanner::commit_to(const Ring<Node>& nodes, double length) noexcept {
    commit_ = force_target_;
    if (!force_to_end_) {
        const double s = nodes[base_].s + length;
        std::uint32_t m = base_ + 1;
        // A cell short of its end the plan in force is still moving: the next plan begins there at the latest.
        while (m + 1 < force_target_ && nodes[m].s < s) {
            ++m;
        }
        commit_ = m;
    }
    cursor_ = base_;
    stage_ = Stage::write;
}

void WindowPlanner::write(const Limits& limits, Ring<Node>& nodes, TrajectoryWriter& writer) noexcept {
    if (crawling_) {
        crawling_ = false;
        ++counts_.crawled;
        in_force_ = false;
        stage_ = Stage::wait;
        const Node& base = nodes[base_];
        if (fresh_) {
            writer.flush();
            crawl(limits, begin_.corner, base.p, writer, item_);
            fresh_ = false;
        } else {
            crawl_cell(limits, nodes[base_ - 1], writer);
        }
        if (base.last) {
            crawl(limits, base.p, end_.corner, writer, base.item);
            done_ = true;
        }
        ++base_;
        nodes.forget_before(base_ - 1);
        return;
    }
    if (cursor_ == base_ && resting_) {
        const Node& base = nodes[base_];
        if (fresh_) {
            const double a = 0.5 * base.c;
            const double t = 2.0 * square_root(base.b) / a;
            writer.join(ramp_from(begin_.corner, base.d1, a / t, t, item_), begin_.joint.duration);
            writer.flush();
        } else {
            writer.cell(nodes[base_ - 1], base, 0.0, 0.0, base.b, base.c);
        }
        fresh_ = resting_ = false;
        if (cursor_ != commit_) {
            return;
        }
    }
    if (cursor_ != commit_) {
        const Node& from = nodes[cursor_];
        const Node& to = nodes[cursor_ + 1];
        writer.cell(from, to, from.b, from.c, to.b, to.c);
        ++counts_.cells;
        ++cursor_;
        return;
    }
    stage_ = Stage::wait;
    base_ = commit_;
    if (commit_ == force_target_) {
        const Node& node = nodes[commit_];
        in_force_ = false;
        if (force_to_end_) {
            const double a = -0.5 * node.c;
            const double t = 2.0 * square_root(node.b) / a;
            writer.wait(ramp_to(end_.corner, node.d1, a / t, t, node.item));
            done_ = true;
        } else {
            writer.cell(node, nodes[force_window_], node.b, node.c, 0.0, 0.0);
            base_ = force_window_ + 1;
            resting_ = true;
        }
    }
    nodes.forget_before(base_ > nodes.first() ? base_ - 1 : base_);
}

/// A cell from rest to rest, over chords that stay close to the curve.
void WindowPlanner::crawl_cell(const Limits& limits, const Node& cell, TrajectoryWriter& writer) noexcept {
    const auto at = [&](double x) noexcept {
        return along(along(along(cell.p, x, cell.d1), 0.5 * x * x, cell.d2), x * x * x * (1.0 / 6.0), cell.d3);
    };
    const double bend = larger(length(cell.d2), length(along(cell.d2, cell.h, cell.d3)));
    std::uint32_t parts = 1;
    while (parts < kMostParts && 0.125 * bend * cell.h * cell.h > kChordShare * limits.tolerance * parts * parts) {
        ++parts;
    }
    const double step = cell.h / parts;
    for (std::uint32_t i = 0; i < parts; ++i) {
        crawl(limits, at(step * i), at(step * (i + 1)), writer, cell.item);
    }
}

void WindowPlanner::crawl(const Limits& limits, const Place& from, const Place& to, TrajectoryWriter& writer,
                          std::uint32_t item) noexcept {
    // 10 τ³ − 15 τ⁴ + 6 τ⁵ peaks at 15/8, 10/√3 and 60 in its derivatives.
    const Place step = minus(to, from);
    double t = 1.875 * length3(step) / limits.speed;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = absolute(step[k]);
        if (d > 0.0) {
            t = larger(t, 1.875 * d / limits.velocity[k]);
            t = larger(t, square_root(5.7736 * d / limits.acceleration[k]));
            t = larger(t, cube_root(60.0 * d / limits.jerk[k]));
        }
    }
    writer.straight(from, to, 1.001 * t, item);
}

}  // namespace sc::trajectory
