// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibration/scribe_budget.hpp"
#include "host/calibration/transforms.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/calibration.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/error.hpp"
#include "host/formats/job.hpp"
#include "host/formats/points.hpp"
#include "host/formats/table.hpp"
#include "host/path/face_places.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell calibration budget --job examples/ras3dm/job.toml
      the places of a job, with the calibration that it names
  scribecell calibration budget --calibration new.toml --table examples/ras3dm/table1.csv --pointing-um 55
      and what a check by eye would show
  scribecell calibration budget --points places.csv --frame c --json
      places in c (no,x,y,z in mm), burnt at faces 0, 90, 180 and 270

1 sigma by source; 95 % is of all sources together. Sources are taken to be independent but for what the set's
cross-covariances say.)";

struct Words {
    std::string calibration;
    std::string store;
    std::string job;
    std::string table;
    std::string points;
    std::string frame = "c";
    std::vector<double> faces;
    double sensor_um = 7.5;
    double registration_um = 0.0;
    double turn_mdeg = 0.5;
    double axes_um = 2.5;
    double pointing_um = 0.0;
    double field_x_mm = 0.0;
    double field_z_mm = 0.0;
    bool json = false;
};

std::vector<BudgetPlace> places_of_table(const VerificationTable& table) {
    std::vector<BudgetPlace> out;
    for (const TableRow& row : table.rows) {
        out.push_back({.name = fmt::format("{}", row.no), .face_deg = row.face_deg, .place = row.measured});
    }
    return out;
}

std::vector<BudgetPlace> places_of_job(const Job& job, const CalibrationSet& set) {
    std::vector<BudgetPlace> out;
    const MachineConfig machine = reference_machine();
    const VerificationTable table = job.table.empty() ? VerificationTable{} : read_table(job.table, machine);
    for (const JobFace& face : job.faces) {
        const FacePlaces places = face_places(job, face, table, set, machine, false);
        for (const MarkerPlace& marker : places.markers) {
            out.push_back({.name = fmt::format("{}", marker.no), .face_deg = face.angle_deg, .place = marker.place});
        }
        if (places.line) {
            out.push_back({.name = "line begins", .face_deg = face.angle_deg, .place = places.line->from});
            out.push_back({.name = "line ends", .face_deg = face.angle_deg, .place = places.line->to});
        }
    }
    for (const JobPath& path : job.paths) {
        const auto steps = path_places(job, path, set, machine);
        for (const std::size_t i : {std::size_t{0}, steps.size() - 1}) {
            out.push_back({.name = path.name + (i == 0 ? " begins" : " ends"),
                           .face_deg = path.face_deg,
                           .place = {steps[i].to},
                           .measured = path.frame != PlaceFrame::h});
        }
    }
    return out;
}

std::vector<BudgetPlace> places_of_points(const Words& words, const CalibrationSet& set) {
    std::vector<BudgetPlace> out;
    const std::vector<double> faces = words.faces.empty() ? std::vector<double>{0, 90, 180, 270} : words.faces;
    for (const FacePoint& point : read_points(words.points).points) {
        if (words.frame == "h") {
            out.push_back({.name = fmt::format("{}", point.no), .face_deg = faces.front(), .place = {point.place}});
            continue;
        }
        for (const double face : faces) {
            out.push_back({.name = fmt::format("{}", point.no),
                           .face_deg = face,
                           .place = to_face(set, Point<frame::C>{point.place}, face)});
        }
    }
    return out;
}

/// Sources of some places, root of the mean variance along each axis.
struct Summary {
    std::vector<std::pair<std::string, Vec3>> sources;
    Vec3 total;
    Vec3 axis_95;
    double distance_95 = 0.0;
    double checked_95 = 0.0;
    std::size_t places = 0;
};

