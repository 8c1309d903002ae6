// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/path_motion.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

using trajectory::value;

using trajectory::Rate;
using trajectory::RateChange;
using trajectory::Retimer;

constexpr double kShortestSpan = 0.62;  ///< of the time of a stop, that passes in nominal time
constexpr double kReserveSpans = 4.6;   ///< of nominal time that is known at any moment, so that a stop can be planned
constexpr double kReserveTicks = 40.0;  ///< and for planning it
constexpr double kLastReserve = 0.5;
constexpr double kReadyShare = 1.25;  ///< of that, before it begins
constexpr double kSameRate = 1e-9;
constexpr double kLeastRate = 0.05;
constexpr double kGoShare = 0.6;
/// Spans of a lifted stretch.
constexpr std::array<double, 4> kLiftSpans{16.0, 10.0, 6.0, 3.0};
constexpr double kLiftAhead = 6.0;  ///< stops' times before the end of one, at which the next is planned
constexpr double kLeastLift = 0.5;  ///< of a stop's time: what is left of the path, if it is to be lifted
constexpr double kGreatestLift = 2.0;
constexpr std::uint32_t kMostLifted = 72;  ///< pieces
constexpr double kLiftPause = 0.1;         ///< s, after all have failed
constexpr std::uint32_t kSlackTicks = 3;

/// Time of a stop from the path's speed.
double stop_time_of(const trajectory::Limits& limits) noexcept {
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double a = limits.acceleration[k];
        const double j = limits.jerk[k];
        if (j > 0.0) {
            const double t = limits.speed * j > a * a ? limits.speed / a + a / j : 2.0 * square_root(limits.speed / j);
            longest = larger(longest, t);
        }
    }
    return longest;
}

}  // namespace

PathMotion::PathMotion() noexcept : planner_({vertex_memory_, node_memory_, piece_memory_}), made_(made_memory_) {}

bool PathMotion::open(const trajectory::Spec& spec) noexcept {
    pending_size_ = pending_taken_ = 0;
    end_pending_ = last_pending_ = bad_ = false;
    given_.size = given_taken_ = 0;
    credit_ = 0;
    idle_ = true;
    leg_first_ = leg_end_ = 0;
    made_.clear();
    retimer_.drop();
    marks_.open();
    newest_distance_ = 0.0;
    full_ = false;
    now_ = 0.0;
    planned_distance_ = 0.0;
    planned_end_ = 0;
    stop_wanted_ = resume_wanted_ = starved_ = complete_ = rests_ = backed_ = false;
    stop_time_ = 1e30;
    rearm_time_ = 0.0;
    task_ = Task::none;
    step_ = missed_ = 0;
    go_rate_ = 1.0;
    rates_size_ = 0;
    lift_ = 1.0;
    lift_after_ = 0.0;
    trajectory::Spec planned = spec;
    planned_speed_ = larger(1.0, override_);
    planned.speed = spec.speed * planned_speed_;
    open_ = planner_.open(planned).has_value();
    if (open_) {
        ends_.open(planned.speed, planner_.limits().merge, spec.limits);
        stop_span_ = kShortestSpan * stop_time_of(planner_.limits());
    }
    rate_ = wanted_rate();
    push({.rate = rate_, .slowness = 1.0 / rate_});
    return open_;
}

double PathMotion::wanted_rate() const noexcept { return clamped(override_ / planned_speed_, kLeastRate, 1.0); }

double PathMotion::wanted_lift() const noexcept { return clamped(override_ / planned_speed_, 1.0, kGreatestLift); }

void PathMotion::push(const Leg& added) noexcept {
    if (leg_end_ - leg_first_ == kLegs) {
        ++leg_first_;
    }
    leg(leg_end_) = added;
    ++leg_end_;
}

// --- points ---------------------------------------------------------------------------------------------------------

bool PathMotion::wants_points() const noexcept {
    return open_ && !bad_ && !end_pending_ && !ends_.finished() && pending_size_ < kPointsPerTick;
}

void PathMotion::take(const PathEnds::Point& point) noexcept {
    pending_[pending_size_] = point;
    ++pending_size_;
}

void PathMotion::finish() noexcept { end_pending_ = true; }

/// To the planner, as far as it has room. True when nothing is left.
bool PathMotion::give_on(std::uint32_t& units) noexcept {
    while (given_taken_ < given_.size) {
        if (!planner_.wants_points()) {
            return false;
        }
        const PathEnds::Point& point = given_.each[given_taken_];
        ++given_taken_;
        units -= point.arc && units > 0 ? 1U : 0U;
        const bool taken = point.arc ? planner_.add_arc(point.via, point.place, point.item).has_value()
                                     : planner_.add(point.place, point.item).has_value();
        bad_ = bad_ || !taken;
    }
    given_.size = given_taken_ = 0;
    return true;
}

