// SPDX-License-Identifier: Apache-2.0
#include "host/cli/bench_faults.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"

namespace sc::host::cli {
namespace {

void add(std::vector<Figure>& figures, const char* program, std::vector<std::string> arguments,
         const BenchOptions& options) {
    if (options.raw) {
        arguments.emplace_back("--raw");
        arguments.push_back(options.raw->string());
    }
    const ProgramOutput output = run_program(required_program(program), arguments);
    const auto object = nlohmann::ordered_json::parse(output.text, nullptr, false);
    if (output.exit_code != 0 || !object.is_object()) {
        throw CellError(std::string(program) + " ended with " + std::to_string(output.exit_code) +
                        " and gave no figures");
    }
    for (const auto& [name, value] : object.items()) {
        figures.push_back({name, value.get<double>(), name.ends_with("_us") ? "us" : ""});
    }
}

}  // namespace

std::vector<Figure> bench_faults(const BenchOptions& options) {
    std::vector<Figure> figures;
    add(figures, "scribecell-fault-bench", {}, options);
    add(figures, "scribecell-fault-mutants", {"--mutants"}, options);
    return figures;
}

}  // namespace sc::host::cli
