// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/run_folder.hpp"
#include "host/cli/stand_pictures.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/file.hpp"
#include "host/measurement/reference_fit.hpp"
#include "host/vision/spot.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kHeads = 10;
constexpr int kRepeats = 100;  ///< 1000 seeds in all, seven angles each
constexpr int kReseatedHeads = 3;
constexpr double kSeatDeg = 0.03;
constexpr double kSeatMm = 0.05;
constexpr int kSpots = 300;
constexpr int kShifts = 20;        ///< a real picture
constexpr double kBlack = 0.04;    ///< of full scale
constexpr double kCropRoom = 3.6;  ///< radii left around a spot at least

void make(const std::vector<std::string>& arguments) {
    if (stop_requested()) {
        throw Interrupted();
    }
    if (run_program(required_program("scribecell-station"), arguments).exit_code != 0) {
        throw CellError("scribecell-station made no data");
    }
}

/// Errors of the angle of one way to measure, degrees.
struct Errors {
    std::vector<double> all;
    std::vector<double> over_sigma;

    void add(const StationResult& result, double truth_deg) {
        const double error = result.angle / kDegree - truth_deg;
        all.push_back(std::abs(error));
        over_sigma.push_back(std::abs(error) * kDegree / result.angle_sigma.total());
    }
    [[nodiscard]] double most() const { return *std::max_element(all.begin(), all.end()); }
    [[nodiscard]] double part95() const {
        std::vector<double> sorted = all;
        std::sort(sorted.begin(), sorted.end());
        return sorted[static_cast<std::size_t>(0.95 * static_cast<double>(sorted.size()))];
    }
    [[nodiscard]] double coverage() const {
        const auto within =
            std::count_if(over_sigma.begin(), over_sigma.end(), [](double z) { return z <= kCoverage95; });
        return 100.0 * static_cast<double>(within) / static_cast<double>(over_sigma.size());
    }
};

using Truth = std::map<std::string, double>;

Truth read_truth(const fs::path& file) {
    const CsvTable csv = CsvTable::read(file);
    Truth out;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        out[csv.text(row, csv.column("station"))] = csv.number(row, csv.column("angle_deg"));
    }
    return out;
}

void measure_all(const TripleRecord& head, const StationFile& stations, const Truth& truth,
                 const StationOptions& options, Errors& errors) {
    for (const Station& station : stations.stations) {
        const auto result = measure_station(head, station, options);
        if (!result) {
            throw CellError("station " + station.id + " is refused: " + result.error().text);
        }
        errors.add(*result, truth.at(station.id));
    }
}

struct Ways {
    Errors median;
    Errors best;
    Errors drawn;
    Errors no_gain;
    Errors no_tilt;
    Errors no_spots;
    Errors no_reference;
    Errors reseated;
    Errors seat_ignored;
};

TripleRecord calibrated(const fs::path& folder, const Stand& stand, const std::vector<PlatePixels>& pixels,
                        const ParallelismParts& parts, bool reference) {
    const Parallelism parallelism = fit_parallelism(stand, pixels, readings_of(stand), parts);
    if (!reference) {
        return parallelism.head;
    }
    const bool whole = parts.gain && parts.tilt && parts.spots;
    return fit_reference(parallelism.head, read_stations(folder / "known_readings.csv"),
                         read_known(folder / "known.csv"), {}, whole)
        .head;
}

void bench_head(const fs::path& folder, std::uint64_t seed, Ways& ways) {
    make({"head", "--out", folder.string(), "--seed", std::to_string(seed), "--repeats", std::to_string(kRepeats)});
    const Stand stand = read_stand(folder / "stand.toml");
    const std::vector<PlatePixels> pixels = pixels_of(stand);
    const StationFile stations = read_stations(folder / "stations.csv");
    const Truth truth = read_truth(folder / "truth.csv");
    const TripleRecord whole = calibrated(folder, stand, pixels, {}, true);
    StationOptions by_median;
    by_median.estimator = Estimator::median;
    measure_all(whole, stations, truth, by_median, ways.median);
    measure_all(whole, stations, truth, {}, ways.best);
    measure_all(drawn_head_of(stand), stations, truth, by_median, ways.drawn);
    const auto without = [&](const ParallelismParts& parts, bool reference, Errors& errors) {
        measure_all(calibrated(folder, stand, pixels, parts, reference), stations, truth, by_median, errors);
    };
    without({.gain = false}, true, ways.no_gain);
    without({.tilt = false}, true, ways.no_tilt);
    without({.spots = false}, true, ways.no_spots);
    without({}, false, ways.no_reference);
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() == ".pgm") {
            fs::remove(entry.path());
        }
    }
}

void bench_reseated(const fs::path& folder, std::uint64_t seed, Ways& ways) {
    make({"head", "--out", folder.string(), "--seed", std::to_string(seed), "--repeats", std::to_string(kRepeats),
          "--seat-deg", std::to_string(kSeatDeg), "--seat-mm", std::to_string(kSeatMm)});
    const Stand stand = read_stand(folder / "stand.toml");
    const TripleRecord head = calibrated(folder, stand, pixels_of(stand), {}, true);
    const StationFile stations = read_stations(folder / "stations.csv");
    const Truth truth = read_truth(folder / "truth.csv");
    StationOptions options;
    measure_all(head, stations, truth, options, ways.seat_ignored);
    options.seat = {.angle = kSeatDeg * kDegree, .place = kSeatMm * 1e-3};
    measure_all(head, stations, truth, options, ways.reseated);
}

