// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/retimer.hpp"

#include "firmware/trajectory/place.hpp"
#include "firmware/trajectory/trajectory_writer.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kCells = 20.0;           ///< of a stretch without boundaries
constexpr double kSlow = 1.7;             ///< cells, next to rest
constexpr double kSlowCell = 0.4;         ///< of a cell, there
constexpr double kMost = 1.002;           ///< excess that is accepted
constexpr double kNominalShare = 1.0003;  ///< of what the nominal trajectory itself takes, so that rate 1 is possible
constexpr double kOffPath = 100e-9;       ///< m that the motion may be off the nominal path within a cell
constexpr double kRampShare = 0.85;       ///< of the limits, for a ramp to or from rest
constexpr double kWait =
    0.5;  ///< of a stretch, in which the rate may yet be what it was: a guess too high costs little
constexpr double kThin = 2e-5;        ///< of b: the set about a rate that is to be met
constexpr double kLeastGuess = 1e-9;  ///< of the greatest b
constexpr std::uint32_t kTries = 4;
constexpr std::uint32_t kLiftTries = 6;

/// (1 − x²)^(4/3): about how b falls over the way of a stop.
double stop_shape(double x) noexcept {
    const double y = larger(1.0 - x * x, 0.0);
    return y * cube_root(y);
}

/// Jerk of a ramp to or from rest that covers the whole cell from `a` to `z`; what comes next to it, up to `beyond`,
/// must be able to take it up.
double ramp_jerk(const Limits& limits, const Node& a, const Node& z, const Node& beyond) noexcept {
    double jerk = 1e15;
    double acceleration = 1e15;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = larger(larger(absolute(a.d1[k]), absolute(z.d1[k])), absolute(beyond.d1[k]));
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

/// State on a ramp of `jerk` over `length` from rest.
Rate ramp_state(double length, double jerk) noexcept {
    const double t = cube_root(6.0 * length / jerk);
    return {.b = 9.0 * length * length / (t * t), .c = 12.0 * length / (t * t)};
}

/// Whether (b, c) is in the set, or beyond an edge by rounding.
bool holds(const StoredPolygon& set, double b, double c) noexcept {
    if (set.count < 3) {
        return false;
    }
    for (std::uint32_t i = 0; i < set.count; ++i) {
        const std::uint32_t k = i + 1 == set.count ? 0 : i + 1;
        const double nb = set.c[k] - set.c[i];
        const double nc = set.b[i] - set.b[k];
        const double d = nb * (b - set.b[i]) + nc * (c - set.c[i]);
        if (d > 1e-6 * (absolute(nb * b) + absolute(nc) * (absolute(c) + 1e-3 * b))) {
            return false;
        }
    }
    return true;
}

/// Takes (b, c) into the set, as the vertex of its hull.
void include(StoredPolygon& set, double b, double c) noexcept {
    std::uint32_t first = set.count;  // edges that see the state from outside are consecutive: their first …
    std::uint32_t seen = 0;           // … and how many
    const auto outside = [&](std::uint32_t i) noexcept {
        const std::uint32_t k = i + 1 == set.count ? 0 : i + 1;
        return (set.c[k] - set.c[i]) * (b - set.b[i]) + (set.b[i] - set.b[k]) * (c - set.c[i]) > 0.0;
    };
    for (std::uint32_t i = 0; i < set.count; ++i) {
        if (outside(i)) {
            ++seen;
            if (!outside(i == 0 ? set.count - 1 : i - 1)) {
                first = i;
            }
        }
    }
    if (set.count < 3 || first == set.count) {
        return;
    }
    StoredPolygon hull;
    hull.b[0] = b;
    hull.c[0] = c;
    hull.count = 1;
    const std::uint32_t kept = set.count - (seen - 1);
    // With no room for one more, the state takes the place of a neighbour: what is left still lies within.
    const std::uint32_t skip = kept + 1 > StoredPolygon::kCapacity ? 1 : 0;
    for (std::uint32_t i = skip; i < kept; ++i) {
        const std::uint32_t at = (first + seen + i) % set.count;
        hull.b[hull.count] = set.b[at];
        hull.c[hull.count] = set.c[at];
        ++hull.count;
    }
    set = hull;
}

/// Place, and its first two derivatives by s, of a nominal piece; s runs with `sign`.
void place_node(const Limits& limits, const Piece& piece, double u, double sign, Node& node) noexcept {
    const double dt = u - piece.start;
    const double per_s = sign / limits.speed;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double unit = k == 3 ? limits.metres_per_turn_unit : 1.0;
        node.p[k] = unit * value(piece.axis[k], dt);
        node.d1[k] = unit * rate(piece.axis[k], dt) * per_s;
        node.d2[k] = unit * second_rate(piece.axis[k], dt) * per_s * per_s;
    }
}

