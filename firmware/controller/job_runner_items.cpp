// SPDX-License-Identifier: Apache-2.0
// Items of a job, as they are taken: what each begins, and what is refused.
#include "firmware/controller/job_runner.hpp"
#include "firmware/safety/watch.hpp"
#include "firmware/trajectory/arc.hpp"
#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

/// The mirrors' set-points follow the stage's by a spline: of its jerk, what that may overshoot.
constexpr double kStageJerkShare = 2.0;
/// Samples of a way between two points at which the mirrors' reach is foretold.
constexpr std::uint32_t kMostSamples = 4;

/// Points keep this far from the ends of travel, so that the matrix cannot push a set-point over them.
constexpr double kTravelMargin = 0.2e-3;

}  // namespace

bool JobRunner::in_travel(const motion::Place& place, std::uint32_t item) noexcept {
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
        const AxisConfig& config = machine_.axis[index(axis)];
        const double p = place[index(axis)];
        const double following = axis == Axis::y ? surface_.reach() : 0.0;
        const double margin = kTravelMargin + geometry_.map_shift(index(axis)) + following;
        if (!(p >= config.travel_min + margin && p <= config.travel_max - margin)) {
            refuse(Refusal::out_of_travel, item, axis, p);
            return false;
        }
    }
    if (safety::in_keep_out(machine_, {place[kX], place[kY], place[kZ]})) {
        refuse(Refusal::in_keep_out, item, Axis::z, place[kZ]);
        return false;
    }
    return true;
}

void JobRunner::take_item(ItemQueue& items) noexcept {
    const Item* front = items.front();
    if (front == nullptr) {
        waiting_ = true;
        limited_by_ = LimitedBy::starved;
        return;
    }
    const Item item = *front;
    items.pop();
    ++items_taken_;
    if (pass_over(item)) {
        return;
    }
    if (const auto* turn = std::get_if<Turn>(&item)) {
        begin_turn(*turn);
    } else if (const auto* begin = std::get_if<PathBegin>(&item)) {
        begin_path(*begin);
    } else if (const auto* look = std::get_if<Look>(&item)) {
        begin_look(*look);
    } else if (std::holds_alternative<JobEnd>(item)) {
        motion::Place to = place_;
        to[kY] = larger(place_[kY], machine_.y_retracted.si());
        begin_stage_move(to, Phase::end_retract);
    } else {
        refuse(Refusal::item_out_of_order, items_taken_ - 1, Axis::x, 0.0);
    }
}

void JobRunner::begin_turn(const Turn& turn) noexcept {
    const double angle = static_cast<double>(turn.c) / kWireUnitsPerDegree;
    const AxisConfig& c = machine_.axis[kC];
    if (!(angle >= c.travel_min && angle <= c.travel_max)) {
        refuse(Refusal::turn_out_of_range, items_taken_ - 1, Axis::c, angle);
        return;
    }
    target_ = place_;
    surface_.forget();
    if (angle != place_[kC]) {
        target_[kY] = larger(place_[kY], machine_.y_retracted.si());
    }
    begin_stage_move(target_, Phase::turn_retract);
    target_[kC] = angle;
}

