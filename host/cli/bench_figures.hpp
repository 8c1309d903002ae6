// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sc::host::cli {

/// One measured figure; what is asked of it stands in tests/bench/asked.toml.
struct Figure {
    std::string name;
    double value = 0.0;
    std::string unit;
};

struct BenchOptions {
    std::uint64_t seed = 1;
    std::optional<std::filesystem::path> raw;  ///< folder for the CSV of all trials
};

/// A benchmark by name. It throws what its work throws.
struct Bench {
    const char* name;
    const char* what;
    std::vector<Figure> (*run)(const BenchOptions& options);
};

/// The main job on the simulated cell. Figures: max_command_error_um, limit_violations, cell_seconds, wall_seconds,
/// ticks_per_second. `raw`: scribe_crosses.csv, one row a cross, from whose places max_command_error_um follows, and
/// scribe_run.csv with ticks, times and violations.
[[nodiscard]] std::vector<Figure> bench_scribe(const BenchOptions& options);

/// The trajectory planner on the workloads of tests/data/motion, by the program scribecell-motion-bench. Figures:
/// a_dense_s, b_corners_s, c_mixed_s, max_limit_ratio, max_deviation_um, plan_us_per_point, worst_insert_us,
/// horizon_256_ratio.
[[nodiscard]] std::vector<Figure> bench_motion(const BenchOptions& options);

/// One polyline instead of the workloads; texts as the program takes them.
struct MotionFile {
    std::string input;
    std::string limits;
    std::string tolerance;
};
/// Becomes scribecell-motion-bench; returns only by throwing.
int bench_motion_file(const MotionFile& file, bool json);

}  // namespace sc::host::cli
