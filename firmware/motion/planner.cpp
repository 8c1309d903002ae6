// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/planner.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

/// Pieces that one element can take: a profile has seven phases at most.
constexpr std::size_t kPiecesPerElement = 7;
/// A task takes kPublishTicks. When one is begun the law must reach two of them further, so that after it there is
/// still time for a stop; where it does not, that stop is begun now.
constexpr double kTaskTicks = static_cast<double>(kPublishTicks);
constexpr double kReserveTicks = 2.0 * kTaskTicks + 0.5;

}  // namespace

void Planner::open(const PathSpec& spec) noexcept {
    builder_.open(spec);
    ring_.clear();
    law_.clear();
    pending_size_ = built_ = 0;
    end_pending_ = too_short_ = false;
    task_ = Task::none;
    stop_wanted_ = resume_wanted_ = stopped_ = starved_ = false;
    stop_time_ = 1e30;
    rearm_time_ = 0.0;
    next_ = 0;
    next_tau_ = next_speed_ = next_time_ = 0.0;
}

bool Planner::complete() const noexcept {
    return builder_.finished() && task_ == Task::none && !stopped_ && !resume_wanted_ && next_ == ring_.end();
}

std::uint32_t Planner::planned_item() const noexcept {
    return next_ > ring_.first() && next_ <= ring_.end() ? ring_.at(next_ - 1).item + 1 : 0;
}

bool Planner::enough_known() const noexcept {
    return next_ < ring_.end() && (builder_.finished() || ring_.end() - next_ >= kBatch + kHorizon);
}

bool Planner::plannable() const noexcept {
    return !stopped_ && !resume_wanted_ && enough_known() && law_.free() >= (kBatch + 1) * kPiecesPerElement;
}

bool Planner::can_continue() const noexcept { return stopped_ && enough_known(); }

bool Planner::ready(double tick_seconds) const noexcept {
    return !law_.empty() && (complete() || law_.end_time() >= (kReserveTicks + kTaskTicks) * tick_seconds);
}

void Planner::request_resume(double distance) noexcept {
    resume_wanted_ = true;
    starved_ = false;
    resume_distance_ = distance;
}

void Planner::add(const Place& point, std::uint32_t item) noexcept {
    pending_[pending_size_] = {point, item};
    ++pending_size_;
}

bool Planner::wants_points() const noexcept {
    // A point makes two elements at most, the end one.
    return !builder_.finished() && !end_pending_ && !too_short_ && pending_size_ < kPointsPerTick &&
           ring_.free() >= 2 * (pending_size_ + 1) + 1;
}

void Planner::build(std::uint32_t& units) noexcept {
    for (; built_ < pending_size_ && units >= kUnitsPerPoint; ++built_, units -= kUnitsPerPoint) {
        builder_.add(pending_[built_].place, pending_[built_].item, ring_);
    }
    if (built_ < pending_size_) {
        return;
    }
    built_ = pending_size_ = 0;
    if (end_pending_) {
        end_pending_ = false;
        too_short_ = !builder_.finish(ring_);
    }
}

bool Planner::tick(std::int64_t tick, double path_time, double tick_seconds) noexcept {
    if (pending_size_ > 0 || end_pending_) {
        return false;
    }
    if (task_ != Task::none) {
        if (tick < publish_tick_) {
            return true;
        }
        if (stage_ != Stage::done || overflow_) {
            return false;
        }
        publish();
    }
    publish_tick_ = tick + kPublishTicks;
    choose_task(path_time, tick_seconds);
    return true;
}

void Planner::choose_task(double path_time, double tick_seconds) noexcept {
    const double published = path_time + kTaskTicks * tick_seconds;
    stage_ = Stage::backward;
    if (resume_wanted_ && stopped_) {
        cut_time_ = larger(law_.end_time(), published);
        task_ = Task::resume;
        return;
    }
    // A law that ends at rest (after backing up, or at a sharp corner) may run out without harm.
    const bool running = path_time > 0.0 && !law_.empty() && !stopped_ && !complete() && next_speed_ > 0.0;
    if (running && !stop_wanted_ && law_.end_time() - path_time < kReserveTicks * tick_seconds) {
        starved_ = true;
        stop_wanted_ = true;
    }
    if (stop_wanted_) {
        if (stopped_ || law_.empty() || (complete() && published >= law_.end_time())) {
            stop_wanted_ = false;  // at rest, or about to be before a stop could begin
            return;
        }
        cut_time_ = published;
        task_ = Task::stop;
        return;
    }
    if (plannable()) {
        if (path_time > 0.0 && !(next_speed_ > 0.0)) {
            next_time_ = larger(next_time_, published);
        }
        begin_plan();
    }
}