/// The nominal trajectory keeps the speed of each axis at rate 1 and below.
void keep_axis_speed(const Limits& limits, Node& node) noexcept {
    if (!(node.cap > 1.001 * limits.speed * limits.speed)) {
        return;
    }
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = absolute(node.d1[k]);
        if (limits.velocity[k] > 0.0 && d * square_root(node.cap) > limits.velocity[k]) {
            node.cap = limits.velocity[k] * limits.velocity[k] / (d * d);
        }
    }
}

}  // namespace

std::uint32_t Retimer::units(std::uint32_t pieces) noexcept {
    // Build and write once; backward, forward and check, and perhaps a second try of these.
    const std::uint32_t nodes = pieces + static_cast<std::uint32_t>(kCells);
    return (nodes < kNodes ? nodes : kNodes) * (2 + (3 * (kUnitsBackward + 1 + kUnitsCheck)) / 2);
}

void Retimer::begin(const RateChange& change) noexcept {
    change_ = change;
    sign_ = change.until < change.from.u ? -1.0 : 1.0;
    fastest_ = 0.0;
    longest_ = absolute(change.until - change.from.u) * (1.0 / kCells);
    piece_ = change.piece;
    count_ = 0;
    tries_ = 0;
    begin_share_ = end_share_ = 1.0;
    state_ = State::build;
}

std::uint32_t Retimer::step(const Limits& limits, const Ring<Piece>& nominal, Ring<Piece>& made) noexcept {
    switch (state_) {
        case State::build: build(limits, nominal); break;
        case State::backward: backward(limits); return kUnitsBackward;
        case State::forward: forward(limits); break;
        case State::check: check(limits, nominal); return kUnitsCheck;
        case State::write: write(limits, nominal, made); break;
        case State::idle:
        case State::done:
        case State::failed: break;
    }
    return 1;
}

/// The next node, and the cell that ends there. Cells end where pieces do: the nominal jerk steps there.
void Retimer::build(const Limits& limits, const Ring<Piece>& nominal) noexcept {
    if (count_ == kNodes) {
        state_ = State::failed;
        return;
    }
    if (static_cast<std::int32_t>(piece_ - nominal.first()) < 0 ||
        static_cast<std::int32_t>(nominal.end() - piece_) <= 0) {
        state_ = State::failed;
        return;
    }
    const Piece& piece = nominal[piece_];
    Node& now = nodes_[count_];
    const double fastest = larger(change_.from.b, change_.rate * change_.rate * limits.speed * limits.speed);
    const bool rises = change_.lifted || change_.from.c > 0.0;
    const double most = rises ? larger(fastest, change_.most * change_.most * limits.speed * limits.speed) : fastest;
    fastest_ = larger(limits.speed, square_root(most));
    const auto reset = [&](Node& n, double s) noexcept {
        n.s = s;
        n.h = 0.0;
        n.cap = most * (1.0 + 1e-6);
        n.share = n.room = 1.0;
        n.slack = 0.0;
        n.last = false;
    };
    double u = 0.0;
    if (count_ == 0) {
        u = change_.from.u;
        rates_[0].u = u;
        reset(now, 0.0);
        place_node(limits, piece, u, sign_, now);
        keep_axis_speed(limits, now);
        ++count_;
    } else {
        u = rates_[count_ - 1].u;
    }
    if (count_ == kNodes) {
        state_ = State::failed;
        return;
    }
    const double boundary = sign_ > 0.0 ? piece.start + piece.duration : piece.start;
    const double left = sign_ * (boundary - u);
    const double whole = sign_ * (change_.until - u);
    const double way = smaller(left, whole);
    if (!(way > 1e-3 * longest_)) {
        if (whole <= left) {
            begin_backward(limits);
        } else {
            piece_ = sign_ > 0.0 ? piece_ + 1 : piece_ - 1;
        }
        return;
    }
    // Equal cells up to the boundary; finer where the motion is slow.
    const double behind = sign_ * (u - change_.from.u);
    const bool slow = (change_.end == RateChange::End::rest && whole < kSlow * longest_) ||
                      (!(change_.from.b > 0.0) && behind < kSlow * longest_);
    const double longest = slow ? kSlowCell * longest_ : longest_;
    double parts = 1.0;
    while (parts * longest * 1.0001 < way) {
        parts += 1.0;
    }
    const double h = way / parts;
    const double next_u = parts > 1.0 ? u + sign_ * h : (whole <= left ? change_.until : boundary);
    Node& from = nodes_[count_ - 1];
    Node& to = nodes_[count_];
    rates_[count_].u = next_u;
    reset(to, from.s + limits.speed * sign_ * (next_u - u));
    place_node(limits, piece, next_u, sign_, to);
    keep_axis_speed(limits, to);
    to.item = piece.item;
    source_[count_ - 1] = piece_;
    from.h = to.s - from.s;
    finish_node(limits, piece, u - piece.start, next_u - piece.start, from, to);
    ++count_;
}

