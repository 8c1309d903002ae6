// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/stop.hpp"
#include "host/bridge/telemetry_values.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/number_text.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell telemetry --link serial:/dev/ttyUSB0?baud=921600 --channels set_point,actual --rate 100 --out axes.csv
      two places of each axis, a hundred times a second, for ten seconds
  scribecell telemetry --link tcp:127.0.0.1:7000 --channels following_error,state,pulses \
      --rate motion=50 --rate state=20 --rate counters=2 --seconds 60 --out run.csv
      each group of channels at a rate of its own
  scribecell telemetry --channels all --rate 10 --seconds 2 --json
      one JSON object a sample, from a simulated cell

Channels, by group:
  motion    set_point, actual, following_error (each of X, Y, Z, C)
  state     state, first_fault, limited_by, override_percent, flags, queue
  counters  pulses, starvations, frames_bad, messages_lost
  sensors   y_sensor, surface_depth, shift, triple
Telemetry may take a quarter of the line; what takes more is refused with the rate that would fit.
One host at a time: a cell that is busy with another host refuses the connection.)";

constexpr Nanoseconds kLook = std::chrono::milliseconds(100);

struct TelemetryOptions {
    std::string link = "sim:";
    LinkOptions link_options;
    std::string channels = "set_point,actual,state";
    std::vector<std::string> rates;
    double seconds = 10.0;
    std::optional<std::uint32_t> line_rate;
    std::string out;
    bool json = false;
};

[[noreturn]] void bad_rate(const std::string& word) {
    throw InputError({.file = {},
                      .problem = "--rate is no rate",
                      .value = word,
                      .action = "give samples a second, or GROUP=RATE with motion, state, counters or sensors"});
}

/// Samples a second of each group.
std::array<double, link::TelemetryRequest::kGroups> read_rates(const std::vector<std::string>& words) {
    std::array<double, link::TelemetryRequest::kGroups> rates{};
    rates.fill(10.0);
    for (const std::string& word : words) {
        const std::size_t sign = word.find('=');
        const std::string group = sign == std::string::npos ? "" : word.substr(0, sign);
        const std::string number = sign == std::string::npos ? word : word.substr(sign + 1);
        double rate = 0.0;
        const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), rate);
        if (error != std::errc{} || end != number.data() + number.size() || !(rate > 0.0)) {
            bad_rate(word);
        }
        bool known = group.empty();
        for (std::size_t g = 0; g < rates.size(); ++g) {
            if (group.empty() || group == link::kTelemetryGroups.at(g)) {
                rates.at(g) = rate;
                known = true;
            }
        }
        if (!known) {
            bad_rate(word);
        }
    }
    return rates;
}

link::TelemetryRequest request_of(const TelemetryOptions& options, double period_s) {
    link::TelemetryRequest request;
    request.channels = read_channels(options.channels);
    const auto rates = read_rates(options.rates);
    for (std::size_t g = 0; g < rates.size(); ++g) {
        const double ticks = std::round(1.0 / (rates.at(g) * period_s));
        if (ticks < link::kTelemetryShortest || ticks > link::kTelemetryLongest) {
            throw InputError(
                {.file = {},
                 .problem = "the rate of the group " + std::string(link::kTelemetryGroups.at(g)) + " is out of range",
                 .value = number_text(rates.at(g)) + " a second",
                 .action = "use " + number_text(1.0 / (link::kTelemetryLongest * period_s)) + " to " +
                           number_text(1.0 / (link::kTelemetryShortest * period_s)) + " a second"});
        }
        request.period_ticks.at(g) = static_cast<std::uint16_t>(ticks);
    }
    request.line_bytes_per_s =
        options.line_rate ? *options.line_rate : line_bytes_per_s(options.link, options.link_options);
    return request;
}

void subscribe(CellClient& client, const link::TelemetryRequest& request, double period_s) {
    try {
        client.subscribe(request);
    } catch (const CellRefused& refused) {
        if (refused.refusal != Refusal::telemetry_over_budget) {
            throw;
        }
        const auto needed = link::telemetry_bytes_per_s(request, static_cast<std::uint32_t>(period_s * 1e9), 1);
        throw CellRefused(
            fmt::format(
                "{}: it would take {} bytes a second, and may take {} of this line; no more than {:.4g} samples "
                "a second of a group would fit (--line-rate says what the line carries, if that is wrong)",
                refused.what(), needed, link::telemetry_budget(request.line_bytes_per_s),
                1.0 / (static_cast<double>(refused.detail) * period_s)),
            refused.refusal, refused.detail);
    }
}

using Column = std::pair<std::size_t, std::size_t>;

std::vector<Column> columns_of(std::uint32_t channels) {
    std::vector<Column> columns;
    for (std::size_t i = 0; i < link::kTelemetryColumns.size(); ++i) {
        for (std::size_t k = 0; ((channels >> i) & 1U) != 0 && k < link::kTelemetryColumns.at(i).count; ++k) {
            columns.emplace_back(i, k);
        }
    }
    return columns;
}