Summary summary_of(const std::vector<const PlaceBudget*>& places) {
    Summary out;
    out.places = places.size();
    const auto n = static_cast<double>(places.size());
    const auto rms = [&](const auto& covariance_at) {
        std::array<double, 3> sum{};
        for (const PlaceBudget* place : places) {
            for (std::size_t i = 0; i < 3; ++i) {
                sum.at(i) += covariance_at(*place)[i][i] / n;
            }
        }
        const auto root = [](double v) { return std::copysign(std::sqrt(std::abs(v)), v); };
        return Vec3{root(sum[0]), root(sum[1]), root(sum[2])};
    };
    for (std::size_t s = 0; s < places.front()->sources.size(); ++s) {
        out.sources.emplace_back(places.front()->sources[s].name,
                                 rms([s](const PlaceBudget& place) { return place.sources[s].covariance; }));
    }
    out.total = rms([](const PlaceBudget& place) { return place.total; });
    for (const PlaceBudget* place : places) {
        out.axis_95 = {std::max(out.axis_95.x, place->axis_95.x), std::max(out.axis_95.y, place->axis_95.y),
                       std::max(out.axis_95.z, place->axis_95.z)};
        out.distance_95 = std::max(out.distance_95, place->distance_95);
        out.checked_95 = std::max(out.checked_95, place->checked_95);
    }
    return out;
}

Json json_of(const Summary& summary) {
    Json sources = Json::array();
    for (const auto& [name, sigma] : summary.sources) {
        sources.push_back({{"name", name}, {"sigma_um", vector_json(1e6 * sigma)}});
    }
    return {{"places", summary.places},
            {"sources", sources},
            {"sigma_um", vector_json(1e6 * summary.total)},
            {"worst_95_um", vector_json(1e6 * summary.axis_95)},
            {"worst_3d_95_um", 1e6 * summary.distance_95},
            {"worst_checked_95_um", 1e6 * summary.checked_95}};
}

std::string text_of(const std::string& title, const Summary& summary, double pointing) {
    std::string out = fmt::format("{} ({} places)\n  {:<18} {:>8} {:>8} {:>8}  um, 1 sigma\n", title, summary.places,
                                  "source", "x", "y", "z");
    for (const auto& [name, sigma] : summary.sources) {
        out += fmt::format("  {:<18} {:>8.2f} {:>8.2f} {:>8.2f}\n", name, 1e6 * sigma.x, 1e6 * sigma.y, 1e6 * sigma.z);
    }
    out += fmt::format("  {:<18} {:>8.2f} {:>8.2f} {:>8.2f}\n", "all", 1e6 * summary.total.x, 1e6 * summary.total.y,
                       1e6 * summary.total.z);
    out += fmt::format("  {:<18} {:>8.1f} {:>8.1f} {:>8.1f}  worst place; in space {:.1f}\n", "95 % within",
                       1e6 * summary.axis_95.x, 1e6 * summary.axis_95.y, 1e6 * summary.axis_95.z,
                       1e6 * summary.distance_95);
    if (pointing > 0.0) {
        out += fmt::format("  a check by eye ({:.3g} um) would show {:.1f} um, 95 % of the worst axis\n", pointing,
                           1e6 * summary.checked_95);
    }
    return out;
}

