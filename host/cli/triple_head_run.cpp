// SPDX-License-Identifier: Apache-2.0
#include "host/cli/triple_head_run.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/cli/all_steps.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/jog_session.hpp"
#include "host/cli/pointing_run.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::host::cli {
namespace {

constexpr int kSamples = 16;
constexpr std::size_t kSensors = 3;
constexpr std::array kSwing{-15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0};  ///< degrees about square
constexpr const char* kHeader = "sensor,facet,c_deg,reading_mm,sigma_mm\n";

struct Stand {
    int facet = 0;
    double c_deg = 0.0;
};

std::vector<Stand> read_angles(const std::filesystem::path& file) {
    const CsvTable csv = CsvTable::read(file);
    std::vector<Stand> out;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        out.push_back({csv.integer(i, csv.column("facet")), csv.number(i, csv.column("c_deg"))});
    }
    return out;
}

Vec3 looking(double looks_deg) {
    const double a = looks_deg * std::numbers::pi / 180.0;
    return {std::cos(a), std::sin(a), 0.0};
}

/// Where each face's normal points against the beams, and some degrees to both sides.
std::vector<Stand> stands_of(const KnownFaces& faces, double looks_deg) {
    std::vector<Stand> out;
    const Vec3 back = -1.0 * looking(looks_deg);
    for (const int facet : faces.facets()) {
        const Vec3 out_of_axis = faces.middle(facet, 0.0) - faces.middle(facet, 180.0);
        if (!(norm(out_of_axis) > 1e-6)) {
            throw InputError({.file = {},
                              .problem = "a face does not turn with the table",
                              .value = std::to_string(facet),
                              .action = "give the column c_deg, the table's angle when the face was measured"});
        }
        const KnownPlane plane = faces.plane(facet, 0.0, out_of_axis);
        const double at = std::atan2(plane.normal.y, plane.normal.x);
        const double turn = (std::atan2(back.y, back.x) - at) * 180.0 / std::numbers::pi;
        for (const double swing : kSwing) {
            out.push_back({facet, std::remainder(std::round(turn) + swing, 360.0)});
        }
    }
    std::ranges::sort(out, {}, &Stand::c_deg);
    return out;
}

std::string rows_of(const Stand& stand, JogMoves& moves) {
    std::string text;
    for (std::size_t sensor = 0; sensor < kSensors; ++sensor) {
        const auto distance = moves.distance(kFirstTriple + sensor, kSamples);
        if (!distance) {
            throw CellError(fmt::format("distance sensor {} of the triple head gives no value over facet {} at C = {}",
                                        sensor + 1, stand.facet, stand.c_deg));
        }
        text += fmt::format("{},{},{:.6f},{:.6f},{:.6f}\n", sensor + 1, stand.facet, moves.reading()[3],
                            distance->mean * 1e3, distance->sigma * 1e3);
    }
    return text;
}

/// The scan alone: readings.csv in `out`.
void scan(const TripleHeadOptions& options, const std::vector<Stand>& stands,
          const std::optional<std::filesystem::path>& world) {
    const std::filesystem::path file = options.out / "readings.csv";
    std::string text = std::filesystem::exists(file) ? read_text_file(file) : kHeader;
    const std::size_t done = std::filesystem::exists(file) ? CsvTable::parse(file, text).size() / kSensors : 0;
    if (done >= stands.size()) {
        return;
    }
    JogSession session({.link = options.link, .world = world, .seed = options.seed, .key = options.key});
    session.run([&](JogMoves& moves) {
        for (std::size_t i = done; i < stands.size(); ++i) {
            moves.turn_to(stands[i].c_deg);
            text += rows_of(stands[i], moves);
            write_text_file(file, text);
        }
    });
}

/// The faces of --points, read now or before.
TripleHeadFit fit_given_faces(const TripleHeadOptions& options, const CalibrationSet& set) {
    const KnownFaces faces(set, *options.points);
    if (!options.readings) {
        scan(options, options.angles ? read_angles(*options.angles) : stands_of(faces, options.looks_deg),
             std::nullopt);
    }
    return fit_triple_head(faces, options.readings.value_or(options.out / "readings.csv"), options.looks_deg,
                           options.accuracy_um * 1e-6);
}

}  // namespace

