// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
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
#include "host/cli/bench_figures.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/file.hpp"
#include "host/vision/circle_pose.hpp"
#include "host/vision/marker.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kScenes = 24;
constexpr int kRepeats = 50;
constexpr int kSets = 1000;  ///< of a bench: with fewer, there are fewer repeats
constexpr int kBoards = 12;
constexpr int kBoardRepeats = 10;
constexpr double kPlaneMmPx = 500.0 / 2232.0;  ///< at the distance of the boards, square to the view
constexpr double kMostOffPx = 3.0;             ///< a marker that is further off is another one

void make(const char* kind, const fs::path& folder, int scenes, int repeats, std::uint64_t seed) {
    if (run_program(required_program("scribecell-circles"),
                    {kind, "--out", folder.string(), "--scenes", std::to_string(scenes), "--repeats",
                     std::to_string(repeats), "--seed", std::to_string(seed)})
            .exit_code != 0) {
        throw CellError("scribecell-circles made no pictures");
    }
}

using Place = std::array<double, 2>;

struct TruePlaces {
    int scene = 0;
    std::vector<Place> ellipses;
    std::vector<Place> centres;
};

std::map<std::string, TruePlaces> read_truth(const fs::path& folder) {
    const CsvTable csv = CsvTable::read(folder / "truth.csv");
    std::map<std::string, TruePlaces> out;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        TruePlaces& places = out[csv.text(row, csv.column("picture"))];
        places.scene = csv.integer(row, csv.column("scene"));
        places.ellipses.push_back(
            {csv.number(row, csv.column("ellipse_x_px")), csv.number(row, csv.column("ellipse_y_px"))});
        places.centres.push_back(
            {csv.number(row, csv.column("centre_x_px")), csv.number(row, csv.column("centre_y_px"))});
    }
    return out;
}

Pinhole read_camera(const fs::path& folder) {
    const CsvTable csv = CsvTable::read(folder / "camera.csv");
    const double focal = csv.number(0, csv.column("focal_px"));
    return {.focal_x = focal,
            .focal_y = focal,
            .middle_x = csv.number(0, csv.column("middle_x_px")),
            .middle_y = csv.number(0, csv.column("middle_y_px"))};
}

std::vector<Marker> markers_of(const fs::path& picture, std::size_t count) {
    const MarkersFound found = find_markers(read_image(picture));
    if (found.markers.size() != count) {
        throw CellError(fmt::format("{}: {} markers are found, there are {}{}", picture.string(), found.markers.size(),
                                    count, found.refused.empty() ? "" : "; " + found.refused.front().text));
    }
    return found.markers;
}

std::size_t nearest(const std::vector<Place>& places, double x, double y) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < places.size(); ++k) {
        if (std::hypot(places[k][0] - x, places[k][1] - y) < std::hypot(places[best][0] - x, places[best][1] - y)) {
            best = k;
        }
    }
    if (!(std::hypot(places[best][0] - x, places[best][1] - y) < kMostOffPx)) {
        throw CellError(fmt::format("there is no marker at ({:.2f}, {:.2f})", x, y));
    }
    return best;
}

/// Errors of the middles of ellipses, over pictures and scenes.
struct Singles {
    double squares = 0.0;
    double squares_over_sigma = 0.0;
    double count = 0.0;
    int refused = 0;
    std::map<int, std::array<double, 3>> by_scene;  ///< sums of x and y, and how many
    std::string rows;

    /// A pixel where no picture gives a centre, as an ablation may.
    [[nodiscard]] double total_mpx() const { return count > 0.0 ? 1e3 * std::sqrt(0.5 * squares / count) : 1e3; }
    [[nodiscard]] double over_sigma() const { return std::sqrt(0.5 * squares_over_sigma / count); }
    /// Rms over the scenes of what their repeats have in common; what is left of the noise is in it.
    [[nodiscard]] double bias_mpx() const {
        double sum = 0.0;
        for (const auto& [scene, s] : by_scene) {
            sum += (s[0] * s[0] + s[1] * s[1]) / (s[2] * s[2]);
        }
        return 1e3 * std::sqrt(0.5 * sum / static_cast<double>(by_scene.size()));
    }
};

