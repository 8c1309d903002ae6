// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/cell/board_cell.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "firmware/laser/xy2_100.hpp"
#include "tests/stm32h743/optics/pulse_reference.hpp"

namespace sc::stm32h743::cell {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
constexpr std::int64_t kFrameNs = 10'000;
/// From the swap of the galvo's buffers to the tick's begin.
constexpr std::int64_t kTickDelayNs = 2'000;
constexpr std::uint32_t kGalvoClock = 1U << 2U;
constexpr unsigned kGalvoSwap = 11;  // interrupt of stream 0 of DMA1
/// A CAN controller takes part in a bus that has been quiet for 11 bits.
constexpr std::int64_t kBusIdleNs = 20'000;
constexpr unsigned kInFirst = 10;
constexpr unsigned kOutFirst = 10;
constexpr std::uint32_t kSixPins = 0x3FU << 10U;
constexpr unsigned kEstopPin = 7, kInterlockPin = 8;

std::uint64_t both(std::uint32_t x, std::uint32_t z) { return std::uint64_t{x} << 32U | z; }

std::uint32_t pins_of(const DigitalOutputs& out) {
    const std::array<bool, 6> on{out.light_green, out.light_yellow, out.master_oscillator,
                                 out.guide_laser, out.shutter_open, out.light_red};
    std::uint32_t pins = 0;
    for (unsigned i = 0; i < on.size(); ++i) {
        pins |= on.at(i) ? 1U << (kOutFirst + i) : 0U;
    }
    return pins;
}

template <class Result>
void need(Result got, Result wanted, const char* what) {
    if (got != wanted) {
        throw std::runtime_error(std::string("the board does not start: ") + what);
    }
}

}  // namespace

BoardCell::BoardCell(const sim::WorldSpec& world, const Options& options)
    : machine_(options.machine),
      host_(options.host_fd),
      drives_(chip_.machine, chip_.drive_wire, machine_, world),
      head_(machine_, world.galvo),
      player_(machine_, [](std::int64_t, std::string_view, std::int64_t) {}),
      link_(host_port_, options.host_fd),
      controller_(machine_, 1),
      loop_(machine_,
            BoardParts{controller_, outputs_, link_, drive_ports_, galvo_, status_, gate_, power_, lines_, clock_}),
      power_line_(machine_.laser.latch_setup_ns, machine_.laser.latch_width_ns) {
    start();
}

