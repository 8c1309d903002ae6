// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/stereo_fit.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/board_input.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/file.hpp"
#include "host/vision/triangulation.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kNormal95 = 1.96;
constexpr int kSwappedViews = 3;

void make(const fs::path& folder, int sets, std::uint64_t seed, int swapped) {
    if (run_program(required_program("scribecell-rig"),
                    {"stereo", "--out", folder.string(), "--sets", std::to_string(sets), "--seed", std::to_string(seed),
                     "--swapped-views", std::to_string(swapped)})
            .exit_code != 0) {
        throw CellError("scribecell-rig made no data");
    }
}

StereoFit fit_set(const fs::path& set, bool find_wrong) {
    BoardWords words;
    words.size = "1280x960";
    const BoardInput left = read_boards({(set / "left.csv").string()}, words);
    const BoardInput right = read_boards({(set / "right.csv").string()}, words);
    CameraFitOptions options;
    options.find_wrong = find_wrong;
    return fit_stereo(set / "left.csv", left.views, set / "right.csv", right.views, options);
}

std::array<double, CameraModel::kParameters> values_of(const CameraModel& m) {
    return {m.focal_x,       m.focal_y,       m.middle_x,      m.middle_y,     m.distortion[0],
            m.distortion[1], m.distortion[2], m.distortion[3], m.distortion[4]};
}

struct Score {
    double inside = 0.0;  ///< parameters within 1.96 sigma
    double parameters = 0.0;
    double places_inside = 0.0;  ///< coordinates of places, likewise
    double coordinates = 0.0;
    double squares = 0.0;  ///< of coordinates of places, µm²
    double bounds = 0.0;   ///< likewise
    double seconds = 0.0;
    std::vector<double> rms;
    std::string rows;

    void parameter(double off, double sigma) {
        inside += std::abs(off) <= kNormal95 * sigma ? 1.0 : 0.0;
        parameters += 1.0;
    }
};

void score_cameras(const CsvTable& truth, std::size_t row, const StereoFit& fit, Score& score) {
    const auto number = [&](const std::string& name) { return truth.number(row, truth.column(name)); };
    const std::array<const char*, 2> sides{"_l", "_r"};
    for (std::size_t c = 0; c < 2; ++c) {
        const auto values = values_of(fit.set.cameras[c].model);
        const auto& sigma = c == 0 ? fit.left_sigma : fit.right_sigma;
        for (std::size_t k = 0; k < values.size(); ++k) {
            score.parameter(values[k] - number(std::string(kCameraParameters[k]) + sides[c]), sigma[k]);
        }
    }
    const CameraSet::Pose& pose = *fit.set.right_from_left;
    Mat3 rotation;
    for (std::size_t r = 0; r < 3; ++r) {
        const std::string name = "r" + std::to_string(r + 1);
        rotation.row[r] = {number(name + "1"), number(name + "2"), number(name + "3")};
    }
    // Small: the rotation vector is half of what the difference is not symmetric by.
    const Mat3 turn = pose.rotation * rotation.transposed();
    score.parameter(0.5 * (turn.row[2].y - turn.row[1].z), fit.pose_sigma[0]);
    score.parameter(0.5 * (turn.row[0].z - turn.row[2].x), fit.pose_sigma[1]);
    score.parameter(0.5 * (turn.row[1].x - turn.row[0].y), fit.pose_sigma[2]);
    score.parameter(pose.translation.x - number("x_mm") * 1e-3, fit.pose_sigma[3]);
    score.parameter(pose.translation.y - number("y_mm") * 1e-3, fit.pose_sigma[4]);
    score.parameter(pose.translation.z - number("z_mm") * 1e-3, fit.pose_sigma[5]);
}

/// The sights of a set, triangulated with the cameras that were found, against their true places.
void score_places(const fs::path& set, const StereoFit& fit, const std::map<std::string, Vec3>& places, Score& score) {
    const CsvTable sights = CsvTable::read(set / "sights.csv");
    const double variance = fit.set.noise * fit.set.noise;
    for (std::size_t i = 0; i < sights.size(); ++i) {
        const auto number = [&](const char* name) { return sights.number(i, sights.column(name)); };
        const auto at = triangulate(
            fit.set, {.at = {number("left_u_px"), number("left_v_px")}, .covariance = {variance, 0.0, variance}},
            {.at = {number("right_u_px"), number("right_v_px")}, .covariance = {variance, 0.0, variance}});
        if (!at) {
            throw CellError((set / "sights.csv").string() + ": " + at.error());
        }
        const Vec3 off = at->place - places.at(set.filename().string() + " " + sights.text(i, sights.column("id")));
        const Vec3 sigma = at->sigma();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            score.squares += off[axis] * off[axis] * 1e12;
            score.places_inside += std::abs(off[axis]) <= kNormal95 * sigma[axis] ? 1.0 : 0.0;
            score.coordinates += 1.0;
        }
    }
}