int run(const Words& words) {
    const int given = (words.job.empty() ? 0 : 1) + (words.table.empty() ? 0 : 1) + (words.points.empty() ? 0 : 1);
    if (given != 1) {
        throw InputError(
            {.problem = "it is not said for which places", .action = "give one of --job, --table and --points"});
    }
    Job job;
    if (!words.job.empty()) {
        job = read_job(words.job);
    }
    const CalibrationSet set = words.calibration.empty() && !words.job.empty()
                                   ? read_calibration(job.calibration)
                                   : named_set(words.calibration, words.store);
    const std::vector<BudgetPlace> places =
        !words.job.empty()
            ? places_of_job(job, set)
            : (!words.table.empty() ? places_of_table(read_table(words.table)) : places_of_points(words, set));
    if (places.empty()) {
        throw InputError({.file = words.job, .problem = "has no places", .action = "give a job with faces or paths"});
    }
    const ScribeBudget budget = scribe_budget(set, places,
                                              {.sensor = words.sensor_um * 1e-6,
                                               .registration = words.registration_um * 1e-6,
                                               .turn = words.turn_mdeg * 1e-3 * kDegree,
                                               .axes = words.axes_um * 1e-6,
                                               .pointing = words.pointing_um * 1e-6,
                                               .field = {words.field_x_mm * 1e-3, words.field_z_mm * 1e-3}});
    std::map<double, std::vector<const PlaceBudget*>> faces;
    std::vector<const PlaceBudget*> all;
    for (const PlaceBudget& place : budget.places) {
        faces[place.at.face_deg].push_back(&place);
        all.push_back(&place);
    }
    if (!words.json) {
        std::string out = fmt::format("{} ({})\n", set.id, set.sha256.substr(0, 12));
        for (const auto& [face, members] : faces) {
            out += text_of(fmt::format("face {:.6g}", face), summary_of(members), words.pointing_um);
        }
        out += faces.size() > 1 ? text_of("all faces", summary_of(all), words.pointing_um) : "";
        for (const std::string& note : budget.notes) {
            out += "note: " + note + "\n";
        }
        std::fputs(out.c_str(), stdout);
        return 0;
    }
    Json by_face = Json::array();
    for (const auto& [face, members] : faces) {
        by_face.push_back({{"face_deg", face}});
        by_face.back().update(json_of(summary_of(members)));
    }
    Json by_place = Json::array();
    for (const PlaceBudget& place : budget.places) {
        by_place.push_back({{"name", place.at.name},
                            {"face_deg", place.at.face_deg},
                            {"place_mm", vector_json(1e3 * place.at.place.v)},
                            {"covariance", place.total},
                            {"axis_95_um", vector_json(1e6 * place.axis_95)},
                            {"distance_95_um", 1e6 * place.distance_95}});
    }
    const Json json{{"format", "scribecell-budget"},
                    {"version", 1},
                    {"calibration", {{"id", set.id}, {"sha256", set.sha256}}},
                    {"all", json_of(summary_of(all))},
                    {"faces", by_face},
                    {"places", by_place},
                    {"notes", budget.notes}};
    std::printf("%s\n", json.dump(2).c_str());
    return 0;
}

}  // namespace

void add_calibration_budget(CLI::App& calibration, int& exit_code) {
    CLI::App* sub = calibration.add_subcommand("budget", "Error of scribing at each place, by source.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--calibration", words->calibration,
                    "set: file, number, sha256 or id (default: the job's, or current)")
        ->type_name("SET");
    sub->add_option("--store", words->store, "folder of the store")->type_name("DIR");
    sub->add_option("--job", words->job, "its places")->type_name("FILE.toml");
    sub->add_option("--table", words->table, "measured places of a verification table")->type_name("FILE.csv");
    sub->add_option("--points", words->points, "places, no,x,y,z in mm")->type_name("FILE.csv");
    sub->add_option("--frame", words->frame, "of --points: c or h")
        ->check(CLI::IsMember({"c", "h"}))
        ->capture_default_str();
    sub->add_option("--face", words->faces, "of --points, degrees; may be given again")->type_name("DEG");
    const CLI::Range some(0.0, 1e6);
    sub->add_option("--sensor-um", words->sensor_um, "1 sigma of a measured marker")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--registration-um", words->registration_um, "1 sigma of stitching views into c")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--turn-mdeg", words->turn_mdeg, "1 sigma of the turntable")->check(some)->capture_default_str();
    sub->add_option("--axes-um", words->axes_um, "1 sigma of each axis")->check(some)->capture_default_str();
    sub->add_option("--pointing-um", words->pointing_um, "1 sigma of a check by eye")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--field-x-mm", words->field_x_mm, "where in the galvo's field it is burnt")->capture_default_str();
    sub->add_option("--field-z-mm", words->field_z_mm, "and along z")->capture_default_str();
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
