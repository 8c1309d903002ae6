// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/job_runner.hpp"

#include <algorithm>
#include <utility>

#include "firmware/safety/watch.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

using trajectory::value;

constexpr double kUnlimited = 1e30;
constexpr std::int64_t kDrainTicks = 3;

}  // namespace

JobRunner::JobRunner(const MachineConfig& machine) noexcept
    : machine_(machine),
      y_retracted_(machine.y_retracted.si()),
      geometry_(machine),
      field_(machine.galvo),
      follower_(machine),
      surface_(machine.control_period_ns, machine.axis[kY].latency_ns) {
    set_galvo_lag(lag_of(machine.galvo));
    set_map(kNoMap, {});
    // Depth goes with the mirrors' path.
    for (const std::size_t mirror : {kX, kY, kZ}) {
        galvo_limits_.speed[mirror] = machine.galvo.speed.si();
        galvo_limits_.acceleration[mirror] = machine.galvo.acceleration.si();
        galvo_limits_.jerk[mirror] = machine.galvo.jerk.si();
    }
}

double JobRunner::seconds(std::int64_t ticks) const noexcept {
    return exact_double(ticks * machine_.control_period_ns) * 1e-9;
}

std::int64_t JobRunner::light_lag_ns() const noexcept {
    const std::int64_t beam = by_mirrors() ? mirror_lag_ns_ : machine_.axis[kX].latency_ns;
    return beam - machine_.laser.latency_ns;
}

void JobRunner::stand_at(const AxisPositions& set_point) noexcept {
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        if (set_point[i] != set_point_[i]) {
            geometry_.settle(i);
        }
    }
    set_point_ = set_point;
    surface_.rest();
    place_ = geometry_.place_of(set_point);
}

void JobRunner::set_compensation(const Compensation& compensation) noexcept {
    geometry_.set(compensation);
    set_retreat();
    field_.set(compensation);
    place_ = geometry_.place_of(set_point_);
}

void JobRunner::set_galvo_lag(const GalvoLag& lag) noexcept {
    lead_ = galvo_lead(with_lag(machine_.galvo, lag), machine_.galvo_period_ns);
    mirror_lag_ns_ = lag.latency_ns - rounded(lead_.per_velocity * 1e9);
    for (const std::size_t axis : {kX, kY, kZ}) {
        stage_late_[axis] =
            exact_double(machine_.axis[axis].latency_ns - mirror_lag_ns_) / exact_double(machine_.control_period_ns);
    }
    follower_.set_mirror_latency(lag.latency_ns);
}

void JobRunner::set_limits() noexcept {
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& axis = machine_.axis[i];
        stage_limits_.speed[i] = axis.speed - map_cost_.speed[i];
        stage_limits_.acceleration[i] = axis.acceleration - map_cost_.acceleration[i];
        stage_limits_.jerk[i] = axis.jerk - map_cost_.jerk[i];
    }
    const auto following = surface_.cost();
    stage_limits_.speed[kY] -= following[0];
    stage_limits_.acceleration[kY] -= following[1];
    stage_limits_.jerk[kY] -= following[2];
    path_limits_ = stage_limits_;
    path_limits_.speed[kC] = path_limits_.acceleration[kC] = path_limits_.jerk[kC] = 0.0;
}

void JobRunner::set_map(const AxisMap& map, const MapCost& cost) noexcept {
    map_cost_ = cost;
    set_limits();
    geometry_.set(map, cost);
    set_retreat();
    place_ = geometry_.place_of(set_point_);
}

/// A turn is watched by the set-point of y: the place to retract to is one whose set-point is retracted.
void JobRunner::set_retreat() noexcept {
    machine_.y_retracted = Length::from_si(y_retracted_ + geometry_.y_shortfall(y_retracted_));
}

