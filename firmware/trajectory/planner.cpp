// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/planner.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kFarthest = 1e4;
constexpr double kFreeRamp = 0.5;       ///< of the time to full acceleration, for a ramp that no corner asks for
constexpr double kShortestRamp = 1e-7;  ///< m
constexpr double kRampOfStub = 0.6;
constexpr std::uint32_t kArcPointsAtOnce = 8;

}  // namespace

Planner::Planner(const Storage& storage) noexcept
    : points_(storage.points), nodes_(storage.nodes), writer_(storage.pieces) {}

std::expected<void, Refusal> Planner::open(const Spec& spec) noexcept {
    const auto limits = make_limits(spec);
    if (!limits) {
        return std::unexpected(limits.error());
    }
    limits_ = *limits;
    points_.open(limits_);
    nodes_.clear();
    writer_.open(limits_);
    window_.clear_counts();
    stage_ = Stage::seek;
    open_ = true;
    finished_ = false;
    count_ = 0;
    corner_ = 0;
    has_run_ = false;
    last_item_ = 0;
    arc_.stop();
    return {};
}

std::expected<void, Refusal> Planner::ready_for_point() const noexcept {
    if (!open_ || finished_) {
        return std::unexpected(Refusal{.problem = Problem::not_open, .point = count_});
    }
    if (!wants_points()) {
        return std::unexpected(Refusal{.problem = Problem::no_room, .point = count_});
    }
    return {};
}

/// The point scaled, with the axes that must not move where they are.
std::expected<Place, Refusal> Planner::usable(const Place& point) noexcept {
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const auto axis = static_cast<std::uint8_t>(k);
        const double most = k == 3 ? kFarthest * 360.0 : kFarthest;
        if (!(point[k] >= -most && point[k] <= most)) {
            return std::unexpected(Refusal{Problem::bad_point, count_, axis});
        }
    }
    Place place = limits_.scaled(point);
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        if (!(limits_.velocity[k] > 0.0)) {
            if (count_ == 0) {
                still_[k] = point[k];
            } else if (point[k] != still_[k]) {
                return std::unexpected(Refusal{Problem::blocked_axis, count_, static_cast<std::uint8_t>(k)});
            }
            place[k] = k == 3 ? 0.0 : point[k];
        }
    }
    return place;
}

std::expected<void, Refusal> Planner::add(const Place& point, std::uint32_t item) noexcept {
    if (const auto ready = ready_for_point(); !ready) {
        return ready;
    }
    const auto place = usable(point);
    if (!place) {
        return std::unexpected(place.error());
    }
    points_.add(*place, item);
    last_ = *place;
    last_item_ = item;
    ++count_;
    return {};
}

std::expected<void, Refusal> Planner::add_arc(const Place& via, const Place& to, std::uint32_t item) noexcept {
    if (const auto ready = ready_for_point(); !ready) {
        return ready;
    }
    if (count_ == 0 || limits_.tolerance < kLeastArcTolerance) {
        return std::unexpected(Refusal{.problem = Problem::no_arc_here, .point = count_});
    }
    const auto middle = usable({via[0], via[1], via[2], to[3]});
    if (!middle) {
        return std::unexpected(middle.error());
    }
    const auto end = usable(to);
    if (!end) {
        return std::unexpected(end.error());
    }
    Arc arc;
    const Arc::Kind kind = arc.begin(last_, *middle, *end, kArcShare * limits_.tolerance, limits_.merge);
    if (kind == Arc::Kind::no_plane || kind == Arc::Kind::too_wide) {
        return std::unexpected(Refusal{.problem = Problem::bad_arc, .point = count_});
    }
    arc_ = arc;
    arc_item_ = item;
    last_ = *end;
    ++count_;
    add_arc_points();
    return {};
}

/// The next few points of the arc, as far as there is room. The item of the arc is passed at its end.
void Planner::add_arc_points() noexcept {
    for (std::uint32_t n = 0; n < kArcPointsAtOnce && arc_.left() > 0 && points_.free() > 0; ++n) {
        Place place = arc_.next();
        for (std::size_t k = 0; k < 3; ++k) {
            place[k] = limits_.velocity[k] > 0.0 ? place[k] : still_[k];
        }
        if (arc_.left() == 0) {
            last_item_ = arc_item_;
        }
        points_.add(place, last_item_);
    }
    if (arc_.left() == 0 && finished_ && !points_.closed()) {
        points_.close();
    }
}

std::expected<void, Refusal> Planner::finish() noexcept {
    if (!open_ || finished_) {
        return std::unexpected(Refusal{.problem = Problem::not_open, .point = count_});
    }
    if (points_.end() < 2 && arc_.left() == 0) {
        return std::unexpected(Refusal{.problem = Problem::too_short, .point = count_});
    }
    finished_ = true;
    if (arc_.left() == 0) {
        points_.close();
    }
    return {};
}

std::uint32_t Planner::work(std::uint32_t units) noexcept {
    std::uint32_t used = 0;
    while (used < units) {
        std::uint32_t step = 0;
        if (arc_.left() > 0 && points_.free() > 0) {
            add_arc_points();
            step = 1;
        } else if (stage_ == Stage::seek) {
            step = seek();
        } else if (stage_ == Stage::curve) {
            step = follow_curve();
        }
        if (step == 0) {
            break;
        }
        used += step;
    }
    return used;
}

