// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/run_folder.hpp"
#include "host/cli/scribe_run.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

constexpr double kMm = 1e3;

std::string place_csv(const Vec3& v) { return fmt::format("{:.6f},{:.6f},{:.6f}", v.x * kMm, v.y * kMm, v.z * kMm); }

/// One row a cross; places in mm.
std::string crosses_csv(const AccuracyReport& accuracy) {
    std::string text = "face_deg,no,commanded_x,commanded_y,commanded_z,found_x,found_y,found_z,true_x,true_y,true_z\n";
    for (const FaceAccuracy& face : accuracy.faces) {
        for (const PointAccuracy& point : face.points) {
            if (point.commanded) {
                text += fmt::format("{:g},{},{},{},{}\n", face.face_deg, point.no, place_csv(*point.commanded),
                                    place_csv(point.found.v), place_csv(point.truth.v));
            }
        }
    }
    return text;
}

std::string run_csv(const Report& report, double wall_seconds) {
    return fmt::format("ticks,cell_seconds,wall_seconds,limit_violations\n{},{:.6f},{:.6f},{}\n", report.samples.ticks,
                       report.run.cell_seconds, wall_seconds, report.samples.limit_violations);
}

}  // namespace

std::vector<Figure> bench_scribe(const BenchOptions& options) {
    ScribeOptions scribe;
    scribe.link_options.seed = options.seed;
    const ScribeOutcome outcome = run_scribe(scribe);
    if (outcome.failure || !outcome.report) {
        throw CellError(outcome.failure ? outcome.failure->message : "the job left no traces");
    }
    const Report& report = *outcome.report;
    if (options.raw) {
        const RunFolder folder(options.raw);
        write_text_file(folder.path() / "scribe_crosses.csv", crosses_csv(report.accuracy));
        write_text_file(folder.path() / "scribe_run.csv", run_csv(report, outcome.wall_seconds));
    }
    return {{"max_command_error_um", report.accuracy.max_command_error * 1e6, "um"},
            {"limit_violations", static_cast<double>(report.samples.limit_violations), ""},
            {"cell_seconds", report.run.cell_seconds, "s"},
            {"wall_seconds", outcome.wall_seconds, "s"},
            {"ticks_per_second", static_cast<double>(report.samples.ticks) / outcome.wall_seconds, "1/s"}};
}

}  // namespace sc::host::cli
