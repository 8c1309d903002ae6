// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/bench_pendant.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kProgram = "scribecell-bus-bench";

}  // namespace

std::vector<Figure> bench_bus(const BenchOptions& options) {
    const ProgramOutput output = run_program(required_program(kProgram), {"--seed", std::to_string(options.seed)});
    const auto object = nlohmann::json::parse(output.text, nullptr, false);
    if (output.exit_code != 0 || !object.is_object()) {
        throw CellError(std::string(kProgram) + " ended with " + std::to_string(output.exit_code) +
                        " and gave no figures");
    }
    if (options.raw) {
        std::filesystem::create_directories(*options.raw);
        std::ofstream(*options.raw / "bus.json") << object.dump(2) << '\n';
    }
    std::vector<Figure> figures;
    double worst = 0.0;
    for (const auto& one : object.at("cases")) {
        worst = std::max(worst, one.at("error_pct").get<double>());
        const auto name = one.at("name").get<std::string>();
        if (one.at("by_master").get<bool>()) {
            continue;
        }
        figures.push_back({name + "_computed", one.at("cyclic_pct").get<double>(), "%"});
        figures.push_back({name + "_counted", one.at("counted_pct").get<double>(), "%"});
    }
    double over = 0.0;
    double nearest = 0.0;
    for (const auto& one : object.at("stuffing")) {
        const double share = one.at("found").get<double>() / one.at("bound").get<double>();
        over += share > 1.0 ? 1.0 : 0.0;
        nearest = std::max(nearest, share);
    }
    figures.insert(figures.begin(), {Figure{"budget_error_pct", worst, "%"}, Figure{"frames_over_bound", over, ""},
                                     Figure{"longest_frame_share", nearest, ""}});
    for (const auto& more : {detent_figures, guest_figures}) {
        const std::vector<Figure> found = more(options);
        figures.insert(figures.end(), found.begin(), found.end());
    }
    return figures;
}

}  // namespace sc::host::cli
