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

constexpr const char* kProgram = "scribecell-sensor-bench";

}  // namespace

std::vector<Figure> bench_sensors(const BenchOptions&) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError("the default world is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    const std::string world = (*root / "boards/sim/world/default/world.toml").string();
    const ProgramOutput output = run_program(required_program(kProgram), {"--world", world});
    const auto object = nlohmann::json::parse(output.text, nullptr, false);
    if (output.exit_code != 0 || !object.is_object()) {
        throw CellError(std::string(kProgram) + " ended with " + std::to_string(output.exit_code) +
                        " and gave no figures");
    }
    const auto figure = [&](const char* name, const char* bus, const char* key, const char* unit) {
        return Figure{name, object.at(bus).at(key).get<double>(), unit};
    };
    return {figure("y_bus_share", "y", "share", ""),
            figure("triple_bus_share", "triple", "share", ""),
            figure("y_readings_per_s", "y", "readings_per_s", "1/s"),
            figure("triple_readings_per_s", "triple", "readings_per_s", "1/s"),
            figure("y_late_bus_share", "y_late", "share", ""),
            figure("triple_late_bus_share", "triple_late", "share", "")};
}

}  // namespace sc::host::cli
