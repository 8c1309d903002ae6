// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/state_text.hpp"

#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace sc::replay {
namespace {

using Json = nlohmann::ordered_json;
using Phase = JobRunner::Phase;

constexpr std::array<const char*, kAxisCount> kAxisNames{"x", "y", "z", "c"};

std::string_view name_of(Phase phase) {
    switch (phase) {
        case Phase::idle: return "nothing to do";
        case Phase::next_item: return "takes the next item";
        case Phase::turn_retract: return "retracts y before a turn";
        case Phase::turn_c: return "turns the table";
        case Phase::open_path: return "collects points until the path's start is known";
        case Phase::travel_across: return "travels to the path in x and z";
        case Phase::travel_in: return "travels to the path in y";
        case Phase::jump: return "mirrors jump";
        case Phase::settle: return "waits for the axes to settle";
        case Phase::await_plan: return "waits for the planner";
        case Phase::path: return "on the path";
        case Phase::look_across: return "travels in x and z to where the Y sensor looks";
        case Phase::look_in: return "travels in y to where the Y sensor looks";
        case Phase::look_settle: return "waits for the shift of y to go";
        case Phase::look_stand: return "waits for the Y sensor to see";
        case Phase::look_on: return "the Y sensor looks along the line";
        case Phase::end_retract: return "retracts y at the job's end";
        case Phase::jog: return "jogs";
        case Phase::done: return "job done";
    }
    return "?";
}

std::string hexadecimal(unsigned value) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "0x%04X", value);
    return text.data();
}

std::string number(double value, const char* format) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

/// mm to the nanometre, or degrees to the microdegree.
std::string place(std::size_t axis, std::int64_t value) {
    return number(static_cast<double>(value) * 1e-9, "%.6f") + (axis == index(Axis::c) ? " deg" : " mm");
}

Json axes_json(const Controller& controller, const ServoOutputs& outputs) {
    Json axes = Json::object();
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const drives::AxisStatus& axis = controller.drives_seen().axis[i];
        Json flags = Json::array();
        const auto flag = [&flags](bool on, const char* name) {
            if (on) {
                flags.push_back(name);
            }
        };
        flag(axis.present, "present");
        flag(axis.enabled, "enabled");
        flag(axis.follows, "follows");
        flag(axis.homed, "homed");
        flag(axis.fault, "in fault");
        flag(axis.homing_failed, "homing failed");
        axes[kAxisNames[i]] = {{"set_point", place(i, outputs.set_point[i])},
                               {"actual", place(i, axis.actual)},
                               {"drive", flags},
                               {"statusword", hexadecimal(axis.statusword)},
                               {"emergency", hexadecimal(axis.error_code)}};
    }
    return axes;
}

Json inputs_json(const ServoInputs& in) {
    return {{"estop_closed", in.digital.estop_closed},
            {"interlock_closed", in.digital.interlock_closed},
            {"laser_ready", in.digital.laser_ready},
            {"laser_alarm", !in.digital.laser_no_alarm},
            {"shutter_reads_open", shutter_reads_open(in.digital)},
            {"key", static_cast<unsigned>(key_mode(in.digital))},
            {"source_pins", in.digital.source_status},
            {"galvo_status", hexadecimal(in.galvo_status)},
            {"guard_causes", in.guard_causes},
            {"link_bytes", in.link_rx.size()},
            {"drive_frames", in.drive_rx.size()}};
}

Json laser_json(const Controller& controller, const ServoOutputs& out) {
    return {{"master_oscillator", controller.master_oscillator().on()},
            {"ready", controller.master_oscillator().ready()},
            {"gate_allowed", out.gate_allowed},
            {"cancel", out.cancel_laser},
            {"runs", out.laser_size},
            {"pulses", out.pulses_size},
            {"pulses_since_boot", controller.pulses_total()},
            {"first_mirror_frame_um", Json::array({static_cast<double>(out.galvo[0].x_pm) * 1e-6,
                                                   static_cast<double>(out.galvo[0].z_pm) * 1e-6})}};
}

Json job_json(const Controller& controller) {
    const JobRunner& runner = controller.runner();
    const FiredPosition& fired = runner.fired_position();
    Json refusal = nullptr;
    if (const CodeText* row = find_code(runner.refusal().refusal);
        row != nullptr && runner.refusal().refusal != Refusal::none) {
        refusal = {{"code", row->number}, {"name", row->name}, {"item", runner.refusal().item}};
    }
    return {{"does", name_of(runner.phase())},
            {"at_rest", runner.at_rest()},
            {"items_received", controller.link().received()},
            {"items_queued", controller.link().items().size()},
            {"items_planned", runner.planned()},
            {"items_fired", runner.fired()},
            {"path", runner.path().path},
            {"feed_override_percent", runner.feed_override_percent()},
            {"fired_position", {{"path", fired.path}, {"pass", fired.pass}, {"pulses", fired.pulses}}},
            {"refusal", refusal}};
}

