// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/program.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell scribe --face 0 --record inputs.rec
  scribecell replay inputs.rec
      runs the controller with the recorded inputs and compares every tick's outputs
  scribecell replay inputs.rec --until 7310 --print-state
      stops after tick 7310 and tells how the controller stands
  scribecell replay inputs.rec --out replayed --json
      tables of what was commanded, tick by tick and pulse by pulse; one JSON object on stdout

Exit codes: 0 every tick is equal; 1 a tick differs, or the disk refuses; 2 bad input or usage.)";

struct ReplayOptions {
    std::string log;
    std::optional<std::int64_t> until;
    std::string key;
    std::string out;
    bool print_state = false;
    bool json = false;
};

std::vector<std::string> words_of(const ReplayOptions& options) {
    std::vector<std::string> words;
    if (options.until) {
        words.insert(words.end(), {"--until", std::to_string(*options.until)});
    }
    if (options.print_state) {
        words.emplace_back("--print-state");
    }
    if (!options.key.empty()) {
        words.insert(words.end(), {"--key", options.key});
    }
    if (!options.out.empty()) {
        words.insert(words.end(), {"--out", options.out});
    }
    if (options.json) {
        words.emplace_back("--json");
    }
    // Behind the mark nothing is an option, whatever the file is called.
    words.insert(words.end(), {"--", options.log});
    return words;
}

/// Becomes the program of the board; returns only when that fails.
int run(const ReplayOptions& options) { become_program(required_program("scribecell-replay"), words_of(options)); }

}  // namespace

void add_replay(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("replay", "Run the controller again with recorded inputs, and compare.");
    sub->footer(kExamples);
    const auto options = std::make_shared<ReplayOptions>();
    sub->add_option("log", options->log, "recording of a controller's inputs")->type_name("LOG")->required();
    sub->add_option_function<std::int64_t>(
           "--until", [&until = options->until](const std::int64_t& tick) { until = tick; }, "last tick to run")
        ->type_name("TICK");
    sub->add_option("--key", options->key, "file of the key, for a log of a cell that took sealed commands")
        ->type_name("FILE");
    sub->add_flag("--print-state", options->print_state, "tell how the controller stands after the last tick");
    sub->add_option("--out", options->out, "folder for ticks.csv and commands.csv")->type_name("DIR");
    sub->add_flag("--json", options->json, "one JSON object on stdout");
    sub->callback([options, &exit_code] { exit_code = guarded(false, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