void JobRunner::start_job(bool preview, const JobStart& start) noexcept {
    drop();
    preview_ = preview;
    phase_ = Phase::next_item;
    surface_.forget();
    if (start.first > 0) {
        items_taken_ = planned_ = fired_ = start.first;
        fired_position_ = start.done;
        done_ = start.done;
        resumes_ = true;
        begin_turn({start.c});
    }
}

void JobRunner::drop() noexcept {
    (void)motion_.open({});
    phase_ = Phase::idle;
    stopping_ = waiting_ = path_closed_ = preview_ = false;
    refusal_ = {};
    limited_by_ = LimitedBy::none;
    items_taken_ = planned_ = fired_ = 0;
    resumes_ = passes_over_ = passes_path_ = false;
    fired_position_ = {};
}

void JobRunner::refuse(Refusal refusal, std::uint32_t item, Axis axis, double value) noexcept {
    if (refusal_.refusal == Refusal::none) {
        const double scale = axis == Axis::c ? kWireUnitsPerDegree : kWireUnitsPerMetre;
        refusal_ = {refusal, item, static_cast<std::uint8_t>(axis), rounded(value * scale)};
    }
}

// --- dark moves

void JobRunner::begin_stage_move(const motion::Place& to, Phase phase) noexcept {
    const Vec3 from{place_[kX], place_[kY], place_[kZ]};
    if (phase != Phase::jog && safety::through_keep_out(machine_, from, {to[kX], to[kY], to[kZ]})) {
        refuse(Refusal::travel_through_keep_out, items_taken_ - 1, Axis::z, to[kZ]);
        return;
    }
    target_ = to;
    const bool chosen = phase == Phase::jog || phase == Phase::look_on;
    move_.begin(place_, to, stage_limits_, chosen ? move_speed_ : kUnlimited);
    phase_ = phase;
    phase_tick_ = tick_;
}

void JobRunner::begin_travel() noexcept {
    check_place(motion_.start(), items_taken_ - 1);
    if (path_.actuator == Actuator::split) {
        check_reach(motion_.start(), 0.0, items_taken_ - 1);
    }
    if (refusal_.refusal != Refusal::none) {
        return;
    }
    motion::Place to = stand();
    const double retracted = machine_.y_retracted.si();
    if (place_[kY] >= retracted - 1e-9 && to[kY] < retracted) {
        to[kY] = place_[kY];
        begin_stage_move(to, Phase::travel_across);
    } else {
        begin_stage_move(to, Phase::travel_in);
    }
}

motion::Place JobRunner::stand() const noexcept {
    switch (path_.actuator) {
        case Actuator::axes: break;
        case Actuator::galvo:
            return {metres(path_.anchor_x), metres(path_.anchor_y), metres(path_.anchor_z), place_[kC]};
        case Actuator::split: return stage_place(stage_.at(0.0));
    }
    return motion_.start();
}

void JobRunner::begin_jump() noexcept {
    motion::Place to{};
    if (by_mirrors()) {
        const motion::Place start = motion_.start();
        const motion::Place stage = stand();
        to = {start[kX] - stage[kX], start[kY] - stage[kY], start[kZ] - stage[kZ], 0.0};
    }
    move_.begin({field_x_ + follower_.x(), field_depth_, field_z_ + follower_.z(), 0.0}, to, galvo_limits_, kUnlimited);
    follower_.drop();
    phase_ = Phase::jump;
    phase_tick_ = tick_ + 1;  // this tick's frames are out already
}

void JobRunner::start_jog(Axis axis, double distance, double speed) noexcept {
    drop();
    motion::Place to = place_;
    to[index(axis)] += distance;
    move_speed_ = speed;
    begin_stage_move(to, Phase::jog);
}