void PathMotion::take_points(std::uint32_t& units) noexcept {
    while (give_on(units) && pending_taken_ < pending_size_ && units > 0) {
        ends_.add(pending_[pending_taken_], given_);
        ++pending_taken_;
        --units;
    }
    if (pending_taken_ < pending_size_) {
        return;
    }
    pending_taken_ = pending_size_ = 0;
    if (end_pending_ && given_.size == 0) {
        end_pending_ = false;
        ends_.finish(given_);
        last_pending_ = true;
    }
    if (last_pending_ && give_on(units)) {
        last_pending_ = false;
        if (!ends_.finished() || !planner_.finish()) {
            bad_ = true;
        }
    }
}

void PathMotion::work(std::uint32_t units) noexcept {
    std::uint32_t left = units < credit_ ? units : credit_;
    credit_ -= left;
    take_points(left);
    while (left > 0) {
        if (retimer_.working()) {
            const std::uint32_t used = retimer_.step(planner_.limits(), planner_.pieces(), made_);
            left = used < left ? left - used : 0;
            continue;
        }
        const std::uint32_t used = planner_.work(left);
        if (used == 0) {
            idle_ = true;
            return;
        }
        left = used < left ? left - used : 0;
    }
}

// --- the law --------------------------------------------------------------------------------------------------------

double PathMotion::nominal_end() const noexcept {
    if (planned_end_ == planner_.pieces().first()) {
        return 0.0;
    }
    const Piece& last = planner_.pieces()[planned_end_ - 1];
    return last.start + last.duration;
}

double PathMotion::nominal_at(double t) const noexcept {
    const Leg& last = newest();
    return last.nominal ? last.u0 + larger(t - last.begin, 0.0) * last.rate : rest_u_;
}

/// The same at this tick, within a cell.
double PathMotion::nominal_now() const noexcept {
    if (now_ >= newest().begin || rests_) {
        return nominal_at(now_);
    }
    std::uint32_t k = 0;
    while (k + 1 < rates_size_ && rates_begin_ + rates_[k].t < now_) {
        ++k;
    }
    return rates_size_ > 0 ? smaller(rates_[k].u, newest().u0) : nominal_at(now_);
}

double PathMotion::end_time() const noexcept {
    const Leg& last = newest();
    const bool goes_on = last.nominal && last.end >= kOpenEnd;
    return goes_on ? last.begin + (nominal_end() - last.u0) * last.slowness : last.end;
}

bool PathMotion::ready() const noexcept {
    if (!open_ || planned_end_ == planner_.pieces().first()) {
        return false;
    }
    if (complete_) {
        return true;
    }
    const double reserve = kReserveSpans * stop_span_ + kReserveTicks * tick_s_;
    const double from = rests_ ? rest_u_ : 0.0;
    return nominal_end() - from >= kReadyShare * reserve || no_room();
}

std::uint32_t PathMotion::planned_item() const noexcept {
    return planned_end_ > planner_.pieces().first() ? planner_.pieces()[planned_end_ - 1].item + 1 : 0;
}

void PathMotion::request_stop() noexcept {
    stop_wanted_ = true;
    resume_wanted_ = backed_ = false;
}

void PathMotion::request_resume(double distance) noexcept {
    resume_wanted_ = true;
    starved_ = false;
    resume_distance_ = distance;
}

bool PathMotion::tick(double path_time, double tick_seconds) noexcept {
    now_ = path_time;
    tick_s_ = tick_seconds;
    const bool late = open_ && credit_ > 0 && !idle_;
    if (late) {
        return false;
    }
    if (!open_) {
        return true;
    }
    if (ran_out()) {
        rest_at_end();
        starved_ = true;
    }
    complete_ = planner_.complete();
    waits_ = idle_ && !no_room();
    planned_end_ = planner_.pieces().end();
    if (planned_end_ != planner_.pieces().first()) {
        const Piece& last = planner_.pieces()[planned_end_ - 1];
        planned_distance_ = value(last.distance, last.duration);
        newest_distance_ = last.distance[0];
        marks_.find(planner_.pieces(), planned_end_);
    }
    if (!(path_time > 0.0) && newest().nominal && newest().u0 == 0.0) {
        rate_ = wanted_rate();
        leg(leg_end_ - 1).rate = rate_;
        leg(leg_end_ - 1).slowness = 1.0 / rate_;
    }
    if (task_ != Task::none && !retimer_.working()) {
        if (retimer_.state() == Retimer::State::done) {
            publish();
        } else {
            give_up();
        }
    }
    if (path_time > 0.0) {
        choose();
    }
    credit_ = kUnitsPerTick;
    idle_ = false;
    return true;
}