double rendered_rms(const fs::path& folder, std::uint64_t seed) {
    make({"spots", "--out", folder.string(), "--count", std::to_string(kSpots), "--seed", std::to_string(seed)});
    const CsvTable truth = CsvTable::read(folder / "truth.csv");
    double squares = 0.0;
    for (std::size_t row = 0; row < truth.size(); ++row) {
        const fs::path picture = folder / truth.text(row, truth.column("picture"));
        const auto spot = find_spot(read_image(picture));
        if (!spot) {
            throw CellError(picture.string() + " is refused: " + spot.error().text);
        }
        squares += std::pow(spot->x - truth.number(row, truth.column("x_px")), 2) +
                   std::pow(spot->y - truth.number(row, truth.column("y_px")), 2);
        fs::remove(picture);
    }
    return std::sqrt(squares / static_cast<double>(truth.size()));
}

/// How far the centre of a real beam moves, px, in a part of its picture with noise of 1 % of full scale.
double moved(const GreyImage& image, const Spot& spot, std::mt19937_64& random) {
    const double room = kCropRoom * spot.radius;
    const auto draw = [&](double least, double most) {
        return static_cast<int>(
            std::lround(std::uniform_real_distribution<double>(least, std::max(least, most))(random)));
    };
    const int left = draw(0.0, spot.x - room);
    const int top = draw(0.0, spot.y - room);
    const int right = draw(std::min(spot.x + room, image.width - 1.0), image.width - 1.0);
    const int bottom = draw(std::min(spot.y + room, image.height - 1.0), image.height - 1.0);
    GreyImage part;
    part.width = right - left + 1;
    part.height = bottom - top + 1;
    part.full_scale = image.full_scale;
    std::normal_distribution<double> normal(0.0, 0.01 * image.full_scale);
    for (int row = top; row <= bottom; ++row) {
        for (int column = left; column <= right; ++column) {
            // A camera has a black level, so that its noise is not cut off in the dark.
            const double value = kBlack * image.full_scale +
                                 (1.0 - kBlack) * static_cast<double>(image.at(column, row)) + normal(random);
            part.pixel.push_back(
                static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, static_cast<double>(image.full_scale)))));
        }
    }
    const auto found = find_spot(part);
    if (!found) {
        throw CellError("a cropped picture is refused: " + found.error().text);
    }
    return std::hypot(found->x + left - spot.x, found->y + top - spot.y);
}

/// The largest of these over all real pictures.
double real_shift(std::uint64_t seed) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError(
            "tests/data/laser-spots is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    std::mt19937_64 random(seed);
    double most = 0.0;
    for (const char* name : {"k-200mm", "k-400mm", "t-210mm", "t-480mm", "TEM00_140mm"}) {
        const GreyImage image = read_image(*root / "tests/data/laser-spots" / (std::string(name) + ".png"));
        const auto whole = find_spot(image);
        if (!whole) {
            throw CellError(std::string(name) + " is refused: " + whole.error().text);
        }
        for (int k = 0; k < kShifts; ++k) {
            most = std::max(most, moved(image, *whole, random));
        }
    }
    return most;
}

}  // namespace

std::vector<Figure> bench_measure(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    Ways ways;
    for (int head = 0; head < kHeads; ++head) {
        std::fprintf(stderr, "head %d of %d\n", head + 1, kHeads + kReseatedHeads);
        bench_head(folder.path() / fmt::format("head_{}", head + 1),
                   options.seed * 1000 + static_cast<std::uint64_t>(head), ways);
    }
    for (int head = 0; head < kReseatedHeads; ++head) {
        std::fprintf(stderr, "head %d of %d, put down again for each station\n", kHeads + head + 1,
                     kHeads + kReseatedHeads);
        bench_reseated(folder.path() / fmt::format("reseated_{}", head + 1),
                       options.seed * 1000 + 500 + static_cast<std::uint64_t>(head), ways);
    }
    std::fprintf(stderr, "pictures\n");
    const double rendered = rendered_rms(folder.path() / "spots", options.seed);
    const double shift = real_shift(options.seed);
    if (options.raw) {
        std::string rows = "trial,error_median_deg,error_best_deg,error_drawn_deg,error_over_sigma\n";
        for (std::size_t i = 0; i < ways.median.all.size(); ++i) {
            rows += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.4f}\n", i + 1, ways.median.all[i], ways.best.all[i],
                                ways.drawn.all[i], ways.best.over_sigma[i]);
        }
        write_text_file(folder.path() / "angles.csv", rows);
    }
    const double coverage = ways.best.coverage();
    return {{"angle_95_deg", ways.median.part95(), "deg"},
            {"angle_max_deg", ways.median.most(), "deg"},
            {"angle_95_best_deg", ways.best.part95(), "deg"},
            {"angle_max_best_deg", ways.best.most(), "deg"},
            {"angle_uncalibrated_max_deg", ways.drawn.most(), "deg"},
            {"coverage_pct", coverage, "%"},
            {"coverage_over_pct", coverage, "%"},
            {"coverage_reseated_pct", ways.reseated.coverage(), "%"},
            {"coverage_seat_ignored_pct", ways.seat_ignored.coverage(), "%"},
            {"without_gain_max_deg", ways.no_gain.most(), "deg"},
            {"without_tilt_max_deg", ways.no_tilt.most(), "deg"},
            {"without_spots_max_deg", ways.no_spots.most(), "deg"},
            {"without_reference_max_deg", ways.no_reference.most(), "deg"},
            {"trials", static_cast<double>(ways.median.all.size()), ""},
            {"spot_rendered_rms_px", rendered, "px"},
            {"spot_real_shift_px", shift, "px"}};
}

}  // namespace sc::host::cli
