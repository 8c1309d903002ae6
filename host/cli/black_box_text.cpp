// SPDX-License-Identifier: Apache-2.0
#include "host/cli/black_box_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/client.hpp"
#include "host/bridge/errors.hpp"
#include "shared/codes/state.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kAxes = "XYZC";
constexpr std::array<std::string_view, 4> kPlaces{"x_mm", "y_mm", "z_mm", "c_deg"};
constexpr std::array<std::string_view, 4> kErrors{"x_error_mm", "y_error_mm", "z_error_mm", "c_error_deg"};

std::string_view state_name(unsigned state) {
    return state < kStateCount ? sc::name_of(static_cast<State>(state)) : std::string_view("?");
}

/// mm, or degrees of C.
double place_of(const link::BlackboxSample& s, std::size_t axis) { return s.actual.at(axis) * 1e-3; }
double error_of(const link::BlackboxSample& s, std::size_t axis) { return s.error.at(axis) * 1e-4; }

std::optional<double> host_s(const ClockFit& clock, double cell_s) {
    const auto time = clock.host_time(static_cast<std::uint64_t>(std::max(0.0, cell_s * 1e6)));
    if (!time) {
        return std::nullopt;
    }
    return std::chrono::duration<double>(time->time_since_epoch()).count();
}

std::string host_column(const ClockFit& clock, double cell_s) {
    const auto seconds = host_s(clock, cell_s);
    return seconds ? fmt::format("{:.4f}", *seconds) : std::string();
}

std::string cause(const BlackBoxContent& content) {
    std::string text = describe_code(static_cast<std::uint16_t>(content.fault));
    if (content.axis < kAxes.size()) {
        text += fmt::format(", axis {}", kAxes[content.axis]);
    }
    return text;
}

/// Samples and events in one order of time: index into samples, or into events beyond them.
struct Row {
    double cell_s = 0.0;
    const link::BlackboxSample* sample = nullptr;
    const link::BlackboxEvent* event = nullptr;
};
std::vector<Row> rows_of(const BlackBoxContent& content) {
    std::vector<Row> samples;
    std::vector<Row> events;
    for (const auto& sample : content.samples) {
        samples.push_back({sample.cell_s, &sample.at, nullptr});
    }
    for (const auto& event : content.events) {
        events.push_back({event.cell_s, nullptr, &event.what});
    }
    // Each is in the order of its numbers already.
    std::vector<Row> rows;
    std::ranges::merge(samples, events, std::back_inserter(rows), {}, &Row::cell_s, &Row::cell_s);
    return rows;
}

std::string sample_line(double since_s, const link::BlackboxSample& s) {
    std::string line = fmt::format("{:>9.3f}", since_s);
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
        line += fmt::format(" {:>9.3f} {:>7.4f}", place_of(s, axis), error_of(s, axis));
    }
    return line +
           fmt::format("  {:<10} {:>4} {:>6} {:>6}\n", state_name(s.state), s.override_percent, s.queue, s.pulses);
}

}  // namespace

std::string describe(const link::BlackboxEvent& event) {
    const auto refused = [&event] { return event.b == 0 ? std::string() : ": refused, " + describe_code(event.b); };
    switch (static_cast<link::BlackboxKind>(event.kind)) {
        case link::BlackboxKind::state: return fmt::format("{} -> {}", state_name(event.b), state_name(event.a));
        case link::BlackboxKind::fault:
            return describe_code(event.b) + (event.a < kAxes.size() ? fmt::format(", axis {}", kAxes[event.a]) : "");
        case link::BlackboxKind::command: return name_of(static_cast<link::Verb>(event.a)) + refused();
        case link::BlackboxKind::request: return "request" + refused();
        case link::BlackboxKind::link_silent: return "the host is silent";
        case link::BlackboxKind::link_back: return event.a == 1 ? "the host is back" : "a host has connected";
        case link::BlackboxKind::job_opened:
            return fmt::format("job ...{:04x} opened{}", event.b, event.a == 1 ? " in its midst" : "");
        case link::BlackboxKind::item_refused: return "item of the job" + refused();
        case link::BlackboxKind::starved: return fmt::format("starved, {} times so far", event.b);
        case link::BlackboxKind::frames_bad: return fmt::format("{} link frames spoilt", event.b);
    }
    return fmt::format("event {} {} {}", event.kind, event.a, event.b);
}

