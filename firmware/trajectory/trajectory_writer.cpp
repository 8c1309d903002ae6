// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/trajectory_writer.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

/// Five-point Gauss-Legendre on [0, 1].
constexpr std::array<double, 5> kNode{0.046910077030668004, 0.23076534494715845, 0.5, 0.76923465505284155,
                                      0.95308992296933200};
constexpr std::array<double, 5> kWeight{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                        0.23931433524968324, 0.11846344252809454};
constexpr double kSharpCosine = -0.2;  ///< of a turn: the speed dips much
constexpr double kShortest = 1e-12;    ///< s; what is left over below is rounding

/// Time over a cell: ∫ ds / √b.
double cell_time(double h, double b0, double c0, double b1, double c1) noexcept {
    if (b0 == 0.0) {
        return 4.0 * square_root(b1) / c1;
    }
    if (b1 == 0.0) {
        return -4.0 * square_root(b0) / c0;
    }
    const double u = (c1 - c0) / h;
    double sum = 0.0;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        const double x = h * kNode[i];
        sum = sum + kWeight[i] / square_root(b0 + x * (c0 + 0.5 * u * x));
    }
    return h * sum;
}

/// Length over x, y, z of the curve in a cell.
double cell_length(const Node& node) noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        const double x = node.h * kNode[i];
        sum = sum + kWeight[i] * length3(along(along(node.d1, x, node.d2), 0.5 * x * x, node.d3));
    }
    return node.h * sum;
}

/// Speed and acceleration along x, y, z of a state at a node.
Motion travel(const Node& node, double b, double c) noexcept {
    const double g = length3(node.d1);
    if (!(g > 0.0)) {
        return {};
    }
    return {0.0, g * square_root(b), 0.5 * g * c + dot3(node.d1, node.d2) / g * b};
}

}  // namespace

CellMotion cell_motion(const Node& from, const Node& to, double b0, double c0, double b1, double c1) noexcept {
    CellMotion made;
    made.duration = cell_time(from.h, b0, c0, b1, c1);
    const double v0 = square_root(b0);
    const double v1 = square_root(b1);
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        if (from.p[k] == to.p[k] && from.d1[k] == 0.0 && to.d1[k] == 0.0 && from.d2[k] == 0.0 && to.d2[k] == 0.0) {
            made.axis[k] = {from.p[k]};
            continue;
        }
        made.axis[k] = hermite({from.p[k], from.d1[k] * v0, from.d2[k] * b0 + 0.5 * from.d1[k] * c0},
                               {to.p[k], to.d1[k] * v1, to.d2[k] * b1 + 0.5 * to.d1[k] * c1}, made.duration);
    }
    return made;
}

double off_curve(const Node& from, const CellMotion& motion, double b0, double c0, double b1, double c1) noexcept {
    const Quintic s = hermite({0.0, square_root(b0), 0.5 * c0}, {from.h, square_root(b1), 0.5 * c1}, motion.duration);
    double worst = 0.0;
    for (int i = 1; i < 4; ++i) {
        const double t = 0.25 * i * motion.duration;
        const double x = value(s, t);
        double sum = 0.0;
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            const double on = from.p[k] + x * (from.d1[k] + x * (0.5 * from.d2[k] + x * from.d3[k] * (1.0 / 6.0)));
            const double off = value(motion.axis[k], t) - on;
            sum = sum + off * off;
        }
        worst = larger(worst, sum);
    }
    return square_root(worst);
}

Excess excess(const Limits& limits, double speed, const CellMotion& motion) noexcept {
    Excess found;
    double fastest = 0.0;
    // Speed and its rate in a few places; a peak between two of them is taken to be where their tangents meet.
    constexpr int kParts = 4;
    const double part = motion.duration * (1.0 / kParts);
    Place per_limit{};
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        per_limit[k] = limits.velocity[k] > 0.0 ? 1.0 / limits.velocity[k] : 0.0;
    }
    std::array<std::size_t, kAxisCount> moving{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const Quintic& q = motion.axis[k];
        if (q[1] != 0.0 || q[2] != 0.0 || q[3] != 0.0 || q[4] != 0.0 || q[5] != 0.0) {
            moving[count] = k;
            ++count;
        }
    }
    const double per_speed = 1.0 / speed;
    std::array<Motion, kAxisCount + 1> last{};
    for (int i = 0; i <= kParts; ++i) {
        const double t = part * i;
        std::array<Motion, kAxisCount + 1> now{};
        double square = 0.0;
        double rise = 0.0;
        for (std::size_t m = 0; m < count; ++m) {
            const std::size_t k = moving[m];
            const double v = rate(motion.axis[k], t);
            const double a = second_rate(motion.axis[k], t);
            const double share = v < 0.0 ? -per_limit[k] : per_limit[k];
            now[m] = {0.0, v * share, a * share};
            if (k < 3) {
                square = square + v * v;
                rise = rise + v * a;
            }
        }
        const double along_path = square_root(square);
        if (along_path > 0.0) {
            now[count] = {0.0, along_path * per_speed, rise / along_path * per_speed};
        }
        for (std::size_t k = 0; k <= count; ++k) {
            fastest = larger(fastest, now[k].v);
            if (i > 0 && last[k].a > 0.0 && now[k].a < 0.0) {
                const double x = clamped((now[k].v - last[k].v - now[k].a * part) / (last[k].a - now[k].a), 0.0, part);
                fastest = larger(fastest, last[k].v + last[k].a * x);
            }
        }
        last = now;
    }
    found.speed = fastest;
    for (std::size_t m = 0; m < count; ++m) {
        const std::size_t k = moving[m];
        if (limits.velocity[k] > 0.0) {
            const Peaks most = peaks(motion.axis[k], motion.duration);
            found.acceleration = larger(found.acceleration, most.acceleration / limits.acceleration[k]);
            found.jerk = larger(found.jerk, most.jerk / limits.jerk[k]);
        }
    }
    // A NaN compares false with everything: make it count.
    if (!(motion.duration > 0.0 && motion.duration < 1e9)) {
        found.speed = found.acceleration = found.jerk = 1e9;
    }
    return found;
}

