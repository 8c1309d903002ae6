// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/number_text.hpp"
#include "host/cli/sensors_text.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "shared/codes/codes.hpp"
#include "shared/path/item.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell sensors
      distance, age and quality of each sensor of a simulated cell
  scribecell sensors --watch --link serial:/dev/ttyUSB0
      the same five times a second, until Ctrl-C
  scribecell sensors --reference 50 --link tcp:127.0.0.1:7000
      the [seating] table for a job, from the workpiece that is seated now
  scribecell sensors --in-turn --watch
      the lasers of the triple head one at a time, for a camera
  scribecell sensors --json --script faults.txt
      one JSON object; the simulated cell has the sensor faults of a script

Exit code 1 if a sensor that is fitted has no good value; out of range is none of its faults.)";

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(200);
constexpr Nanoseconds kFirstLimit = std::chrono::seconds(3);
constexpr Nanoseconds kSampleLimit = std::chrono::seconds(2);
constexpr int kMostSamples = 1000;

struct SensorsOptions {
    std::string link = "sim:";
    LinkOptions link_options;
    bool watch = false;
    bool json = false;
    bool in_turn = false;
    double after_s = 0.0;
    std::optional<int> reference;
};

/// The sensor has found its way to a value, or to a reason why not.
bool settled(const link::SensorReport& report) {
    return std::ranges::none_of(report.code, [](std::uint16_t code) {
        return code == static_cast<std::uint16_t>(SensorCode::not_read) ||
               code == static_cast<std::uint16_t>(SensorCode::unconfirmed);
    });
}

link::SensorReport first_report(CellClient& client) {
    const HostTime end = client.now() + kFirstLimit;
    for (;;) {
        const link::SensorReport report = client.read_sensors();
        if (settled(report) || client.now() >= end) {
            return report;
        }
        client.pump_until([] { return false; }, kPeriod / 4);
    }
}

void show(const link::SensorReport& report, const SensorsOptions& options) {
    if (options.json) {
        std::printf("%s\n", options.watch ? sensors_json(report).dump().c_str() : sensors_json(report).dump(2).c_str());
    } else {
        std::fputs(sensors_text(report).c_str(), stdout);
    }
    std::fflush(stdout);
}

void watch(CellClient& client, const SensorsOptions& options, std::string shown) {
    const bool terminal = !options.json && ::isatty(STDOUT_FILENO) == 1;
    for (;;) {
        if (is_simulated(options.link)) {
            // Its virtual time would race by.
            std::this_thread::sleep_for(kPeriod);
        }
        client.pump_until([] { return false; }, kPeriod);
        const link::SensorReport report = client.read_sensors();
        if (terminal) {
            std::printf("\x1b[%zdA\x1b[J", std::ranges::count(shown, '\n'));
        }
        show(report, options);
        shown = sensors_text(report);
    }
}

/// Means of so many measurements of each sensor of the triple head, mm, and their standard deviations.
struct Reference {
    std::array<double, 3> mean{};
    std::array<double, 3> sigma{};
};

Reference take_reference(CellClient& client, int samples) {
    std::array<std::vector<double>, 3> values;
    std::array<std::uint32_t, 3> seen{};
    HostTime end = client.now() + kFirstLimit + kSampleLimit;
    const auto enough = [&](const auto& list) { return list.size() >= static_cast<std::size_t>(samples); };
    while (!std::ranges::all_of(values, enough)) {
        const link::SensorReport report = client.read_sensors();
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t sensor = i + 1;
            if (report.code.at(sensor) == 0 && report.count.at(sensor) != seen.at(i) && !enough(values.at(i))) {
                seen.at(i) = report.count.at(sensor);
                values.at(i).push_back(static_cast<double>(report.value.at(sensor)) * 1e3 / kWireUnitsPerMetre);
                end = client.now() + kSampleLimit;
            }
        }
        if (client.now() > end) {
            for (std::size_t i = 0; i < 3; ++i) {
                if (!enough(values.at(i))) {
                    throw CellError(fmt::format("sensor {} of the triple head gives no values: {}", i + 1,
                                                trouble_text(report, i + 1)));
                }
            }
        }
        client.pump_until([] { return false; }, std::chrono::milliseconds(20));
    }
    Reference out;
    for (std::size_t i = 0; i < 3; ++i) {
        for (const double v : values.at(i)) {
            out.mean.at(i) += v / samples;
        }
        for (const double v : values.at(i)) {
            out.sigma.at(i) += (v - out.mean.at(i)) * (v - out.mean.at(i)) / std::max(1, samples - 1);
        }
        out.sigma.at(i) = std::sqrt(out.sigma.at(i));
    }
    return out;
}

