// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/cell_report.hpp"

#include <nlohmann/json.hpp>

namespace sc::sim {
namespace {

using Json = nlohmann::ordered_json;

std::string name_of_fault(Fault fault) {
    const CodeText* row = find_code(fault);
    return row == nullptr ? std::string() : std::string(row->name);
}

Json faults_json(std::uint64_t faults) {
    Json list = Json::array();
    for (unsigned number = 1; number < 64; ++number) {
        if ((faults >> number & 1U) != 0) {
            list.push_back(name_of_fault(static_cast<Fault>(number)));
        }
    }
    return list;
}

Json events_json(const std::vector<FaultRecord>& records) {
    Json list = Json::array();
    for (const FaultRecord& r : records) {
        Json event{{"t_ns", r.t_ns}, {"what", r.what}, {"last_pulse_after_ns", nullptr}};
        if (r.last_pulse_ns) {
            event["last_pulse_after_ns"] = *r.last_pulse_ns - r.t_ns;
        }
        list.push_back(event);
    }
    return list;
}

Json errors_json(const std::vector<KnownError>& errors) {
    Json list = Json::array();
    for (const KnownError& e : errors) {
        list.push_back({{"name", e.name}, {"value", e.value}, {"unit", e.unit}, {"compensated_by", e.compensated_by}});
    }
    return list;
}

double seconds_of(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

Json max_json(const InstructionMax& most) { return {{"count", most.count}, {"tick", most.tick}}; }

Json instructions_json(const InstructionFigures& figures) {
    return {{"servo_max", max_json(figures.servo)}, {"plan_max", max_json(figures.plan)},
            {"tick_max", max_json(figures.tick)},   {"servo_total", figures.servo_total},
            {"plan_total", figures.plan_total},     {"ticks", figures.ticks}};
}

/// What a board measured; null where the controller runs in the cell's own process.
Json figures_json(const std::optional<BoardFigures>& figures) {
    if (!figures) {
        return nullptr;
    }
    return {{"instructions", instructions_json(figures->all)},
            {"instructions_marking", instructions_json(figures->marking)},
            {"stack_used_at_start_bytes", figures->stack_used_at_start},
            {"stack_used_bytes", figures->stack_used},
            {"stack_size_bytes", figures->stack_size},
            {"controller_bytes", figures->controller_bytes}};
}

}  // namespace

std::string to_json(const CellReport& report) {
    Json first = nullptr;
    if (report.first_fault != Fault::none) {
        first = name_of_fault(report.first_fault);
    }
    const Json json{{"state", name_of(report.state)},
                    {"faults", faults_json(report.faults)},
                    {"first_fault", first},
                    {"cell_seconds", static_cast<double>(report.now_ns) * 1e-9},
                    {"pulses", report.pulses},
                    {"unlit", report.laser.unlit},
                    {"last_pulse_ns", report.last_pulse_ns},
                    {"command_trace_sha256", report.command_trace_sha256},
                    {"set_point_sha256", report.set_point_sha256},
                    {"laser_sha256", report.laser_sha256},
                    {"board", report.board},
                    {"figures", figures_json(report.figures)},
                    {"pulses_not_allowed", report.laser.not_allowed},
                    {"pulses_cancelled", report.laser.cancelled},
                    {"pulses_cut", report.laser.cut},
                    {"pulses_out_of_rate", report.laser.out_of_rate},
                    {"pulses_disordered", report.laser.disordered},
                    {"pulse_width_ns", report.pulse_width_ns},
                    {"power_strobes", report.laser.strobes},
                    {"power_strobes_bad", report.laser.bad_strobes},
                    {"pulses_wrong_power", report.laser.wrong_power},
                    {"pulses_shuttered", report.beam.shuttered},
                    {"master_oscillator_seconds", seconds_of(report.beam.master_oscillator_ns)},
                    {"gate_seconds", seconds_of(report.beam.gate_ns)},
                    {"shutter_seconds", seconds_of(report.beam.shutter_ns)},
                    {"guide_seconds", seconds_of(report.beam.guide_ns)},
                    {"galvo_words_dropped", report.galvo_words_dropped},
                    {"script_events", events_json(report.script_events)},
                    {"errors", errors_json(report.errors)}};
    return json.dump(2);
}

}  // namespace sc::sim