void TrajectoryWriter::open(const Limits& limits) noexcept {
    limits_ = limits;
    pieces_.clear();
    waiting_.count = 0;
    time_ = 0.0;
    distance_ = 0.0;
    item_ = 0;
}

Piece& TrajectoryWriter::open_piece(double duration, std::uint32_t item, LimitedBy limited) noexcept {
    Piece& piece = pieces_.push();
    piece = {};
    piece.start = time_;
    piece.duration = duration;
    item_ = item > item_ ? item : item_;
    piece.item = item_;
    piece.limited = limited;
    return piece;
}

void TrajectoryWriter::close_piece(Piece& piece) noexcept {
    time_ += piece.duration;
    distance_ = value(piece.distance, piece.duration);
    const double unit = limits_.unscale(3);
    for (double& k : piece.axis[3]) {
        k *= unit;
    }
}

Stretch ramp_from(const Place& corner, const Place& direction, double jerk, double duration,
                  std::uint32_t item) noexcept {
    Stretch made{.origin = corner, .direction = direction};
    made.add({duration, 0.0, 0.0, 0.0, jerk}, item);
    return made;
}

Stretch ramp_to(const Place& corner, const Place& direction, double jerk, double duration,
                std::uint32_t item) noexcept {
    Stretch made{.origin = corner, .direction = direction};
    const double t = duration;
    made.add({t, -jerk * t * t * t * (1.0 / 6.0), 0.5 * jerk * t * t, -jerk * t, jerk}, item);
    return made;
}

void TrajectoryWriter::write_phase(const Stretch& stretch, const Phase& phase, std::uint32_t item) noexcept {
    const LimitedBy limited = phase.j != 0.0   ? LimitedBy::axis_jerk
                              : phase.a != 0.0 ? LimitedBy::axis_acceleration
                                               : LimitedBy::path_speed;
    Piece& piece = open_piece(phase.duration, item, limited);
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = stretch.direction[k];
        piece.axis[k] = {stretch.origin[k] + d * phase.s, d * phase.v, 0.5 * d * phase.a,
                         d * phase.j * (1.0 / 6.0),       0.0,         0.0};
    }
    const double g = length3(stretch.direction);
    piece.distance = {distance_, g * phase.v, 0.5 * g * phase.a, g * phase.j * (1.0 / 6.0), 0.0, 0.0};
    close_piece(piece);
}

/// Two stretches at once: the sum of both relative to the corner, which is the origin of `next`.
void TrajectoryWriter::write_both(const Stretch& last, const Phase& a, const Stretch& next, const Phase& b,
                                  double duration, std::uint32_t item) noexcept {
    Piece& piece = open_piece(duration, item, LimitedBy::corner);
    Place v0{};
    Place a0{};
    Place jerk{};
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d1 = last.direction[k];
        const double d2 = next.direction[k];
        v0[k] = d1 * a.v + d2 * b.v;
        a0[k] = d1 * a.a + d2 * b.a;
        jerk[k] = d1 * a.j + d2 * b.j;
        piece.axis[k] = {last.origin[k] + d1 * a.s + d2 * b.s, v0[k], 0.5 * a0[k], jerk[k] * (1.0 / 6.0), 0.0, 0.0};
    }
    const auto velocity = [&](double t) noexcept { return along(along(v0, t, a0), 0.5 * t * t, jerk); };
    const auto along_path = [&](double t) noexcept {
        const Place v = velocity(t);
        const double speed = length3(v);
        return Motion{0.0, speed, speed > 0.0 ? dot3(v, along(a0, t, jerk)) / speed : 0.0};
    };
    double length = 0.0;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        length = length + kWeight[i] * length3(velocity(duration * kNode[i]));
    }
    Motion begin = along_path(0.0);
    Motion end = along_path(duration);
    begin.p = distance_;
    end.p = distance_ + duration * length;
    piece.distance = hermite(begin, end, duration);
    close_piece(piece);
}

