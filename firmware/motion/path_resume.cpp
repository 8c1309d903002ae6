// SPDX-License-Identifier: Apache-2.0
// From rest: back along the path by the run-in, and on.
#include "firmware/motion/path_motion.hpp"
#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

using trajectory::value;

using trajectory::RateChange;

/// Rates, and shares of the way, that a way back is tried at: the slower and shorter, the more the limits have left.
/// What is left of the way is then gone from the next rest.
constexpr std::array<double, 7> kBackRates{1.0, 0.6, 0.3, 0.8, 0.4, 0.5, 0.2};
constexpr std::array<double, 7> kBackShares{1.0, 1.0, 1.0, 0.4, 0.4, 0.12, 0.04};
constexpr double kLeastBack = 0.5;  ///< of a stop's time
constexpr double kRest = 1e-6;      ///< m: a way back shorter than this is none

}  // namespace

/// Nominal time at which the beam has come `distance` far; that of the oldest piece kept, if that is further on.
double PathMotion::time_at_distance(double distance) const noexcept {
    const trajectory::Ring<Piece>& pieces = planner_.pieces();
    std::uint32_t k = piece_at(rest_u_);
    while (k != pieces.first() && pieces[k].distance[0] > distance) {
        --k;
    }
    const Piece& piece = pieces[k];
    double low = 0.0;
    double high = piece.duration;
    if (piece.distance[0] >= distance) {
        return piece.start;
    }
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        (value(piece.distance, middle) < distance ? low : high) = middle;
    }
    return piece.start + low;
}

void PathMotion::choose_at_rest() noexcept {
    const Piece& piece = planner_.pieces()[piece_at(rest_u_)];
    const double here = value(piece.distance, rest_u_ - piece.start);
    if (complete_ && rest_u_ >= nominal_end() && resume_distance_ > mark_end() + kRest) {
        go_on(now_);  // nothing is left to be marked: the path is over
    } else if (!backed_ && rest_u_ > 0.0 && here + ends_.run_in() - resume_distance_ > kRest) {
        begin_back();
    } else {
        begin_go();
    }
}

/// The law moves forward again from path time `begin`.
void PathMotion::go_on(double begin) noexcept {
    rests_ = backed_ = starved_ = resume_wanted_ = false;
    rearm_time_ = begin;
    stop_time_ = 1e30;
}

void PathMotion::begin_back() noexcept {
    climb_for(Task::back);
    RateChange change;
    change.from = {.u = rest_u_};
    change.piece = piece_at(rest_u_);
    if (planner_.pieces()[change.piece].start == rest_u_ && change.piece != planner_.pieces().first()) {
        --change.piece;
    }
    const double aim = time_at_distance(resume_distance_ - ends_.run_in());
    // Too short a way has no room to gather speed.
    double u = larger(smaller(aim, rest_u_ - kLeastBack * stop_span_), 0.0);
    std::uint32_t k = change.piece;
    for (std::uint32_t n = 0; n < kTooMany && k != planner_.pieces().first() && planner_.pieces()[k].start > u; ++n) {
        --k;
    }
    u = larger(u, planner_.pieces()[k].start);
    if (!(u < rest_u_ - 0.5 * kLeastBack * stop_span_)) {
        backed_ = true;  // no more is kept to back up over
        begin_go();
        return;
    }
    change.until = rest_u_ - kBackShares[step_] * (rest_u_ - u);
    change.end = change.until > 0.0 ? RateChange::End::rest : RateChange::End::free;
    change.rate = kBackRates[step_];
    back_reaches_ = !(change.until > aim);
    begin_change(Task::back, change);
}

void PathMotion::begin_go() noexcept {
    climb_for(Task::go);
    if (step_ == 0 && !(go_rate_ < wanted_rate())) {
        go_rate_ = wanted_rate();
    }
    if (!(rest_u_ > 0.0)) {
        // The nominal trajectory begins at rest itself.
        rate_ = wanted_rate();
        const double begin = now_ + tick_s_;
        push({.begin = begin, .u0 = 0.0, .rate = rate_, .slowness = 1.0 / rate_});
        go_on(begin);
        return;
    }
    RateChange change;
    change.from = {.u = rest_u_};
    change.piece = piece_at(rest_u_);
    change.rate = go_rate_;
    change.until = rest_u_ + kSpans[step_] * stop_span_ * go_rate_;
    change.end = RateChange::End::rate;
    const double end = nominal_end();
    if (change.until >= end) {
        if (!complete_) {
            return;
        }
        change.until = end;
        change.end = RateChange::End::free;
    }
    begin_change(Task::go, change);
}

}  // namespace sc::motion
