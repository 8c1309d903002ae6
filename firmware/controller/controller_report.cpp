// SPDX-License-Identifier: Apache-2.0
// What the controller tells: states, acknowledgements, telemetry, the black box.
#include <algorithm>
#include <span>

#include "firmware/controller/controller.hpp"
#include "shared/machine/source_status.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

using safety::Event;

constexpr std::int64_t kStatusEveryTicks = 20;

}  // namespace

LimitedBy Controller::limited_by() const noexcept {
    const bool held = state() == State::stopping || state() == State::held;
    return held && stop_reason_ == Event::hold ? LimitedBy::override_zero : runner_.limited_by();
}

std::uint8_t Controller::status_flags(const ServoInputs& in, const ServoOutputs& out) const noexcept {
    unsigned flags = 0;
    const auto flag = [&flags](bool on, link::StatusFlag bit) noexcept {
        flags |= on ? static_cast<unsigned>(bit) : 0U;
    };
    flag(homed(), link::kFlagHomed);
    flag(in.digital.estop_closed, link::kFlagEstopClosed);
    flag(in.digital.interlock_closed, link::kFlagInterlockClosed);
    flag(mo_.on(), link::kFlagMasterOscillator);
    flag(out.laser_size > 0, link::kFlagGateOpen);
    flag(job_done_, link::kFlagJobDone);
    flag(out.digital.guide_laser, link::kFlagGuideLaser);
    flag(shutter_reads_open(in.digital), link::kFlagShutterOpen);
    return static_cast<std::uint8_t>(flags);
}

void Controller::report(const ServoInputs& in, ServoOutputs& out) noexcept {
    if (job_started_) {
        link_.progress(runner_.planned(), runner_.fired(), runner_.fired_position());
    }
    const bool burns = job_started_ && job_burns_;
    fired_.tick(burns ? JobPlace{runner_.fired(), runner_.fired_position()} : fired_.record().reached,
                burns && (supervisor_.faults() != 0 || suspicion_));
    const State now = state();
    if (now != reported_state_ || in.tick - report_tick_ >= kStatusEveryTicks) {
        link::Status status;
        status.cell_time_us = static_cast<std::uint64_t>(in.tick * machine_.control_period_ns / 1000);
        status.state = static_cast<std::uint8_t>(now);
        status.faults = supervisor_.faults();
        status.first_fault = static_cast<std::uint8_t>(supervisor_.first_fault().fault);
        status.first_fault_axis = supervisor_.first_fault().axis;
        status.limited_by = static_cast<std::uint8_t>(limited_by());
        status.override_percent = runner_.feed_override_percent();
        status.map_crc = map_crc_;
        status.flags = status_flags(in, out);
        status.key = static_cast<std::uint8_t>(key_mode(in.digital));
        status.source = static_cast<std::uint8_t>(source_state(machine_.laser.source, in.digital.source_status));
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            status.actual[i] = static_cast<std::int32_t>(drives_seen_.axis[i].actual / kPmPerWireUnit);
        }
        status.pulses_total = pulses_total_;
        status.starvations = starvations_;
        link_.status(status);
        reported_state_ = now;
        report_tick_ = in.tick;
    }
    record(in, out);
    out.link_tx_size = link_.transmit(out.link_tx);
    send_more(in, out);
    out.set_point = runner_.set_point();
    out.state = static_cast<std::uint8_t>(now);
    out.faults = supervisor_.faults();
}

void Controller::note(link::BlackboxKind kind, std::uint8_t a, std::uint16_t b) noexcept {
    black_box_.note(tick_, kind, a, b);
}

void Controller::note_starved() noexcept {
    ++starvations_;
    note(link::BlackboxKind::starved, 0, static_cast<std::uint16_t>(starvations_ & 0xFFFFU));
}

