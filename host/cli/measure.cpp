// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/measure_link.hpp"
#include "host/cli/measure_live.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/station_log.hpp"
#include "host/measurement/robot_frames.hpp"
#include "host/measurement/station_view.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell measure stations.csv --calibration head.toml
      angle, yaw and distance of each station against the reference plane, with 95 % uncertainties
  scribecell measure stations.csv --job rail.toml --database run.db --robot-out frames --pictures pictures
      the batch: what to turn until all sit the same, figures into SQLite, frames for KUKA, ABB, FANUC, pictures
  scribecell measure stations.csv --calibration head.toml --check known.csv
      stations of known pose first: if they do not fit (swapped sensors, a head that was hit), nothing is measured
  scribecell measure readings.csv --calibration head.toml --live
      follows a file that grows (or - for stdin) and shows the workpiece as it is turned
  scribecell measure --link serial:/dev/ttyUSB0 --calibration head.toml --live
      the same from the three sensors of a cell; sim: is a simulated one

Exit codes: 0 all stations have figures; 1 a station was refused; 2 bad input or usage; 130 Ctrl-C.)";

struct Words {
    std::string readings;
    std::string calibration;
    std::string job;
    std::string check;
    std::string database;
    std::string robot_out;
    std::string pictures;
    bool median = false;
    bool json = false;
    bool live = false;
    double idle_s = 60.0;
    int port = 0;
    int most = 0;
    std::string link;
    LinkOptions link_options;
};

struct Measured {
    std::string station;
    std::optional<StationResult> result;
    std::optional<StationRefusal> refusal;
    std::optional<Correction> correction;
};

Json json_of(const UncertaintyParts& sigma, double unit) {
    return {{"u95", kCoverage95 * sigma.total() / unit},
            {"sensors", sigma.sensors / unit},
            {"geometry", sigma.geometry / unit},
            {"seat", sigma.seat / unit}};
}

Json json_of(const Measured& m) {
    Json json{{"station", m.station}};
    if (m.refusal) {
        json["problem"] = name_of(m.refusal->problem);
        json["text"] = m.refusal->text;
        return json;
    }
    const StationResult& r = *m.result;
    json["rail_mm"] = r.rail ? Json(*r.rail * 1e3) : Json(nullptr);
    json["angle_deg"] = r.angle / kDegree;
    json["angle_sigma_deg"] = json_of(r.angle_sigma, kDegree);
    json["about_y_deg"] = r.about_y / kDegree;
    json["about_y_sigma_deg"] = json_of(r.about_y_sigma, kDegree);
    json["about_z_deg"] = r.about_z / kDegree;
    json["about_z_sigma_deg"] = json_of(r.about_z_sigma, kDegree);
    json["distance_mm"] = r.distance * 1e3;
    json["distance_sigma_mm"] = json_of(r.distance_sigma, 1e-3);
    Json spots = Json::array();
    for (const Vec3& spot : r.spots) {
        spots.push_back({spot.x * 1e3, spot.y * 1e3, spot.z * 1e3});
    }
    json["spots_mm"] = spots;
    json["readings"] = r.used;
    json["left_out"] = r.left_out;
    json["noise_mm"] = r.noise * 1e3;
    json["noisier_than_calibrated"] = r.noisier;
    json["misfit"] = r.misfit ? Json(*r.misfit) : Json(nullptr);
    if (m.correction) {
        constexpr std::array kVerdicts{"good", "adjust", "too_near_to_tell"};
        Json screws = Json::array();
        for (const ScrewTurn& s : m.correction->screws) {
            screws.push_back({{"id", s.id}, {"travel_mm", s.travel * 1e3}, {"turns_clockwise", s.turns}});
        }
        json["correction"] = {
            {"turn_z_deg", m.correction->turn_z / kDegree},
            {"turn_y_deg", m.correction->turn_y / kDegree},
            {"shift_x_mm", m.correction->shift_x * 1e3},
            {"off_angle_deg", m.correction->off_angle / kDegree},
            {"screws", screws},
            {"verdict", m.correction->verdict ? Json(kVerdicts[static_cast<std::size_t>(*m.correction->verdict)])
                                              : Json(nullptr)}};
    }
    return json;
}

/// Known stations among those measured must read what is known of them.
void check_known(const TripleRecord& head, const StationFile& stations, const std::string& file,
                 const StationOptions& options) {
    for (const KnownPose& known : read_known(file)) {
        const auto found = std::find_if(stations.stations.begin(), stations.stations.end(),
                                        [&](const Station& station) { return station.id == known.station; });
        if (found == stations.stations.end()) {
            throw InputError({.file = file,
                              .problem = "names a station without readings",
                              .value = known.station,
                              .action = "measure it with the others, or leave it out"});
        }
        if (const auto refusal = check_station(head, *found, known, options)) {
            throw CellError(std::string(name_of(refusal->problem)) + ": " + refusal->text);
        }
    }
}

