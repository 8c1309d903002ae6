// SPDX-License-Identifier: Apache-2.0
#include "host/cli/y_sensor_run.hpp"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/cli/all_steps.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/jog_session.hpp"
#include "host/cli/known_faces.hpp"
#include "host/cli/pointing_run.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

constexpr int kSamples = 8;
constexpr double kStep = 0.012;                     ///< metres, between places on a face
constexpr std::array kHeights{-0.016, 0.0, 0.016};  ///< metres, of the head
constexpr const char* kHeader = "facet,x_mm,y_mm,z_mm,reading_mm,sigma_mm\n";

struct Place {
    int facet = 0;
    Vec3 place;
};

std::vector<Place> read_places(const std::filesystem::path& file) {
    const CsvTable csv = CsvTable::read(file);
    std::vector<Place> out;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const auto mm = [&](const char* name) { return csv.number(i, csv.column(name)) * 1e-3; };
        out.push_back({csv.integer(i, csv.column("facet")), {mm("x_mm"), mm("y_mm"), mm("z_mm")}});
    }
    return out;
}

/// All faces; those that turn with the table where they stand at C = 0.
std::vector<KnownPlane> planes_of(const CalibrationSet& set, const std::filesystem::path& file,
                                  const Rigid<frame::C, frame::C>& c_from_points) {
    const KnownFaces faces(set, file, [&c_from_points](const std::string&) { return c_from_points; });
    std::vector<KnownPlane> out;
    for (const int facet : faces.facets()) {
        out.push_back(faces.plane(facet, 0.0, {0.0, 1.0, 0.0}));
    }
    return out;
}

}  // namespace

SensorRayFit fit_y_sensor(const CalibrationSet& set, const std::filesystem::path& points,
                          const std::filesystem::path& readings, const Rigid<frame::C, frame::C>& c_from_points) {
    const CsvTable csv = CsvTable::read(readings);
    std::vector<RangeReading> list;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const auto mm = [&](const char* name) { return csv.number(i, csv.column(name)) * 1e-3; };
        RangeReading r;
        r.plane = csv.integer(i, csv.column("facet"));
        r.carrier = focus_of(set, {mm("x_mm"), mm("y_mm"), mm("z_mm")});
        r.reading = mm("reading_mm");
        r.sigma = std::max(mm("sigma_mm"), 1e-6);
        r.line = csv.line(i);
        list.push_back(r);
    }
    return fit_sensor_ray(readings, planes_of(set, points, c_from_points), list, 0.0);
}

void scan_roof(const YSensorOptions& options, const std::filesystem::path& roughly,
               const std::optional<std::filesystem::path>& world) {
    const std::filesystem::path file = options.out / "readings.csv";
    std::string text = std::filesystem::exists(file) ? read_text_file(file) : kHeader;
    const std::size_t done = std::filesystem::exists(file) ? CsvTable::parse(file, text).size() : 0;
    JogSession session({.link = options.link, .world = world, .seed = options.seed, .key = options.key});
    session.run([&](JogMoves& moves) {
        std::size_t number = 0;
        for (const Place& facet : read_places(roughly)) {
            if (options.only_facet != 0 && facet.facet != options.only_facet) {
                continue;
            }
            for (const double height : kHeights) {
                for (const auto& [dx, dz] : {std::pair{-kStep, -kStep}, std::pair{kStep, -kStep}, std::pair{0.0, 0.0},
                                             std::pair{kStep, kStep}, std::pair{-kStep, kStep}}) {
                    if (number++ < done) {
                        continue;
                    }
                    moves.to(
                        {facet.place.x + dx - options.beside_mm * 1e-3, facet.place.y + height, facet.place.z + dz});
                    const auto distance = moves.distance(0, kSamples);
                    if (!distance) {
                        throw CellError(fmt::format("the Y sensor gives no distance over facet {}", facet.facet));
                    }
                    const Vec3 at = 1e3 * moves.place();
                    text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f}\n", facet.facet, at.x, at.y, at.z,
                                        distance->mean * 1e3, distance->sigma * 1e3);
                    write_text_file(file, text);
                }
            }
        }
    });
}

SensorRayFit scan_simulated_roof(const YSensorOptions& options, const CalibrationSet& set,
                                 const std::filesystem::path& cell) {
    const std::filesystem::path roof = options.out / "roof";
    survey({"roof", "--world", in_project("boards/sim/world/default/world.toml").string(), "--out", roof.string(),
            "--seed", std::to_string(options.seed), "--sigma-um", fmt::format("{}", options.sigma_um)});
    scan_roof(options, roof / "roughly.csv", roof / "world.toml");
    const Stitch placed = stitch_folders({cell / "plate/seen", cell / "table/ring", roof});
    return fit_y_sensor(set, roof / "points.csv", options.out / "readings.csv", placed.of("roof/roof"));
}

SensorRay y_sensor_record(const SensorRayFit& fit, const std::string& time) {
    return {.id = "y1",
            .origin = {fit.origin},
            .direction = {fit.direction},
            .zero = fit.zero,
            .sigma = fit.sigma,
            .provenance = {.parents = {"h_from_c", "axes", "readings.csv"},
                           .residual_rms = fit.rms,
                           .time = time,
                           .note = fmt::format("{} readings, {} left out", fit.readings, fit.wrong.size())}};
}

YSensorOutcome run_y_sensor(const YSensorOptions& options) {
    make_folder(options.out);
    const bool simulated = is_simulated(options.link);
    if (!options.points && !(simulated && options.cell && !options.readings)) {
        throw InputError({.file = {},
                          .problem = "which planes stand before the head is not said",
                          .value = options.link,
                          .action = "give --points with --roughly or --readings; the simulated cell takes --cell, the "
                                    "folder of `scribecell calibrate all`"});
    }
    if (options.points && !options.roughly && !options.readings) {
        throw InputError({.file = {},
                          .problem = "where the faces are for the head is not said",
                          .value = "--points",
                          .action = "give --roughly, or --readings of a scan that was made before"});
    }
    if (!options.calibration && !options.cell) {
        throw InputError({.file = {},
                          .problem = "points in c need h_from_c",
                          .value = "no --calibration",
                          .action = "give the set that has it"});
    }
    const CalibrationSet set =
        read_calibration(options.calibration.value_or(options.cell.value_or(".") / "calibration.toml"));
    YSensorOutcome out;
    const std::filesystem::path readings = options.readings.value_or(options.out / "readings.csv");
    if (options.points) {
        if (!options.readings) {
            scan_roof(options, *options.roughly, std::nullopt);
        }
        out.fit = fit_y_sensor(set, *options.points, readings);
    } else {
        out.fit = scan_simulated_roof(options, set, *options.cell);
    }
    out.set = set;
    out.set.parents = {set.id};
    out.set.id += "+y-sensor";
    out.set.time = now_text();
    out.set.y_sensor = y_sensor_record(out.fit, out.set.time);
    out.files = (options.out / "calibration.toml").string();
    static_cast<void>(write_calibration(out.files, out.set));
    return out;
}

}  // namespace sc::host::cli