namespace {

/// Takes `duration` off the front of a phase.
void advance(Phase& phase, double duration) noexcept {
    const double t = duration;
    phase.s += t * (phase.v + t * (0.5 * phase.a + t * phase.j * (1.0 / 6.0)));
    phase.v += t * (phase.a + t * 0.5 * phase.j);
    phase.a += t * phase.j;
    phase.duration -= t;
}

double duration_of(const Stretch& stretch) noexcept {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < stretch.count; ++i) {
        sum += stretch.phase[i].duration;
    }
    return sum;
}

void drop_first(Stretch& stretch) noexcept {
    for (std::uint32_t i = 1; i < stretch.count; ++i) {
        stretch.phase[i - 1] = stretch.phase[i];
        stretch.item[i - 1] = stretch.item[i];
    }
    --stretch.count;
}

}  // namespace

/// In parts, so that the distance, a quintic in each, is true to some nanometres where the speed dips.
void TrajectoryWriter::write_corner(const Stretch& last, Phase a, const Stretch& next, Phase b, double duration,
                                    std::uint32_t item) noexcept {
    const int parts = dot(last.direction, next.direction) < kSharpCosine ? 4 : 3;
    const double part = duration / parts;
    for (int i = 0; i < parts; ++i) {
        write_both(last, a, next, b, part, item);
        advance(a, part);
        advance(b, part);
    }
}

/// Writes the first `duration` of what waits.
void TrajectoryWriter::write_waiting(double duration) noexcept {
    double left = duration;
    while (waiting_.count > 0 && left > kShortest) {
        Phase& first = waiting_.phase[0];
        if (first.duration - left > kShortest) {
            Phase part = first;
            part.duration = left;
            write_phase(waiting_, part, waiting_.item[0]);
            advance(first, left);
            return;
        }
        left -= first.duration;
        write_phase(waiting_, first, waiting_.item[0]);
        drop_first(waiting_);
    }
}

void TrajectoryWriter::join(const Stretch& stretch, double overlap) noexcept {
    Stretch next = stretch;
    const double whole = duration_of(waiting_);
    const double shared = smaller(overlap, smaller(whole, duration_of(next)));
    if (!(shared > kShortest)) {
        flush();
        waiting_ = next;
        return;
    }
    write_waiting(whole - shared);
    // Both together, from one change of phase to the next; what waits ends here by construction.
    while (waiting_.count > 0 && next.count > 0) {
        Phase& a = waiting_.phase[0];
        Phase& b = next.phase[0];
        const bool a_first = a.duration <= b.duration;
        const double t = a_first ? a.duration : b.duration;
        if (t > kShortest) {
            write_corner(waiting_, a, next, b, t, waiting_.item[0]);
        }
        const bool both = absolute(a.duration - b.duration) <= kShortest;
        if (a_first || both) {
            drop_first(waiting_);
        } else {
            advance(a, t);
        }
        if (!a_first || both) {
            drop_first(next);
        } else {
            advance(b, t);
        }
    }
    waiting_ = next;
}

void TrajectoryWriter::flush() noexcept {
    for (std::uint32_t i = 0; i < waiting_.count; ++i) {
        if (waiting_.phase[i].duration > kShortest) {
            write_phase(waiting_, waiting_.phase[i], waiting_.item[i]);
        }
    }
    waiting_.count = 0;
}

void TrajectoryWriter::cell(const Node& from, const Node& to, double b0, double c0, double b1, double c1) noexcept {
    const CellMotion motion = cell_motion(from, to, b0, c0, b1, c1);
    Piece& piece = open_piece(motion.duration, from.item, LimitedBy::axis_jerk);
    piece.axis = motion.axis;
    Motion begin = travel(from, b0, c0);
    Motion end = travel(to, b1, c1);
    begin.p = distance_;
    end.p = distance_ + cell_length(from);
    piece.distance = hermite(begin, end, motion.duration);
    close_piece(piece);
}

void TrajectoryWriter::straight(const Place& from, const Place& to, double duration, std::uint32_t item) noexcept {
    Piece& piece = open_piece(duration, item, LimitedBy::axis_jerk);
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        piece.axis[k] = hermite({from[k], 0.0, 0.0}, {to[k], 0.0, 0.0}, duration);
    }
    const double length = length3(minus(to, from));
    piece.distance = hermite({distance_, 0.0, 0.0}, {distance_ + length, 0.0, 0.0}, duration);
    close_piece(piece);
}

}  // namespace sc::trajectory