std::optional<double> host_seconds(const CellClient& client, std::uint64_t cell_us) {
    const auto time = client.clock().host_time(cell_us);
    if (!time) {
        return std::nullopt;
    }
    return std::chrono::duration<double>(time->time_since_epoch()).count();
}

std::string csv_head(const std::vector<Column>& columns) {
    std::string line = "cell_s,host_s";
    for (const auto& [column, element] : columns) {
        line += "," + column_name(column, element);
    }
    return line + "\n";
}

std::string csv_row(const CellClient& client, const link::Telemetry& sample, const std::vector<TelemetryValue>& values,
                    const std::vector<Column>& columns) {
    const auto host = host_seconds(client, sample.cell_time_us);
    std::string line = fmt::format("{:.3f},{}", static_cast<double>(sample.cell_time_us) * 1e-6,
                                   host ? fmt::format("{:.4f}", *host) : std::string());
    auto next = values.begin();
    for (const auto& [column, element] : columns) {
        line += ",";
        if (next != values.end() && next->column == column && next->element == element) {
            line += fmt::format("{:.10g}", next->value());
            ++next;
        }
    }
    return line + "\n";
}

std::string json_row(const CellClient& client, const link::Telemetry& sample,
                     const std::vector<TelemetryValue>& values) {
    const auto host = host_seconds(client, sample.cell_time_us);
    nlohmann::ordered_json row{{"cell_s", static_cast<double>(sample.cell_time_us) * 1e-6},
                               {"host_s", host ? nlohmann::ordered_json(*host) : nlohmann::ordered_json()}};
    for (const TelemetryValue& value : values) {
        row[column_name(value.column, value.element)] = value.value();
    }
    return row.dump() + "\n";
}

int run(const TelemetryOptions& options) {
    if (!(options.seconds > 0.0 && options.seconds <= 1e6)) {
        throw InputError({.file = {},
                          .problem = "--seconds is no time",
                          .value = number_text(options.seconds),
                          .action = "give seconds, more than 0"});
    }
    static_cast<void>(read_channels(options.channels));
    static_cast<void>(read_rates(options.rates));
    install_stop_signals();
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    const double period_s = static_cast<double>(client.read_config().control_period_ns) * 1e-9;
    const link::TelemetryRequest request = request_of(options, period_s);
    std::ofstream file;
    if (!options.out.empty()) {
        file.open(options.out);
        if (!file) {
            throw InputError(
                {.file = options.out, .problem = "cannot be written", .value = {}, .action = "use another"});
        }
    }
    const auto put = [&](const std::string& text) {
        if (file.is_open()) {
            file << text;
        } else {
            std::fputs(text.c_str(), stdout);
        }
    };
    const std::vector<Column> columns = columns_of(request.channels);
    bool headed = options.json;
    std::size_t samples = 0;
    std::uint16_t skipped = 0;
    client.on_telemetry([&](const link::Telemetry& sample) {
        if (!headed) {
            put(csv_head(columns));
            headed = true;
        }
        if (const auto values = decode(sample)) {
            put(options.json ? json_row(client, sample, *values) : csv_row(client, sample, *values, columns));
            ++samples;
            skipped = sample.skipped;
        }
    });
    subscribe(client, request, period_s);
    const HostTime end = client.now() + Nanoseconds(static_cast<std::int64_t>(options.seconds * 1e9));
    while (client.now() < end) {
        client.pump(std::min(end, client.now() + kLook));
    }
    client.subscribe({});
    std::fprintf(stderr, "%zu samples, %u skipped for want of room on the line\n", samples, unsigned{skipped});
    return 0;
}

}  // namespace

void add_telemetry(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("telemetry", "Channels of a cell at chosen rates, as CSV or JSON.");
    sub->footer(kExamples);
    const auto options = std::make_shared<TelemetryOptions>();
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_option("--channels", options->channels, "names, with commas between; all")
        ->type_name("NAMES")
        ->capture_default_str();
    sub->add_option("--rate", options->rates, "samples a second, or GROUP=RATE; again for other groups (default: 10)")
        ->type_name("RATE")
        ->allow_extra_args(false);
    sub->add_option("--seconds", options->seconds, "how long")->capture_default_str();
    sub->add_option("--line-rate", options->line_rate, "bytes a second that the line carries (default: by the URL)")
        ->type_name("BYTES");
    sub->add_option("--out", options->out, "write to a file instead of here")->type_name("FILE");
    sub->add_flag("--json", options->json, "one JSON object a sample instead of CSV");
    sub->add_option("--world", options->link_options.world, "world of the simulated cell")->type_name("FILE");
    sub->add_option("--script", options->link_options.script, "its script of faults")->type_name("FILE");
    sub->callback([options, &exit_code] { exit_code = guarded(false, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
