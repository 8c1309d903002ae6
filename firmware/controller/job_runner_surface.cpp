// SPDX-License-Identifier: Apache-2.0
// The surface in a job: looks of the Y sensor at the lines before they are burnt, and what comes of them.
#include "firmware/controller/job_runner.hpp"
#include "shared/math/scalar.hpp"

namespace sc {

using sensors::Surface;

bool JobRunner::set_surface(const sensors::SurfaceSettings& settings) noexcept {
    if (!surface_.set(settings)) {
        return false;
    }
    set_limits();
    place_ = geometry_.place_of(set_point_);
    return true;
}

void JobRunner::refuse_surface(Surface::Verdict verdict, std::uint32_t item, double y) noexcept {
    if (verdict == Surface::Verdict::not_seen) {
        refuse(Refusal::surface_not_seen, item, Axis::y, y);
    } else if (verdict == Surface::Verdict::off) {
        refuse(Refusal::surface_not_there, item, Axis::y, surface_.depth());
    }
}

// --- looks

/// Of a job that goes on behind looks: paths that are done come again and are passed over.
bool JobRunner::pass_over(const Item& item) noexcept {
    if (resumes_) {
        passes_over_ = passes_over_ || std::holds_alternative<Look>(item);
        resumes_ = !std::holds_alternative<Turn>(item);
    }
    if (!passes_over_) {
        return false;
    }
    if (passes_path_) {
        passes_path_ = !std::holds_alternative<PathEnd>(item);
    } else if (const auto* begin = std::get_if<PathBegin>(&item)) {
        passes_over_ = begin->path != done_.path || begin->pass != done_.pass;
        passes_path_ = passes_over_;
    } else if (std::holds_alternative<Look>(item)) {
        return false;
    } else {
        refuse(Refusal::item_out_of_order, items_taken_ - 1, Axis::x, 0.0);
        return true;
    }
    if (passes_over_ || passes_path_) {
        fired_ = planned_ = items_taken_;
        return true;
    }
    return false;
}

void JobRunner::begin_look(const Look& look) noexcept {
    const std::uint32_t item = items_taken_ - 1;
    look_ = {metres(look.x), metres(look.y), metres(look.z), place_[kC]};
    if (preview_) {
        fired_ = planned_ = items_taken_;  // nothing is burnt
        return;
    }
    if (!surface_.on()) {
        refuse(Refusal::surface_not_seen, item, Axis::y, look_[kY]);
        return;
    }
    if (!in_travel(look_, item)) {
        return;
    }
    if (look.speed_um_s > 0) {
        move_speed_ = static_cast<double>(look.speed_um_s) * 1e-6;
        begin_stage_move(look_, Phase::look_on);
        return;
    }
    const double retracted = machine_.y_retracted.si();
    if (place_[kY] >= retracted - 1e-9 && look_[kY] < retracted) {
        motion::Place to = look_;
        to[kY] = place_[kY];
        begin_stage_move(to, Phase::look_across);
    } else {
        begin_stage_move(look_, Phase::look_in);
    }
}

void JobRunner::stand_to_look(bool begins) noexcept {
    surface_.stand(begins);
    phase_ = Phase::look_stand;
}

/// The axes stand at the beginning or the end of a piece of a look.
void JobRunner::look_step() noexcept {
    if (phase_ == Phase::look_settle) {
        if (surface_.settled()) {
            stand_to_look(true);
        }
        return;
    }
    const Surface::Verdict verdict = surface_.look();
    if (verdict == Surface::Verdict::fine) {
        fired_ = planned_ = items_taken_;
        phase_ = Phase::next_item;
    } else if (verdict != Surface::Verdict::waiting) {
        refuse_surface(verdict, items_taken_ - 1, look_[kY]);
    }
}

// --- paths

/// Before a path begins: where it begins the surface has been looked at and is where it should be, and the shift of y
/// has come to rest.
bool JobRunner::surface_is_there() noexcept {
    if (!surface_.on() || preview_) {
        return true;
    }
    const Surface::Verdict verdict = surface_.verdict_at({first_point_[kX], first_point_[kY], first_point_[kZ]});
    refuse_surface(verdict, last_point_item_, first_point_[kY]);
    return verdict == Surface::Verdict::fine && surface_.settled();
}

void JobRunner::watch_beam(const motion::Segment& segment, double t) noexcept {
    const double x = segment.x(t);
    beam_ = segment.piece->place(x);
    beam_is_lit_ = !preview_ && motion_.marked(trajectory::value(segment.piece->distance, x));
}

void JobRunner::follow_surface() noexcept {
    const bool before = (phase_ == Phase::settle || phase_ == Phase::await_plan) && has_point_;
    if (before && !preview_) {
        surface_.expect({first_point_[kX], first_point_[kY], first_point_[kZ]}, false, false);
    } else if (phase_ == Phase::path && !preview_) {
        surface_.expect({beam_[kX], beam_[kY], beam_[kZ]}, beam_is_lit_, by_mirrors());
    } else {
        surface_.release();
    }
    const bool looking = phase_ == Phase::look_on || phase_ == Phase::look_stand;
    surface_.step(tick_ * machine_.control_period_ns, sample_, {place_[kX], place_[kY], place_[kZ]}, looking);
}

}  // namespace sc
