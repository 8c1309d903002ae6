// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/laser_head.hpp"

namespace sc::linux_rt {
namespace {

/// A mirror that has been sent somewhere within so many frames before the end is on its way when it is looked at.
constexpr std::size_t kOnItsWay = 15;

}  // namespace

void FixedOptics::play(const ServoOutputs& acting) noexcept {
    const GalvoFrame& last = acting.galvo[kGalvoFramesPerTick - 1];
    const GalvoFrame& before = acting.galvo[kGalvoFramesPerTick - 1 - kOnItsWay];
    unsigned status = kGalvoStatusOk;
    if (last.word_x != before.word_x) {
        status &= ~unsigned{kGalvoAckX};
    }
    if (last.word_z != before.word_z) {
        status &= ~unsigned{kGalvoAckZ};
    }
    status_ = static_cast<std::uint16_t>(status);
}

void NoLaser::sample(std::int64_t /*tick*/, DigitalInputs& digital) noexcept {
    digital.laser_ready = false;
    digital.laser_no_alarm = true;
    digital.shutter_open = open_;
    digital.shutter_closed = !open_;
    digital.source_status = 0;
}

void NoLaser::accept(std::int64_t /*tick*/, const ServoOutputs& outputs) noexcept {
    open_ = outputs.digital.shutter_open;
}

void EventHead::hear() noexcept {
    event_device::Status heard;
    if (link_->receive(heard)) {
        status_ = heard;
        heard_tick_ = heard.tick;
        fresh_ = true;
    }
}

void EventHead::sample(std::int64_t /*tick*/, DigitalInputs& digital) noexcept {
    hear();
    if (!fresh_) {
        status_.source_size = 0;
    }
    fresh_ = false;
    const bool there = !link_->lost() && heard_tick_ >= 0;
    digital.laser_ready = there && status_.lines.laser_ready;
    digital.laser_no_alarm = there && status_.lines.laser_no_alarm;
    // Before its first word a shutter is where its spring puts it.
    digital.shutter_open = there && status_.lines.shutter_open;
    digital.shutter_closed = !there || status_.lines.shutter_closed;
    digital.source_status = there ? status_.lines.source_status : std::uint8_t{0};
}

void EventHead::veto(std::uint8_t causes) noexcept {
    if (causes != causes_) {
        causes_ = causes;
        link_->veto(causes);
    }
}

bool EventHead::settled() noexcept {
    hear();
    return link_->lost() || heard_tick_ >= sent_tick_;
}

void GatedHead::sample(std::int64_t /*tick*/, DigitalInputs& /*digital*/) noexcept { line_->set(next_ && !vetoed_); }

void GatedHead::accept(std::int64_t /*tick*/, const ServoOutputs& outputs) noexcept {
    next_ = outputs.laser_size > 0 && outputs.gate_allowed;
    if (outputs.cancel_laser) {
        next_ = false;
        line_->set(false);
    }
}

void GatedHead::veto(std::uint8_t causes) noexcept {
    vetoed_ = causes != 0;
    if (vetoed_) {
        line_->set(false);
    }
}

void restrict_to_gate(MachineConfig& machine) noexcept {
    const double rate = 1e9 / static_cast<double>(machine.control_period_ns);
    machine.laser.prr_nominal = Frequency::from_si(rate);
    machine.laser.prr_min = Frequency::from_si(rate * 1e-3);
}

void restrict_to_axes(MachineConfig& machine) noexcept {
    machine.galvo.half_field = Length::from_si(0.0);
    machine.galvo.follow = FollowAxes::off;
    if (machine.galvo.convention == GalvoConvention::unset) {
        machine.galvo.convention = GalvoConvention::offset_binary;
    }
}

}  // namespace sc::linux_rt
