// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <string>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/casting_run.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

constexpr std::uint64_t kSeeds = 20;
constexpr std::uint64_t kPlainSeeds = 5;

/// The worst over castings.
struct Worst {
    double burnt_95 = 0.0;
    double burnt_most = 0.0;
    std::size_t missed = 0;
    std::size_t violations = 0;
    double least_burnt = 1e9;  ///< metres of line
};

void one_casting(std::uint64_t seed, bool plain, Worst& worst, std::string& rows) {
    if (stop_requested()) {
        throw Interrupted();
    }
    const RunFolder folder(std::nullopt);
    const CastingRun run = run_casting(folder.path(), {.seed = seed, .plain = plain});
    if (run.scribed.failure) {
        throw CellError("the casting of seed " + std::to_string(seed) + ": " + run.scribed.failure->message);
    }
    worst.burnt_95 = std::max(worst.burnt_95, run.burnt.share(0.95));
    worst.burnt_most = std::max(worst.burnt_most, run.burnt.share(1.0));
    worst.missed += run.burnt.missed;
    worst.violations += run.scribed.report->samples.limit_violations;
    worst.least_burnt = std::min(worst.least_burnt, run.lines.burnt_length);
    rows += std::to_string(seed) + (plain ? ",plain," : ",,") + std::to_string(1e6 * run.burnt.share(0.95)) + "," +
            std::to_string(1e6 * run.burnt.share(1.0)) + "," + std::to_string(run.burnt.missed) + "," +
            std::to_string(1e3 * run.lines.burnt_length) + "," + std::to_string(1e3 * run.lines.missed_length) + "\n";
    std::fprintf(stderr, "seed %llu%s: 95 %% within %.1f um, all within %.1f um\n",
                 static_cast<unsigned long long>(seed), plain ? " (plain)" : "", 1e6 * run.burnt.share(0.95),
                 1e6 * run.burnt.share(1.0));
}

}  // namespace

std::vector<Figure> bench_casting(const BenchOptions& options) {
    std::string rows = "seed,how,burnt_95_um,burnt_max_um,missed_pulses,burnt_mm,not_reached_mm\n";
    Worst worst;
    for (std::uint64_t i = 0; i < kSeeds; ++i) {
        one_casting(options.seed + i, false, worst, rows);
    }
    Worst plain;
    for (std::uint64_t i = 0; i < kPlainSeeds; ++i) {
        one_casting(options.seed + i, true, plain, rows);
    }
    if (options.raw) {
        std::filesystem::create_directories(*options.raw);
        write_text_file(*options.raw / "casting.csv", rows);
    }
    return {{"burnt_95_um", 1e6 * worst.burnt_95, "um"},
            {"burnt_max_um", 1e6 * worst.burnt_most, "um"},
            {"missed_pulses", static_cast<double>(worst.missed), ""},
            {"limit_violations", static_cast<double>(worst.violations), ""},
            {"least_burnt_mm", 1e3 * worst.least_burnt, "mm"},
            {"plain_max_um", 1e6 * plain.burnt_most, "um"}};
}

}  // namespace sc::host::cli