void JobRunner::move_done() noexcept {
    switch (phase_) {
        case Phase::turn_retract: {
            const motion::Place at = place_;
            motion::Place to = at;
            to[kC] = target_[kC];
            begin_stage_move(to, Phase::turn_c);
            break;
        }
        case Phase::travel_across: begin_stage_move(stand(), Phase::travel_in); break;
        case Phase::travel_in: begin_jump(); break;
        case Phase::jump: phase_ = Phase::settle; break;
        case Phase::turn_c:
            fired_ = planned_ = items_taken_;
            phase_ = Phase::next_item;
            break;
        case Phase::end_retract:
            fired_ = planned_ = items_taken_;
            phase_ = Phase::done;
            break;
        case Phase::jog: phase_ = Phase::idle; break;
        case Phase::look_across: begin_stage_move(look_, Phase::look_in); break;
        case Phase::look_in: phase_ = Phase::look_settle; break;
        case Phase::look_on: stand_to_look(false); break;
        case Phase::idle:
        case Phase::next_item:
        case Phase::open_path:
        case Phase::settle:
        case Phase::await_plan:
        case Phase::path:
        case Phase::look_settle:
        case Phase::look_stand:
        case Phase::done: break;
    }
}

void JobRunner::move_step(ServoOutputs& out) noexcept {
    const double t = seconds(tick_ - phase_tick_);
    limited_by_ = LimitedBy::axis_speed;
    const bool done = move_.done(t);
    if (phase_ == Phase::jump) {
        galvo_jump(t, out);
    } else {
        place_ = move_.at(t);
        rest_ticks_ = 0;
        galvo_still(out);
    }
    if (!done) {
        return;
    }
    if (stopping_) {
        at_rest_ = true;
    } else {
        move_done();
    }
}

// --- the path

void JobRunner::place_pulses(std::int64_t t_ns, bool may_mark, ServoOutputs& out) noexcept {
    if (!may_mark) {
        return;
    }
    const std::int64_t lag = light_lag_ns();
    const std::int64_t from = t_ns - lag;
    const std::int64_t act = (phase_tick_ + 1) * machine_.control_period_ns + lag;
    placer_.place(motion_, from, from + machine_.control_period_ns, act, out);
    if (out.laser_size > 0) {
        const double period = exact_double(out.laser[0].period_ns256) / 256e9;
        pulse_speed_ = period > 0.0 ? static_cast<double>(path_.pitch_nm) * 1e-9 / period : 0.0;
        fired_position_ = {path_.path, path_.pass, placer_.last_item(), placer_.next_pulse()};
        if (placer_.last_item() > fired_) {
            fired_ = placer_.last_item();
        }
    }
}

void JobRunner::trace_line(double t) noexcept {
    motion::Cursor cursor;
    const motion::Segment segment = motion_.segment(t, cursor);
    const double distance = value(segment.piece->distance, segment.x(t));
    traced_ = larger(traced_, distance);
    on_line_ = motion_.marked(distance);
}

void JobRunner::path_step(bool may_mark, ServoOutputs& out) noexcept {
    const std::int64_t since = tick_ - phase_tick_;
    if (since < 0) {
        galvo_still(out);
        return;
    }
    const double t = seconds(since);
    const motion::Segment segment = motion_.segment(t, cursor_);
    if (surface_.on()) {
        watch_beam(segment, t);
    }
    limited_by_ = motion_.stopped() ? LimitedBy::starved : rate_held_ ? LimitedBy::pulse_rate : segment.piece->limited;
    if (by_mirrors()) {
        if (path_.actuator == Actuator::split) {
            stage_step(segment, t);
        }
        galvo_path(segment, t, out);
    } else {
        const motion::Place beam = segment.piece->place(segment.x(t));
        place_ = {beam[kX], beam[kY], beam[kZ], place_[kC]};
        rest_ticks_ = 0;
        galvo_still(out);
    }
    const double lag = exact_double(light_lag_ns()) * 1e-9;
    if (preview_) {
        trace_line(larger(t - lag, 0.0));
    } else {
        place_pulses(since * machine_.control_period_ns, may_mark, out);
    }
    motion_.forget_before(t - lag - seconds(2), next_distance());
    const bool split = path_.actuator == Actuator::split;
    const bool drained = t > motion_.end_time() + lag + seconds(kDrainTicks) &&
                         (!split || (stage_follower_.settled() && history_.stands()));
    if (motion_.stopped() && drained) {
        at_rest_ = true;
    } else if (motion_.complete() && drained) {
        finish_path();
    }
}