void BoardCell::start() {
    chip_.host_wire.join(host_);
    chip_.machine.on_interrupt(kGalvoSwap, [this] { loop_.on_window(); });
    chip_.machine.on_interrupt(model::PeriodTimer::kInterrupt, [this] { loop_.on_guard(); });
    chip_.machine.on_interrupt(model::EdgeLines::kInterrupt5To9, [this] { loop_.on_edge(); });
    chip_.port_e.on_edge = [this](std::uint32_t before, std::uint32_t after) { see_edge(before, after); };
    chip_.port_f.on_change = [this](std::int64_t ns, std::uint32_t levels) {
        power_line_.change(ns - origin_ns_, levels);
    };
    set_lines(true, true);
    chip_.tim1.set_break_pin(true);
    chip_.machine.advance_to(1'000);
    drive_inputs();
    const std::uint32_t middle = laser::WordFormat(machine_.galvo.word, machine_.galvo.convention).word(0);
    frames_due_.assign(2 * kGalvoFramesPerTick, both(middle, middle));
    need(host_port_.start(), Fdcan::Start::ok, "FDCAN1");
    need(drive_port_.start(), Fdcan::Start::ok, "FDCAN2");
    chip_.machine.advance_to(chip_.machine.now_ns() + kBusIdleNs);
    need(loop_.start(), BoardLoop::Start::ok, "its loop");
    origin_ns_ = chip_.tim6.started_ns + kTickNs;
    drives_.set_origin(origin_ns_);
    trigger_line_.set_origin(kTickNs * 6 / 25);
}

void BoardCell::set_lines(bool estop_closed, bool interlock_closed) {
    chip_.exti.set_pin(kEstopPin, estop_closed);
    chip_.exti.set_pin(kInterlockPin, interlock_closed);
}

void BoardCell::tick() {
    const std::int64_t tick = loop_.next_tick();
    chip_.machine.advance_to(origin_ns_ + tick * kTickNs + kTickDelayNs);
    asked_ = outputs_.digital;
    loop_.tick();
    if (loop_.next_tick() == tick) {
        throw std::runtime_error("the board has not made its tick");
    }
    (void)loop_.plan();
    report_.lines_wrong += (chip_.port_f.levels() & kSixPins) == pins_of(asked_) ? 0U : 1U;
    see_pins();
    player_.window(tick, outputs_);
    runs_.insert(runs_.end(), outputs_.laser.begin(),
                 outputs_.laser.begin() + static_cast<std::ptrdiff_t>(outputs_.laser_size));
    for (const GalvoFrame& frame : outputs_.galvo) {
        frames_due_.push_back(both(frame.word_x, frame.word_z));
    }
    drive_inputs();
}

/// What the lines showed since the last look.
void BoardCell::see_pins() {
    const std::size_t before = triggers_.size();
    trigger_line_.take(chip_.tim1.levels, triggers_);
    pulses_ += static_cast<std::uint64_t>(
        std::count_if(triggers_.begin() + static_cast<std::ptrdiff_t>(before), triggers_.end(),
                      [](const TriggerLine::Trigger& trigger) { return trigger.passes; }));
    chip_.port_e.edges.clear();
}

/// Of the galvo's lines: the head answers with each rising clock and moves with each frame.
void BoardCell::see_edge(std::uint32_t before, std::uint32_t after) {
    if ((after & ~before & kGalvoClock) != 0) {
        chip_.status_line.clock();
    }
    const std::optional<GalvoLine::Frame> frame = galvo_line_.edge(chip_.machine.now_ns(), before, after);
    if (!frame) {
        return;
    }
    const auto number = static_cast<std::int64_t>(report_.frames++);
    const std::int64_t begin = chip_.tim6.started_ns + GalvoWave::kWordNs + number * kFrameNs;
    const bool right = !frames_due_.empty() && frames_due_.front() == both(frame->word_x, frame->word_z);
    report_.frames_wrong += right && frame->begin_ns == begin ? 0U : 1U;
    if (!frames_due_.empty()) {
        frames_due_.pop_front();
    }
    head_.play(frame->word_x, frame->word_z);
    chip_.status_line.set(head_.status());
}

/// What laser, shutter and source show at the chip's inputs.
void BoardCell::drive_inputs() {
    const DigitalInputs& in = player_.status().lines;
    const std::array<bool, 6> levels{
        in.laser_ready, in.laser_no_alarm, in.shutter_open, in.shutter_closed, false, true};
    std::uint32_t pins = 0;
    for (unsigned i = 0; i < levels.size(); ++i) {
        pins |= levels.at(i) ? 1U << (kInFirst + i) : 0U;
    }
    chip_.port_d.drive(kSixPins, pins);
    chip_.port_g.drive(0xF, in.source_status);
}

BoardCellReport BoardCell::report() {
    BoardCellReport report = report_;
    report.events = player_.report();
    const std::vector<test::Pulse> expected = test::expected_pulses(runs_);
    // What is to leave in the next window has not left yet.
    const std::int64_t left_by = (loop_.next_tick() - 1) * kTickNs * 6 / 25;
    const auto due = static_cast<std::size_t>(std::count_if(
        expected.begin(), expected.end(), [left_by](const test::Pulse& one) { return one.count < left_by; }));
    report.triggers = triggers_.size();
    const std::size_t common = std::min(due, triggers_.size());
    report.triggers_wrong = due + triggers_.size() - 2 * common;
    for (std::size_t i = 0; i < common; ++i) {
        const bool right =
            std::abs(expected[i].count - triggers_[i].count) <= 1 && expected[i].picked == triggers_[i].passes;
        report.triggers_wrong += right ? 0U : 1U;
    }
    report.pulses = pulses_;
    report.strobes = power_line_.strobes();
    report.power_wrong = power_line_.bad();
    for (const LaserRun& run : runs_) {
        const std::int64_t last = run.count - 1;
        const std::int64_t last_ns =
            run.t0_ns + (last * run.period_ns256 + run.change_ns256 * (last * (last - 1) / 2)) / 256;
        const bool right = power_line_.at(run.t0_ns) == run.power && power_line_.at(last_ns) == run.power;
        report.power_wrong += right ? 0U : 1U;
    }
    report.unsent = drive_ports_.counters().unsent + link_.lost();
    report.bus_errors = host_.errors();
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        report.bus_errors += drives_.at(i).errors();
    }
    report.frames_wrong += galvo_line_.broken();
    report.failed = loop_.failed();
    report.violations = chip_.machine.violations_text();
    return report;
}

std::string to_json(const BoardCellReport& report) {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(sim::to_json(report.events));
    json["frames"] = report.frames;
    json["frames_wrong"] = report.frames_wrong;
    json["triggers"] = report.triggers;
    json["triggers_wrong"] = report.triggers_wrong;
    json["pulses_seen"] = report.pulses;
    json["strobes"] = report.strobes;
    json["power_wrong"] = report.power_wrong;
    json["lines_wrong"] = report.lines_wrong;
    json["unsent"] = report.unsent;
    json["bus_errors"] = report.bus_errors;
    json["failed"] = report.failed;
    json["violations"] = report.violations;
    return json.dump(2);
}

}  // namespace sc::stm32h743::cell