std::vector<Measured> measure_all(const TripleRecord& head, const StationFile& stations, const StationOptions& options,
                                  const StationJob& job) {
    std::vector<Measured> out;
    std::vector<StationResult> good;
    for (const Station& station : stations.stations) {
        if (stop_requested()) {
            throw Interrupted();
        }
        Measured measured{.station = station.id, .result = {}, .refusal = {}, .correction = {}};
        if (auto result = measure_station(head, station, options)) {
            good.push_back(*result);
            measured.result = std::move(*result);
        } else {
            measured.refusal = result.error();
        }
        out.push_back(std::move(measured));
    }
    if (job.target && !good.empty()) {
        const StationTarget target = job.target->same ? median_target(good) : *job.target;
        for (Measured& measured : out) {
            if (measured.result) {
                measured.correction = correction_of(*measured.result, target, job);
            }
        }
    }
    return out;
}

void write_log(const std::string& database, const std::string& sha256, const std::vector<Measured>& all) {
    std::vector<StationFigure> figures;
    for (const Measured& m : all) {
        if (m.refusal) {
            figures.push_back({m.station, name_of(m.refusal->problem), 0.0, 0.0, ""});
            continue;
        }
        const StationResult& r = *m.result;
        figures.push_back({m.station, "angle", r.angle / kDegree, r.angle_sigma.total() / kDegree, "deg"});
        figures.push_back({m.station, "about_y", r.about_y / kDegree, r.about_y_sigma.total() / kDegree, "deg"});
        figures.push_back({m.station, "about_z", r.about_z / kDegree, r.about_z_sigma.total() / kDegree, "deg"});
        figures.push_back({m.station, "distance", r.distance * 1e3, r.distance_sigma.total() * 1e3, "mm"});
    }
    log_stations(
        database,
        fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                    fmt::gmtime(std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now()))),
        sha256, figures);
}

void write_frames(const std::string& folder, const StationJob& job, const std::vector<Measured>& all) {
    if (!job.robot || !job.target) {
        throw InputError({.file = job.file.string(),
                          .problem = "has no [robot] or no [target], which --robot-out needs",
                          .value = {},
                          .action = "add them (docs/formats.md)"});
    }
    std::vector<StationResult> good;
    for (const Measured& m : all) {
        if (m.result) {
            good.push_back(*m.result);
        }
    }
    if (good.empty()) {
        return;
    }
    const StationTarget target = job.target->same ? median_target(good) : *job.target;
    std::vector<StationFrame> frames;
    int number = job.robot->first_number;
    for (const Measured& m : all) {
        if (m.result) {
            frames.push_back(frame_of(*m.result, target, *job.robot, number));
        }
        ++number;  // a refused station keeps its number: the program's stations stay where they are
    }
    std::filesystem::create_directories(folder);
    const std::filesystem::path path = folder;
    write_text_file(path / "frames.csv", frames_csv(frames));
    write_text_file(path / "stations.src", frames_kuka(frames));
    write_text_file(path / "Stations.mod", frames_abb(frames));
    write_text_file(path / "stations.ls", frames_fanuc(frames));
}

void write_pictures(const std::string& folder, const std::vector<Measured>& all) {
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const Measured& m : all) {
        const std::filesystem::path file = std::filesystem::path(folder) / fmt::format("station_{:04}", ++number);
        const Drawing drawing = m.result ? station_drawing(*m.result, m.correction ? &*m.correction : nullptr)
                                         : refusal_drawing(m.station, *m.refusal);
        write_text_file(file.string() + ".svg", svg_of(drawing));
        write_png(file.string() + ".png", pixels_of(drawing));
    }
}

int run_batch(const Words& words, const CalibrationSet& set, const StationJob& job, const StationOptions& options) {
    const StationFile stations = read_stations(words.readings);
    if (!words.check.empty()) {
        check_known(*set.triple, stations, words.check, options);
    }
    const std::vector<Measured> all = measure_all(*set.triple, stations, options, job);
    Json rows = Json::array();
    bool refused = false;
    if (!words.json) {
        std::fputs(table_head().c_str(), stdout);
    }
    for (const Measured& m : all) {
        refused = refused || m.refusal.has_value();
        if (words.json) {
            rows.push_back(json_of(m));
        } else if (m.result) {
            std::fputs(table_row(*m.result, m.correction ? &*m.correction : nullptr).c_str(), stdout);
        } else {
            std::printf("%-14s refused, %s: %s\n", m.station.c_str(), name_of(m.refusal->problem),
                        m.refusal->text.c_str());
        }
    }
    if (!words.database.empty()) {
        write_log(words.database, set.sha256, all);
    }
    if (!words.robot_out.empty()) {
        write_frames(words.robot_out, job, all);
    }
    if (!words.pictures.empty()) {
        write_pictures(words.pictures, all);
    }
    if (words.json) {
        std::printf("%s\n", Json{{"calibration", set.sha256}, {"stations", rows}}.dump(2).c_str());
    }
    return refused ? kFailed : kDone;
}