Json planner_json(const Controller& controller) {
    const motion::PathMotion& path = controller.runner().motion();
    const CodeText* limit = find_code(controller.runner().limited_by());
    const auto& pieces = path.planner().pieces();
    return {{"pieces", pieces.size()},
            {"first_piece", pieces.first()},
            {"end_piece", pieces.end()},
            {"legs", path.legs()},
            {"rate", path.rate()},
            {"path_closed", path.has_last()},
            {"all_planned", path.complete()},
            {"starved", path.starved()},
            {"stopped", path.stopped()},
            {"starvations_since_boot", controller.starvations()},
            {"limited_by",
             controller.runner().limited_by() == LimitedBy::none || limit == nullptr ? Json() : Json(limit->name)}};
}

Json link_json(const Controller& controller, std::int64_t tick) {
    const link::LinkCounters c = controller.link().counters();
    return {{"session_open", controller.link().session_open()},
            {"alive", controller.link().alive(tick)},
            {"last_heard_tick", controller.link().last_heard()},
            {"frames_bad", c.frames_bad},
            {"messages_lost", c.messages_lost},
            {"messages_repeated", c.messages_repeated},
            {"items_repeated", c.items_repeated},
            {"blocks_ahead", c.blocks_ahead},
            {"events_lost", c.events_lost}};
}

std::string word(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

void add_lines(std::string& text, const Json& json, std::size_t depth) {
    for (const auto& [key, value] : json.items()) {
        text += std::string(2 * depth, ' ') + key + ":";
        if (value.is_object()) {
            text += "\n";
            add_lines(text, value, depth + 1);
            continue;
        }
        if (value.is_array()) {
            for (const Json& entry : value) {
                text += " " + word(entry) + (&entry == &value.back() ? "" : ",");
            }
            text += value.empty() ? " none\n" : "\n";
            continue;
        }
        text += " " + (value.is_null()      ? "none"
                       : value.is_boolean() ? (value.get<bool>() ? "yes" : "no")
                                            : word(value));
        text += "\n";
    }
}

}  // namespace

Json faults_json(std::uint64_t faults) {
    Json list = Json::array();
    for (unsigned number = 1; number < 64; ++number) {
        if ((faults >> number & 1U) != 0) {
            const CodeText* row = find_code(static_cast<Fault>(number));
            list.push_back(row == nullptr ? std::to_string(number) : std::string(row->name));
        }
    }
    return list;
}

Json fault_json(const safety::FaultRecord& record) {
    const CodeText* row = find_code(record.fault);
    if (record.fault == Fault::none || row == nullptr) {
        return nullptr;
    }
    return {{"name", row->name},
            {"code", row->number},
            {"axis", record.axis < kAxisCount ? Json(kAxisNames[record.axis]) : Json()},
            {"tick", record.tick},
            {"state_before", name_of(record.state)},
            {"text", row->text},
            {"action", row->action}};
}

std::string name_of_state(std::uint8_t state) {
    return state < kStateCount ? std::string(name_of(static_cast<State>(state))) : std::to_string(state);
}

std::string_view name_of(recording::OutputPart part) noexcept {
    using recording::OutputPart;
    switch (part) {
        case OutputPart::link: return "bytes to the host";
        case OutputPart::drives: return "frames to the drives";
        case OutputPart::set_points: return "set-points";
        case OutputPart::mirrors: return "mirrors";
        case OutputPart::laser: return "laser runs";
        case OutputPart::pulses: return "pulses";
        case OutputPart::lines: return "digital lines, gate, state or faults";
    }
    return "?";
}

Json state_json(const Controller& controller, const ServoInputs& inputs, const ServoOutputs& outputs,
                const MachineConfig& machine) {
    return {{"tick", inputs.tick},
            {"time_s", static_cast<double>(inputs.tick) * static_cast<double>(machine.control_period_ns) * 1e-9},
            {"state", name_of(controller.state())},
            {"faults", faults_json(controller.faults())},
            {"first_fault", fault_json(controller.first_fault())},
            {"inputs", inputs_json(inputs)},
            {"axes", axes_json(controller, outputs)},
            {"laser", laser_json(controller, outputs)},
            {"job", job_json(controller)},
            {"planner", planner_json(controller)},
            {"link", link_json(controller, inputs.tick)}};
}

std::string lines_of(const Json& json) {
    std::string text;
    add_lines(text, json, 0);
    return text;
}

}  // namespace sc::replay
