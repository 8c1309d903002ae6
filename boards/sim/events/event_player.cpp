// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/events/event_player.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include "boards/sim/plant/cell_plant.hpp"
#include "boards/sim/plant/source_pins.hpp"
#include "firmware/recording/io_image.hpp"
#include "shared/codes/state.hpp"
#include "shared/trace/trace.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::sim {
EventPlayer::EventPlayer(const MachineConfig& machine, Sink sink)
    : machine_(machine),
      sink_(std::move(sink)),
      laser_(machine.laser, LaserTruth{}),
      source_(machine.laser.source),
      acting_(std::make_unique<ServoOutputs>()) {}

void EventPlayer::level(std::int64_t t_ns, std::string_view what, bool& last, bool now) {
    if (last != now) {
        last = now;
        sink_(t_ns, what, now ? 1 : 0);
    }
}

void EventPlayer::window(std::int64_t tick, const ServoOutputs& outputs) {
    if (tick != tick_ + 1) {
        report_.gaps += tick_ >= 0 ? 1 : 0;
        has_acting_ = has_acting_ && tick == tick_ + 1;
    }
    tick_ = tick;
    ++report_.windows;
    hashes_.tick(outputs);
    const std::int64_t begin = tick * machine_.control_period_ns;
    for (std::size_t i = 0; i < outputs.laser_size; ++i) {
        laser_.queue(outputs.laser[i], outputs.gate_allowed);
    }
    if (outputs.cancel_laser) {
        laser_.cancel(begin + kCancelActNs);
    }
    play(begin, has_acting_ ? acting_.get() : nullptr);
    *acting_ = outputs;
    has_acting_ = true;
}

void EventPlayer::play(std::int64_t begin_ns, const ServoOutputs* acting) {
    const DigitalOutputs lines = acting == nullptr ? DigitalOutputs{} : acting->digital;
    laser_.set_master_oscillator(lines.master_oscillator, begin_ns);
    if (acting == nullptr || acting->clear_power) {
        laser_.clear_power(begin_ns);
    }
    // The hard line from e-stop and interlock feeds the coil.
    constexpr unsigned kHardLine =
        static_cast<unsigned>(GuardCause::estop) | static_cast<unsigned>(GuardCause::interlock);
    shutter_.command(lines.shutter_open && (causes_ & kHardLine) == 0);
    source_.emit(lines.master_oscillator);
    if (acting != nullptr) {
        source_.receive(std::span(acting->source_tx).first(acting->source_tx_size));
    }
    level(begin_ns, "mo", oscillator_, lines.master_oscillator);
    level(begin_ns, "shutter", open_, lines.shutter_open);
    level(begin_ns, "guide", guide_, lines.guide_laser);
    level(begin_ns, "gate", gate_, acting != nullptr && acting->gate_allowed && causes_ == 0);
    if (causes_ == 0) {
        laser_.open_gate();
    } else {
        laser_.cancel(begin_ns);
        laser_.shut_gate(begin_ns);
    }
    const std::int64_t end = begin_ns + machine_.control_period_ns;
    for (std::int64_t t = begin_ns + machine_.guard_period_ns; t <= end; t += machine_.guard_period_ns) {
        shutter_.step_to(t);
        while (const std::optional<LaserPulse> pulse = laser_.next(t)) {
            if (!pulse->lit) {
                continue;
            }
            if (!shutter_.passes()) {
                ++report_.shuttered;
                continue;
            }
            ++report_.pulses;
            report_.last_pulse_ns = pulse->t_ns;
            sink_(pulse->t_ns, "pulse", pulse->energy_nj);
        }
    }
    source_.take(source_bytes_);
}

void EventPlayer::veto(std::uint8_t causes) {
    if (causes == causes_) {
        return;
    }
    const std::int64_t now = (tick_ + 1) * machine_.control_period_ns;
    causes_ = causes;
    report_.vetoes += causes != 0 ? 1 : 0;
    sink_(now, "veto", causes);
    if (causes != 0) {
        laser_.cancel(now);
        laser_.shut_gate(now);
        level(now, "gate", gate_, false);
    }
}

void EventPlayer::shut() {
    const std::int64_t now = (tick_ + 1) * machine_.control_period_ns;
    laser_.cancel(now);
    laser_.shut_gate(now);
    laser_.set_master_oscillator(false, now);
    shutter_.command(false);
    level(now, "gate", gate_, false);
    level(now, "mo", oscillator_, false);
    level(now, "shutter", open_, false);
    level(now, "guide", guide_, false);
    has_acting_ = false;
}

event_device::Status EventPlayer::status() {
    event_device::Status status;
    status.tick = tick_;
    status.lines.laser_ready = status.lines.laser_no_alarm = !alarm_;
    status.lines.shutter_open = shutter_.reads_open();
    status.lines.shutter_closed = shutter_.reads_closed();
    status.lines.source_status = source_pins(machine_.laser.source, SourceTrouble::none);
    status.source_size = std::min(source_bytes_.size(), status.source.size());
    const auto end = source_bytes_.begin() + static_cast<std::ptrdiff_t>(status.source_size);
    std::copy(source_bytes_.begin(), end, status.source.begin());
    source_bytes_.erase(source_bytes_.begin(), end);
    return status;
}

EventReport EventPlayer::report() const {
    EventReport report = report_;
    report.laser = laser_.counters();
    report.command_trace_sha256 = hashes_.commands();
    report.set_point_sha256 = hashes_.set_points();
    report.laser_sha256 = hashes_.laser();
    return report;
}

std::string to_json(const EventReport& report) {
    const nlohmann::ordered_json json{{"windows", report.windows},
                                      {"gaps", report.gaps},
                                      {"pulses", report.pulses},
                                      {"shuttered", report.shuttered},
                                      {"vetoes", report.vetoes},
                                      {"last_pulse_ns", report.last_pulse_ns},
                                      {"unlit", report.laser.unlit},
                                      {"not_allowed", report.laser.not_allowed},
                                      {"cancelled", report.laser.cancelled},
                                      {"out_of_rate", report.laser.out_of_rate},
                                      {"disordered", report.laser.disordered},
                                      {"wrong_power", report.laser.wrong_power},
                                      {"command_trace_sha256", report.command_trace_sha256},
                                      {"set_point_sha256", report.set_point_sha256},
                                      {"laser_sha256", report.laser_sha256}};
    return json.dump(2);
}

}  // namespace sc::sim