void Planner::publish() noexcept {
    if (to_splice_) {
        law_.cut(cut_time_);
        for (std::size_t i = 0; i < splice_size_; ++i) {
            (void)law_.append(splice_[i]);
        }
        to_splice_ = false;
    }
    law_.publish();
    if (task_ == Task::stop) {
        stop_time_ = cut_time_;
        stop_wanted_ = false;
        stopped_ = rests_after_publish_;
    } else if (task_ == Task::resume) {
        stopped_ = false;
        starved_ = false;
        resume_wanted_ = false;
        rearm_time_ = rearm_after_publish_;
        stop_time_ = 1e30;
    }
    task_ = Task::none;
}

void Planner::work(std::uint32_t units) noexcept {
    build(units);
    if (task_ == Task::none || stage_ == Stage::done) {
        return;
    }
    if (task_ == Task::stop) {
        plan_stop();
        stage_ = Stage::done;
        return;
    }
    if (task_ == Task::resume) {
        plan_resume();
        stage_ = Stage::done;
        return;
    }
    while (stage_ != Stage::done) {
        const std::uint32_t cost = stage_ == Stage::backward ? 1 : kUnitsPerElement;
        if (units < cost) {
            return;
        }
        units -= cost;
        stage_ == Stage::backward ? step_backward() : step_forward();
    }
}

// --- a batch --------------------------------------------------------------------------------------------------------

Planner::Span Planner::forward_span(std::uint32_t number, double from) const noexcept {
    const Element& e = ring_.at(number);
    return {number, from, e.end() - from, e.cap, e.limits, e.kind == Element::Kind::blend, e.stop_at_end};
}

void Planner::begin_plan() noexcept {
    const std::uint32_t known = ring_.end() - next_;
    commit_end_ = next_ + (known < kBatch ? known : kBatch);
    window_end_ = next_ + (known < kBatch + kHorizon ? known : kBatch + kHorizon);
    cursor_ = window_end_;
    task_ = Task::plan;
    stage_ = Stage::backward;
    overflow_ = false;
    to_splice_ = false;
}

void Planner::step_backward() noexcept {
    const std::uint32_t number = cursor_ - 1;
    const Span span = forward_span(number, number == next_ ? next_tau_ : ring_.at(number).start);
    double after = cursor_ == window_end_ || span.stop_after ? 0.0 : entry_speed_[cursor_ % ElementRing::kCapacity];
    after = smaller(after, span.cap);
    const double entry = span.blend ? after : smaller(span.cap, reachable_speed(after, span.length, span.limits));
    entry_speed_[number % ElementRing::kCapacity] = entry;
    cursor_ = number;
    if (cursor_ == next_) {
        stage_ = Stage::forward;
    }
}

void Planner::step_forward() noexcept {
    if (next_ == commit_end_) {
        stage_ = Stage::done;
        return;
    }
    const Span span = forward_span(next_, next_tau_);
    double after =
        next_ + 1 == window_end_ || span.stop_after ? 0.0 : entry_speed_[(next_ + 1) % ElementRing::kCapacity];
    after = smaller(smaller(after, span.cap),
                    span.blend ? next_speed_ : reachable_speed(next_speed_, span.length, span.limits));
    append_span(span, next_speed_, after, 1.0, next_time_);
    next_tau_ = ring_.at(next_).end();
    next_speed_ = after;
    ++next_;
    if (next_ == commit_end_) {
        stage_ = Stage::done;
    }
}

void Planner::append(const Piece& piece) noexcept {
    if (to_splice_) {
        if (splice_size_ < kSpliceCapacity) {
            splice_[splice_size_] = piece;
            ++splice_size_;
        } else {
            overflow_ = true;
        }
    } else if (!law_.append(piece)) {
        overflow_ = true;
    }
}