void JobRunner::begin_path(const PathBegin& begin) noexcept {
    const std::uint32_t item = items_taken_ - 1;
    path_ = begin;
    laser::PulseSpec pulses;
    pulses.path = begin.path;
    pulses.pass = begin.pass;
    pulses.pitch = static_cast<double>(begin.pitch_nm) * 1e-9;
    pulses.energy = static_cast<double>(begin.energy_nj) * 1e-9;
    pulses.speed_min = machine_.laser.mark_speed_min.si();
    pulses.prr_min = machine_.laser.prr_min.si();
    pulses.prr_nominal = machine_.laser.prr_nominal.si();
    pulses.power = curve_.measured() ? curve_.most() : machine_.laser.power.si();
    pulses.curve = curve_;
    pulses.power_byte = machine_.laser.power_byte;
    trajectory::Spec spec;
    spec.speed = static_cast<double>(begin.speed_um_s) * 1e-6;
    spec.tolerance = static_cast<double>(begin.tolerance_nm) * 1e-9;
    const bool split = begin.actuator == Actuator::split;
    spec.limits = begin.actuator == Actuator::axes ? path_limits_ : galvo_limits_;
    double fastest = begin.actuator == Actuator::axes ? machine_.axis[kX].speed : machine_.galvo.speed.si();
    for (const std::size_t i : {kX, kY, kZ}) {
        if (split) {
            // What the stage does, the mirrors must be able to take back.
            spec.limits.speed[i] -= 0.5 * stage_limits_.speed[i];
            spec.limits.acceleration[i] -= stage_limits_.acceleration[i];
            spec.limits.jerk[i] -= kStageJerkShare * stage_limits_.jerk[i];
            fastest = smaller(fastest, spec.limits.speed[i]);
        }
    }
    if (!(spec.speed >= pulses.speed_min && spec.speed <= fastest)) {
        refuse(Refusal::bad_speed, item, Axis::x, spec.speed);
    } else if (!(pulses.pitch > 0.0 && spec.speed <= pulses.pitch * pulses.prr_nominal)) {
        refuse(Refusal::bad_pitch, item, Axis::x, pulses.pitch);
    } else if (!(pulses.energy > 0.0 && pulses.energy * pulses.prr_nominal <= pulses.power)) {
        refuse(Refusal::bad_energy, item, Axis::x, pulses.energy);
    } else if (curve_.measured() && 0.5 * pulses.energy * pulses.prr_nominal < curve_.least()) {
        // At the lowest rate that the source is run with it would give more than is asked for.
        refuse(Refusal::bad_energy, item, Axis::x, pulses.energy);
    } else if (!laser::firing_at(spec.speed, pulses).possible) {
        refuse(Refusal::bad_pitch, item, Axis::x, pulses.pitch);
    }
    if (begin.actuator == Actuator::galvo) {
        (void)in_travel({metres(begin.anchor_x), metres(begin.anchor_y), metres(begin.anchor_z), place_[kC]}, item);
    }
    if (preview_) {
        spec.speed = smaller(spec.speed, machine_.laser.guide_speed_max.si());
    }
    traced_ = 0.0;
    stage_.open();
    // By its smoothing and its latency.
    stage_lag_ = static_cast<double>(begin.speed_um_s) * 1e-6 *
                 (seconds(motion::kStageSmoothing) + exact_double(machine_.axis[kX].latency_ns) * 1e-9);
    has_way_ = dark_ = false;
    if (split && !(motion::StageHistory::readable(stage_late(kX)) && motion::StageHistory::readable(stage_late(kY)) &&
                   motion::StageHistory::readable(stage_late(kZ)))) {
        refuse(Refusal::bad_stage_curve, item, Axis::x, 0.0);
    }
    placer_.open(pulses, resumes_ ? done_.pulses : 0);
    resumes_ = false;
    motion_.set_override(override_share());
    if (!motion_.open(spec)) {
        refuse(Refusal::bad_speed, item, Axis::x, spec.speed);
    }
    taken_length_ = motion_.longest_run();
    cursor_ = {};
    path_closed_ = false;
    end_checked_ = false;
    has_point_ = false;
    phase_ = Phase::open_path;
}

/// A place that the path passes, run-in and run-out included: within the field and its depth, or the travel.
void JobRunner::check_place(const motion::Place& place, std::uint32_t item) noexcept {
    if (path_.actuator == Actuator::galvo) {
        const double half = machine_.galvo.half_field.si();
        const double x = place[kX] - metres(path_.anchor_x);
        const double y = place[kY] - metres(path_.anchor_y);
        const double z = place[kZ] - metres(path_.anchor_z);
        if (!(absolute(x) <= half)) {
            refuse(Refusal::galvo_out_of_field, item, Axis::x, x);
        } else if (!(absolute(z) <= half)) {
            refuse(Refusal::galvo_out_of_field, item, Axis::z, z);
        } else if (!(absolute(y) <= GalvoField::kDepthMost)) {
            refuse(Refusal::galvo_out_of_field, item, Axis::y, y);
        }
    } else if (path_.actuator == Actuator::axes) {
        (void)in_travel(place, item);
    }
}

