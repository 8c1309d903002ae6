// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/faults/faulty_cell.hpp"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace sc::faults {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
constexpr std::int32_t kMm = 100'000;  // wire units

/// pm in mm, ndeg in degrees.
double base(std::int64_t place) { return static_cast<double>(place) * 1e-9; }

}  // namespace

FaultyCell::FaultyCell() {
    test::CellRig::Options options;
    options.controller = [this](const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained) {
        auto board = std::make_unique<BenchBoard>(machine, boot_id, retained);
        board_ = board.get();
        return board;
    };
    options.troubled_stream = true;
    rig_ = std::make_unique<test::CellRig>(options);
    rig_->cell().plant().watch_pins([this](std::int64_t t_ns, sim::Pin pin, bool level) {
        const auto line = static_cast<Line>(pin);
        int& last = level_.at(static_cast<std::size_t>(pin));
        if (line == Line::trigger || last != static_cast<int>(level)) {
            last = static_cast<int>(level);
            trace_.lines.push_back({t_ns, line, level});
        }
    });
    rig_->watch([this] { see_tick(); });
}

void FaultyCell::see_tick() {
    const ServoOutputs& out = rig_->cell().latest();
    const std::int64_t t_ns = now_ns() - kTickNs;
    AxisSample axes;
    axes.t_ns = t_ns;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double unit = i == index(Axis::c) ? 1.0 : 1e3;
        axes.place.at(i) = rig_->cell().plant().drive(static_cast<Axis>(i)).true_position() * unit;
        axes.command.at(i) = base(out.set_point.at(i));
    }
    Instant instant;
    instant.state = state();
    if (!trace_.axes.empty()) {
        const auto& last = trace_.axes.back().command;
        instant.speed =
            1e3 * std::hypot(axes.command[0] - last[0], axes.command[1] - last[1], axes.command[2] - last[2]);
        instant.acceleration = 1e3 * (instant.speed - instants_.back().speed);
        instant.turn = 1e3 * (axes.command[3] - last[3]);
        instant.climb = 1e3 * (axes.command[2] - last[2]);
    }
    instant.mirrors = out.galvo[0].x_pm != out.galvo[99].x_pm || out.galvo[0].z_pm != out.galvo[99].z_pm;
    instants_.push_back(instant);
    trace_.axes.push_back(axes);
    trace_.states.push_back({t_ns, instant.state, static_cast<int>(board_->first_fault()), out.digital.light_yellow});
    for (; burns_seen_ < rig_->pulses().size(); ++burns_seen_) {
        const trace::PulseRecord& pulse = rig_->pulses()[burns_seen_];
        Burn burn;
        burn.t_ns = pulse.t_ns;
        for (std::size_t i = 0; i < 3; ++i) {
            burn.place.at(i) = static_cast<double>(pulse.table_pm.at(i)) * 1e-9;
        }
        trace_.burns.push_back(burn);
    }
}

void FaultyCell::inject(const std::string& what, std::int64_t after_ns) {
    const std::string line = fmt::format("at {:.9f} {}", static_cast<double>(now_ns() + after_ns) * 1e-9, what);
    for (const sim::FaultEvent& event : sim::parse_fault_script(line, "campaign")) {
        rig_->cell().plant().inject(event);
    }
}

bool FaultyCell::ask(link::Verb verb, std::string_view name, bool cause_present) {
    const bool granted = rig_->command(verb).refusal == 0;
    trace_.requests.push_back({now_ns(), name, granted, cause_present});
    return granted;
}

std::int64_t FaultyCell::before_trigger() const {
    const ServoOutputs& out = rig_->cell().latest();
    std::int64_t best = 330'000;
    for (std::size_t i = 0; i < out.laser_size; ++i) {
        const std::int64_t light = out.laser.at(i).t0_ns + 1'000 - now_ns() - 400;
        if (light > 250'000 && light < 600'000) {
            best = light;
        }
    }
    return best;
}

void FaultyCell::begin_job() {
    if (rig_->open_job(job()).refusal != 0) {
        throw std::runtime_error("the job is refused");
    }
}

/// Two faces: a cross by the mirrors, a bent line by the axes; turned, a stroke by the mirrors. Dense, so that light is
/// missed or left within microseconds.
std::vector<Item> FaultyCell::job() {
    std::vector<Item> items;
    const std::int32_t x = -250 * kMm;
    const std::int32_t y = -319 * kMm;
    const std::int32_t z = -390 * kMm;
    std::uint32_t path = 0;
    const auto stroke = [&](std::int32_t dx, std::int32_t dz) {
        PathBegin begin;
        begin.path = path++;
        begin.actuator = Actuator::galvo;
        begin.speed_um_s = 400'000;
        begin.pitch_nm = 10'000;
        begin.energy_nj = 300'000;
        begin.anchor_x = x;
        begin.anchor_y = y;
        begin.anchor_z = z;
        items.emplace_back(begin);
        items.emplace_back(PathPoint{x - dx, y, z - dz});
        items.emplace_back(PathPoint{x + dx, y, z + dz});
        items.emplace_back(PathEnd{});
    };
    items.emplace_back(Turn{0});
    stroke(4 * kMm, 0);
    stroke(0, 4 * kMm);
    PathBegin line;
    line.path = path++;
    line.actuator = Actuator::axes;
    line.speed_um_s = 60'000;
    line.pitch_nm = 2'000;
    line.energy_nj = 300'000;
    line.tolerance_nm = 10'000;
    items.emplace_back(line);
    items.emplace_back(PathPoint{x - 8 * kMm, y, z - 4 * kMm});
    items.emplace_back(PathPoint{x, y, z + 4 * kMm});
    items.emplace_back(PathPoint{x + 8 * kMm, y, z - 4 * kMm});
    items.emplace_back(PathEnd{});
    items.emplace_back(Turn{-9'000'000});
    stroke(4 * kMm, 0);
    items.emplace_back(JobEnd{});
    return items;
}

}  // namespace sc::faults