void Planner::append_span(const Span& span, double v0, double v1, double sign, double& time) noexcept {
    Piece piece;
    piece.element = span.element;
    piece.tau0 = span.from;
    piece.v0 = sign * v0;
    if (!(span.length > 0.0)) {
        return;
    }
    if (span.blend) {
        piece.t0 = time;
        piece.duration = span.length / v0;
        append(piece);
        time = piece.end();
        return;
    }
    const PhaseList list = fastest_profile(v0, v1, span.cap, span.length, span.limits);
    for (std::size_t i = 0; i < list.count; ++i) {
        piece.t0 = time;
        piece.duration = list.phase[i].duration;
        piece.a0 = sign * list.phase[i].start_acceleration;
        piece.j = sign * list.phase[i].jerk;
        append(piece);
        time = piece.end();
        piece.tau0 = piece.tau(time);
        piece.v0 = piece.speed(time);
    }
}

// --- stop on the path
// -------------------------------------------------------------------------------------------------

void Planner::plan_stop() noexcept {
    to_splice_ = true;
    splice_size_ = 0;
    overflow_ = false;
    std::uint32_t k = law_.find(cut_time_, law_.first());
    double time = cut_time_;
    // A ramp down that has begun is finished as planned: breaking it off would meet the next corner too fast.
    while (law_.at(k).acceleration(time) < -1e-9) {
        time = law_.at(k).end();
        if (k + 1 == law_.published()) {
            break;
        }
        ++k;
    }
    const Piece& from = law_.at(k);
    if (time >= law_.end_time() && builder_.finished() && next_ == ring_.end()) {
        cut_time_ = law_.end_time();
        rests_after_publish_ = false;  // it comes to rest at the path's end anyway
        return;
    }
    cut_time_ = time;
    std::uint32_t number = from.element;
    double tau = from.tau(time);
    double v = larger(from.speed(time), 0.0);
    const double a = from.acceleration(time);
    if (a > 1e-9) {
        const double jerk = ring_.at(number).limits.jerk;
        const Piece ramp{time, a / jerk, tau, v, a, -jerk, number};
        append(ramp);
        time = ramp.end();
        tau = ramp.tau(time);
        v = ramp.speed(time);
    }
    while (v > 0.0 && number < ring_.end()) {
        Span span = forward_span(number, tau);
        const double braking = span.blend ? 0.0 : change_distance(v, 0.0, span.limits);
        if (!span.blend && braking <= span.length) {
            // Rest where there is room behind to gain speed on before the corner, should the path be backed up.
            const Element& line = ring_.at(number);
            const double room = line.start + smaller(0.5 * line.length, builder_.mark_begin()) - span.from;
            span.length = smaller(larger(braking, room), span.length);
            span.cap = larger(v, 0.0);
            append_span(span, v, 0.0, 1.0, time);
            tau = span.from + span.length;
            break;
        }
        const double after = span.blend ? v : (span.stop_after ? 0.0 : lowest_speed(v, span.length, span.limits));
        span.cap = larger(v, after);
        append_span(span, v, after, 1.0, time);
        v = after;
        tau = ring_.at(number).end();
        ++number;
    }
    rests_after_publish_ = true;
    next_ = number < ring_.end() ? number : ring_.end() - 1;
    next_tau_ = tau;
    next_speed_ = 0.0;
    next_time_ = time;
}

// --- resume
// -----------------------------------------------------------------------------------------------------------

double Planner::back_up_to(double distance, std::uint32_t& number) const noexcept {
    // From the element that holds the place back to one on a line, with the run-in's length or a whole line to gain
    // speed on.
    const std::uint32_t reach = kBackCapacity - 2;
    const std::uint32_t oldest = number > ring_.first() + reach ? number - reach : ring_.first();
    while (number > oldest && ring_.at(number).distance > distance) {
        --number;
    }
    double need = builder_.mark_begin();
    double tau = ring_.at(number).kind == Element::Kind::line
                     ? ring_.at(number).start +
                           larger(0.0, smaller(distance - ring_.at(number).distance, ring_.at(number).length))
                     : ring_.at(number).start;
    while (true) {
        const Element& e = ring_.at(number);
        const double room = tau - e.start;
        if (e.kind == Element::Kind::line && room >= need) {
            // Not near the line's end: the blend behind it must be met moving, from either side.
            const double latest = e.end() - smaller(0.5 * e.length, builder_.mark_begin());
            return larger(e.start, smaller(tau - need, latest));
        }
        if (number == oldest) {
            if (e.kind == Element::Kind::blend) {
                ++number;  // a blend is the oldest that is kept: begin behind it
            }
            return ring_.at(number).start;
        }
        need = larger(need - room, 0.0);
        --number;
        tau = ring_.at(number).end();
    }
}

