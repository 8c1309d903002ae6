// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include <nlohmann/json.hpp>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/black_box_text.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/number_text.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell blackbox --link serial:/dev/ttyUSB0
      the last 10 s before the fault, as a table
  scribecell blackbox --link tcp:127.0.0.1:7000 --last 1
      the last second of them
  scribecell blackbox --link tcp:127.0.0.1:7000 --out fault.csv
      all of it as a file for a spreadsheet
  scribecell blackbox --link tcp:127.0.0.1:7000 --json
      one JSON object

A fault freezes the box. It stays readable after the fault has been reset, until the axes are powered again: read it
before that. Without a fault it shows the last 10 s up to now. Times are relative to its newest sample, s.)";

/// For the clock: a few answers to heartbeats.
constexpr Nanoseconds kClockTime = std::chrono::milliseconds(500);

struct BlackBoxOptions {
    std::string link = "sim:";
    LinkOptions link_options;
    std::string out;
    double last_s = 1e9;
    bool json = false;
};

int run(const BlackBoxOptions& options) {
    if (!(options.last_s > 0.0)) {
        throw InputError({.file = {},
                          .problem = "--last is no time",
                          .value = number_text(options.last_s),
                          .action = "give seconds, more than 0"});
    }
    install_stop_signals();
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    client.pump_until([] { return false; }, kClockTime);
    const BlackBoxContent content = client.read_black_box();
    if (!options.out.empty()) {
        write_text_file(options.out, black_box_csv(content, client.clock()));
    }
    if (options.json) {
        std::printf("%s\n", black_box_json(content, client.clock()).dump(2).c_str());
    } else if (options.out.empty()) {
        std::fputs(black_box_text(content, options.last_s, client.clock()).c_str(), stdout);
    } else {
        std::printf("%zu samples and %zu events in %s\n", content.samples.size(), content.events.size(),
                    options.out.c_str());
    }
    return 0;
}

}  // namespace

void add_blackbox(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("blackbox", "What a cell did in the 10 s before its fault.");
    sub->footer(kExamples);
    const auto options = std::make_shared<BlackBoxOptions>();
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_option("--out", options->out, "write all of it as CSV")->type_name("FILE");
    sub->add_option("--last", options->last_s, "seconds to show (default: all)")->type_name("S");
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
