// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/cli/doctor_checks.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell doctor
      one line each for what is installed, connected and missing, and what to do
  scribecell doctor --json

Exit codes: 0 everything is there that ./run needs; 1 something of that is missing.)";

void print_text(const std::vector<Check>& checks) {
    for (const Check& check : checks) {
        const char* mark = check.good ? "ok     " : (check.needed ? "MISSING" : "absent ");
        std::printf("%s  %-20s %s\n", mark, check.name.c_str(), check.found.c_str());
        if (!check.good && !check.action.empty()) {
            std::printf("         %-20s -> %s\n", "", check.action.c_str());
        }
    }
}

void print_json(const std::vector<Check>& checks, bool good) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Check& check : checks) {
        list.push_back({{"name", check.name},
                        {"good", check.good},
                        {"needed", check.needed},
                        {"found", check.found},
                        {"action", check.good ? std::string() : check.action}});
    }
    const nlohmann::ordered_json object{{"good", good}, {"checks", list}};
    std::printf("%s\n", object.dump(2).c_str());
}

int run(bool json) {
    const std::vector<Check> checks = all_checks();
    const bool good = std::none_of(checks.begin(), checks.end(), [](const Check& c) { return c.needed && !c.good; });
    if (json) {
        print_json(checks, good);
    } else {
        print_text(checks);
    }
    return good ? kDone : kFailed;
}

}  // namespace

void add_doctor(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("doctor", "What is installed, connected and missing, and what to do.");
    sub->footer(kExamples);
    const auto json = std::make_shared<bool>(false);
    sub->add_flag("--json", *json, "one JSON object");
    sub->callback([json, &exit_code] { exit_code = guarded(*json, [&json] { return run(*json); }); });
}

}  // namespace sc::host::cli
