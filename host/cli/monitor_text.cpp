// SPDX-License-Identifier: Apache-2.0
#include "host/cli/monitor_text.hpp"

#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "shared/machine/source_status.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kAxes = "XYZC";

double place_of(const link::Status& status, std::size_t axis) {
    const auto units = static_cast<double>(status.actual.at(axis));
    return axis == index(Axis::c) ? units / kWireUnitsPerDegree : units / kWireUnitsPerMetre * 1e3;
}

std::string_view key_of(const link::Status& status) {
    return status.key == 0 ? "off" : (status.key == 1 ? "setup" : "production");
}
std::string_view source_of(const link::Status& status) { return sc::name_of(static_cast<SourceState>(status.source)); }

std::vector<std::uint16_t> fault_numbers(const link::Status& status) {
    std::vector<std::uint16_t> numbers;
    for (std::uint16_t number = 1; number < 64; ++number) {
        if (((status.faults >> number) & 1U) != 0) {
            numbers.push_back(number);
        }
    }
    return numbers;
}

std::vector<std::pair<std::string_view, bool>> flags_of(const link::Status& status) {
    const auto set = [&](std::uint8_t bit) { return (status.flags & bit) != 0; };
    return {{"homed", set(link::kFlagHomed)},
            {"estop_closed", set(link::kFlagEstopClosed)},
            {"interlock_closed", set(link::kFlagInterlockClosed)},
            {"master_oscillator", set(link::kFlagMasterOscillator)},
            {"gate_open", set(link::kFlagGateOpen)},
            {"job_done", set(link::kFlagJobDone)},
            {"guide_laser", set(link::kFlagGuideLaser)},
            {"shutter_open", set(link::kFlagShutterOpen)}};
}

}  // namespace

std::string status_text(const link::Status& status, const WireCounters& wire) {
    std::string text =
        fmt::format("state      {}   ({:.1f} s since start)\n", sc::name_of(static_cast<State>(status.state)),
                    static_cast<double>(status.cell_time_us) * 1e-6);
    for (const std::uint16_t number : fault_numbers(status)) {
        const bool first = number == status.first_fault;
        const bool of_axis = first && status.first_fault_axis < kAxes.size();
        text += fmt::format("fault      {}{}{}\n", describe_code(number), first ? "  <- first" : "",
                            of_axis ? fmt::format(", axis {}", kAxes[status.first_fault_axis]) : std::string());
    }
    text += "axes      ";
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
        text += fmt::format(" {} {:.4f} {}", kAxes[axis], place_of(status, axis), axis == 3 ? "deg" : "mm");
    }
    text += "\nflags     ";
    for (const auto& [name, set] : flags_of(status)) {
        text += fmt::format(" {} {}", name, set ? "yes" : "no");
    }
    text += fmt::format("\nkey        {}\nsource     {}", key_of(status), source_of(status));
    text += fmt::format("\noverride   {} %", status.override_percent);
    text += status.map_crc == 0 ? std::string("\naxis map   none") : fmt::format("\naxis map   {:08x}", status.map_crc);
    text += fmt::format("\nlimited by {}\n", status.limited_by == 0 ? "nothing" : describe_code(status.limited_by));
    text += fmt::format("counters   pulses {}, starvations {}, items repeated {}\n", status.pulses_total,
                        status.starvations, status.items_repeated);
    text += fmt::format("link       to the cell: {} bad frames, {} messages lost; from it: {} bad frames, {} lost\n",
                        status.frames_bad, status.messages_lost, wire.frames_bad, wire.messages_lost);
    return text;
}