int show_reference(CellClient& client, const SensorsOptions& options) {
    const Reference found = take_reference(client, *options.reference);
    // Means of ten against this mean: four times their spread, and what the surface's roughness adds is the user's.
    const double worst = *std::ranges::max_element(found.sigma);
    const double tolerance = std::max(0.05, std::ceil(400.0 * worst / std::sqrt(10.0)) / 100.0);
    if (options.json) {
        nlohmann::ordered_json out;
        out["expected_mm"] = found.mean;
        out["sigma_mm"] = found.sigma;
        out["samples"] = *options.reference;
        out["tolerance_mm"] = tolerance;
        std::printf("%s\n", out.dump(2).c_str());
        return 0;
    }
    fmt::print("[seating]   # mean of {} measurements; σ of one: {:.3f}, {:.3f}, {:.3f} mm\n", *options.reference,
               found.sigma[0], found.sigma[1], found.sigma[2]);
    fmt::print("expected_mm = [{:.4f}, {:.4f}, {:.4f}]\n", found.mean[0], found.mean[1], found.mean[2]);
    fmt::print("tolerance_mm = {}\ntilt_mm = {}\nsamples = 10\n", number_text(tolerance), number_text(2 * tolerance));
    return 0;
}

void check(const SensorsOptions& options) {
    if (options.reference && (*options.reference < 2 || *options.reference > kMostSamples)) {
        throw InputError({.file = {},
                          .problem = "--reference is no number of measurements",
                          .value = std::to_string(*options.reference),
                          .action = "give 2 to " + std::to_string(kMostSamples)});
    }
    if (!(options.after_s >= 0.0 && options.after_s <= 3600.0)) {
        throw InputError({.file = {},
                          .problem = "--after is no time",
                          .value = number_text(options.after_s),
                          .action = "give seconds, 0 to 3600"});
    }
    if (!is_simulated(options.link) && (options.link_options.world || options.link_options.script)) {
        throw InputError({.file = {},
                          .problem = "--world and --script belong to the simulated cell",
                          .value = options.link,
                          .action = "give them to `scribecell cell`, or use --link sim:"});
    }
}

int run(const SensorsOptions& options) {
    check(options);
    install_stop_signals();
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    if (options.in_turn) {
        client.command(link::Verb::lasers_in_turn, 1);
    }
    client.pump_until([] { return false; }, Nanoseconds(static_cast<std::int64_t>(options.after_s * 1e9)));
    const link::SensorReport report = first_report(client);
    if (options.reference) {
        return show_reference(client, options);
    }
    show(report, options);
    if (options.watch) {
        watch(client, options, sensors_text(report));
    }
    const bool wrong = std::ranges::any_of(report.code, [](std::uint16_t code) {
        return code != 0 && code != static_cast<std::uint16_t>(SensorCode::out_of_range) &&
               code != static_cast<std::uint16_t>(Refusal::sensor_not_fitted);
    });
    return wrong ? 1 : 0;
}

}  // namespace

void add_sensors(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("sensors", "What the distance sensors of a cell say.");
    sub->footer(kExamples);
    const auto options = std::make_shared<SensorsOptions>();
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_flag("--watch", options->watch, "again and again, until Ctrl-C");
    sub->add_flag("--json", options->json, "one JSON object; with --watch one a line");
    sub->add_flag("--in-turn", options->in_turn, "light the lasers of the triple head one at a time");
    sub->add_option("--reference", options->reference, "print a [seating] table from so many measurements");
    sub->add_option("--after", options->after_s, "seconds of the cell's time to wait first");
    sub->add_option("--capture", options->link_options.capture, "pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    sub->add_option("--world", options->link_options.world, "world of the simulated cell")->type_name("FILE");
    sub->add_option("--script", options->link_options.script, "its script of faults")->type_name("FILE");
    sub->callback([options, &exit_code] {
        exit_code = guarded(options->json && !options->watch, [&] { return run(*options); });
    });
}

}  // namespace sc::host::cli
