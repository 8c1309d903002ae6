// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/program.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell cell
      a cell on a pseudo-terminal; its name is printed. In another terminal:
      scribecell monitor --link serial:/dev/pts/7
  scribecell cell --tcp 7000 --out run1
      a cell on 127.0.0.1, port 7000; its traces go to run1. In another terminal:
      scribecell scribe --link tcp:127.0.0.1:7000

It runs in real time until Ctrl-C.)";

struct CellOptions {
    bool pty = false;
    std::optional<unsigned> tcp;
    std::string world;
    std::string out;
    std::string script;
    std::string record;
    std::string key;
    double record_limit_mb = 100.0;
    double speed = 1.0;
};

void check_file(const std::string& file) {
    if (!file.empty() && !std::ifstream(file)) {
        throw InputError({.file = file, .problem = "cannot be read", .value = {}, .action = "check the name"});
    }
}

std::vector<std::string> words_of(const CellOptions& options) {
    std::vector<std::string> words;
    if (options.tcp) {
        words = {"--tcp", std::to_string(*options.tcp)};
    } else {
        words = {"--pty"};
    }
    const auto add = [&words](const char* name, const std::string& value) {
        if (!value.empty()) {
            words.emplace_back(name);
            words.push_back(value);
        }
    };
    add("--world", options.world);
    add("--out", options.out);
    add("--script", options.script);
    add("--key", options.key);
    const bool by_folder = options.record.empty() && !options.out.empty();
    const std::string record =
        by_folder ? (std::filesystem::path(options.out) / "inputs.rec").string() : options.record;
    add("--record", record);
    if (!record.empty()) {
        add("--record-limit", std::to_string(options.record_limit_mb));
    }
    add("--speed", std::to_string(options.speed));
    return words;
}

/// Becomes the simulated cell; returns only when that fails.
int run(const CellOptions& options) {
    check_file(options.world);
    check_file(options.script);
    become_program(required_program("scribecell-cell"), words_of(options));
}

}  // namespace

void add_cell(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("cell", "The simulated cell, waiting for a host in real time.");
    sub->footer(kExamples);
    const auto options = std::make_shared<CellOptions>();
    CLI::Option* pty = sub->add_flag("--pty", options->pty, "wait on a pseudo-terminal (the default)");
    sub->add_option_function<unsigned>(
           "--tcp", [&tcp = options->tcp](const unsigned& port) { tcp = port; }, "wait on 127.0.0.1; 0 = any free port")
        ->type_name("PORT")
        ->check(CLI::Range(0U, 65535U))
        ->excludes(pty);
    sub->add_option("--world", options->world, "world file (default: the reference cell)")->type_name("FILE");
    sub->add_option("--out", options->out, "folder for its traces")->type_name("DIR");
    sub->add_option("--script", options->script, "faults to provoke")->type_name("FILE");
    sub->add_option("--key", options->key, "file of its key: it takes sealed commands only")->type_name("FILE");
    sub->add_option("--record", options->record,
                    "log of the controller's inputs, for replay (default: inputs.rec in the folder of --out)")
        ->type_name("FILE");
    sub->add_option("--record-limit", options->record_limit_mb, "MB; the log ends there, the cell goes on")
        ->check(CLI::Range(0.1, 1e6))
        ->capture_default_str();
    sub->add_option("--speed", options->speed, "seconds of its time a second")->capture_default_str();
    sub->callback([options, &exit_code] { exit_code = guarded(false, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
