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
constexpr double kShortest = 1e-12;  ///< s; what is left over below is rounding

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

Excess excess(const Limits& limits, const CellMotion& motion) noexcept {
    Excess found;
    double fastest = 0.0;
    constexpr int kSamples = 4;
    for (int i = 0; i <= kSamples; ++i) {
        const double t = motion.duration * i * (1.0 / kSamples);
        double sum = 0.0;
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            const double v = rate(motion.axis[k], t);
            if (k < 3) {
                sum = sum + v * v;
            }
            if (limits.velocity[k] > 0.0) {
                fastest = larger(fastest, absolute(v) / limits.velocity[k]);
            }
        }
        fastest = larger(fastest, square_root(sum) / limits.speed);
    }
    found.speed = fastest;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
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
    has_waiting_ = false;
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

/// Part of a ramp, from `from` to `to` of its time; one to rest is the other run backward.
void TrajectoryWriter::ramp_piece(const Ramp& ramp, double from, double to, bool to_rest) noexcept {
    const double duration = to - from;
    if (!(duration > kShortest)) {
        return;
    }
    // Along the path relative to the corner: s = ± J t³/6 with the time t from the corner.
    const double t = to_rest ? ramp.duration - from : from;
    const double sign = to_rest ? -1.0 : 1.0;
    const double j = ramp.jerk;
    line(ramp.corner, ramp.direction, {duration, sign * j * t * t * t * (1.0 / 6.0), 0.5 * j * t * t, sign * j * t, j},
         ramp.item, LimitedBy::axis_jerk);
}

void TrajectoryWriter::line(const Place& origin, const Place& direction, const Phase& phase, std::uint32_t item,
                            LimitedBy limited) noexcept {
    Piece& piece = open_piece(phase.duration, item, limited);
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = direction[k];
        piece.axis[k] = {origin[k] + d * phase.s, d * phase.v, 0.5 * d * phase.a, d * phase.j * (1.0 / 6.0), 0.0, 0.0};
    }
    const double g = length3(direction);
    piece.distance = {distance_, g * phase.v, 0.5 * g * phase.a, g * phase.j * (1.0 / 6.0), 0.0, 0.0};
    close_piece(piece);
}

void TrajectoryWriter::begin(const Ramp& ramp, double overlap) noexcept {
    if (!has_waiting_) {
        ramp_piece(ramp, 0.0, ramp.duration, false);
        return;
    }
    has_waiting_ = false;
    const Ramp& last = waiting_;
    const double t = smaller(overlap, smaller(last.duration, ramp.duration));
    if (!(t > kShortest)) {
        ramp_piece(last, 0.0, last.duration, true);
        ramp_piece(ramp, 0.0, ramp.duration, false);
        return;
    }
    ramp_piece(last, 0.0, last.duration - t, true);
    Piece& piece = open_piece(t, last.item, LimitedBy::corner);
    const double third = 1.0 / 6.0;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d1 = last.jerk * last.direction[k];
        const double d2 = ramp.jerk * ramp.direction[k];
        piece.axis[k] = {
            ramp.corner[k] - d1 * t * t * t * third, 0.5 * d1 * t * t, -0.5 * d1 * t, (d1 + d2) * third, 0.0, 0.0};
    }
    double length = 0.0;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        const double u = t * kNode[i];
        const double w = t - u;
        const Place v = along(times(0.5 * last.jerk * w * w, last.direction), 0.5 * ramp.jerk * u * u, ramp.direction);
        length = length + kWeight[i] * length3(v);
    }
    const double g1 = length3(last.direction) * last.jerk;
    const double g2 = length3(ramp.direction) * ramp.jerk;
    piece.distance =
        hermite({distance_, 0.5 * g1 * t * t, -g1 * t}, {distance_ + t * length, 0.5 * g2 * t * t, g2 * t}, t);
    close_piece(piece);
    ramp_piece(ramp, t, ramp.duration, false);
}

void TrajectoryWriter::end(const Ramp& ramp) noexcept {
    waiting_ = ramp;
    has_waiting_ = true;
}

void TrajectoryWriter::flush() noexcept {
    if (has_waiting_) {
        has_waiting_ = false;
        ramp_piece(waiting_, 0.0, waiting_.duration, true);
    }
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