Json status_json(const link::Status& status, const WireCounters& wire) {
    Json faults = Json::array();
    for (const std::uint16_t number : fault_numbers(status)) {
        const CodeText* code = find_code(number);
        faults.push_back({{"code", number},
                          {"name", code != nullptr ? code->name : "unknown"},
                          {"text", code != nullptr ? code->text : ""},
                          {"action", code != nullptr ? code->action : ""}});
    }
    Json flags = Json::object();
    for (const auto& [name, set] : flags_of(status)) {
        flags[std::string(name)] = set;
    }
    return {{"state", sc::name_of(static_cast<State>(status.state))},
            {"cell_seconds", static_cast<double>(status.cell_time_us) * 1e-6},
            {"faults", faults},
            {"first_fault", status.first_fault},
            {"limited_by", status.limited_by},
            {"override_percent", status.override_percent},
            {"axis_map_crc", status.map_crc == 0 ? Json() : Json(fmt::format("{:08x}", status.map_crc))},
            {"flags", flags},
            {"key", key_of(status)},
            {"source", source_of(status)},
            {"x_mm", place_of(status, 0)},
            {"y_mm", place_of(status, 1)},
            {"z_mm", place_of(status, 2)},
            {"c_deg", place_of(status, 3)},
            {"pulses", status.pulses_total},
            {"starvations", status.starvations},
            {"items_repeated", status.items_repeated},
            {"cell_frames_bad", status.frames_bad},
            {"cell_messages_lost", status.messages_lost},
            {"host_frames_bad", wire.frames_bad},
            {"host_messages_lost", wire.messages_lost}};
}

std::string machine_text(const MachineConfig& m) {
    std::string text =
        fmt::format("{:<5} {:>22} {:>10} {:>10} {:>10} {:>12}\n", "axis", "travel", "speed", "acc.", "jerk", "counts");
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& a = m.axis[i];
        const bool turn = i == index(Axis::c);
        const double k = turn ? 1.0 : 1e3;
        text += fmt::format("{:<5} {:>10g} ..{:>10g} {:>10g} {:>10g} {:>10g} {:>12g}   {}\n", kAxes[i],
                            a.travel_min * k, a.travel_max * k, a.speed * k, a.acceleration * k, a.jerk * k,
                            a.counts_per_unit / k, turn ? "deg, s" : "mm, s");
    }
    text += fmt::format("galvo: field +-{:g} mm, {:g} m/s, {:g} m/s2\n", m.galvo.half_field.si() * 1e3,
                        m.galvo.speed.si(), m.galvo.acceleration.si());
    text +=
        fmt::format("laser: {:g} W, {:g}..{:g} kHz, marks from {:g} mm/s on\n", m.laser.power.si(),
                    m.laser.prr_min.si() * 1e-3, m.laser.prr_nominal.si() * 1e-3, m.laser.mark_speed_min.si() * 1e3);
    text += fmt::format("C turns with y at {:g} mm or above\n", m.y_retracted.si() * 1e3);
    for (std::size_t i = 0; i < m.keep_out_count; ++i) {
        const KeepOut& k = m.keep_out[i];
        text += fmt::format("keep-out: x {:g}..{:g}, y {:g}..{:g}, z {:g}..{:g} mm\n", k.min.x * 1e3, k.max.x * 1e3,
                            k.min.y * 1e3, k.max.y * 1e3, k.min.z * 1e3, k.max.z * 1e3);
    }
    return text;
}

Json machine_json(const MachineConfig& m) {
    Json axes = Json::array();
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& a = m.axis[i];
        axes.push_back({{"axis", std::string(1, kAxes[i])},
                        {"unit", i == index(Axis::c) ? "deg" : "m"},
                        {"travel_min", a.travel_min},
                        {"travel_max", a.travel_max},
                        {"speed", a.speed},
                        {"acceleration", a.acceleration},
                        {"jerk", a.jerk},
                        {"counts_per_unit", a.counts_per_unit}});
    }
    Json volumes = Json::array();
    for (std::size_t i = 0; i < m.keep_out_count; ++i) {
        const KeepOut& k = m.keep_out[i];
        volumes.push_back({{"min_m", {k.min.x, k.min.y, k.min.z}}, {"max_m", {k.max.x, k.max.y, k.max.z}}});
    }
    return {{"axes", axes},
            {"galvo", {{"half_field_m", m.galvo.half_field.si()}, {"speed_m_s", m.galvo.speed.si()}}},
            {"laser",
             {{"power_w", m.laser.power.si()},
              {"prr_min_hz", m.laser.prr_min.si()},
              {"prr_nominal_hz", m.laser.prr_nominal.si()}}},
            {"y_retracted_m", m.y_retracted.si()},
            {"keep_out", volumes}};
}

}  // namespace sc::host::cli
