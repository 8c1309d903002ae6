// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibration/hand_eye.hpp"
#include "host/calibration/hand_eye_suggest.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/measurement/robot_frames.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell calibrate hand-eye --robot-poses robot.csv --target clouds.csv
      where the 3-D sensor sits on the flange (f_from_c), from markers (view,id,x_mm,y_mm,z_mm,sigma_um) and robot poses
  scribecell calibrate hand-eye --robot-poses robot.csv --target poses.csv --fit-noise --json
      the target as poses (c_from_g); how large the noise is comes from the data
  scribecell calibrate hand-eye --robot-poses hand.csv --target eye.csv --unit m
      --robot-columns time_s,x,y,z,qx,qy,qz,qw --target-columns time_s,x,y,z,qx,qy,qz,qw --fit-noise
      two streams without headers, brought together by time
  ... --suggest 3 --suggest-out more.csv
      three further robot poses that would help most, as a list to edit
  ... --calibration old.toml --out new.toml
      the result as a record f_from_c of a calibration set

Robot poses are b_from_f: quaternions (qw,qx,qy,qz; ABB's q1..q4), matrices (r11..r33), KUKA a,b,c, FANUC w,p,r; mm, m or
inch by name (docs/formats.md). Poses given the other way round, views or markers that do not belong together and poses
that cannot show where the sensor sits are named.

Exit codes: 0 done; 2 bad input, or poses that cannot support a calibration.)";

struct Words {
    std::string robot;
    std::string target;
    std::string robot_columns;
    std::string target_columns;
    std::string unit;
    std::string calibration;
    std::string out;
    double robot_um = 6.7;
    double robot_mdeg = 1.5;
    double marker_um = 7.5;
    double target_mdeg = 1.5;
    double most_mm = 5.0;
    double most_deg = 0.5;
    double time_offset = 0.0;
    int views = 50;
    bool fit_noise = false;
    bool keep_all = false;
    bool json = false;
    int suggest = 0;
    std::string suggest_out;
    std::string suggest_by = "worst";
    double suggest_turn_deg = 20.0;
    double suggest_reach_mm = 50.0;
};

Json json_of(const HandEyeResult& r) {
    Json views = Json::array();
    for (const HandEyeViewResult& v : r.views) {
        views.push_back({{"view", v.name},
                         {"used", v.used},
                         {"pose_off_um", v.place_off * 1e6},
                         {"pose_off_mdeg", v.turn_off / kDegree * 1e3},
                         {"chi_squared", v.surprise},
                         {"markers", v.markers},
                         {"markers_rms_um", v.marker_rms * 1e6}});
    }
    Json markers = Json::array();
    for (const MarkerFinding& m : r.markers) {
        markers.push_back({{"view", m.view}, {"id", m.id}, {"line", m.line}, {"text", m.text()}});
        if (m.kind != MarkerFinding::Kind::wrong) {
            markers.back()["other"] = m.other;
        }
    }
    Json json{{"format", "scribecell-hand-eye"}, {"version", 1}};
    json["f_from_c"] = transform_json(r.f_from_c.rotation, r.f_from_c.translation, r.covariance);
    json["turn_sigma_mdeg"] = r.turn_sigma / kDegree * 1e3;
    json["place_sigma_um"] = r.place_sigma * 1e6;
    json["least_certain"] = {{"turn_about", vector_json(r.least_turn)}, {"place_along", vector_json(r.least_place)}};
    json["chi_squared"] = r.chi_squared;
    json["freedom"] = r.freedom;
    json["robot_noise_ratio"] = r.robot_ratio;
    json["target_noise_ratio"] = r.marker_ratio;
    json["scatter_rms_mm"] = r.scatter_rms * 1e3;
    json["robot_inverted"] = r.robot_inverted;
    json["target_inverted"] = r.target_inverted;
    json["bad_poses"] = r.bad_poses;
    json["markers"] = markers;
    json["notes"] = r.notes;
    json["views"] = views;
    return json;
}