std::string black_box_text(const BlackBoxContent& content, double last_s, const ClockFit& clock) {
    std::string text =
        content.frozen ? "frozen by " + cause(content) : "not frozen: no fault since the axes were powered";
    text += fmt::format("\nnewest sample at {:.3f} s of the cell's time", content.newest_s);
    if (const std::string host = host_column(clock, content.newest_s); !host.empty()) {
        text += fmt::format(", {} s of the host's", host);
    }
    text += fmt::format("\n{:>9}", "s");
    for (const char axis : kAxes) {
        text += fmt::format(" {:>9} {:>7}", axis == 'C' ? "C deg" : fmt::format("{} mm", axis), "error");
    }
    text += fmt::format("  {:<10} {:>4} {:>6} {:>6}\n", "state", "%", "queue", "pulses");
    for (const Row& row : rows_of(content)) {
        const double since = row.cell_s - content.newest_s;
        if (since < -last_s) {
            continue;
        }
        text += row.sample != nullptr ? sample_line(since, *row.sample)
                                      : fmt::format("{:>9.3f}   * {}\n", since, describe(*row.event));
    }
    return text;
}

std::string black_box_csv(const BlackBoxContent& content, const ClockFit& clock) {
    std::string text =
        "cell_s,host_s,x_mm,y_mm,z_mm,c_deg,x_error_mm,y_error_mm,z_error_mm,c_error_deg,state,limited_by,"
        "override_percent,flags,queue,pulses,event\n";
    for (const Row& row : rows_of(content)) {
        text += fmt::format("{:.3f},{},", row.cell_s, host_column(clock, row.cell_s));
        if (row.sample == nullptr) {
            text += ",,,,,,,,,,,,,,\"" + describe(*row.event) + "\"\n";
            continue;
        }
        const link::BlackboxSample& s = *row.sample;
        for (std::size_t axis = 0; axis < 4; ++axis) {
            text += fmt::format("{:.3f},", place_of(s, axis));
        }
        for (std::size_t axis = 0; axis < 4; ++axis) {
            text += fmt::format("{:.4f},", error_of(s, axis));
        }
        text += fmt::format("{},{},{},{},{},{},\n", state_name(s.state), s.limited_by, s.override_percent, s.flags,
                            s.queue, s.pulses);
    }
    return text;
}

Json black_box_json(const BlackBoxContent& content, const ClockFit& clock) {
    Json samples = Json::array();
    for (const auto& [cell_s, s] : content.samples) {
        Json row{{"cell_s", cell_s}};
        for (std::size_t axis = 0; axis < 4; ++axis) {
            row[std::string(kPlaces.at(axis))] = place_of(s, axis);
            row[std::string(kErrors.at(axis))] = error_of(s, axis);
        }
        row["state"] = state_name(s.state);
        row["limited_by"] = s.limited_by;
        row["override_percent"] = s.override_percent;
        row["flags"] = s.flags;
        row["queue"] = s.queue;
        row["pulses_low"] = s.pulses;
        samples.push_back(row);
    }
    Json events = Json::array();
    for (const auto& [cell_s, e] : content.events) {
        events.push_back({{"cell_s", cell_s},
                          {"kind", link::name_of(static_cast<link::BlackboxKind>(e.kind))},
                          {"a", e.a},
                          {"b", e.b},
                          {"text", describe(e)}});
    }
    const auto host = host_s(clock, content.newest_s);
    return {{"frozen", content.frozen},
            {"fault", static_cast<unsigned>(content.fault)},
            {"fault_text", content.frozen ? cause(content) : std::string()},
            {"newest_cell_s", content.newest_s},
            {"newest_host_s", host ? Json(*host) : Json()},
            {"samples", samples},
            {"events", events}};
}

std::string clock_text(const ClockFit& clock, HostTime now) {
    const auto c = clock.at(now);
    if (!c) {
        return "clock      not known yet\n";
    }
    return fmt::format(
        "clock      cell - host {:.6f} s +- {:.3f} ms, rate {:+.1f} +- {:.1f} ppm, round trip {:.2f} ms\n", c->offset_s,
        c->uncertainty_s * 1e3, c->rate * 1e6, c->rate_uncertainty * 1e6, c->round_trip_s * 1e3);
}

Json clock_json(const ClockFit& clock, HostTime now) {
    const auto c = clock.at(now);
    if (!c) {
        return {};
    }
    return {{"offset_s", c->offset_s},
            {"uncertainty_ms", c->uncertainty_s * 1e3},
            {"rate_ppm", c->rate * 1e6},
            {"rate_uncertainty_ppm", c->rate_uncertainty * 1e6},
            {"round_trip_ms", c->round_trip_s * 1e3},
            {"inconsistency_ms", c->inconsistency_s * 1e3},
            {"samples", c->samples},
            {"restarts", c->restarts}};
}

}  // namespace sc::host::cli