void Retimer::finish_node(const Limits& limits, const Piece& piece, double begin, double end, Node& node,
                          const Node& next) noexcept {
    const double r = 1.0 / node.h;
    const double v2 = limits.speed * limits.speed;
    // The nominal jerk varies within the cell; timing.hpp knows its mean.
    double mean = 0.0;
    double peak = 0.0;
    double varies = 0.0;
    double acceleration = 0.0;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        node.d3[k] = (next.d2[k] - node.d2[k]) * r;
        if (limits.jerk[k] > 0.0) {
            const double unit = (k == 3 ? limits.metres_per_turn_unit : 1.0) / limits.jerk[k];
            const double own = absolute(node.d3[k]) * v2 * limits.speed / limits.jerk[k];
            const double most = unit * larger(absolute(third_rate(piece.axis[k], begin)),
                                              larger(absolute(third_rate(piece.axis[k], 0.5 * (begin + end))),
                                                     absolute(third_rate(piece.axis[k], end))));
            mean = larger(mean, own);
            peak = larger(peak, most);
            varies = larger(varies, most - own);
            const double a = larger(absolute(node.d2[k]), absolute(next.d2[k]));
            acceleration = larger(acceleration, a * v2 / limits.acceleration[k]);
        }
    }
    node.share = larger(larger(1.0, peak) - varies, kNominalShare * mean) / kJerkShare;
    node.room = larger(1.0, kNominalShare * acceleration) / kAccelerationShare;
}

void Retimer::begin_backward(const Limits& limits) noexcept {
    const bool from_rest = !(change_.from.b > 0.0);
    const bool to_rest = change_.end == RateChange::End::rest;
    if (count_ < 2U + (from_rest ? 1U : 0U) + (to_rest ? 1U : 0U)) {
        state_ = State::failed;
        return;
    }
    nodes_[count_ - 1].d3 = {};
    nodes_[count_ - 1].room = nodes_[count_ - 2].room;
    first_ = from_rest ? 1 : 0;
    target_ = to_rest ? count_ - 2 : count_ - 1;
    guess(limits);
    cursor_ = target_;
    state_ = State::backward;
}

void Retimer::guess(const Limits& limits) noexcept {
    if (first_ > 0) {
        begin_jerk_ = begin_share_ * ramp_jerk(limits, nodes_[0], nodes_[1], nodes_[count_ > 2 ? 2 : 1]);
    }
    if (target_ + 1 < count_) {
        end_jerk_ =
            end_share_ * ramp_jerk(limits, nodes_[target_], nodes_[target_ + 1], nodes_[target_ > 0 ? target_ - 1 : 0]);
    }
    if (tries_ > 0) {
        return;
    }
    const double v2 = limits.speed * limits.speed;
    const double b0 = change_.from.b;
    const double b1 = change_.rate * change_.rate * v2;
    const double per_s = 1.0 / nodes_[count_ - 1].s;
    const bool to_rest = change_.end == RateChange::End::rest;
    for (std::uint32_t i = 0; i < count_; ++i) {
        Node& n = nodes_[i];
        const double x = n.s * per_s;
        const double y = clamped((x - kWait) * (1.0 / (1.0 - kWait)), 0.0, 1.0);
        double b = b0 + (b1 - b0) * y;
        if (first_ > 0 && to_rest) {
            const double middle = 2.0 * absolute(x - 0.5);
            b = b1 * stop_shape(middle);
        } else if (to_rest) {
            b = b0 * stop_shape(larger(x - kWait, 0.0) * (1.0 / (1.0 - kWait)));
        } else if (first_ > 0) {
            b = b1 * stop_shape(larger(1.0 - x - kWait, 0.0) * (1.0 / (1.0 - kWait)));
        } else if (change_.lifted) {
            b = larger(b0, b1);
        } else if (change_.end == RateChange::End::free) {
            b = larger(b0, b1);
        }
        n.guess = larger(b, kLeastGuess * n.cap);
    }
    if (first_ > 0 && to_rest) {
        // How fast it becomes is not known: no faster than the accelerations allow.
        double b = 0.0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            double a = 1e15;
            for (std::size_t k = 0; k < kAxisCount; ++k) {
                const double d = absolute(nodes_[i].d1[k]);
                a = d > 0.0 ? smaller(a, limits.acceleration[k] / d) : a;
            }
            b = smaller(b + a * nodes_[i].h, nodes_[i].cap);
            nodes_[i].guess = smaller(nodes_[i].guess, larger(b, kLeastGuess * nodes_[i].cap));
        }
    }
}

