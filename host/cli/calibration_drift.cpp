// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibration/drift_check.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/calibration.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/iso_time.hpp"
#include "host/formats/target.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell calibration drift --seen now.csv --save target.csv
      stores where the markers of a target are (id,x_mm,y_mm,z_mm,sigma_um)
  scribecell calibration drift --target target.csv --seen now.csv
      one cloud in the same frame as the stored one
  scribecell calibration drift --target target.csv --seen views.csv --robot-poses robot.csv --limit-um 30
      views from a robot: tells a sensor that moved on its flange from a target that moved
  scribecell calibration drift --target fixed_target.toml --seen views.csv --robot-poses robot.csv
      a target by its certificate, with b_from_g of the calibration

Each result is added to the history (drift.csv in the store's folder, or --history).

Exit codes: 0 nothing has drifted; 1 drifted; 2 bad input.)";
constexpr const char* kHistoryHeader =
    "time,target,seen,calibration,drifted,suspect,largest_um,sigma_um,turn_mdeg,chance,seen_from_um\n";

struct Words {
    std::string target;
    std::string seen;
    std::string robot;
    std::string unit;
    std::string calibration;
    std::string store;
    std::string history;
    std::string save;
    double limit_um = 20.0;
    double marker_um = 7.5;
    double robot_um = 6.7;
    double robot_mdeg = 1.5;
    bool target_moved = false;
    bool json = false;
};

std::vector<DriftView> views_of(const Words& words) {
    const MarkerFile seen = read_marker_views(words.seen, {.columns = {}, .unit = words.unit});
    std::vector<DriftView> out;
    if (words.robot.empty()) {
        for (const MarkerView& view : seen.views) {
            out.push_back({.name = view.view, .b_from_f = std::nullopt, .markers = view.markers});
        }
        return out;
    }
    const PoseFile robot = read_poses(words.robot, {.columns = {}, .unit = words.unit});
    for (const MarkerView& view : seen.views) {
        const auto pose = std::ranges::find(robot.poses, view.view, &NamedPose::view);
        if (pose == robot.poses.end()) {
            throw InputError({.file = words.seen,
                              .line = view.line,
                              .problem = "the robot poses lack this view",
                              .value = view.view,
                              .action = "name views alike in both files"});
        }
        out.push_back({.name = view.view,
                       .b_from_f = Rigid<frame::B, frame::F>{pose->rotation, pose->translation},
                       .markers = view.markers});
    }
    return out;
}

/// Places as they were, in the stored frame.
std::vector<SeenMarker> stored_places(const Words& words) {
    if (!words.target.ends_with(".toml")) {
        const MarkerFile stored = read_marker_views(words.target, {.columns = {}, .unit = words.unit});
        if (stored.views.size() != 1) {
            throw InputError({.file = words.target,
                              .problem = "is not one cloud of markers",
                              .value = fmt::format("{} views", stored.views.size()),
                              .action = "store it with --save"});
        }
        return stored.views.front().markers;
    }
    const Target target = read_target(words.target);
    const CalibrationSet set = named_set(words.calibration, words.store);
    const TransformRecord* pose = set.find("b_from_g");
    if (pose == nullptr) {
        throw InputError({.file = set.file.string(),
                          .problem = "the calibration does not say where the target is",
                          .value = "b_from_g",
                          .action = "store its markers with --save instead"});
    }
    std::vector<SeenMarker> out;
    for (const TargetMarker& marker : target.markers) {
        out.push_back({.line = 0,
                       .id = marker.id,
                       .place = pose->rotation * marker.place + pose->translation,
                       .sigma = {marker.sigma, marker.sigma, marker.sigma}});
    }
    return out;
}

std::string stored_text(const std::vector<SeenMarker>& markers) {
    std::string out = "id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
    for (const SeenMarker& m : markers) {
        out += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.3f},{:.3f},{:.3f}\n", m.id, 1e3 * m.place.x, 1e3 * m.place.y,
                           1e3 * m.place.z, 1e6 * m.sigma.x, 1e6 * m.sigma.y, 1e6 * m.sigma.z);
    }
    return out;
}

const DriftHypothesis& suspect_in(const DriftResult& result) {
    return *std::ranges::find(result.hypotheses, result.suspect, &DriftHypothesis::cause);
}

void add_to_history(const Words& words, const DriftResult& result, const std::string& calibration) {
    const std::filesystem::path file =
        words.history.empty() ? open_store(words.store).folder() / "drift.csv" : std::filesystem::path(words.history);
    if (words.history.empty()) {
        std::error_code ignored;
        std::filesystem::create_directories(file.parent_path(), ignored);
    }
    std::string text = std::filesystem::exists(file) ? read_text_file(file) : kHistoryHeader;
    const DriftHypothesis& suspect = suspect_in(result);
    text += fmt::format("{},{},{},{},{},{},{:.3f},{:.3f},{:.4f},{:.4g},{:.3f}\n", iso_time_text(now_in_seconds()),
                        std::filesystem::path(words.target).filename().string(),
                        std::filesystem::path(words.seen).filename().string(), calibration, result.drifted ? 1 : 0,
                        name_of(result.suspect), 1e6 * suspect.largest, 1e6 * suspect.sigma,
                        1e3 * suspect.turn / kDegree, result.chance, 1e6 * result.seen_from);
    write_text_file(file, text);
}

