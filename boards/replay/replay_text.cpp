// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/replay_text.hpp"

#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "boards/replay/build_id.hpp"
#include "boards/replay/state_text.hpp"

namespace sc::replay {
namespace {

using Json = nlohmann::ordered_json;
using recording::LogEnd;

const char* name_of_end(LogEnd end) {
    switch (end) {
        case LogEnd::none: return "not reached";
        case LogEnd::closed: return "closed";
        case LogEnd::full: return "full";
        case LogEnd::torn: return "torn";
        case LogEnd::not_a_log: return "not_a_log";
        case LogEnd::other_version: return "other_version";
        case LogEnd::bad_machine: return "bad_machine";
        case LogEnd::damaged_head: return "damaged_head";
        case LogEnd::damaged_chunk: return "damaged_chunk";
        case LogEnd::out_of_order: return "out_of_order";
        case LogEnd::malformed: return "malformed";
    }
    return "?";
}

std::string text_of(const recording::LogHeader& header) {
    std::string text;
    for (const char c : header.build_id) {
        if (c >= ' ' && c <= '~') {
            text += c;
        }
    }
    return text;
}

std::string number(double value, const char* format) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

double ticks_per_second(const ReplayResult& result) {
    return result.wall_seconds > 0.0 ? static_cast<double>(result.ticks) / result.wall_seconds : 0.0;
}
double times_real_time(const ReplayResult& result) {
    return result.wall_seconds > 0.0 ? result.cell_seconds / result.wall_seconds : 0.0;
}

Json difference_json(const Difference& difference) {
    Json parts = Json::array();
    for (const recording::OutputPart part : difference.parts) {
        parts.push_back(name_of(part));
    }
    return {
        {"tick", difference.tick},
        {"parts", parts},
        {"recorded",
         {{"state", name_of_state(difference.recorded.state)}, {"faults", faults_json(difference.recorded.faults)}}},
        {"replayed",
         {{"state", name_of_state(difference.replayed.state)}, {"faults", faults_json(difference.replayed.faults)}}}};
}

std::string end_text(const ReplayResult& result) {
    switch (result.end) {
        case LogEnd::full: return "recording ended there, at the limit of the log's size\n";
        case LogEnd::torn:
            return "the log breaks off there without an end (power loss, or it is still being written): byte " +
                   std::to_string(result.end_offset) + "\n";
        case LogEnd::none:
        case LogEnd::closed:
        case LogEnd::not_a_log:
        case LogEnd::other_version:
        case LogEnd::bad_machine:
        case LogEnd::damaged_head:
        case LogEnd::damaged_chunk:
        case LogEnd::out_of_order:
        case LogEnd::malformed: return "";
    }
    return "";
}

}  // namespace

std::string problem_text(const std::string& file, LogEnd end, const recording::LogReader& reader) {
    const std::string at = file + ", byte " + std::to_string(reader.offset()) + ": ";
    switch (end) {
        case LogEnd::none:
        case LogEnd::closed:
        case LogEnd::full:
        case LogEnd::torn: return "";
        case LogEnd::not_a_log:
            return file + ": not a recording of a controller's inputs, or cut within its head; make one with --record";
        case LogEnd::other_version:
            return file + ": the log has format version " + std::to_string(reader.version()) + ", this program reads " +
                   std::to_string(recording::kLogVersion) + "; replay it with the build that recorded it";
        case LogEnd::bad_machine:
            return file +
                   ": the machine's configuration in the log is of another version or cannot be run with; replay it "
                   "with the build that recorded it";
        case LogEnd::damaged_head:
            return at + "the head of a chunk does not match its checksum: the log has been changed; use another copy";
        case LogEnd::damaged_chunk:
            return at + "a chunk does not match its checksum: the log has been changed; use another copy";
        case LogEnd::out_of_order:
            return at +
                   "a chunk is missing, repeated, or stands behind the end: the log has been changed; use another "
                   "copy";
        case LogEnd::malformed:
            return at + "the checksums agree but the content is none of this program's; use another copy";
    }
    return "";
}

Json result_json(const std::string& file, const Replayer& replayer, const ReplayResult& result) {
    const recording::LogHeader& header = replayer.reader().header();
    return {{"log", file},
            {"equal", result.equal()},
            {"end", name_of_end(result.end)},
            {"ticks", result.ticks},
            {"first_tick", result.first_tick},
            {"last_tick", result.last_tick},
            {"difference", result.difference ? difference_json(*result.difference) : Json()},
            {"first_fault", fault_json(result.first_fault)},
            {"pulses", result.pulses},
            {"command_trace_sha256", result.command_trace_sha256},
            {"outputs_sha256", result.outputs_sha256},
            {"inner_sha256", result.inner_sha256},
            {"ticks_per_s", ticks_per_second(result)},
            {"times_real_time", times_real_time(result)},
            {"boot_id", header.boot_id},
            {"recorded_by", text_of(header)},
            {"replayed_by", build_id()}};
}

std::string result_text(const std::string& file, const Replayer& replayer, const ReplayResult& result) {
    std::string text = file + ": recorded by " + text_of(replayer.reader().header()) + "\n";
    text += "ticks " + std::to_string(result.first_tick) + " to " + std::to_string(result.last_tick) + ", " +
            std::to_string(result.pulses) + " pulses; " + number(ticks_per_second(result), "%.0f") + " ticks/s, " +
            number(times_real_time(result), "%.1f") + " times real time\n";
    text += end_text(result);
    text += "command_trace_sha256 " + result.command_trace_sha256 + "\n";
    if (const Json fault = fault_json(result.first_fault); !fault.is_null()) {
        text += "first fault:\n";
        std::string line;
        for (const char c : lines_of(fault)) {
            line += c;
            if (c == '\n') {
                text += "  " + line;
                line.clear();
            }
        }
    }
    if (result.difference) {
        text += "DIFFERENT from tick " + std::to_string(result.difference->tick) + " on\n" +
                lines_of(difference_json(*result.difference));
    } else if (result.equal()) {
        text += "equal: every tick gives the outputs that were recorded\n";
    }
    return text;
}

}  // namespace sc::replay