/// The stage goes on along its curve; it is where this says one axis latency later.
void JobRunner::stage_step(const motion::Segment& segment, double t) noexcept {
    const double distance = stage_follower_.push(nearest(value(segment.piece->distance, segment.x(t)) * kPmPerMetre));
    motion::StageCurve::Point place = stage_.at(distance);
    for (double& p : place) {
        p = exact_double(nearest(p * kPmPerMetre)) / kPmPerMetre;
    }
    // What is said of new points is said of where the stage may be then, at most so far back.
    stage_.forget_before(distance - stage_lag_);
    history_.push(place);
    place_ = stage_place(place);
    rest_ticks_ = 0;
    const double half = machine_.galvo.half_field.si();
    for (const auto& [axis, share] : {std::pair{Axis::x, field_x_}, std::pair{Axis::z, field_z_}}) {
        if (!(absolute(share) <= half)) {
            refuse(Refusal::galvo_out_of_field, items_taken_ - 1, axis, share);
        }
    }
}

void JobRunner::finish_path() noexcept {
    fired_ = planned_ = path_end_item_ + 1;
    phase_ = Phase::next_item;
    path_closed_ = false;
    at_rest_ = stopping_;
}

double JobRunner::override_share() noexcept {
    const double wanted = static_cast<double>(feed_override_percent_) * 0.01;
    const double speed = static_cast<double>(path_.speed_um_s) * 1e-6;
    const double fastest = static_cast<double>(path_.pitch_nm) * 1e-9 * machine_.laser.prr_nominal.si();
    const double slowest = machine_.laser.mark_speed_min.si();
    if (preview_) {
        return smaller(wanted, 1.0);
    }
    if (path_.actuator == Actuator::split) {
        // The stage's limits were checked at the programmed speed.
        rate_held_ = false;
        return larger(smaller(wanted, 1.0), smaller(1.0, speed > 0.0 ? 1.01 * slowest / speed : 1.0));
    }
    const double share = larger(smaller(wanted * speed, fastest), smaller(speed, 1.01 * slowest));
    rate_held_ = wanted * speed > fastest;
    return speed > 0.0 ? share / speed : 1.0;
}

void JobRunner::set_feed_override(std::uint8_t percent) noexcept {
    feed_override_percent_ = percent;
    motion_.set_override(override_share());
}

// --- the tick
// ---------------------------------------------------------------------------------------------------------------

void JobRunner::request_stop() noexcept {
    if (stopping_) {
        return;
    }
    stopping_ = true;
    switch (phase_) {
        case Phase::turn_retract:
        case Phase::turn_c:
        case Phase::travel_across:
        case Phase::travel_in:
        case Phase::jump:
        case Phase::end_retract:
        case Phase::look_across:
        case Phase::look_in:
        case Phase::look_on:
        case Phase::jog: move_.stop(seconds(tick_ + 1 - phase_tick_)); break;
        case Phase::path: motion_.request_stop(); break;
        case Phase::idle:
        case Phase::next_item:
        case Phase::open_path:
        case Phase::settle:
        case Phase::await_plan:
        case Phase::look_settle:
        case Phase::look_stand:
        case Phase::done: break;
    }
}

