// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/cli/bench_pulses.hpp"
#include "host/cli/lag_run.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"
#include "host/verification/pulse_checker.hpp"

namespace sc::host::cli {
namespace {

constexpr double kSigmaUm = 7.5;

std::vector<std::filesystem::path> worlds() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(beam_world("lag"))) {
        if (entry.path().extension() == ".toml") {
            files.push_back(entry.path());
        }
    }
    if (files.empty()) {
        throw CellError("boards/sim/world/beam/lag holds no world");
    }
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

std::vector<Figure> bench_lag(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    const PulseWorkload work = pulse_workload();
    const std::vector<DrawnJobPath> job = draw(work.items);
    const auto judged = [&](const std::filesystem::path& world, const GalvoLag& lag, const std::string& name) {
        return check_pulses(
            job, burn_pulses(work.items, {.world = world, .lag = lag, .seed = options.seed}, folder.path() / name),
            {.only = work.straight});
    };
    std::string table =
        "world,untuned_peak_um,tuned_peak_um,tuned_rms_um,latency_us,natural_frequency_hz,damping,marks,rms_um,"
        "placement_sigma_um\n";
    double tuned_peak = 0.0;
    double tuned_rms = 0.0;
    double untuned_most = 0.0;
    for (const std::filesystem::path& world : worlds()) {
        const std::string name = world.stem().string();
        std::fprintf(stderr, "tuning mirrors: %s\n", name.c_str());
        const PulseFigures untuned = judged(world, {}, name + "_untuned");
        const std::filesystem::path plate = folder.path() / (name + "_lines");
        std::filesystem::create_directories(plate);
        GalvoLagOptions lines;
        lines.world = world;
        lines.seed = options.seed;
        lines.machine = {"galvo.word=18"};
        const CalibrationSet set;
        burn_lag_plate(lines, set, nominal_field(), plate);
        measure_lag_plate(plate, kSigmaUm, options.seed, plate / "measured.csv");
        const LagFit fit = fit_lag_plate(plate / "plan.csv", plate / "measured.csv", set).fit;
        const PulseFigures tuned = judged(world, fit.lag, name + "_tuned");
        tuned_peak = std::max(tuned_peak, tuned.placement_peak);
        tuned_rms = std::max(tuned_rms, tuned.placement_rms);
        untuned_most = std::max(untuned_most, untuned.placement_peak);
        table += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f},{:.5f},{},{:.3f},{:.3f}\n", name,
                             untuned.placement_peak * 1e6, tuned.placement_peak * 1e6, tuned.placement_rms * 1e6,
                             static_cast<double>(fit.lag.latency_ns) * 1e-3, fit.lag.natural_frequency.si(),
                             fit.lag.damping, fit.marks, fit.rms * 1e6, fit.placement_sigma * 1e6);
    }
    if (options.raw) {
        write_text_file(folder.path() / "lag.csv", table);
    }
    return {{"placement_mismatched_peak_um", tuned_peak * 1e6, "um"},
            {"placement_mismatched_rms_um", tuned_rms * 1e6, "um"},
            {"placement_untuned_peak_um", untuned_most * 1e6, "um"}};
}

}  // namespace sc::host::cli