void Retimer::backward(const Limits& limits) noexcept {
    Node& n = nodes_[cursor_];
    if (cursor_ == target_) {
        Polygon& set = workspace_.set;
        if (change_.end == RateChange::End::rest) {
            set = ramp_set(n.h, end_jerk_, true);
        } else if (change_.end == RateChange::End::free) {
            set.box(n.cap, 20.0 * limits.acceleration[0] + 20.0 * limits.acceleration[2]);
            set.clip(-1.0, 0.0, -kLeastGuess * n.cap);
        } else {
            const double b = change_.rate * change_.rate * limits.speed * limits.speed;
            const double c = kThin * b / nodes_[target_ - 1].h;
            set.count = 4;
            set.b[0] = set.b[3] = b * (1.0 - kThin);
            set.b[1] = set.b[2] = b * (1.0 + 1e-9);
            set.c[0] = set.c[1] = -c;
            set.c[2] = set.c[3] = c;
        }
        n.set.store(set);
    } else if (!backward_step(limits, n, nodes_[cursor_ + 1], workspace_)) {
        again(limits);
        return;
    }
    // To run on at an even rate is always possible where the next node allows it. Dropped vertices must not hide that.
    if (cursor_ != target_ && change_.from.c == 0.0 && change_.from.b > 0.0 &&
        change_.from.b < (1.0 + 1e-6) * limits.speed * limits.speed &&
        holds(nodes_[cursor_ + 1].set, change_.from.b, 0.0)) {
        include(n.set, change_.from.b, 0.0);
    }
    if (cursor_ != first_) {
        --cursor_;
        return;
    }
    // The start must be in the set; from rest the ramp may be slower.
    if (first_ > 0) {
        const Rate ramp = ramp_state(nodes_[0].h, begin_jerk_);
        const double share = reach(n.set, ramp.b, ramp.c);
        if (!(share > 1e-4)) {
            again(limits);
            return;
        }
        n.trial_b = share * ramp.b;
        n.trial_c = share * ramp.c;
    } else {
        if (!holds(n.set, change_.from.b, change_.from.c)) {
            again(limits);
            return;
        }
        n.trial_b = change_.from.b;
        n.trial_c = change_.from.c;
    }
    state_ = State::forward;
}

void Retimer::forward(const Limits& limits) noexcept {
    if (!forward_step(limits, nodes_[cursor_], nodes_[cursor_ + 1], workspace_)) {
        again(limits);
        return;
    }
    ++cursor_;
    if (cursor_ != target_) {
        return;
    }
    Node& n = nodes_[target_];
    if (change_.end == RateChange::End::rest) {
        n.trial_c = -n.trial_b / (0.75 * n.h);
        nodes_[target_ + 1].trial_b = nodes_[target_ + 1].trial_c = 0.0;
    } else if (change_.end == RateChange::End::rate) {
        n.trial_b = change_.rate * change_.rate * limits.speed * limits.speed;
        n.trial_c = 0.0;
    }
    if (first_ > 0) {
        nodes_[0].trial_b = nodes_[0].trial_c = 0.0;
    }
    good_ = true;
    cursor_ = 0;
    state_ = State::check;
}