void JobRunner::resume() noexcept {
    stopping_ = false;
    at_rest_ = false;
    switch (phase_) {
        case Phase::turn_retract: {
            const double angle = target_[kC];
            motion::Place to = target_;
            to[kC] = place_[kC];
            begin_stage_move(to, Phase::turn_retract);
            target_[kC] = angle;
            break;
        }
        case Phase::turn_c:
        case Phase::travel_across:
        case Phase::travel_in:
        case Phase::look_across:
        case Phase::look_in:
        case Phase::look_on:
        case Phase::end_retract: begin_stage_move(target_, phase_); break;
        case Phase::jump: begin_jump(); break;
        case Phase::path:
            if (motion_.stopped()) {
                motion_.request_resume(next_distance());
            }
            break;
        case Phase::idle:
        case Phase::next_item:
        case Phase::open_path:
        case Phase::settle:
        case Phase::await_plan:
        case Phase::look_settle:
        case Phase::look_stand:
        case Phase::jog:
        case Phase::done: break;
    }
}

bool JobRunner::step(std::int64_t tick, ItemQueue& items, bool may_mark, ServoOutputs& out) noexcept {
    tick_ = tick;
    beam_is_lit_ = false;
    pulse_speed_ = 0.0;
    on_line_ = false;
    waiting_ = false;
    at_rest_ = false;
    if (rest_ticks_ < 1'000'000) {
        ++rest_ticks_;
    }
    const std::int64_t since = phase_ == Phase::path && tick > phase_tick_ ? tick - phase_tick_ : 0;
    const bool in_time = motion_.tick(seconds(since), seconds(1));
    const bool path_open = phase_ == Phase::open_path || phase_ == Phase::travel_across || phase_ == Phase::travel_in ||
                           phase_ == Phase::jump || phase_ == Phase::settle || phase_ == Phase::await_plan ||
                           phase_ == Phase::path;
    if (path_open) {
        check_end();
        feed(items);
        planned_ = motion_.planned_item() > planned_ ? motion_.planned_item() : planned_;
    }
    const bool refused = refusal_.refusal != Refusal::none;
    switch (phase_) {
        case Phase::idle:
        case Phase::done:
            galvo_still(out);
            limited_by_ = LimitedBy::none;
            at_rest_ = true;
            break;
        case Phase::next_item:
            galvo_still(out);
            at_rest_ = stopping_;
            if (!stopping_ && !refused) {
                take_item(items);
            }
            break;
        case Phase::open_path:
            galvo_still(out);
            at_rest_ = stopping_;
            waiting_ = items.empty();
            if (!stopping_ && !refused && motion_.has_start()) {
                begin_travel();
            }
            break;
        case Phase::settle:
            galvo_still(out);
            at_rest_ = stopping_;
            if (rest_ticks_ * machine_.control_period_ns >= machine_.settle_ns && surface_is_there()) {
                phase_ = Phase::await_plan;
            }
            break;
        case Phase::await_plan:
            galvo_still(out);
            at_rest_ = stopping_;
            waiting_ = !motion_.ready();
            if (!stopping_ && !refused && motion_.ready()) {
                phase_ = Phase::path;
                phase_tick_ = tick + 1;
                stage_follower_.open();
                history_.fill({place_[kX], place_[kY], place_[kZ]});
            }
            break;
        case Phase::turn_retract:
        case Phase::turn_c:
        case Phase::travel_across:
        case Phase::travel_in:
        case Phase::jump:
        case Phase::look_across:
        case Phase::look_in:
        case Phase::look_on:
        case Phase::end_retract:
        case Phase::jog: move_step(out); break;
        case Phase::look_settle:
        case Phase::look_stand:
            galvo_still(out);
            at_rest_ = stopping_;
            if (!stopping_ && !refused) {
                look_step();
            }
            break;
        case Phase::path: path_step(may_mark, out); break;
    }
    if (surface_.on()) {
        follow_surface();
        motion::Place shifted = place_;
        shifted[kY] += surface_.shift();
        set_point_ = geometry_.set_point_of(shifted);
    } else {
        set_point_ = geometry_.set_point_of(place_);
    }
    if (machine_.galvo.follow != FollowAxes::off) {
        follower_.note(tick, set_point_);
    }
    return in_time;
}

}  // namespace sc
