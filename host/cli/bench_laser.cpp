// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/bench_pulses.hpp"
#include "host/cli/bench_split.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"
#include "host/path/plate_plan.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kTruth = "scribecell-field-truth";
constexpr double kSigmaUm = 7.5;

struct Residual {
    double rms_um = 0.0;
    double max_um = 0.0;
};

/// The plate of one simulated run, measured and fitted as often as wanted.
class FieldBench {
public:
    FieldBench(const BenchOptions& options, const std::filesystem::path& root)
        : folder_(options.raw), world_(root / "boards/sim/world/plate/world.toml"), seed_(options.seed) {
        set_ = read_calibration(root / "examples/ras3dm/calibration.toml");
        GalvoFieldOptions burn;
        burn.world = world_;
        burn.seed = options.seed;
        burn_plate(burn, set_, folder_.path());
    }

    /// `told`: options of the program that holds the truth.
    [[nodiscard]] Residual residual(double sigma_um, const std::vector<std::string>& told = {}) const {
        const std::filesystem::path measured = folder_.path() / fmt::format("measured_{}um.csv", sigma_um);
        measure_plate(folder_.path(), sigma_um, seed_, measured);
        const GalvoFieldOutcome outcome = fit_plate(folder_.path() / "plan.csv", measured, set_, {});
        const GalvoField field = galvo_field_of(outcome.set);
        std::string numbers;
        for (std::size_t i = 0; i < GalvoField::kNumbers; ++i) {
            numbers += fmt::format("{:.17g}\n", field.number(i));
        }
        const std::filesystem::path file = folder_.path() / fmt::format("field_{}um.txt", sigma_um);
        write_text_file(file, numbers);
        // Where the plate was: the axes' own errors at other places are not the galvo's.
        const Vec3 anchor = PlateOptions{}.centre;
        const Compensation compensation = compensation_of(set_);
        const Vec3 reading = compensation.axis_from_h * anchor + compensation.axis_offset;
        std::vector<std::string> words{file.string(), "--world", world_.string()};
        for (const auto& [name, place] : {std::pair{"--anchor-mm", anchor}, std::pair{"--reading-mm", reading}}) {
            words.emplace_back(name);
            for (std::size_t i = 0; i < 3; ++i) {
                words.push_back(fmt::format("{:.9f}", place[i] * 1e3));
            }
        }
        words.insert(words.end(), told.begin(), told.end());
        const ProgramOutput output = run_program(required_program(kTruth), words);
        const auto object = nlohmann::json::parse(output.text, nullptr, false);
        if (output.exit_code != 0 || !object.is_object()) {
            throw CellError(std::string(kTruth) + " ended with " + std::to_string(output.exit_code));
        }
        return {object.at("rms_um").get<double>(), object.at("max_um").get<double>()};
    }

private:
    RunFolder folder_;
    std::filesystem::path world_;
    std::uint64_t seed_;
    CalibrationSet set_;
};

}  // namespace

std::vector<Figure> bench_laser(const BenchOptions& options) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError("the plate's world is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    const FieldBench bench(options, *root);
    const Residual noisy = bench.residual(kSigmaUm);
    const Residual clean = bench.residual(0.0);
    // What the third dimension earns: the same correction, not told the depth.
    const Residual flat = bench.residual(kSigmaUm, {"--no-depth"});
    std::vector<Figure> figures{{"field_residual_rms_um", noisy.rms_um, "um"},
                                {"field_residual_max_um", noisy.max_um, "um"},
                                {"field_noise_free_rms_um", clean.rms_um, "um"},
                                {"field_noise_free_max_um", clean.max_um, "um"},
                                {"field_without_depth_max_um", flat.max_um, "um"}};
    const std::vector<Figure> pulses = bench_pulses(options);
    figures.insert(figures.end(), pulses.begin(), pulses.end());
    const std::vector<Figure> tiles = bench_split(options);
    figures.insert(figures.end(), tiles.begin(), tiles.end());
    const std::vector<Figure> lag = bench_lag(options);
    figures.insert(figures.end(), lag.begin(), lag.end());
    const std::vector<Figure> follow = bench_follow(options);
    figures.insert(figures.end(), follow.begin(), follow.end());
    return figures;
}

}  // namespace sc::host::cli