TripleHeadFit fit_triple_head(const KnownFaces& faces, const std::filesystem::path& readings, double looks_deg,
                              double accuracy) {
    const CsvTable csv = CsvTable::read(readings);
    const Vec3 along = looking(looks_deg);
    const bool by_x = std::abs(along.x) > std::abs(along.y);
    std::array<std::vector<RangeReading>, kSensors> list;
    std::array<std::vector<KnownPlane>, kSensors> planes;
    std::array<double, kSensors> anchor{};
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const int sensor = csv.integer(i, csv.column("sensor"));
        if (sensor < 1 || sensor > static_cast<int>(kSensors)) {
            throw InputError({.file = readings.string(),
                              .line = csv.line(i),
                              .problem = "the triple head has the sensors 1, 2 and 3",
                              .value = std::to_string(sensor),
                              .action = "number them so"});
        }
        const auto at = static_cast<std::size_t>(sensor) - 1;
        const int facet = csv.integer(i, csv.column("facet"));
        const double c_deg = csv.number(i, csv.column("c_deg"));
        KnownPlane plane = faces.plane(facet, c_deg, -1.0 * along);
        plane.id = static_cast<int>(planes[at].size());
        const Vec3 middle = faces.middle(facet, c_deg);
        anchor[at] += by_x ? middle.x : middle.y;
        planes[at].push_back(plane);
        list[at].push_back({.plane = plane.id,
                            .carrier = {},
                            .reading = csv.number(i, csv.column("reading_mm")) * 1e-3,
                            .sigma = std::max(csv.number(i, csv.column("sigma_mm")) * 1e-3, 1e-6),
                            .line = csv.line(i),
                            .group = facet,
                            .common = accuracy});
    }
    TripleHeadFit out;
    for (std::size_t k = 0; k < kSensors; ++k) {
        SensorRayOptions options;
        options.along = along;
        options.most_origin = 1e-3;
        const double middle = list[k].empty() ? 0.0 : anchor[k] / static_cast<double>(list[k].size());
        out.rays[k] = fit_sensor_ray(readings, planes[k], list[k], std::round(middle * 1e3) * 1e-3, options);
    }
    return out;
}

void put_triple_head(CalibrationSet& set, const TripleHeadFit& fit, const std::string& time) {
    set.triple_head.clear();
    for (std::size_t k = 0; k < kSensors; ++k) {
        const SensorRayFit& ray = fit.rays[k];
        set.triple_head.push_back(
            {.id = fmt::format("triple{}", k + 1),
             .origin = {ray.origin},
             .direction = {ray.direction},
             .zero = ray.zero,
             .sigma = ray.sigma,
             .provenance = {.parents = {"h_from_c", "turntable", "readings.csv"},
                            .residual_rms = ray.rms,
                            .time = time,
                            .note = fmt::format("{} readings, {} left out", ray.readings, ray.wrong.size())}});
    }
}

TripleHeadFit scan_simulated_sides(const TripleHeadOptions& options, const CalibrationSet& set,
                                   const std::filesystem::path& cell) {
    const std::filesystem::path sides = options.out / "sides";
    survey({"sides", "--world", in_project("boards/sim/world/default/world.toml").string(), "--out", sides.string(),
            "--seed", std::to_string(options.seed), "--sigma-um", fmt::format("{}", options.sigma_um)});
    const Stitch placed = stitch_folders({cell / "plate/seen", cell / "table/ring", sides});
    const KnownFaces faces(set, sides / "points.csv",
                           [&placed](const std::string& view) { return placed.of("sides/" + view); });
    scan(options, stands_of(faces, options.looks_deg), sides / "world.toml");
    return fit_triple_head(faces, options.out / "readings.csv", options.looks_deg, options.accuracy_um * 1e-6);
}

TripleHeadOutcome run_triple_head(const TripleHeadOptions& options) {
    make_folder(options.out);
    const bool simulated = is_simulated(options.link);
    if (!options.points && !(simulated && options.cell && !options.readings)) {
        throw InputError({.file = {},
                          .problem = "which faces stand on the table is not said",
                          .value = options.link,
                          .action = "give --points; the simulated cell takes --cell, the folder of `scribecell "
                                    "calibrate all`"});
    }
    if (!options.calibration && !options.cell) {
        throw InputError({.file = {},
                          .problem = "faces in c need h_from_c and the turntable's axis",
                          .value = "no --calibration",
                          .action = "give the set that has them"});
    }
    const CalibrationSet set =
        read_calibration(options.calibration.value_or(options.cell.value_or(".") / "calibration.toml"));
    const TripleHeadFit fit =
        options.points ? fit_given_faces(options, set) : scan_simulated_sides(options, set, *options.cell);
    CalibrationSet with = set;
    with.parents = {set.id};
    with.id += "+triple-head";
    with.time = now_text();
    put_triple_head(with, fit, with.time);
    const std::filesystem::path file = options.out / "calibration.toml";
    static_cast<void>(write_calibration(file, with));
    return {.fit = fit, .set = with, .files = file.string()};
}

}  // namespace sc::host::cli
