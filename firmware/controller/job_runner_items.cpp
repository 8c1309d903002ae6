// SPDX-License-Identifier: Apache-2.0
// Items of a job, as they are taken: what each begins, and what is refused.
#include "firmware/controller/job_runner.hpp"
#include "firmware/safety/watch.hpp"
#include "firmware/trajectory/arc.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

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
    if (const auto* turn = std::get_if<Turn>(&item)) {
        begin_turn(*turn);
    } else if (const auto* begin = std::get_if<PathBegin>(&item)) {
        begin_path(*begin);
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
    spec.limits = begin.actuator == Actuator::galvo ? galvo_limits_ : path_limits_;
    const double fastest = begin.actuator == Actuator::galvo ? machine_.galvo.speed.si() : machine_.axis[kX].speed;
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
    placer_.open(pulses);
    motion_.set_override(override_share());
    if (!motion_.open(spec)) {
        refuse(Refusal::bad_speed, item, Axis::x, spec.speed);
    }
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
    } else {
        (void)in_travel(place, item);
    }
}

void JobRunner::add_point(const PathPoint& point, std::uint32_t item) noexcept {
    last_point_ = {metres(point.x), metres(point.y), metres(point.z), place_[kC]};
    has_point_ = true;
    check_place(last_point_, item);
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
    last_point_ = to;
    motion_.add_arc(via, to, item);
}

void JobRunner::feed(ItemQueue& items) noexcept {
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
        } else if (std::holds_alternative<PathEnd>(*front)) {
            path_closed_ = true;
            path_end_item_ = item;
            motion_.finish();
        } else {
            const bool turns = std::holds_alternative<Turn>(*front);
            refuse(turns ? Refusal::c_motion_in_path : Refusal::item_out_of_order, item, turns ? Axis::c : Axis::x,
                   0.0);
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
    }
}

}  // namespace sc