std::string text_of(const HandEyeResult& r) {
    std::string out =
        "f_from_c, where the sensor sits on the flange:\n" +
        transform_text(r.f_from_c.rotation, r.f_from_c.translation) +
        fmt::format("1 sigma in the least certain direction: {:.4g} mdeg, {:.4g} um (chi-squared {:.1f} of {:.0f})\n",
                    r.turn_sigma / kDegree * 1e3, r.place_sigma * 1e6, r.chi_squared, r.freedom) +
        fmt::format("the target scatters by {:.4g} mm rms with the robot's poses as read\n", r.scatter_rms * 1e3);
    out += fmt::format("{:<12} {:>11} {:>13} {:>10} {:>8} {:>12}\n", "view", "pose off um", "pose off mdeg",
                       "chi2 of 6", "markers", "rms um");
    for (const HandEyeViewResult& v : r.views) {
        out += fmt::format("{:<12} {:>11.2f} {:>13.2f} {:>10.1f} {:>8} {:>12.2f}{}\n", v.name, v.place_off * 1e6,
                           v.turn_off / kDegree * 1e3, v.surprise, v.markers, v.marker_rms * 1e6,
                           v.used ? "" : "  left out: this pose is wrong");
    }
    for (const MarkerFinding& m : r.markers) {
        out += m.text() + "\n";
    }
    for (const std::string& note : r.notes) {
        out += "note: " + note + "\n";
    }
    return out;
}

std::vector<HandEyeView> views_of(const Words& words) {
    const PoseFile robot = read_poses(words.robot, {.columns = words.robot_columns, .unit = words.unit});
    const PoseFileWords target{.columns = words.target_columns, .unit = words.unit};
    if (holds_markers(words.target, target)) {
        return pair_views(robot, read_marker_views(words.target, target));
    }
    return pair_views(robot, read_poses(words.target, target),
                      {.time_offset = words.time_offset, .views = static_cast<std::size_t>(words.views)});
}

Suggestion suggestion_of(const Words& words, const std::vector<HandEyeView>& views, const HandEyeResult& result,
                         const HandEyeNoise& noise) {
    std::vector<HandEyeView> used;
    for (const HandEyeView& view : views) {
        if (std::ranges::find(result.bad_poses, view.name) == result.bad_poses.end()) {
            used.push_back(view);
        }
    }
    return suggest_poses(used, result.f_from_c,
                         {.count = words.suggest,
                          .turn = words.suggest_turn_deg * kDegree,
                          .reach = words.suggest_reach_mm * 1e-3,
                          .criterion = words.suggest_by == "worst" ? SuggestCriterion::worst : SuggestCriterion::volume,
                          .noise = noise});
}

std::string poses_csv(const Suggestion& suggestion) {
    std::string out = "view,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
    int no = 1;
    for (const SuggestedPose& pose : suggestion.poses) {
        const Vec3 t = 1e3 * pose.b_from_f.translation;
        const auto q = quaternion_of(pose.b_from_f.rotation);
        out += fmt::format("suggested{},{:.4f},{:.4f},{:.4f},{:.9f},{:.9f},{:.9f},{:.9f}\n", no++, t.x, t.y, t.z, q[0],
                           q[1], q[2], q[3]);
    }
    return out;
}

Json json_of(const Suggestion& s) {
    Json poses = Json::array();
    for (const SuggestedPose& pose : s.poses) {
        poses.push_back({{"translation_mm", vector_json(1e3 * pose.b_from_f.translation)},
                         {"quaternion_wxyz", quaternion_of(pose.b_from_f.rotation)},
                         {"turn_sigma_mdeg", 1e3 * pose.turn_sigma / kDegree},
                         {"place_sigma_um", 1e6 * pose.place_sigma},
                         {"criterion_um", 1e6 * pose.criterion}});
    }
    return {{"turn_sigma_mdeg", 1e3 * s.turn_sigma / kDegree},
            {"place_sigma_um", 1e6 * s.place_sigma},
            {"criterion_um", 1e6 * s.criterion},
            {"one_random_view_criterion_um", 1e6 * s.random_criterion},
            {"poses", poses}};
}

std::string text_of(const Suggestion& s) {
    std::string out = fmt::format(
        "further poses that would help most (b_from_f, mm and degrees; check that the robot and its way are free):\n"
        "{:>4} {:>10} {:>10} {:>10} {:>9} {:>9} {:>9}  expected 1 sigma: now {:.3g} mdeg, {:.3g} um about the sensor\n",
        "", "x", "y", "z", "a", "b", "c", 1e3 * s.turn_sigma / kDegree, 1e6 * s.place_sigma);
    int no = 1;
    for (const SuggestedPose& pose : s.poses) {
        const Vec3 t = 1e3 * pose.b_from_f.translation;
        const auto abc = abc_of(pose.b_from_f.rotation);
        out +=
            fmt::format("{:>4} {:>10.2f} {:>10.2f} {:>10.2f} {:>9.3f} {:>9.3f} {:>9.3f}  then {:.3g} mdeg, {:.3g} um\n",
                        no++, t.x, t.y, t.z, abc[0] / kDegree, abc[1] / kDegree, abc[2] / kDegree,
                        1e3 * pose.turn_sigma / kDegree, 1e6 * pose.place_sigma);
    }
    return out;
}