[[noreturn]] void refuse_words(const std::string& problem, const std::string& action) {
    throw InputError({.file = {}, .problem = problem, .value = {}, .action = action});
}

void check(const Words& words) {
    if (words.link.empty() && (words.link_options.world || words.link_options.script || words.link_options.capture)) {
        refuse_words("--world, --script and --capture belong to a link", "give them with --link sim:");
    }
    if (words.link.empty()) {
        return;
    }
    if (!words.live) {
        refuse_words("--link gives readings as they come", "add --live, or name a file of readings");
    }
    if (!words.readings.empty()) {
        refuse_words("there are two sources of readings", "give a file or --link");
    }
    if (!is_simulated(words.link) && (words.link_options.world || words.link_options.script)) {
        refuse_words("--world and --script belong to the simulated cell", "use --link sim:");
    }
}

int run_live(const Words& words, const TripleRecord& head, const StationJob& job, const StationOptions& options) {
    const bool cell = !words.link.empty();
    return measure_live({.source = cell ? link_source(words.link, words.link_options) : line_source(words.readings),
                         .name = cell ? words.link : words.readings,
                         .head = head,
                         .options = options,
                         .job = job,
                         .idle_s = words.idle_s,
                         .port = words.port,
                         .most = words.most});
}

int run(Words words) {
    check(words);
    install_stop_signals();
    const StationJob job = words.job.empty() ? default_station_job() : read_station_job(words.job);
    if (words.calibration.empty()) {
        words.calibration = job.calibration.string();
    }
    if (words.readings.empty() && words.link.empty()) {
        words.readings = job.readings.string();
    }
    if (words.calibration.empty() || (words.readings.empty() && words.link.empty())) {
        throw InputError(
            {.file = words.job,
             .problem = words.calibration.empty() ? "no calibration is named" : "no readings are named",
             .value = {},
             .action = "give them on the command line or in --job; with --live --link can stand for readings"});
    }
    const CalibrationSet set = read_calibration(words.calibration);
    if (!set.triple) {
        throw InputError({.file = words.calibration,
                          .problem = "has no triple-laser head",
                          .value = {},
                          .action = "run scribecell calibrate parallelism, or name the set that has it"});
    }
    StationOptions options = options_of(job);
    options.estimator = words.median ? Estimator::median : Estimator::mean;
    if (words.live) {
        return run_live(words, *set.triple, job, options);
    }
    return run_batch(words, set, job, options);
}

}  // namespace

void add_measure(CLI::App& app, int& exit_code) {
    CLI::App* sub =
        app.add_subcommand("measure", "Pose of workpieces against their reference, by the triple-laser head.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("readings", words->readings,
                    "readings, station after station: CSV or TOML; - for stdin with --live")
        ->type_name("FILE");
    sub->add_option("--calibration", words->calibration, "calibration set with the head")->type_name("FILE");
    sub->add_option("--job", words->job, "target, tolerances, screws, seat, robot")->type_name("FILE");
    sub->add_option("--check", words->check, "known poses of some of the stations: measured first")->type_name("FILE");
    sub->add_flag("--median", words->median, "the median of the readings, as the paper has it");
    sub->add_option("--database", words->database, "SQLite file to add the figures to")->type_name("FILE");
    sub->add_option("--robot-out", words->robot_out, "folder for the frames: CSV, KUKA, ABB, FANUC")->type_name("DIR");
    sub->add_option("--pictures", words->pictures, "folder for a picture of each station (SVG and PNG)")
        ->type_name("DIR");
    sub->add_flag("--live", words->live, "follow the readings, and show each as it comes");
    sub->add_option("--idle", words->idle_s, "--live: ends after so many seconds without a reading")
        ->type_name("S")
        ->check(CLI::Range(0.1, 86400.0))
        ->capture_default_str();
    sub->add_option("--most", words->most, "--live: ends after so many readings; 0 = never")
        ->type_name("N")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    sub->add_option("--link", words->link, "--live: the sensors of this cell in place of a file")->type_name("URL");
    add_key_option(*sub, words->link_options.key);
    sub->add_option("--capture", words->link_options.capture, "--link: pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    sub->add_option("--world", words->link_options.world, "--link sim: world of the simulated cell")->type_name("FILE");
    sub->add_option("--script", words->link_options.script, "--link sim: its script of faults")->type_name("FILE");
    sub->add_option("--port", words->port, "--live: port of the page on this computer; 0 = any that is free")
        ->type_name("N")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    sub->add_flag("--json", words->json, "one JSON object on stdout");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