/// The mirrors' share of a place that the path reaches at `distance`, wherever the stage may be then: behind by its
/// lag, or not at all after a hold.
void JobRunner::check_reach(const motion::Place& place, double distance, std::uint32_t item) noexcept {
    const double half = machine_.galvo.half_field.si() - motion::kFieldMargin;
    if (!stage_.reaches(distance + 0.5 * stage_.spacing())) {
        refuse(Refusal::bad_stage_curve, item, Axis::x, distance);
        return;
    }
    for (const double back : {0.0, stage_lag_}) {
        const motion::StageCurve::Point stage = stage_.at(distance - back);
        if (!(absolute(place[kX] - stage[kX]) <= half)) {
            refuse(Refusal::galvo_out_of_field, item, Axis::x, place[kX] - stage[kX]);
        } else if (!(absolute(place[kZ] - stage[kZ]) <= half)) {
            refuse(Refusal::galvo_out_of_field, item, Axis::z, place[kZ] - stage[kZ]);
        } else if (!(absolute(place[kY] - stage[kY]) <= GalvoField::kDepthMost)) {
            refuse(Refusal::galvo_out_of_field, item, Axis::y, place[kY] - stage[kY]);
        }
    }
}

/// On from the last point of a split path, `length` far.
void JobRunner::check_way(const motion::Place& to, double length, std::uint32_t item) noexcept {
    // Between two samples the curve bends away from their chord by an eighth of a knot's share at most.
    const double parts = 1.0 + 2.0 * length / stage_.spacing();
    if (!(stage_.begun() && parts < static_cast<double>(kMostSamples + 1))) {
        refuse(Refusal::bad_stage_curve, item, Axis::x, length);
        return;
    }
    const auto count = static_cast<std::uint32_t>(parts);
    for (std::uint32_t i = 1; i <= count; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(count);
        motion::Place at{};
        for (const std::size_t k : {kX, kY, kZ}) {
            at[k] = last_point_[k] + share * (to[k] - last_point_[k]);
        }
        check_reach(at, taken_length_ + share * length, item);
    }
    taken_length_ += length;
}

void JobRunner::add_point(const PathPoint& point, std::uint32_t item) noexcept {
    const motion::Place place{metres(point.x), metres(point.y), metres(point.z), place_[kC]};
    check_place(place, item);
    if (path_.actuator == Actuator::split) {
        last_point_ = has_point_ ? last_point_ : place;
        check_way(place, trajectory::length3(trajectory::minus(place, last_point_)), item);
    }
    first_point_ = has_point_ ? first_point_ : place;
    before_ = last_point_;
    has_way_ = has_point_;
    by_arc_ = false;
    last_point_ = place;
    last_point_item_ = item;
    has_point_ = true;
    motion_.add(last_point_, item);
}

void JobRunner::add_arc(const PathArc& arc, std::uint32_t item) noexcept {
    const motion::Place via{metres(arc.via.x), metres(arc.via.y), metres(arc.via.z), place_[kC]};
    const motion::Place to{metres(arc.to.x), metres(arc.to.y), metres(arc.to.z), place_[kC]};
    const double tolerance = static_cast<double>(path_.tolerance_nm) * 1e-9;
    trajectory::Arc trial;
    const auto kind = trial.begin(last_point_, via, to, trajectory::kArcShare * tolerance, 0.0);
    if (!has_point_ || tolerance < trajectory::kLeastArcTolerance || kind == trajectory::Arc::Kind::no_plane ||
        kind == trajectory::Arc::Kind::too_wide) {
        refuse(Refusal::bad_arc, item, Axis::x, to[kX]);
        return;
    }
    const trajectory::ArcShape shape = trajectory::arc_shape(last_point_, via, to);
    check_place(via, item);
    check_place(to, item);
    for (std::uint32_t i = 0; i < shape.turn_count; ++i) {
        check_place(shape.turns[i], item);
    }
    if (path_.actuator == Actuator::split) {
        const std::optional<trajectory::Circle> circle = trajectory::circle_through(last_point_, via, to);
        const double length =
            circle ? circle->radius * circle->turn : trajectory::length3(trajectory::minus(to, last_point_));
        check_way(to, length, item);
        for (std::uint32_t i = 0; i < shape.turn_count && stage_.begun(); ++i) {
            check_reach(shape.turns[i], taken_length_ - length, item);
            check_reach(shape.turns[i], taken_length_, item);
        }
    }
    arrives_ = shape.arrives;
    has_way_ = by_arc_ = true;
    last_point_ = to;
    last_point_item_ = item;
    motion_.add_arc(via, to, item);
}

