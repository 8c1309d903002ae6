// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "host/bridge/key_file.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell key --out cell.key
      a new key, from the system's random numbers, in a file that only its owner may read
  scribecell key --check cell.key
      eight digits that tell two keys apart and say nothing else of them
  scribecell-cell --tcp 7000 --key cell.key
  scribecell scribe --link tcp:127.0.0.1:7000 --key cell.key
      a cell that does only what a host with its key says

One key a cell. Carry it on a medium that you trust; docs/link.md says what it protects from and what not.)";

struct KeyOptions {
    std::string out;
    std::string check;
    bool json = false;
};

int run(const KeyOptions& options) {
    if (options.out.empty() == options.check.empty()) {
        throw InputError({.file = {},
                          .problem = "a key is either made or looked at",
                          .value = {},
                          .action = "give --out FILE or --check FILE"});
    }
    const bool made = !options.out.empty();
    const crypto::Key key = made ? make_key_file(options.out) : read_key_file(options.check);
    const std::string& file = made ? options.out : options.check;
    if (options.json) {
        std::printf("%s\n", nlohmann::ordered_json{{"file", file}, {"check", key_check_text(key)}}.dump(2).c_str());
    } else {
        std::printf("%s: %s, check %s\n", file.c_str(), made ? "a new key" : "a key", key_check_text(key).c_str());
    }
    return 0;
}

}  // namespace

void add_key(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("key", "A key for commands that a cell takes from nobody else.");
    sub->footer(kExamples);
    const auto options = std::make_shared<KeyOptions>();
    sub->add_option("--out", options->out, "make a key, in this file")->type_name("FILE");
    sub->add_option("--check", options->check, "tell which key this file holds")->type_name("FILE");
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