link::BlackboxSample Controller::black_box_sample(const ServoInputs& in, const ServoOutputs& out) const noexcept {
    constexpr std::int64_t kPlacePm = 1'000'000;
    constexpr std::int64_t kErrorPm = 100'000;
    link::BlackboxSample sample;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const std::int64_t actual = drives_seen_.axis[i].actual;
        sample.actual[i] = static_cast<std::int32_t>(
            std::clamp<std::int64_t>(actual / kPlacePm, -link::kBlackboxPlaceLimit, link::kBlackboxPlaceLimit));
        sample.error[i] = static_cast<std::int16_t>(
            std::clamp<std::int64_t>(following_.error(i, actual) / kErrorPm, -0x7FFF, 0x7FFF));
    }
    sample.state = static_cast<std::uint8_t>(state());
    sample.limited_by = static_cast<std::uint8_t>(limited_by());
    sample.override_percent = runner_.feed_override_percent();
    sample.flags = status_flags(in, out);
    sample.queue = static_cast<std::uint16_t>(link_.items().size());
    sample.pulses = static_cast<std::uint16_t>(pulses_total_ & 0xFFFFU);
    return sample;
}

/// Behind everything that can trip in this tick.
void Controller::record(const ServoInputs& in, const ServoOutputs& out) noexcept {
    const State now = state();
    if (now == State::enabling && black_box_.frozen()) {
        black_box_.thaw();
    }
    if (now != recorded_state_) {
        note(link::BlackboxKind::state, static_cast<std::uint8_t>(now), static_cast<std::uint16_t>(recorded_state_));
        recorded_state_ = now;
    }
    const bool freezes = supervisor_.faults() != 0 && !black_box_.frozen();
    if (!freezes && !black_box_.sample_due(in.tick)) {
        return;
    }
    const std::uint32_t bad = link_.counters().frames_bad;
    if (bad != recorded_bad_) {
        note(link::BlackboxKind::frames_bad, 0, static_cast<std::uint16_t>((bad - recorded_bad_) & 0xFFFFU));
        recorded_bad_ = bad;
    }
    const link::BlackboxSample sample = black_box_sample(in, out);
    if (freezes) {
        black_box_.freeze(in.tick, supervisor_.first_fault().fault, supervisor_.first_fault().axis, sample);
    } else {
        black_box_.add(in.tick, sample);
    }
}

/// What waits for everything else: telemetry, the black box. Nothing of it changes what the cell does.
void Controller::send_more(const ServoInputs& in, ServoOutputs& out) noexcept {
    const auto room = [&out] { return std::span(out.link_tx).subspan(out.link_tx_size); };
    if (link_.telemetry_due() != 0) {
        out.link_tx_size += link_.transmit(room(), telemetry(in, out));
    } else if (link_.blackbox_wanted()) {
        link::BlackboxChunk chunk;
        black_box_.read(*link_.blackbox_wanted(), chunk);
        out.link_tx_size += link_.transmit(room(), chunk);
    } else if (link_.parameters_wanted()) {
        out.link_tx_size += link_.transmit(room(), parameters(link_.parameters_wanted()->offset));
    }
}

link::TelemetryValues Controller::telemetry(const ServoInputs& in, const ServoOutputs& out) const noexcept {
    link::TelemetryValues values;
    const AxisPositions& set_point = runner_.set_point();
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const std::int64_t actual = drives_seen_.axis[i].actual;
        values.set_point[i] = static_cast<std::int32_t>(set_point[i] / kPmPerWireUnit);
        values.actual[i] = static_cast<std::int32_t>(actual / kPmPerWireUnit);
        values.following_error[i] = static_cast<std::int32_t>(following_.error(i, actual) / kPmPerWireUnit);
    }
    values.state = static_cast<std::uint8_t>(state());
    values.first_fault = static_cast<std::uint8_t>(supervisor_.first_fault().fault);
    values.limited_by = static_cast<std::uint8_t>(limited_by());
    values.override_percent = runner_.feed_override_percent();
    values.flags = status_flags(in, out);
    values.queue = static_cast<std::uint16_t>(link_.items().size());
    values.pulses = pulses_total_;
    values.starvations = starvations_;
    const link::LinkCounters counters = link_.counters();
    values.frames_bad = counters.frames_bad;
    values.messages_lost = counters.messages_lost;
    values.y_sensor = hub_.fitted(kYSensor) ? hub_.sample(kYSensor).value : 0;
    values.surface_depth = nearest32(runner_.surface().depth() * kWireUnitsPerMetre);
    values.shift = nearest32(runner_.surface().shift() * kWireUnitsPerMetre);
    for (std::size_t i = 0; i < kTripleCount; ++i) {
        values.triple[i] = hub_.fitted(kFirstTriple + i) ? hub_.sample(kFirstTriple + i).value : 0;
    }
    return values;
}

}  // namespace sc
