// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/control_loop.hpp"

#include <span>

#include "firmware/motion/path_motion.hpp"
#include "firmware/recording/io_image.hpp"
#include "firmware/safety/frame_guard.hpp"

namespace sc::linux_rt {

ControlLoop::ControlLoop(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained,
                         const LoopParts& parts, const DrivePlan& drives)
    : machine_(machine),
      parts_(parts),
      controller_(machine, boot_id, retained, drives),
      lines_(*parts.lines),
      outputs_{std::make_unique<ServoOutputs>(), std::make_unique<ServoOutputs>()} {}

void ControlLoop::tick() noexcept {
    optics_.play(*outputs_[1 - newest_]);  // the window that has just ended
    ServoInputs in;
    take_inputs(in);
    if (tick_ > 0) {
        act();
    }
    newest_ = 1 - newest_;
    ServoOutputs& out = *outputs_[newest_];
    recording::clear(out);
    controller_.servo_step(in, out);
    parts_.head->accept(tick_, out);
    parts_.link->send(std::span(out.link_tx).first(out.link_tx_size));
    controller_.plan_step(motion::kUnitsPerTick);
    ++tick_;
}

void ControlLoop::take_inputs(ServoInputs& in) noexcept {
    in.tick = tick_;
    in.drive_rx = parts_.drives->receive();
    const LineSample lines = lines_.sample();
    in.digital = digital_of(lines.levels);
    in.galvo_status = optics_.status();
    parts_.head->sample(tick_, in.digital);
    in.source_rx = parts_.head->source_rx();
    guard(in, lines.worst);
    in.digital.estop_closed = in.digital.estop_closed && !stopping_;
    in.guard_causes = causes_;
    causes_ = 0;
    in.link_rx = std::span(link_rx_).first(parts_.link->receive(link_rx_));
    const std::int64_t now = tick_ * machine_.control_period_ns;
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        if (parts_.sensors[bus] != nullptr) {
            in.sensor_rx[bus] = parts_.sensors[bus]->take(now);
        }
    }
}

/// The outputs of the last tick take effect now.
void ControlLoop::act() noexcept {
    const ServoOutputs& out = *outputs_[newest_];
    parts_.drives->send(std::span(out.drive_tx).first(out.drive_tx_size));
    lines_.write(out.digital);
    const std::int64_t before = (tick_ - 1) * machine_.control_period_ns;
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        if (parts_.sensors[bus] != nullptr) {
            parts_.sensors[bus]->give(before, machine_.control_period_ns, out.sensor_tx[bus]);
        }
    }
}

void ControlLoop::guard(const ServoInputs& in, InputBits worst) noexcept {
    GuardInputs guarded{in.digital, in.galvo_status, latest().gate_allowed, machine_.laser.source};
    const DigitalInputs pulsed = digital_of(worst);
    guarded.digital.estop_closed = pulsed.estop_closed && !stopping_;
    guarded.digital.interlock_closed = pulsed.interlock_closed;
    const GuardVeto veto = safety::frame_guard(guarded);
    causes_ = static_cast<std::uint8_t>(causes_ | veto.causes);
    const bool vetoed = veto.causes != 0 && veto.close_gate;
    vetoes_ += vetoed && !vetoed_ ? 1 : 0;
    vetoed_ = vetoed;
    parts_.head->veto(vetoed ? veto.causes : std::uint8_t{0});
}

bool ControlLoop::stopped() const noexcept {
    const State state = controller_.state();
    return state == State::boot || (controller_.drives_seen().all_disabled && controller_.runner().at_rest());
}

void ControlLoop::make_safe() noexcept {
    parts_.head->veto(static_cast<std::uint8_t>(GuardCause::estop));
    lines_.make_safe();
}

LoopReport ControlLoop::report() const noexcept {
    return {controller_.state(), controller_.first_fault().fault, tick_, vetoes_, lines_.counters()};
}

}  // namespace sc::linux_rt