/// The law has come to the end of what was planned, and of no stop. Every plan ends at rest there; what is planned from
/// now on must not be jumped into.
bool PathMotion::ran_out() const noexcept {
    return !complete_ && !rests_ && now_ > 0.0 && planned_end_ != planner_.pieces().first() && newest().nominal &&
           now_ >= newest().begin && nominal_at(now_) > nominal_end();
}

void PathMotion::rest_at_end() noexcept {
    if (task_ != Task::none) {
        drop_task();
    }
    stop_wanted_ = false;
    rests_ = true;
    rest_u_ = nominal_end();
    leg(leg_end_ - 1).end = end_time();
    stop_time_ = smaller(stop_time_, now_);
}

/// What is next. A change from motion that is not ready in time is begun anew.
void PathMotion::choose() noexcept {
    if (task_ != Task::none) {
        const bool moving = task_ != Task::back && task_ != Task::go;
        const bool missed = moving && now_ + 1.5 * tick_s_ > task_begin_;
        const bool unwanted = stop_wanted_ && task_ != Task::stop;
        if (!missed && !unwanted) {
            return;
        }
        missed_ += missed ? 1U : 0U;
        drop_task();
    }
    if (rests_) {
        stop_wanted_ = false;
        if (resume_wanted_ && now_ >= end_time()) {
            choose_at_rest();
        }
        return;
    }
    watch_supply();
    if (stop_wanted_) {
        begin_moving_task(Task::stop);
    } else if (absolute(rate_ - wanted_rate()) > kSameRate ||
               (lift_ > wanted_lift() + kSameRate && now_ < newest().begin)) {
        begin_moving_task(Task::rate);
    } else if (wanted_lift() > 1.0 + kSameRate) {
        begin_lift();
    }
}

void PathMotion::drop_task() noexcept {
    retimer_.drop();
    made_.drop_from(made_begin_);
    if (task_ != Task::stop) {
        step_ = 0;
    }
    task_ = Task::none;
}

/// A stop for want of points is begun while there is still enough of them for it.
void PathMotion::watch_supply() noexcept {
    // While there is no room for more, the way on makes some.
    if (complete_ || stop_wanted_ || no_room()) {
        return;
    }
    const double reserve = lift_ * (kReserveSpans * stop_span_ + kReserveTicks * tick_s_ * rate_);
    const double ahead = nominal_end() - nominal_now();
    // While the planner is at work, it is a drought only when little is left.
    if (ahead < (waits_ ? reserve : kLastReserve * reserve)) {
        starved_ = true;
        stop_wanted_ = true;
    }
}

/// Number of the nominal piece that holds u: the last one that begins at or before it.
std::uint32_t PathMotion::piece_at(double u) const noexcept {
    const trajectory::Ring<Piece>& pieces = planner_.pieces();
    std::uint32_t low = pieces.first();
    std::uint32_t count = planned_end_ - low;
    while (count > 1) {
        const std::uint32_t half = count / 2;
        if (pieces[low + half].start <= u) {
            low += half;
            count -= half;
        } else {
            count = half;
        }
    }
    return low;
}

std::uint32_t PathMotion::pieces_between(std::uint32_t from, double until) const noexcept {
    std::uint32_t count = 1;
    while (count < kTooMany && from + count != planned_end_ && planner_.pieces()[from + count].start < until) {
        ++count;
    }
    return count;
}

/// State at the first moment for which a change over `span` can be ready in time; nominal time that it is to take.
double PathMotion::place_change(double span, std::uint32_t most_pieces, RateChange& change) noexcept {
    const trajectory::Limits& limits = planner_.limits();
    const Leg& last = newest();
    const Rate even{.u = last.u0, .b = rate_ * rate_ * limits.speed * limits.speed};
    double taken = span;
    // Twice: how long planning takes depends on where it begins.
    std::uint32_t ticks = kSlackTicks;
    for (int i = 0; i < 2; ++i) {
        task_begin_ = now_ + static_cast<double>(ticks) * tick_s_;
        change.from = even;
        if (task_begin_ >= last.begin) {
            change.from.u = nominal_at(task_begin_);
        } else {
            // In the midst of the change that is in force.
            std::uint32_t k = 0;
            while (k + 1 < rates_size_ && rates_begin_ + rates_[k].t < task_begin_) {
                ++k;
            }
            const bool moves = k + 1 < rates_size_ && rates_[k].b > 0.0;
            change.from = moves ? rates_[k] : even;
            task_begin_ = moves ? rates_begin_ + rates_[k].t : last.begin;
        }
        change.from.t = 0.0;
        change.piece = piece_at(change.from.u);
        taken = span * larger(1.0, square_root(change.from.b) / limits.speed);
        std::uint32_t pieces = pieces_between(change.piece, change.from.u + taken);
        if (pieces > most_pieces) {
            pieces = most_pieces;
            taken = planner_.pieces()[change.piece + pieces].start - change.from.u;
        }
        ticks = kSlackTicks + (1 + missed_) * (Retimer::units(pieces) / kUnitsPerTick);
    }
    return taken;
}