void Planner::plan_resume() noexcept {
    to_splice_ = true;
    splice_size_ = 0;
    overflow_ = false;
    double time = cut_time_;
    const std::uint32_t element_rest = next_;
    const double tau_rest = next_tau_;
    std::uint32_t element_back = next_;
    const double rest = ring_.at(element_rest).distance_at(tau_rest);
    const double tau_back = back_up_to(smaller(resume_distance_, rest), element_back);
    if (tau_back < tau_rest) {
        run_back(tau_rest, element_rest, tau_back, element_back, time);
        next_ = element_back;
        next_tau_ = tau_back;
    }
    next_speed_ = 0.0;
    next_time_ = time;
    rearm_after_publish_ = time;
}

Planner::Span Planner::reverse_span(std::uint32_t number, double from, double to) const noexcept {
    const Element& e = ring_.at(number);
    const bool stop = number > ring_.first() && ring_.at(number - 1).stop_at_end;
    return {number, from, from - to, e.cap, e.limits, e.kind == Element::Kind::blend, stop};
}

void Planner::run_back(double tau_rest, std::uint32_t element_rest, double tau_back, std::uint32_t element_back,
                       double& time) noexcept {
    std::size_t count = 0;
    for (std::uint32_t number = element_rest; count < kBackCapacity; --number) {
        const Element& e = ring_.at(number);
        const double from = number == element_rest ? tau_rest : e.end();
        const double to = number == element_back ? tau_back : e.start;
        if (from > to) {
            back_[count] = reverse_span(number, from, to);
            ++count;
        }
        if (number == element_back) {
            break;
        }
    }
    back_speed_[count] = 0.0;
    for (std::size_t i = count; i > 0; --i) {
        const Span& span = back_[i - 1];
        const double after = span.stop_after ? 0.0 : smaller(back_speed_[i], span.cap);
        back_speed_[i - 1] = span.blend ? after : smaller(span.cap, reachable_speed(after, span.length, span.limits));
    }
    double v = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const Span& span = back_[i];
        double after = span.stop_after ? 0.0 : smaller(back_speed_[i + 1], span.cap);
        after = smaller(after, span.blend ? v : reachable_speed(v, span.length, span.limits));
        append_span(span, v, after, -1.0, time);
        v = after;
    }
}

// --- readers
// ------------------------------------------------------------------------------------------------------------

MotionState Planner::state(double t, std::uint32_t& hint) const noexcept {
    MotionState s;
    if (law_.empty()) {
        return s;
    }
    hint = law_.find(t, hint);
    const Piece& piece = law_.at(hint);
    const double inside = clamped(t, piece.t0, piece.end());
    s.tau = piece.tau(inside);
    s.speed = t > piece.end() ? 0.0 : piece.speed(inside);
    s.acceleration = t > piece.end() ? 0.0 : piece.acceleration(inside);
    s.element = piece.element;
    s.piece = hint;
    return s;
}

Segment Planner::segment(double t, std::uint32_t& hint) const noexcept {
    hint = law_.find(t, hint);
    const Piece& piece = law_.at(hint);
    Segment s;
    s.element = &ring_.at(piece.element);
    s.begin = piece.t0;
    s.end = piece.end();
    s.t0 = piece.t0;
    s.way0 = piece.tau0 - s.element->start;
    if (t >= s.end || t < s.begin) {
        const bool after = t >= s.end;
        s.way0 = clamped(piece.tau(after ? s.end : s.begin) - s.element->start, 0.0, s.element->length);
        s.begin = after ? s.end : -1e30;
        s.end = after ? 1e30 : piece.t0;
        return s;
    }
    s.moving = true;
    s.v0 = piece.v0;
    s.a0_half = 0.5 * piece.a0;
    s.j_sixth = (1.0 / 6.0) * piece.j;
    return s;
}

void Planner::forget_before(double t) noexcept {
    if (law_.empty() || task_ == Task::stop || task_ == Task::resume) {
        return;
    }
    law_.forget_before(t);
    const std::uint32_t present = law_.at(law_.first()).element;
    if (present > kHistory) {
        ring_.forget_before(present - kHistory);
    }
}

}  // namespace sc::motion
