// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

// A program of the tests: it links CGAL where that is installed, which must not ship.
constexpr const char* kProgram = "scribecell-allowance-bench";

struct Wanted {
    const char* name;
    const char* unit;
};
constexpr Wanted kWanted[]{{"sorted_native_vs_embree", ""},
                           {"sorted_211k_vs_embree", ""},
                           {"sorted_951k_vs_embree", ""},
                           {"sorted_native_avx2_vs_embree", ""},
                           {"sorted_211k_avx2_vs_embree", ""},
                           {"sorted_951k_avx2_vs_embree", ""},
                           {"random_native_vs_embree", ""},
                           {"random_211k_vs_embree", ""},
                           {"random_951k_vs_embree", ""},
                           {"random_native_avx2_vs_embree", ""},
                           {"random_211k_avx2_vs_embree", ""},
                           {"random_951k_avx2_vs_embree", ""},
                           {"exact_error_mm", "mm"},
                           {"wrong_signs", ""},
                           {"fit_s", "s"},
                           {"fit_error_um", "um"},
                           {"borrow_s", "s"},
                           {"kkt_residual", ""},
                           {"drag_frame_ms", "ms"},
                           {"line_cloud_vs_truth_95_mm", "mm"},
                           {"chain_s", "s"},
                           {"published_radial_mm", "mm"},
                           {"published_axial_mm", "mm"},
                           {"published_margin_gain_mm", "mm"},
                           {"paper_shift_mm", "mm"},
                           {"paper_left_mm", "mm"},
                           {"paper_right_mm", "mm"}};

}  // namespace

std::vector<Figure> bench_allowance(const BenchOptions& options) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError(
            "tests/data/casting-blank is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    std::fprintf(stderr, "a minute or two; a machine that does other things gives other figures\n");
    const ProgramOutput output =
        run_program(required_program(kProgram), {(*root / "tests/data/casting-blank").string()});
    const auto object = nlohmann::json::parse(output.text, nullptr, false);
    if (output.exit_code != 0 || !object.is_object()) {
        throw CellError(std::string(kProgram) + " ended with " + std::to_string(output.exit_code) +
                        " and gave no figures");
    }
    if (options.raw) {
        std::filesystem::create_directories(*options.raw);
        write_text_file(*options.raw / "allowance.json", output.text);
    }
    std::vector<Figure> figures;
    for (const Wanted& wanted : kWanted) {
        if (object.contains(wanted.name)) {
            figures.push_back({wanted.name, object.at(wanted.name).get<double>(), wanted.unit});
        } else {
            std::fprintf(stderr,
                         "not measured: %s (the peer was not installed when %s was built: ./run bench allowance)\n",
                         wanted.name, kProgram);
        }
    }
    return figures;
}

}  // namespace sc::host::cli