/// Ramp that a curve leaves to its corner: that of the joint, or a longer one if the stub allows. Where full
/// acceleration is reached within nanometres the ramp is longer than that, with less jerk.
Planner::End Planner::ramp_at(const Stub& stub, const Joint& joint) const noexcept {
    const Along along = limits_along(limits_, stub.direction);
    const double asked = joint.jerk * joint.duration * joint.duration * joint.duration * (1.0 / 6.0);
    const double t = smaller(kFreeRamp * along.acceleration / joint.jerk, 0.8 * square_root(along.speed / joint.jerk));
    const double free = larger(joint.jerk * t * t * t * (1.0 / 6.0), kShortestRamp);
    const double ramp = smaller(kRampOfStub * stub.length, free);
    if (ramp <= asked) {
        return {joint.jerk, asked};
    }
    const double a = kFreeRamp * along.acceleration;
    const double v = 0.64 * along.speed;
    // On a ramp of length s: a³ = 6 s j², v³ = 9/2 s² j.
    const double by_acceleration = a * square_root(a / (6.0 * ramp));
    const double by_speed = v * v * v / (4.5 * ramp * ramp);
    return {smaller(joint.jerk, smaller(by_acceleration, by_speed)), ramp};
}

namespace {

Stub line_between(const Place& from, const Place& to, const Stub& stub) noexcept {
    Stub line = stub;
    const Place step = minus(to, from);
    line.length = length(step);
    line.direction = times(1.0 / line.length, step);
    return line;
}

}  // namespace

/// The joint at `corner`, where a run with the stub `before` ends (whole lines: it began at `from`), and what begins
/// there. At the path's end a plain stop. False while more points are needed.
bool Planner::look_behind(std::uint32_t corner, const Stub& before, const Place& from, Behind& behind) const noexcept {
    behind = {};
    behind.corner = points_[corner].p;
    Stub line = before;
    if (is_end(corner)) {
        line = before.whole ? line_between(from, behind.corner, before) : before;
        behind.joint = {0.0, limits_along(limits_, line.direction).jerk};
        return true;
    }
    if (!points_.stub(corner, true, limits_, behind.stub)) {
        return false;
    }
    const Outward here = move_corner(limits_, before, behind.stub);
    behind.corner = plus(behind.corner, here.shift);
    if (before.whole) {
        line = line_between(from, behind.corner, before);
    }
    behind.line = behind.stub;
    if (behind.stub.whole) {
        const std::uint32_t next = behind.stub.point;
        Place to = points_[next].p;
        if (!is_end(next)) {
            Stub after;
            if (!points_.stub(next, true, limits_, after)) {
                return false;
            }
            to = plus(to, move_corner(limits_, behind.stub, after).shift);
        }
        behind.line = line_between(behind.corner, to, behind.stub);
    }
    behind.joint = make_joint(limits_, line, behind.line, here.room);
    return true;
}

void Planner::next_run(std::uint32_t corner, const Behind& behind) noexcept {
    corner_ = corner;
    run_ = behind;
    has_run_ = true;
    points_.forget_before(corner);
    stage_ = Stage::seek;
    if (is_end(corner)) {
        writer_.flush();
        stage_ = Stage::complete;
    }
}

std::uint32_t Planner::seek() noexcept {
    if (writer_.pieces().free() < kPiecesAtOnce) {
        return 0;
    }
    if (!has_run_) {
        run_ = {};
        if (points_.known() < 1 || !points_.stub(corner_, true, limits_, run_.stub)) {
            return 0;
        }
        run_.corner = points_[corner_].p;
        run_.joint = {0.0, limits_along(limits_, run_.stub.direction).jerk};
        has_run_ = true;
    }
    const Stub& head = run_.stub;
    if (head.whole) {
        Behind behind;
        if (!look_behind(head.point, head, run_.corner, behind)) {
            return 0;
        }
        const std::uint32_t end = head.point;
        write_line(line_between(run_.corner, behind.corner, head), behind.joint);
        next_run(end, behind);
        return 4;
    }
    points_.absorb(corner_, head, true);
    const End ramp = ramp_at(head, run_.joint);
    nodes_.clear();
    spline_.start(points_, corner_, ramp.length);
    window_.start(nodes_, run_.corner, {run_.joint.duration, ramp.jerk}, ramp.length, points_[corner_].item);
    stage_ = Stage::curve;
    return 1;
}

void Planner::write_line(const Stub& line, const Joint& end) noexcept {
    const Along along = limits_along(limits_, line.direction);
    const LinePlan plan = plan_line(line.length, along, run_.joint, end);
    Stretch stretch{.origin = run_.corner, .direction = line.direction};
    const double s = points_[corner_].s;
    std::uint32_t i = corner_;
    for (std::uint32_t k = 0; k < plan.count; ++k) {
        while (i + 1 < line.point && points_[i + 1].s - s <= plan.phase[k].s) {
            ++i;
        }
        stretch.add(plan.phase[k], points_[i].item);
    }
    writer_.join(stretch, run_.joint.duration);
}

std::uint32_t Planner::follow_curve() noexcept {
    if (window_.done()) {
        next_run(spline_.end_seen(), next_);
        return 1;
    }
    const std::uint32_t units = window_.step(limits_, nodes_, writer_);
    if (units > 0) {
        return units;
    }
    if (spline_.wants_end()) {
        Stub tail;
        const std::uint32_t end = spline_.end_seen();
        if (points_.stub(end, false, limits_, tail) && look_behind(end, tail, {}, next_)) {
            points_.absorb(end, tail, false);
            const End ramp = ramp_at(tail, next_.joint);
            spline_.set_end(end, ramp.length);
            window_.set_end(points_[end].p, {next_.joint.duration, ramp.jerk}, ramp.length);
            return 1;
        }
    }
    const bool moved = spline_.step(points_, limits_, nodes_);
    points_.forget_before(spline_.oldest_point());
    return moved ? 1 : 0;
}

}  // namespace sc::trajectory
