// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/cli/build_info.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "shared/link/schema.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell version
  scribecell version --json

Host and controller talk only if their schema hash is the same.)";

int run(bool json) {
    char schema[17] = {};
    std::snprintf(schema, sizeof(schema), "%016llx", static_cast<unsigned long long>(link::kSchemaHash));
    if (json) {
        const nlohmann::ordered_json object{{"version", kVersion},
                                            {"git", kGitHash},
                                            {"protocol_major", link::kProtocolMajor},
                                            {"protocol_minor", link::kProtocolMinor},
                                            {"schema_hash", schema},
                                            {"compiler", kCompiler}};
        std::printf("%s\n", object.dump(2).c_str());
    } else {
        std::printf("scribecell %s (git %s)\nlink protocol %d.%d, schema %s\nbuilt with %s\n", kVersion, kGitHash,
                    link::kProtocolMajor, link::kProtocolMinor, schema, kCompiler);
    }
    return 0;
}

}  // namespace

void add_version(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("version", "Version of this program, of its messages, of its build.");
    sub->footer(kExamples);
    const auto json = std::make_shared<bool>(false);
    sub->add_flag("--json", *json, "one JSON object");
    sub->callback([json, &exit_code] { exit_code = guarded(*json, [&json] { return run(*json); }); });
}

}  // namespace sc::host::cli