void Retimer::check(const Limits& limits, const Ring<Piece>& nominal) noexcept {
    Node& from = nodes_[cursor_];
    Node& to = nodes_[cursor_ + 1];
    const CellMotion motion = cell_motion(from, to, from.trial_b, from.trial_c, to.trial_b, to.trial_c);
    const Excess found = excess(limits, fastest_, motion);
    const double worst = larger(found.jerk, found.acceleration);
    if (worst > kMost || found.speed > kMost) {
        good_ = false;
        if (first_ > 0 && cursor_ == 0) {
            begin_share_ *= larger(0.4, 0.99 / worst);
        } else if (cursor_ == target_) {
            end_share_ *= larger(0.4, 0.99 / worst);
        } else {
            // A lifted stretch need not be the fastest.
            const double aim = change_.lifted ? 0.95 : 0.995;
            from.share *= found.jerk > kMost ? larger(0.5, aim / found.jerk) : 1.0;
            const double room = found.acceleration > kMost ? larger(0.5, 0.997 / found.acceleration) : 1.0;
            from.room *= room;
            to.room *= room;
            if (found.speed > kMost) {
                const double slower = 0.995 / (found.speed * found.speed);
                from.cap = larger(from.cap * slower, limits.speed * limits.speed);
                to.cap = larger(to.cap * slower, limits.speed * limits.speed);
            }
        }
    }
    // The nominal path itself, where the motion is half-way through the cell.
    const double half = 0.5 * motion.duration;
    const Quintic s = hermite({0.0, square_root(from.trial_b), 0.5 * from.trial_c},
                              {from.h, square_root(to.trial_b), 0.5 * to.trial_c}, motion.duration);
    const Piece& piece = nominal[source_[cursor_]];
    const double dt = rates_[cursor_].u + sign_ * value(s, half) / limits.speed - piece.start;
    Place off{};
    Place tangent{};
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double unit = k == 3 ? limits.metres_per_turn_unit : 1.0;
        off[k] = value(motion.axis[k], half) - unit * value(piece.axis[k], dt);
        tangent[k] = unit * rate(piece.axis[k], dt);
    }
    // What it is ahead or behind along the path does no harm.
    const double square = dot(tangent, tangent);
    if (square > 0.0) {
        off = along(off, -dot(off, tangent) / square, tangent);
    }
    if (!(dot(off, off) <= kOffPath * kOffPath)) {
        state_ = State::failed;  // a longer stretch has it easier, and smaller cells have it exact
        return;
    }
    ++cursor_;
    if (cursor_ + 1 < count_) {
        return;
    }
    if (!good_) {
        again(limits);
        return;
    }
    rates_[0].t = change_.from.t;
    cursor_ = 0;
    state_ = State::write;
}

void Retimer::again(const Limits& limits) noexcept {
    ++tries_;
    const bool sound = state_ == State::check;
    if (!sound || tries_ == (change_.lifted ? kLiftTries : kTries)) {
        state_ = State::failed;
        return;
    }
    for (std::uint32_t i = first_; i <= target_; ++i) {
        nodes_[i].guess = larger(nodes_[i].trial_b, kLeastGuess * nodes_[i].cap);
    }
    guess(limits);
    cursor_ = target_;
    state_ = State::backward;
}

/// True distance, its rate and its second rate over real time.
Motion Retimer::travel(const Limits& limits, const Piece& piece, double u, double b, double c) const noexcept {
    const double dt = u - piece.start;
    const double du = sign_ * square_root(b) / limits.speed;
    const double ddu = sign_ * 0.5 * c / limits.speed;
    const double v = rate(piece.distance, dt);
    return {value(piece.distance, dt), v * du, second_rate(piece.distance, dt) * du * du + v * ddu};
}

void Retimer::write(const Limits& limits, const Ring<Piece>& nominal, Ring<Piece>& made) noexcept {
    const Node& from = nodes_[cursor_];
    const Node& to = nodes_[cursor_ + 1];
    const Piece& source = nominal[source_[cursor_]];
    const CellMotion motion = cell_motion(from, to, from.trial_b, from.trial_c, to.trial_b, to.trial_c);
    Rate& now = rates_[cursor_];
    now.b = from.trial_b;
    now.c = from.trial_c;
    Piece& piece = made.push();
    piece.start = now.t;
    piece.duration = motion.duration;
    piece.axis = motion.axis;
    if (limits.metres_per_turn_unit > 0.0) {
        for (double& k : piece.axis[3]) {
            k *= 1.0 / limits.metres_per_turn_unit;
        }
    } else {
        piece.axis[3] = {value(source.axis[3], 0.0)};
    }
    piece.distance = hermite(travel(limits, source, now.u, from.trial_b, from.trial_c),
                             travel(limits, source, rates_[cursor_ + 1].u, to.trial_b, to.trial_c), motion.duration);
    piece.item = source.item;
    piece.limited = source.limited;
    Rate& next = rates_[cursor_ + 1];
    next.t = now.t + motion.duration;
    next.b = to.trial_b;
    next.c = to.trial_c;
    ++cursor_;
    if (cursor_ + 1 == count_) {
        state_ = State::done;
    }
}

}  // namespace sc::trajectory
