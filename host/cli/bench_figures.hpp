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
    int sets = 1000;                           ///< of each kind: calibration alone
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

/// The galvo's field correction, from a plate burnt in the simulated cell and measured with σ 7.5 µm, judged by the
/// world's own rays over 110 mm and ± 1 mm of depth (scribecell-field-truth). Figures: field_residual_rms_um,
/// field_residual_max_um, the same noise-free, and field_without_depth_max_um: the correction in two dimensions only.
/// Then those of bench_pulses and bench_split. `raw`: the plate's files, pulses.csv (one row a run) and each run's
/// traces.
[[nodiscard]] std::vector<Figure> bench_laser(const BenchOptions& options);

/// What the controller costs on a Cortex-M7, in instructions, and whether its bits are the same everywhere. One job at
/// 4 000 points/s and 200 kHz, ramps, corners and a dense line, run three times: on the board m7 (recorded), on this
/// PC, and as a replay of the recording; and a path of stage and mirrors together (split_*), on the board and on this
/// PC. Figures: servo_instructions_max, tick_instructions_max (marking ticks), split_servo_instructions_max,
/// split_tick_instructions_max,
/// servo_instructions_max_any (all ticks), plan_instructions_per_point (all planning over all points), points_per_s and
/// pulses_per_s of the fastest path, hashes_equal, replay_equal, pc_ticks_per_s. `raw`: the board's cell.json, the
/// recording, and the replay's commands.csv and ticks.csv.
[[nodiscard]] std::vector<Figure> bench_controller(const BenchOptions& options);

/// The triple-laser head on files that scribecell-station makes: 10 heads with errors, each calibrated on its stand and
/// at other angles, 100 seeds each at seven angles. Figures: tests/bench/asked.toml. `raw`: all files but the pictures,
/// and angles.csv, a row a measurement.
[[nodiscard]] std::vector<Figure> bench_measure(const BenchOptions& options);

/// Hand-eye, rigid transforms and turntable axes on files that scribecell-rig makes, `sets` of each kind, against the
/// truth and the Cramér-Rao bound that came with it, and against OpenCV by the program scribecell-hand-eye-peer (its
/// figure is left out, and that said on stderr, where calib3d was not there); then whole cells (bench_chain.hpp) and
/// the centre_* and perspective_* figures of bench_centres, with pictures in proportion to `sets`. *_half_interval is
/// half of the 95 % confidence interval of the figure before it. Figures: tests/bench/asked.toml. `raw`: all files,
/// errors.csv and figures.csv.
[[nodiscard]] std::vector<Figure> bench_calibration(const BenchOptions& options);
/// Pairs of cameras on the boards that scribecell-rig makes, a tenth of `sets` of them: stereo_coverage_pct (parameters
/// within 1.96 of their stated sigma), stereo_place_coverage_pct (triangulated places likewise), stereo_place_over_crlb
/// (rms of a coordinate over its bound, calibration and noise together), stereo_swaps_named_pct (two points swapped in
/// each of three pictures: just these are named), stereo_ms, and stereo_reprojection_over_opencv, the largest rms over
/// OpenCV's, by the program scribecell-stereo-peer. `raw`: all files and stereo.csv.
[[nodiscard]] std::vector<Figure> bench_stereo(const BenchOptions& options);
/// Circular markers on pictures that scribecell-circles renders. Figures: centre_total_mpx (rms of a coordinate of the
/// ellipse's middle, semi-axes 20 and 14 px), centre_bias_mpx (what 50 pictures of a scene have in common, rms over 24
/// scenes), centre_error_over_sigma (rms over the stated 1 sigma), perspective_residue_um (rms of a coordinate of the
/// circle's middle at 45°, radius 5 mm, the plane told by five markers alone), and the same without smoothing, weights
/// and correction. `raw`: pictures, truth, and centres.csv, a row a picture.
[[nodiscard]] std::vector<Figure> bench_centres(const BenchOptions& options);

/// The main job over 20 castings, the worst of each: burnt_95_um, burnt_max_um (each pulse from its true datum plane),
/// missed_pulses, limit_violations, least_burnt_mm; and plain_max_um, without the care that BeamReach takes (5 of
/// them). Some minutes. `raw`: casting.csv, one row a casting.
[[nodiscard]] std::vector<Figure> bench_casting(const BenchOptions& options);

/// The link. By the program scribecell-link-bench, both real ends over mock carriers in virtual time: points/s with 1 %
/// of the frames lost over the carrier's limit (*_share), bytes_per_point, resume_s, and a campaign judged by an oracle
/// that knows only points (campaign_points, lost, doubled, reordered), with its ablations (go_back_n_share,
/// no_index_check_wrong). Then 200 runs of a short job whose host is killed at a random moment and started again with
/// --resume, against the undisturbed run's pulse trace (kill_*), and 20 losses of power (power_*). Some minutes. `raw`:
/// resume.csv, one row a run.
[[nodiscard]] std::vector<Figure> bench_link(const BenchOptions& options);

/// Both sensor buses against what their lines can carry, by the program scribecell-sensor-bench. Figures: y_bus_share,
/// triple_bus_share, the readings a second behind them, and both shares with a board that hands bytes over once a
/// telegram has ended (the ablation).
[[nodiscard]] std::vector<Figure> bench_sensors(const BenchOptions& options);

/// The drive bus, by the program scribecell-bus-bench: budget_error_pct, the worst difference of the computed share and
/// the one of frames counted in running drives (set up and enabled by the drive master's own code); each case's cyclic
/// share (*_computed) and what was counted (*_counted, heartbeats included); whether a frame longer than the bound was
/// found, and how near to it the longest came. `raw`: bus.json, with the length that the frames really had.
[[nodiscard]] std::vector<Figure> bench_bus(const BenchOptions& options);

/// Inspection of the casting in tests/data/casting-blank beside its peers, by the program scribecell-allowance-bench:
/// speed against Embree, exactness against every triangle, signs against CGAL, fit, borrowing, published examples.
/// Figures of a peer that was not there are left out, and said on stderr. `raw`: allowance.json with the absolute
/// speeds.
[[nodiscard]] std::vector<Figure> bench_allowance(const BenchOptions& options);

}  // namespace sc::host::cli