std::map<std::string, Vec3> read_places(const fs::path& folder) {
    const CsvTable csv = CsvTable::read(folder / "places.csv");
    std::map<std::string, Vec3> out;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        out[csv.text(i, csv.column("set")) + " " + csv.text(i, csv.column("id"))] = {
            csv.number(i, csv.column("x_mm")) * 1e-3, csv.number(i, csv.column("y_mm")) * 1e-3,
            csv.number(i, csv.column("z_mm")) * 1e-3};
    }
    return out;
}

Score measure(const fs::path& folder) {
    const CsvTable truth = CsvTable::read(folder / "truth.csv");
    const auto places = read_places(folder);
    Score score;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const fs::path set = folder / truth.text(i, truth.column("set"));
        const auto start = std::chrono::steady_clock::now();
        const StereoFit fit = fit_set(set, false);
        score.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        score.rms.push_back(fit.rms);
        score_cameras(truth, i, fit, score);
        const double before = score.squares;
        score_places(set, fit, places, score);
        const double bound = truth.number(i, truth.column("bound_place_um"));
        score.bounds += 12.0 * bound * bound;
        score.rows += fmt::format("{},{:.6f},{:.4f},{:.4f}\n", set.filename().string(), fit.rms,
                                  std::sqrt((score.squares - before) / 12.0), bound);
    }
    return score;
}

/// Largest rms over OpenCV's on the same files; below 0 where it was not there at build time.
double over_opencv(const fs::path& folder, const Score& score) {
    const auto program = find_program("scribecell-stereo-peer");
    if (!program) {
        std::fprintf(stderr,
                     "stereo_reprojection_over_opencv is left out: OpenCV's calib3d was not there at build time "
                     "(./run bench stereo installs it)\n");
        return -1.0;
    }
    if (run_program(*program, {folder.string()}, ProgramErrors::dropped).exit_code != 0) {
        throw CellError("scribecell-stereo-peer failed");
    }
    const CsvTable csv = CsvTable::read(folder / "opencv.csv");
    if (csv.size() != score.rms.size()) {
        throw CellError("scribecell-stereo-peer left sets out");
    }
    double worst = 0.0;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        worst = std::max(worst, score.rms[i] / csv.number(i, csv.column("rms_px")));
    }
    return worst;
}

/// Share of sets in which just the swapped points are named.
double swaps_named(const fs::path& folder) {
    const CsvTable truth = CsvTable::read(folder / "truth.csv");
    double named = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const StereoFit fit = fit_set(folder / truth.text(i, truth.column("set")), true);
        std::size_t swaps = 0;
        for (const WrongPoint& w : fit.wrong) {
            swaps += w.swapped ? 1U : 0U;
        }
        const std::string& asked = truth.text(i, truth.column("swapped"));
        const auto count = static_cast<std::size_t>(std::ranges::count(asked, ' ')) + 1;
        named += swaps == 2 * count && fit.wrong.size() == swaps ? 100.0 : 0.0;
    }
    return named / static_cast<double>(truth.size());
}

}  // namespace

std::vector<Figure> bench_stereo(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    const fs::path sound = folder.path() / "sound";
    const fs::path swapped = folder.path() / "swapped";
    const int sets = std::max(options.sets / 10, 4);
    make(sound, sets, options.seed * 10, 0);
    make(swapped, std::max(sets / 4, 4), options.seed * 10 + 1, kSwappedViews);
    const Score score = measure(sound);
    if (options.raw) {
        write_text_file(folder.path() / "stereo.csv", "set,rms_px,place_um,bound_um\n" + score.rows);
    }
    const double coverage = 100.0 * score.inside / score.parameters;
    const double places = 100.0 * score.places_inside / score.coordinates;
    std::vector<Figure> out{{"stereo_coverage_pct", coverage, "%"},
                            {"stereo_coverage_most_pct", coverage, "%"},
                            {"stereo_place_coverage_pct", places, "%"},
                            {"stereo_place_over_crlb", std::sqrt(score.squares / score.bounds), ""},
                            {"stereo_swaps_named_pct", swaps_named(swapped), "%"},
                            {"stereo_ms", 1e3 * score.seconds / static_cast<double>(sets), "ms"}};
    const double peer = over_opencv(sound, score);
    if (peer > 0.0) {
        out.push_back({"stereo_reprojection_over_opencv", peer, ""});
    }
    return out;
}

}  // namespace sc::host::cli