Singles measure_singles(const fs::path& folder, const MarkerSettings& settings) {
    Singles out;
    for (const auto& [picture, places] : read_truth(folder)) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const MarkersFound found = find_markers(read_image(folder / picture), settings);
        if (found.markers.size() != 1) {
            ++out.refused;
            continue;
        }
        const Marker& marker = found.markers.front();
        const double dx = marker.ellipse.x - places.ellipses.front()[0];
        const double dy = marker.ellipse.y - places.ellipses.front()[1];
        out.squares += dx * dx + dy * dy;
        out.squares_over_sigma += dx * dx / marker.covariance[0] + dy * dy / marker.covariance[2];
        out.count += 1.0;
        auto& scene = out.by_scene[places.scene];
        scene[0] += dx;
        scene[1] += dy;
        scene[2] += 1.0;
        out.rows += fmt::format("{},{:.6f},{:.6f},{:.6f}\n", picture, dx, dy, marker.sigma);
    }
    return out;
}

struct Boards {
    double corrected_um = 0.0;
    double uncorrected_um = 0.0;
};

Boards measure_boards(const fs::path& folder) {
    const Pinhole camera = read_camera(folder);
    double with = 0.0;
    double without = 0.0;
    double count = 0.0;
    for (const auto& [picture, places] : read_truth(folder)) {
        if (stop_requested()) {
            throw Interrupted();
        }
        std::vector<Ellipse> ellipses;
        for (const Marker& marker : markers_of(folder / picture, places.centres.size())) {
            ellipses.push_back(marker.ellipse);
        }
        const auto normal = common_normal(ellipses, camera);
        if (!normal) {
            throw CellError((folder / picture).string() + ": " + normal.error());
        }
        for (const Ellipse& e : ellipses) {
            const Place& truth = places.centres[nearest(places.centres, e.x, e.y)];
            const auto centre = circle_centre(e, camera, *normal);
            with += std::pow(centre[0] - truth[0], 2) + std::pow(centre[1] - truth[1], 2);
            without += std::pow(e.x - truth[0], 2) + std::pow(e.y - truth[1], 2);
            count += 1.0;
        }
    }
    return {.corrected_um = 1e3 * kPlaneMmPx * std::sqrt(0.5 * with / count),
            .uncorrected_um = 1e3 * kPlaneMmPx * std::sqrt(0.5 * without / count)};
}

}  // namespace

std::vector<Figure> bench_centres(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    const fs::path singles = folder.path() / "singles";
    const fs::path boards = folder.path() / "boards";
    std::fprintf(stderr, "rendering\n");
    const auto share = [&options](int most) { return std::clamp(options.sets * most / kSets, 3, most); };
    make("singles", singles, kScenes, share(kRepeats), options.seed * 1000);
    make("boards", boards, kBoards, share(kBoardRepeats), options.seed * 1000 + 1);
    std::fprintf(stderr, "measuring\n");
    const Singles best = measure_singles(singles, {});
    const Singles raw_gradients = measure_singles(singles, {.smoothing_px = 0.0});
    const Singles unweighted = measure_singles(singles, {.weight_power = 0.0});
    const Boards board = measure_boards(boards);
    if (options.raw) {
        write_text_file(folder.path() / "centres.csv", "picture,error_x_px,error_y_px,sigma_px\n" + best.rows);
    }
    return {{"centre_total_mpx", best.total_mpx(), "mpx"},
            {"centre_bias_mpx", best.bias_mpx(), "mpx"},
            {"centre_error_over_sigma", best.over_sigma(), ""},
            {"centre_error_over_sigma_least", best.over_sigma(), ""},
            {"perspective_residue_um", board.corrected_um, "um"},
            {"without_smoothing_mpx", raw_gradients.total_mpx(), "mpx"},
            {"without_weights_mpx", unweighted.total_mpx(), "mpx"},
            {"without_perspective_um", board.uncorrected_um, "um"},
            {"pictures", best.count, ""},
            {"pictures_refused", static_cast<double>(best.refused), ""}};
}

}  // namespace sc::host::cli
