// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/planner.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kFarthest = 1e4;
constexpr double kFreeRamp = 0.5;  ///< of the time to full acceleration, for a ramp that no corner asks for
constexpr double kRampOfStub = 0.6;
constexpr std::uint32_t kLinePieces = 24;

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
    has_head_ = false;
    return {};
}

std::expected<void, Refusal> Planner::add(const Place& point, std::uint32_t item) noexcept {
    if (!open_ || finished_) {
        return std::unexpected(Refusal{.problem = Problem::not_open, .point = count_});
    }
    if (points_.free() == 0) {
        return std::unexpected(Refusal{.problem = Problem::no_room, .point = count_});
    }
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
    points_.add(place, item);
    ++count_;
    return {};
}

std::expected<void, Refusal> Planner::finish() noexcept {
    if (!open_ || finished_) {
        return std::unexpected(Refusal{.problem = Problem::not_open, .point = count_});
    }
    if (points_.end() < 2) {
        return std::unexpected(Refusal{.problem = Problem::too_short, .point = count_});
    }
    points_.close();
    finished_ = true;
    return {};
}

std::uint32_t Planner::work(std::uint32_t units) noexcept {
    std::uint32_t used = 0;
    while (used < units) {
        std::uint32_t step = 0;
        if (stage_ == Stage::seek) {
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

/// Ramp in s that a curve leaves to its corner: that of the joint, or a longer one if the stub allows.
double Planner::ramp_length(const Stub& stub, const Joint& joint) const noexcept {
    const Along along = limits_along(limits_, stub.direction);
    const double t = smaller(kFreeRamp * along.acceleration / joint.jerk, 0.8 * square_root(along.speed / joint.jerk));
    const double free = smaller(kRampOfStub * stub.length, joint.jerk * t * t * t * (1.0 / 6.0));
    const double asked = joint.jerk * joint.duration * joint.duration * joint.duration * (1.0 / 6.0);
    return larger(free, asked);
}

/// Joint of the run that ends with `before` at a corner with the one behind it; at the path's end a plain stop.
bool Planner::joint_at(std::uint32_t corner, const Stub& before, Joint& joint, Stub& after) const noexcept {
    if (points_.closed() && corner + 1 == points_.end()) {
        joint = {0.0, limits_along(limits_, before.direction).jerk};
        after = {};
        return true;
    }
    if (!points_.stub(corner, true, limits_, after)) {
        return false;
    }
    joint = make_joint(limits_, before, after);
    return true;
}

void Planner::next_run(std::uint32_t corner, const Joint& joint, const Stub& after) noexcept {
    corner_ = corner;
    joint_ = joint;
    head_ = after;
    has_head_ = true;
    points_.forget_before(corner);
    stage_ = Stage::seek;
    if (points_.closed() && corner + 1 == points_.end()) {
        writer_.flush();
        stage_ = Stage::complete;
    }
}

std::uint32_t Planner::seek() noexcept {
    if (writer_.pieces().free() < kLinePieces) {
        return 0;
    }
    if (!has_head_) {
        if (points_.known() < 1 || !points_.stub(corner_, true, limits_, head_)) {
            return 0;
        }
        joint_ = {0.0, limits_along(limits_, head_.direction).jerk};
        has_head_ = true;
    }
    if (head_.whole) {
        Joint end;
        Stub after;
        if (!joint_at(head_.point, head_, end, after)) {
            return 0;
        }
        write_line(end);
        next_run(head_.point, end, after);
        return 4;
    }
    points_.absorb(corner_, head_, true);
    const double ramp = ramp_length(head_, joint_);
    nodes_.clear();
    spline_.start(points_, corner_, ramp);
    window_.start(nodes_, points_[corner_].p, joint_, joint_.duration, ramp, points_[corner_].item);
    stage_ = Stage::curve;
    return 1;
}

void Planner::write_line(const Joint& end) noexcept {
    const Vertex& from = points_[corner_];
    const Place& d = head_.direction;
    const Along along = limits_along(limits_, d);
    const LinePlan plan = plan_line(head_.length, along, joint_, end);
    Stretch stretch{.origin = from.p, .direction = d};
    std::uint32_t i = corner_;
    for (std::uint32_t k = 0; k < plan.count; ++k) {
        while (i + 1 < head_.point && points_[i + 1].s - from.s <= plan.phase[k].s) {
            ++i;
        }
        stretch.add(plan.phase[k], points_[i].item);
    }
    writer_.join(stretch, joint_.duration);
}

std::uint32_t Planner::follow_curve() noexcept {
    if (window_.done()) {
        next_run(spline_.end_seen(), next_joint_, next_head_);
        return 1;
    }
    const std::uint32_t units = window_.step(limits_, nodes_, writer_);
    if (units > 0) {
        return units;
    }
    if (spline_.wants_end()) {
        Stub tail;
        const std::uint32_t end = spline_.end_seen();
        if (points_.stub(end, false, limits_, tail) && joint_at(end, tail, next_joint_, next_head_)) {
            points_.absorb(end, tail, false);
            const double ramp = ramp_length(tail, next_joint_);
            spline_.set_end(end, ramp);
            window_.set_end(points_[end].p, next_joint_, ramp);
            return 1;
        }
    }
    const bool moved = spline_.step(points_, limits_, nodes_);
    points_.forget_before(spline_.oldest_point());
    return moved ? 1 : 0;
}

}  // namespace sc::trajectory