void JobRunner::add_light(const PathLight& light, std::uint32_t item) noexcept {
    if (!has_way_ || light.on != dark_) {
        refuse(Refusal::item_out_of_order, item, Axis::x, 0.0);
        return;
    }
    dark_ = !light.on;
    const motion::Place way = by_arc_ ? arrives_ : trajectory::minus(last_point_, before_);
    motion_.add_light(last_point_, way, last_point_item_);
}

void JobRunner::add_curve(const StageCurve& curve, std::uint32_t item) noexcept {
    if (path_.actuator != Actuator::split || has_point_ || stage_.begun()) {
        refuse(Refusal::item_out_of_order, item, Axis::x, 0.0);
    } else if (!stage_.begin(static_cast<double>(curve.spacing_um) * 1e-6)) {
        refuse(Refusal::bad_stage_curve, item, Axis::x, static_cast<double>(curve.spacing_um) * 1e-6);
    }
}

/// The curve stays within the hull of its control points, so it is enough to look at these and between them.
void JobRunner::add_knot(const StageKnot& knot, std::uint32_t item) noexcept {
    if (!stage_.begun()) {
        refuse(Refusal::item_out_of_order, item, Axis::x, 0.0);
        return;
    }
    stage_.push(knot);
    const motion::StageCurve::Point at = stage_.knot();
    if (!in_travel(stage_place(at), item)) {
        return;
    }
    const motion::StageCurve::Point before = stage_.knot(stage_.size() > 1 ? 1 : 0);
    if (safety::through_keep_out(machine_, {before[kX], before[kY], before[kZ]}, {at[kX], at[kY], at[kZ]})) {
        refuse(Refusal::in_keep_out, item, Axis::z, at[kZ]);
    }
    const double speed = static_cast<double>(path_.speed_um_s) * 1e-6;
    const motion::StageCurve::Breach breach = stage_.check(speed, seconds(1), stage_limits_);
    if (breach.broken) {
        refuse(Refusal::stage_too_fast, item, static_cast<Axis>(breach.axis), breach.value);
    }
}

/// An item that says something of the path other than where it goes. False: there is no room for it yet.
bool JobRunner::add_mark(const Item& front, std::uint32_t item) noexcept {
    if (const auto* light = std::get_if<PathLight>(&front)) {
        if (!motion_.wants_lights()) {
            return false;
        }
        add_light(*light, item);
    } else if (const auto* curve = std::get_if<StageCurve>(&front)) {
        add_curve(*curve, item);
    } else if (const auto* knot = std::get_if<StageKnot>(&front)) {
        if (!stage_.room()) {
            return false;
        }
        add_knot(*knot, item);
    } else {
        const bool turns = std::holds_alternative<Turn>(front);
        refuse(turns ? Refusal::c_motion_in_path : Refusal::item_out_of_order, item, turns ? Axis::c : Axis::x, 0.0);
    }
    return true;
}

void JobRunner::feed(ItemQueue& items) noexcept {
    motion_.hold_back(false);
    while (!path_closed_ && motion_.wants_points()) {
        const Item* front = items.front();
        if (front == nullptr || refusal_.refusal != Refusal::none) {
            return;
        }
        const std::uint32_t item = items_taken_;
        if (const auto* point = std::get_if<PathPoint>(front)) {
            add_point(*point, item);
        } else if (const auto* arc = std::get_if<PathArc>(front)) {
            add_arc(*arc, item);
        } else if (std::holds_alternative<PathEnd>(*front) && !dark_) {
            path_closed_ = true;
            path_end_item_ = item;
            motion_.finish();
        } else if (!add_mark(*front, item)) {
            motion_.hold_back(true);
            return;
        } else if (refusal_.refusal != Refusal::none) {
            return;
        }
        items.pop();
        ++items_taken_;
    }
}

void JobRunner::check_end() noexcept {
    if (motion_.too_short()) {
        refuse(Refusal::path_too_short, path_end_item_, Axis::x, 0.0);
    } else if (motion_.has_last() && !end_checked_) {
        end_checked_ = true;
        check_place(motion_.last(), path_end_item_);
        if (path_.actuator == Actuator::split) {
            check_reach(motion_.last(), taken_length_ + motion_.longest_run(), path_end_item_);
        }
    }
}

}  // namespace sc
