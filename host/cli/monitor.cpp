// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/black_box_text.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/monitor_text.hpp"
#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell monitor --once
      state of a simulated cell that has just been switched on
  scribecell monitor --link serial:/dev/ttyUSB0
      state, faults, axes and counters, five times a second, until Ctrl-C
  scribecell monitor --link tcp:127.0.0.1:7000 --once --config --json
      state and limits of the machine as one JSON object

One host at a time: a cell that is busy with another host refuses the connection.)";

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(200);
constexpr Nanoseconds kClockTime = std::chrono::milliseconds(300);
constexpr Nanoseconds kFirstLimit = std::chrono::seconds(2);

struct MonitorOptions {
    std::string link = "sim:";
    LinkOptions link_options;
    bool once = false;
    bool json = false;
    bool config = false;
};

std::string shown_text(const CellClient& client) {
    return status_text(*client.status(), client.counters()) + clock_text(client.clock(), client.now());
}

void show_once(const CellClient& client, const MonitorOptions& options, const MachineConfig* machine) {
    if (options.json) {
        nlohmann::ordered_json object = status_json(*client.status(), client.counters());
        object["clock"] = clock_json(client.clock(), client.now());
        if (machine != nullptr) {
            object["machine"] = machine_json(*machine);
        }
        std::printf("%s\n", options.once ? object.dump(2).c_str() : object.dump().c_str());
    } else {
        std::fputs(shown_text(client).c_str(), stdout);
        if (machine != nullptr) {
            std::fputs(machine_text(*machine).c_str(), stdout);
        }
    }
    std::fflush(stdout);
}

void show_again(const CellClient& client, const MonitorOptions& options, std::size_t lines) {
    if (!options.json && ::isatty(STDOUT_FILENO) == 1) {
        // Back over what was shown before, and clear it.
        std::printf("\x1b[%zuA\x1b[J", lines);
    }
    show_once(client, options, nullptr);
}

int run(const MonitorOptions& options) {
    install_stop_signals();
    const bool simulated = is_simulated(options.link);
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    const MachineConfig machine = client.read_config();
    if (!client.pump_until([&] { return client.status().has_value(); }, kFirstLimit)) {
        throw LinkError("the cell tells no state");
    }
    // A cell that has just been switched on is still looking for its drives.
    client.pump_until([&] { return client.state() != State::boot; }, kFirstLimit);
    // Some answers to heartbeats say how its clock stands.
    client.pump_until([] { return false; }, kClockTime);
    show_once(client, options, options.config ? &machine : nullptr);
    while (!options.once) {
        if (simulated) {
            // Its virtual time would race by.
            std::this_thread::sleep_for(kPeriod);
        }
        const std::string shown = shown_text(client);
        client.pump_until([] { return false; }, kPeriod);
        show_again(client, options, static_cast<std::size_t>(std::count(shown.begin(), shown.end(), '\n')));
    }
    return 0;
}

}  // namespace

void add_monitor(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("monitor", "State, faults, axes and counters of a cell.");
    sub->footer(kExamples);
    const auto options = std::make_shared<MonitorOptions>();
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_option("--capture", options->link_options.capture, "pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    sub->add_flag("--once", options->once, "print once and end");
    sub->add_flag("--json", options->json, "one JSON object (with --once), else one a line");
    sub->add_flag("--config", options->config, "the machine's configuration too");
    sub->callback(
        [options, &exit_code] { exit_code = guarded(options->json && options->once, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
