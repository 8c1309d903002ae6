// SPDX-License-Identifier: Apache-2.0
// The readers' side of PathMotion: where the beam is, and what is not needed any more.
#include "firmware/motion/path_motion.hpp"
#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

constexpr std::uint32_t kMostBehind = 340;  ///< pieces that are kept behind the reader

}  // namespace

/// Number of the leg at path time t, sought from `i` on.
std::uint32_t PathMotion::leg_at(double t, std::uint32_t i) const noexcept {
    if (static_cast<std::int32_t>(i - leg_first_) < 0 || static_cast<std::int32_t>(leg_end_ - i) <= 0) {
        i = leg_end_ - 1;
    }
    while (i != leg_first_ && t < leg(i).begin) {
        --i;
    }
    while (i + 1 != leg_end_ && t >= leg(i).end) {
        ++i;
    }
    return i;
}

Segment PathMotion::segment(double t, Cursor& cursor) const noexcept {
    const std::uint32_t i = leg_at(t, cursor.leg);
    cursor.leg = i;
    const Leg& now = leg(i);
    const bool nominal = now.nominal;
    const trajectory::Ring<Piece>& ring = nominal ? planner_.pieces() : made_;
    const std::uint32_t first = nominal ? ring.first() : now.first;
    const std::uint32_t last = (nominal ? planned_end_ : now.last) - 1;
    // A law that rests before the end of what is planned does not go beyond it.
    const double until = smaller(t, now.end);
    const double u = nominal ? now.u0 + (until - now.begin) * now.rate : until - now.begin;
    std::uint32_t k = cursor.piece;
    if (k - first > last - first) {
        k = nominal ? piece_at(u) : first;
    }
    while (k != first && ring[k].start > u) {
        --k;
    }
    while (k != last && ring[k + 1].start <= u) {
        ++k;
    }
    const double scale = nominal ? now.slowness : 1.0;
    const double u0 = nominal ? now.u0 : 0.0;
    const double rate = nominal ? now.rate : 1.0;
    double t0 = 0.0;
    double end = 0.0;
    while (true) {
        t0 = now.begin + (ring[k].start - u0) * scale;
        if (k == last) {
            end = now.end < kOpenEnd ? now.end : t0 + ring[k].duration * scale;
            break;
        }
        end = smaller(now.begin + (ring[k + 1].start - u0) * scale, now.end);
        // Rounding must not give the same piece again at its own end.
        if (t < end || end >= now.end) {
            break;
        }
        ++k;
    }
    cursor.piece = k;
    const Piece& piece = ring[k];
    const double begin = larger(t0, now.begin);
    if (t < begin || (t >= end && (k == last || t >= now.end))) {
        // Before the law begins, between two legs at rest, or behind its end.
        const bool after = t >= end;
        const double at = after ? end : begin;
        const double next = i + 1 != leg_end_ ? leg(i + 1).begin : 1e30;
        return {&piece, after ? end : -1e30, after ? next : at, t, clamped((at - t0) * rate, 0.0, piece.duration), 0.0,
                false};
    }
    return {&piece, begin, end, t0, 0.0, rate, true};
}

Segment PathMotion::segment_after(const Segment& before, double t, Cursor& cursor) const noexcept {
    const Leg& now = leg(cursor.leg);
    const std::uint32_t k = cursor.piece + 1;
    if (before.moving && now.nominal && before.end < now.end && planned_end_ - k > 1) {
        const trajectory::Ring<Piece>& ring = planner_.pieces();
        const double end = smaller(now.begin + (ring[k + 1].start - now.u0) * now.slowness, now.end);
        if (t < end && ring[k + 1].start > now.u0 + (t - now.begin) * now.rate) {
            cursor.piece = k;
            return {&ring[k], before.end, end, before.end, 0.0, now.rate, true};
        }
    }
    return segment(t, cursor);
}

std::optional<Stretch> PathMotion::stretch(std::uint32_t number) const noexcept {
    Stretch s{.begin = ends_.run_in(), .end = mark_end(), .end_known = complete_};
    if (number > 0) {
        if (!marks_.found(2 * number - 1)) {
            return std::nullopt;
        }
        s.begin = marks_.distance(2 * number - 1);
    }
    const std::uint32_t last = 2 * number;
    if (last < marks_.known()) {
        s.more = true;
        s.end_known = marks_.found(last);
        // The newest piece may go beyond a boundary that is not found yet; it does not begin beyond it.
        s.end = s.end_known ? marks_.distance(last) : smaller(s.end, newest_distance_);
    }
    return s;
}

bool PathMotion::marked(double distance) const noexcept {
    if (!(distance >= ends_.run_in() && distance <= mark_end())) {
        return false;
    }
    std::uint32_t before = marks_.oldest();
    while (marks_.found(before) && marks_.distance(before) <= distance) {
        ++before;
    }
    return before % 2 == 0;
}

void PathMotion::forget_before(double t, double distance) noexcept {
    marks_.forget_before(distance);
    // A way back, or on from rest, is planned over what was passed.
    if (task_ == Task::back || task_ == Task::go || !open_ || !ready()) {
        return;
    }
    Cursor cursor;
    const Segment s = segment(t, cursor);
    while (leg_first_ != cursor.leg) {
        ++leg_first_;
    }
    const Leg& now = leg(cursor.leg);
    trajectory::Ring<Piece>& pieces = planner_.pieces();
    std::uint32_t at = cursor.piece;
    if (now.nominal) {
        // Re-timed legs that are still to come keep theirs, and so does what is being made.
        std::uint32_t next = cursor.leg;
        while (next != leg_end_ && leg(next).nominal) {
            ++next;
        }
        const std::uint32_t made_end = task_ != Task::none ? made_begin_ : made_.end();
        made_.forget_before(next == leg_end_ ? made_end : leg(next).first);
    } else {
        made_.forget_before(cursor.piece);
        if (now.backward && !backed_) {
            return;
        }
        at = piece_at(now.backward ? rest_u_ : now.u0);
    }
    // Behind the reader, and what is still to be marked, the way of a run-in is kept, to back up.
    const double next = resume_wanted_ ? smaller(distance, resume_distance_) : distance;
    const double keep =
        !now.nominal && now.backward ? 1e30 : smaller(s.piece->distance[0], next) - 1.3 * ends_.run_in();
    while (pieces.first() != at &&
           (pieces[pieces.first() + 1].distance[0] < keep || at - pieces.first() > kMostBehind)) {
        pieces.forget_before(pieces.first() + 1);
    }
}

}  // namespace sc::motion
