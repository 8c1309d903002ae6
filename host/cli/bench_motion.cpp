// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kProgram = "scribecell-motion-bench";

}  // namespace

std::vector<Figure> bench_motion(const BenchOptions&) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError("tests/data/motion is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    const ProgramOutput output =
        run_program(required_program(kProgram), {"--workloads", (*root / "tests/data/motion").string(), "--json"});
    // Broken limits end the program with 1; the figures say which, and are judged by the caller.
    const auto object = nlohmann::json::parse(output.text, nullptr, false);
    if (!object.is_object()) {
        throw CellError(std::string(kProgram) + " ended with " + std::to_string(output.exit_code) +
                        " and gave no figures");
    }
    const auto figure = [&](const char* name, const char* unit) {
        return Figure{name, object.at(name).get<double>(), unit};
    };
    return {figure("a_dense_s", "s"),        figure("b_corners_s", "s"),       figure("c_mixed_s", "s"),
            figure("max_limit_ratio", ""),   figure("max_deviation_um", "um"), figure("plan_us_per_point", "us"),
            figure("worst_insert_us", "us"), figure("horizon_256_ratio", "")};
}

int bench_motion_file(const MotionFile& file, bool json) {
    std::vector<std::string> words{"--input", file.input};
    if (!file.limits.empty()) {
        words.insert(words.end(), {"--limits", file.limits});
    }
    if (!file.tolerance.empty()) {
        words.insert(words.end(), {"--tolerance", file.tolerance});
    }
    if (json) {
        words.emplace_back("--json");
    }
    become_program(required_program(kProgram), words);
}

}  // namespace sc::host::cli