Json json_of(const DriftResult& r, bool by_robot) {
    Json hypotheses = Json::array();
    for (const DriftHypothesis& h : r.hypotheses) {
        hypotheses.push_back({{"cause", name_of(h.cause)},
                              {"chi_squared", h.chi_squared},
                              {"parameters", h.parameters},
                              {"turn_mdeg", 1e3 * h.turn / kDegree},
                              {"place_um", 1e6 * h.place},
                              {"scale_ppm", 1e6 * h.scale},
                              {"largest_um", 1e6 * h.largest},
                              {"sigma_um", 1e6 * h.sigma}});
    }
    Json markers = Json::array();
    for (const DriftMarker& m : r.markers) {
        markers.push_back(
            {{"id", m.id}, {"off_um", vector_json(1e6 * m.off)}, {"chance", m.chance}, {"moved_alone", m.moved_alone}});
    }
    return {{"format", "scribecell-drift"},
            {"version", 1},
            {"drifted", r.drifted},
            {"suspect", name_of(r.suspect)},
            {"suspect_transform", suspect_of(r.suspect, by_robot)},
            {"text", r.text},
            {"chance", r.chance},
            {"freedom", r.freedom},
            {"seen_from_um", 1e6 * r.seen_from},
            {"hypotheses", hypotheses},
            {"markers", markers},
            {"notes", r.notes}};
}

std::string text_of(const DriftResult& r) {
    std::string out = r.text + "\n";
    out += fmt::format("{:<10} {:>12} {:>6} {:>11} {:>10} {:>12} {:>10}\n", "if moved", "chi-squared", "of",
                       "turn mdeg", "place um", "markers um", "sigma um");
    for (const DriftHypothesis& h : r.hypotheses) {
        out += fmt::format("{:<10} {:>12.1f} {:>6.0f} {:>11.3f} {:>10.2f} {:>12.2f} {:>10.2f}\n", name_of(h.cause),
                           h.chi_squared, r.freedom - h.parameters, 1e3 * h.turn / kDegree, 1e6 * h.place,
                           1e6 * h.largest, 1e6 * h.sigma);
    }
    for (const DriftMarker& m : r.markers) {
        out += fmt::format("marker {:<4} now - then {:>9.2f} {:>9.2f} {:>9.2f} um{}\n", m.id, 1e6 * m.off.x,
                           1e6 * m.off.y, 1e6 * m.off.z, m.moved_alone ? "  moved by itself" : "");
    }
    for (const std::string& note : r.notes) {
        out += "note: " + note + "\n";
    }
    return out;
}

int run(const Words& words) {
    if (words.target.empty() == words.save.empty()) {
        throw InputError({.problem = "it is not said what to compare with",
                          .action = "give --target, or --save to store what is seen"});
    }
    const std::vector<DriftView> views = views_of(words);
    std::optional<Rigid<frame::F, frame::C>> f_from_c;
    std::string calibration;
    if (!words.robot.empty()) {
        const CalibrationSet set = named_set(words.calibration, words.store);
        calibration = set.sha256.substr(0, 12);
        if (const TransformRecord* record = set.find("f_from_c")) {
            f_from_c = {record->rotation, record->translation};
        } else {
            throw InputError({.file = set.file.string(),
                              .problem = "the calibration does not say where the sensor sits on the flange",
                              .value = "f_from_c",
                              .action = "use a set of `scribecell calibrate hand-eye`"});
        }
    }
    const DriftOptions options{.limit = words.limit_um * 1e-6,
                               .marker = words.marker_um * 1e-6,
                               .robot_place = words.robot_um * 1e-6,
                               .robot_turn = words.robot_mdeg * 1e-3 * kDegree,
                               .target_moved = words.target_moved};
    if (!words.save.empty()) {
        const std::vector<SeenMarker> markers = places_to_store(views, f_from_c, options);
        write_text_file(words.save, stored_text(markers));
        std::printf("%s: %zu markers\n", words.save.c_str(), markers.size());
        return kDone;
    }
    const DriftResult result = check_drift(words.seen, stored_places(words), views, f_from_c, options);
    add_to_history(words, result, calibration);
    if (words.json) {
        std::printf("%s\n", json_of(result, !words.robot.empty()).dump(2).c_str());
    } else {
        std::fputs(text_of(result).c_str(), stdout);
    }
    return result.drifted ? kFailed : kDone;
}

}  // namespace

void add_calibration_drift(CLI::App& calibration, int& exit_code) {
    CLI::App* sub = calibration.add_subcommand("drift", "Has anything moved since a target was stored?");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--target", words->target, "markers as stored (CSV), or the target's certificate (TOML)")
        ->type_name("FILE");
    sub->add_option("--seen", words->seen, "markers as seen now")->type_name("FILE.csv")->required();
    sub->add_option("--robot-poses", words->robot, "b_from_f of each view")->type_name("FILE.csv");
    sub->add_option("--unit", words->unit, "of x,y,z without one: mm, m, inch")->type_name("UNIT");
    sub->add_option("--calibration", words->calibration, "set: file, number, sha256 or id (default: current)")
        ->type_name("SET");
    sub->add_option("--store", words->store, "folder of the store")->type_name("DIR");
    sub->add_option("--history", words->history, "file that the result is added to")->type_name("FILE.csv");
    sub->add_option("--save", words->save, "store what is seen, compare nothing")->type_name("FILE.csv");
    const CLI::Range some(1e-3, 1e6);
    sub->add_option("--limit-um", words->limit_um, "that a marker may be off")->check(some)->capture_default_str();
    sub->add_option("--marker-um", words->marker_um, "noise of a marker without one of its own")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--robot-um", words->robot_um, "noise of a robot pose")->check(some)->capture_default_str();
    sub->add_option("--robot-mdeg", words->robot_mdeg, "and of its rotation")->check(some)->capture_default_str();
    sub->add_flag("--target-moved", words->target_moved, "the target was put down again: its rigid move is no drift");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
