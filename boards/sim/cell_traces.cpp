// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/cell_traces.hpp"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

namespace sc::sim {
namespace {

constexpr std::int64_t kFlushTicks = 100;

using Json = nlohmann::ordered_json;

Json array_of(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

Json machine_json(const MachineConfig& machine) {
    Json axes = Json::array();
    constexpr std::array<const char*, kAxisCount> kNames{"x", "y", "z", "c"};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& a = machine.axis[i];
        axes.push_back({{"name", kNames[i]},
                        {"unit", i == index(Axis::c) ? "deg" : "m"},
                        {"travel_min", a.travel_min},
                        {"travel_max", a.travel_max},
                        {"speed", a.speed},
                        {"acceleration", a.acceleration},
                        {"jerk", a.jerk},
                        {"following_window", a.following_window},
                        {"counts_per_unit", a.counts_per_unit}});
    }
    const GalvoConfig& g = machine.galvo;
    Json keep_out = Json::array();
    for (std::size_t i = 0; i < machine.keep_out_count; ++i) {
        keep_out.push_back(
            {{"min_m", array_of(machine.keep_out[i].min)}, {"max_m", array_of(machine.keep_out[i].max)}});
    }
    return {{"axis", axes},
            {"galvo",
             {{"half_field", g.half_field.si()},
              {"speed", g.speed.si()},
              {"acceleration", g.acceleration.si()},
              {"jerk", g.jerk.si()}}},
            {"galvo_period_ns", machine.galvo_period_ns},
            {"y_retracted", machine.y_retracted.si()},
            {"keep_out", keep_out}};
}

std::unique_ptr<TraceFile> open_trace(const std::filesystem::path& directory, const char* name,
                                      const std::array<char, 8>& magic, const std::string& header) {
    return std::make_unique<TraceFile>(directory / name, magic, header);
}

template <std::size_t Size, class Record>
void put(TraceFile& file, const Record& record) {
    std::array<std::uint8_t, Size> bytes{};
    trace::pack(record, bytes);
    file.write(bytes);
}

}  // namespace

std::string trace_header_json(const MachineConfig& machine, const World& world) {
    Json errors = Json::array();
    for (const KnownError& e : world.errors()) {
        errors.push_back(
            {{"name", e.name}, {"value", e.value}, {"unit", e.unit}, {"compensated_by", e.compensated_by}});
    }
    const AxisLine axis = world.axis();
    const Json header{{"format", 1},
                      {"world", world.spec().title},
                      {"control_period_ns", machine.control_period_ns},
                      {"axis", {{"point_m", array_of(axis.point.v)}, {"direction", array_of(axis.direction.v)}}},
                      {"machine", machine_json(machine)},
                      {"errors", errors}};
    return header.dump();
}

CellTraces::CellTraces(const std::filesystem::path& directory, bool with_commands, const std::string& header_json) {
    if (directory.empty()) {
        return;
    }
    pulses_ = open_trace(directory, "pulses.trace", trace::kPulseMagic, header_json);
    samples_ = open_trace(directory, "samples.trace", trace::kSampleMagic, header_json);
    if (with_commands) {
        commands_ = open_trace(directory, "command.trace", kCommandMagic, header_json);
    }
}

void CellTraces::pulse(const trace::PulseRecord& record) {
    if (pulses_) {
        put<trace::kPulseRecordSize>(*pulses_, record);
    }
}

void CellTraces::tick(std::int64_t tick, const ServoOutputs& outputs, const AxisPositions& encoders) {
    hashes_.tick(outputs);
    for (std::size_t i = 0; commands_ && i < outputs.pulses_size; ++i) {
        command(outputs.pulses[i]);
    }
    if (samples_) {
        sample(tick, outputs, encoders);
        if (tick % kFlushTicks == 0) {
            flush();
        }
    }
}

void CellTraces::sample(std::int64_t tick, const ServoOutputs& outputs, const AxisPositions& encoders) {
    const bool deflected =
        std::ranges::any_of(outputs.galvo, [](const GalvoFrame& f) { return f.x_pm != 0 || f.z_pm != 0; });
    trace::SampleRecord record;
    record.tick = tick;
    record.set_point = outputs.set_point;
    record.actual = encoders;
    record.state = outputs.state;
    record.gate = outputs.laser_size > 0 && outputs.gate_allowed ? 1 : 0;
    record.galvo_frames = deflected ? static_cast<std::uint16_t>(kGalvoFramesPerTick) : std::uint16_t{0};
    put<trace::kSampleRecordSize>(*samples_, record);
    if (deflected) {
        for (const GalvoFrame& frame : outputs.galvo) {
            put<trace::kGalvoSampleSize>(*samples_, trace::GalvoSample{frame.x_pm, frame.z_pm});
        }
    }
}

void CellTraces::command(const PathPulse& pulse) {
    put<trace::kCommandRecordSize>(*commands_, trace::CommandRecord{pulse.path, pulse.pass, pulse.number, pulse.s_pm,
                                                                    pulse.place_pm, pulse.energy_code, pulse.t_ns});
}

void CellTraces::flush() {
    for (auto* file : {&pulses_, &samples_, &commands_}) {
        if (*file) {
            (*file)->flush();
        }
    }
}

void CellTraces::close() {
    for (auto* file : {&pulses_, &samples_, &commands_}) {
        if (*file) {
            (*file)->close();
            file->reset();
        }
    }
}

}  // namespace sc::sim
