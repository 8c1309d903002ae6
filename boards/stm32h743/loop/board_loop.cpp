// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/loop/board_loop.hpp"

#include <span>

#include "boards/stm32h743/registers/interrupt_lock.hpp"
#include "firmware/laser/xy2_100.hpp"
#include "firmware/motion/path_motion.hpp"
#include "firmware/recording/io_image.hpp"
#include "firmware/safety/frame_guard.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;

constexpr std::uint8_t bit(GuardCause cause) noexcept { return static_cast<std::uint8_t>(cause); }

}  // namespace

BoardLoop::Start BoardLoop::start() noexcept {
    if (!DigitalPort::start()) {
        return Start::digital;
    }
    if (!parts_.lines.start()) {
        return Start::lines;
    }
    if (!parts_.status.start()) {
        return Start::status;
    }
    const std::uint32_t middle = laser::WordFormat(machine_.galvo.word, machine_.galvo.convention).word(0);
    // These follow one another closely: what lies between them stays.
    if (!parts_.galvo.start(middle, middle)) {
        return Start::galvo;
    }
    if (!parts_.gate.start(-kTickNs) || !parts_.gate.fill({})) {
        return Start::gate;
    }
    if (!parts_.clock.start(-kTickNs)) {
        return Start::clock;
    }
    return parts_.power.start(kTickNs) ? Start::ok : Start::power;
}

void BoardLoop::close(std::uint8_t causes) noexcept {
    parts_.gate.shut();
    if (causes != 0) {
        causes_ |= causes;
        closed_ = true;
        allowed_ = false;
        next_allowed_ = false;
    }
}

void BoardLoop::on_edge() noexcept {
    const SafetyLines::State state = parts_.lines.edge();
    close(static_cast<std::uint8_t>((state.estop_closed ? 0U : bit(GuardCause::estop)) |
                                    (state.interlock_closed ? 0U : bit(GuardCause::interlock))));
}

void BoardLoop::on_guard() noexcept {
    const SafetyLines::State lines = parts_.lines.guard_period();
    estop_closed_ = lines.estop_closed;
    interlock_closed_ = lines.interlock_closed;
    GuardInputs in;
    DigitalPort::sample(in.digital);
    in.digital.estop_closed = lines.estop_closed;
    in.digital.interlock_closed = lines.interlock_closed;
    in.galvo_status = parts_.status.word();
    status_ = in.galvo_status;
    in.gate_allowed = allowed_;
    in.source = machine_.laser.source;
    std::uint8_t causes = safety::frame_guard(in).causes;
    const bool frames = parts_.galvo.check();
    const bool open = parts_.gate.check();
    if (in.gate_allowed && !frames) {
        causes |= bit(GuardCause::galvo);
    }
    if (in.gate_allowed && !open) {  // pulses do not leave: the break input, or the stream of segments
        causes |= GateWave::broken() ? bit(GuardCause::estop) : bit(GuardCause::laser_alarm);
    }
    if (causes != 0 || !(in.gate_allowed || next_allowed_)) {
        vetoes_ += causes != 0 ? 1 : 0;
        close(causes);
    }
    for (SensorPort* sensor : parts_.sensors) {
        if (sensor != nullptr) {
            sensor->poll(now_ns());
        }
    }
}

void BoardLoop::on_sensor(std::size_t bus) noexcept { parts_.sensors[bus]->on_interrupt(now_ns()); }

void BoardLoop::on_window() noexcept {
    const bool played = parts_.galvo.swapped();
    ++windows_;
    allowed_ = next_allowed_.exchange(false);
    if (!played) {
        close(allowed_ ? bit(GuardCause::galvo) : std::uint8_t{0});
    }
}

void BoardLoop::tick() noexcept {
    if (failed_ || windows_ == tick_) {
        return;
    }
    if (windows_ > tick_ + 1) {
        fail();
        return;
    }
    if (tick_ > 0) {
        act();
    }
    ServoInputs in;
    take_inputs(in);
    ServoOutputs& out = parts_.outputs;
    recording::clear(out);
    parts_.controller.servo_step(in, out);
    lay_out(out);
    parts_.host.send(std::span(out.link_tx).first(out.link_tx_size));
    ++tick_;
}

bool BoardLoop::plan() noexcept {
    if (failed_ || planned_ == tick_) {
        return false;
    }
    parts_.controller.plan_step(motion::kUnitsPerTick);
    planned_ = tick_;
    return windows_ == tick_;
}

/// The outputs of the last tick take effect now.
void BoardLoop::act() noexcept {
    const ServoOutputs& out = parts_.outputs;
    parts_.drives.send(std::span(out.drive_tx).first(out.drive_tx_size));
    DigitalPort::write(out.digital);
    const InterruptLock locked;
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        if (parts_.sensors[bus] != nullptr) {
            parts_.sensors[bus]->give(out.sensor_tx[bus], tick_ * kTickNs);
        }
    }
}

void BoardLoop::take_inputs(ServoInputs& in) noexcept {
    const std::int64_t now = tick_ * kTickNs;
    in.tick = tick_;
    parts_.host.service(now);
    parts_.drives.service(now);
    in.link_rx = std::span(link_rx_).first(parts_.host.receive(link_rx_));
    in.drive_rx = parts_.drives.receive();
    DigitalPort::sample(in.digital);
    in.digital.estop_closed = estop_closed_;
    in.digital.interlock_closed = interlock_closed_;
    in.galvo_status = status_;
    const InterruptLock locked;
    closed_ = false;
    in.guard_causes = causes_.exchange(0);
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        if (parts_.sensors[bus] != nullptr) {
            in.sensor_rx[bus] = parts_.sensors[bus]->take(now);
        }
    }
}

/// Frames, pulses and strobes of the window that comes next, to the hardware that plays them.
void BoardLoop::lay_out(const ServoOutputs& out) noexcept {
    if (out.cancel_laser) {
        allowed_ = false;
        parts_.gate.cancel();
        parts_.power.cancel();
    }
    const auto runs = std::span(out.laser).first(out.laser_size);
    const bool pulses = parts_.gate.fill(runs);
    const bool power = parts_.power.fill(runs, out.clear_power);
    const bool frames = parts_.galvo.fill(out.galvo);
    const InterruptLock locked;
    if (!out.gate_allowed || closed_) {
        return;
    }
    if (!pulses || !power || !frames || !parts_.gate.arm()) {
        close(bit(frames ? GuardCause::laser_alarm : GuardCause::galvo));
        return;
    }
    next_allowed_ = true;
}

void BoardLoop::fail() noexcept {
    failed_ = true;
    close(0);
    DigitalPort::make_safe();
}

}  // namespace sc::stm32h743