/// Stop, or another rate, while it moves.
void PathMotion::begin_moving_task(Task task) noexcept {
    climb_for(task);
    RateChange change;
    const double span = kSpans[step_] * stop_span_ * (task == Task::stop ? rate_ : 1.0);
    change.until = place_change(span, kTooMany, change);
    change.until += change.from.u;
    const double end = nominal_end();
    if (change.until >= end) {
        if (complete_) {
            // It comes to rest at the path's end, before any other stop would be over.
            step_ = 0;
            if (task == Task::stop) {
                rest_at_end();
            }
            return;
        }
        change.until = end;
    }
    change.rate = task == Task::stop ? rate_ : wanted_rate();
    change.most = lift_;
    change.end = task == Task::stop ? RateChange::End::rest : RateChange::End::rate;
    if (change.until > change.from.u) {
        begin_change(task, change);
    }
}

/// A lifted leg after the other, each planned while the one before has still to slow down to rate 1 at its end; so if
/// none is found, nothing is lost.
void PathMotion::begin_lift() noexcept {
    const double left = newest().begin - now_;
    const double reserve = kReadyShare * wanted_lift() * (kReserveSpans * stop_span_ + kReserveTicks * tick_s_);
    if (now_ < lift_after_ || left > kLiftAhead * stop_span_ ||
        (!complete_ && nominal_end() - nominal_now() < reserve)) {
        return;
    }
    climb_for(Task::lift);
    RateChange change;
    change.until = place_change(kLiftSpans[step_] * stop_span_, kMostLifted, change);
    change.until += change.from.u;
    change.end = RateChange::End::rate;
    const double end = nominal_end();
    if (change.until >= end) {
        change.until = end;
        change.end = complete_ ? RateChange::End::free : RateChange::End::rate;
    }
    change.most = wanted_lift();
    change.lifted = true;
    if (change.until - change.from.u > kLeastLift * stop_span_) {
        begin_change(Task::lift, change);
    }
}

void PathMotion::begin_change(Task task, const RateChange& change) noexcept {
    if (made_.free() < Retimer::kMostPieces) {
        return;
    }
    task_ = task;
    change_ = change;
    made_begin_ = made_.end();
    retimer_.begin(change);
}

/// A longer stretch, or a gentler change.
void PathMotion::give_up() noexcept {
    made_.drop_from(made_begin_);
    const Task failed = task_;
    task_ = Task::none;
    missed_ = 0;
    ++step_;
    if (step_ < (failed == Task::lift ? kLiftSpans.size() : kSpans.size())) {
        return;
    }
    step_ = 0;
    if (failed == Task::lift) {
        lift_after_ = now_ + kLiftPause;
    } else if (failed == Task::go) {
        go_rate_ = larger(kGoShare * go_rate_, kLeastRate);
    } else if (failed == Task::back) {
        backed_ = true;  // from here, then: what lacks the way to gather speed is withheld and counted
    }
}

void PathMotion::publish() noexcept {
    const Task task = task_;
    task_ = Task::none;
    step_ = missed_ = 0;
    const bool from_rest = task == Task::back || task == Task::go;
    const double begin = from_rest ? now_ + tick_s_ : task_begin_;
    const Rate& end = retimer_.at(retimer_.count() - 1);
    if (!from_rest) {
        // What was to come behind this moment is replaced.
        while (leg_end_ - leg_first_ > 1 && newest().begin >= begin) {
            --leg_end_;
        }
        leg(leg_end_ - 1).end = begin;
    }
    lift_ = task == Task::lift ? change_.most : 1.0;
    rates_size_ = retimer_.count();
    rates_begin_ = begin;
    for (std::uint32_t i = 0; i < rates_size_; ++i) {
        rates_[i] = retimer_.at(i);
    }
    push({.begin = begin,
          .end = begin + end.t,
          .nominal = false,
          .backward = task == Task::back,
          .u0 = change_.from.u,
          .first = made_begin_,
          .last = made_.end()});
    if (task == Task::stop || task == Task::back) {
        rests_ = true;
        rest_u_ = end.u;
        backed_ = task == Task::back && resume_wanted_ && back_reaches_;
        if (task == Task::stop) {
            stop_wanted_ = false;
            stop_time_ = smaller(stop_time_, begin);
        }
        return;
    }
    rate_ = change_.rate;
    push({.begin = begin + end.t, .u0 = end.u, .rate = rate_, .slowness = 1.0 / rate_});
    if (task == Task::go) {
        go_rate_ = 1.0;
        go_on(begin);
    }
}

}  // namespace sc::motion