int run(const Words& words) {
    HandEyeOptions options;
    options.noise = {.robot_place = words.robot_um * 1e-6,
                     .robot_turn = words.robot_mdeg * 1e-3 * kDegree,
                     .marker = words.marker_um * 1e-6,
                     .pose_turn = words.target_mdeg * 1e-3 * kDegree,
                     .fit = words.fit_noise};
    options.find_wrong = !words.keep_all;
    options.most_place = words.most_mm * 1e-3;
    options.most_turn = words.most_deg * kDegree;
    const std::vector<HandEyeView> views = views_of(words);
    const HandEyeResult result = calibrate_hand_eye(words.robot, views, options);
    std::optional<Suggestion> suggestion;
    if (words.suggest > 0) {
        suggestion = suggestion_of(words, views, result, options.noise);
        if (!words.suggest_out.empty()) {
            write_text_file(words.suggest_out, poses_csv(*suggestion));
        }
    }
    std::string saved;
    if (!words.out.empty()) {
        saved = save_transform(
            {.calibration = words.calibration, .out = words.out}, "hand-eye",
            {.id = "f_from_c",
             .rotation = result.f_from_c.rotation,
             .translation = result.f_from_c.translation,
             .covariance = result.covariance,
             .provenance = {
                 .parents = {words.robot, words.target}, .residual_rms = result.scatter_rms, .time = {}, .note = {}}});
    }
    if (words.json) {
        Json json = json_of(result);
        if (suggestion) {
            json["suggestion"] = json_of(*suggestion);
        }
        if (!saved.empty()) {
            json["out"] = words.out;
            json["sha256"] = saved;
        }
        std::printf("%s\n", json.dump(2).c_str());
    } else {
        std::fputs((text_of(result) + (suggestion ? text_of(*suggestion) : "") +
                    (saved.empty() ? "" : "set " + saved.substr(0, 12) + ": " + words.out + "\n"))
                       .c_str(),
                   stdout);
    }
    return 0;
}

}  // namespace

void add_calibrate_hand_eye(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand("hand-eye", "Where the 3-D sensor sits on the robot's flange.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--robot-poses", words->robot, "b_from_f of each view")->type_name("FILE")->required();
    sub->add_option("--target", words->target, "markers or poses (c_from_g) of the fixed target")
        ->type_name("FILE")
        ->required();
    sub->add_option("--robot-columns", words->robot_columns, "header of a file that has none")->type_name("NAMES");
    sub->add_option("--target-columns", words->target_columns, "header of a file that has none")->type_name("NAMES");
    sub->add_option("--unit", words->unit, "of x,y,z without one: mm, m, inch")->type_name("UNIT");
    const CLI::Range some(1e-6, 1e9);
    sub->add_option("--robot-um", words->robot_um, "noise of a robot pose, each axis")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--robot-mdeg", words->robot_mdeg, "noise of its rotation")->check(some)->capture_default_str();
    sub->add_option("--target-um", words->marker_um, "noise of a marker without one of its own, or of a target pose")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--target-mdeg", words->target_mdeg, "noise of a target pose's rotation")
        ->check(some)
        ->capture_default_str();
    sub->add_flag("--fit-noise", words->fit_noise, "how large the noise is comes from the data");
    sub->add_flag("--keep-all", words->keep_all, "leave nothing out");
    sub->add_option("--most-mm", words->most_mm, "1 sigma of the place beyond which the result is refused")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--most-deg", words->most_deg, "and of the turn")->check(some)->capture_default_str();
    sub->add_option("--time-offset-s", words->time_offset, "added to the times of the target")->capture_default_str();
    sub->add_option("--views", words->views, "that are taken of streams")
        ->check(CLI::Range(3, 500))
        ->capture_default_str();
    sub->add_option("--calibration", words->calibration, "set to extend")->type_name("FILE");
    sub->add_option("--out", words->out, "calibration set to write")->type_name("FILE");
    sub->add_option("--suggest", words->suggest, "so many further poses that would help most")
        ->type_name("N")
        ->check(CLI::Range(1, 50));
    sub->add_option("--suggest-out", words->suggest_out, "them as a list of poses, to edit")->type_name("FILE.csv");
    sub->add_option("--suggest-by", words->suggest_by, "worst (direction) or volume (of the covariance)")
        ->check(CLI::IsMember({"worst", "volume"}))
        ->capture_default_str();
    sub->add_option("--suggest-turn-deg", words->suggest_turn_deg, "at most about the target, beside a given pose")
        ->check(CLI::Range(0.1, 180.0))
        ->capture_default_str();
    sub->add_option("--suggest-reach-mm", words->suggest_reach_mm, "beyond the box of the given places")
        ->check(CLI::Range(0.0, 5000.0))
        ->capture_default_str();
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
