// SPDX-License-Identifier: Apache-2.0
#include "host/cli/override.hpp"

#include <cstdio>
#include <memory>
#include <random>
#include <string>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell override 50 --link tcp:127.0.0.1:7000
      paths run at half their programmed speed, until told otherwise or the cell is switched off
  scribecell override 100 --link serial:/dev/ttyUSB0
  scribecell scribe --override 50
      for a job; in the terminal of a running one + and - change it by 10 %, and 0 sets 100 %

Pulses keep their pitch and energy. Travel, turns and jogs are not changed. One host at a time: a cell that is busy
with another host refuses the connection.)";

constexpr Nanoseconds kStatusLimit = std::chrono::seconds(2);

struct OverrideOptions {
    int percent = 0;
    std::string link;
    LinkOptions link_options;
};

int run(const OverrideOptions& options) {
    check_override(options.percent);
    if (is_simulated(options.link)) {
        throw InputError({.file = {},
                          .problem = "a simulated cell of its own ends with this command",
                          .value = options.link,
                          .action = "name a cell that runs (`scribecell cell --tcp 7000`), or use scribe --override"});
    }
    install_stop_signals();
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    client.pump_until([&] { return client.status().has_value(); }, kStatusLimit);
    const int before = client.status() ? client.status()->override_percent : 0;
    client.command(link::Verb::set_override, options.percent);
    if (!client.pump_until([&] { return client.status_is_fresh(); }, kStatusLimit)) {
        throw LinkError("the cell tells no state");
    }
    std::printf("feed override: %d %% -> %d %%\n", before, client.status()->override_percent);
    return 0;
}

}  // namespace

void check_override(int percent) {
    if (percent < link::kMinOverride || percent > link::kMaxOverride) {
        throw InputError(
            {.file = {},
             .problem = "the feed override is out of range, percent",
             .value = std::to_string(percent),
             .action = "use " + std::to_string(link::kMinOverride) + ".." + std::to_string(link::kMaxOverride)});
    }
}

void add_override(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("override", "Set the feed override of a cell that runs.");
    sub->footer(kExamples);
    const auto options = std::make_shared<OverrideOptions>();
    sub->add_option("percent", options->percent, "of the programmed speed of paths, 10..200")->required();
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->required();
    add_key_option(*sub, options->link_options.key);
    sub->add_option("--capture", options->link_options.capture, "pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    sub->callback([options, &exit_code] { exit_code = guarded(false, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
