// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/calibration/stereo_fit.hpp"
#include "host/cli/board_input.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kCameraExamples = R"(Examples:
  scribecell calibrate camera --pictures view*.png --board 9x6 --square 25
      focal lengths, middle and distortion from pictures of a chessboard with 9 by 6 inner corners, 25 mm apart
  scribecell calibrate camera --pictures view*.png --board 10x10 --square 20 --dots --dot-diameter 10
      from a grid of dots; what perspective does to their middles is taken out
  scribecell calibrate camera --pictures centres.csv --square 25 --size 640x480 --out camera.toml --json
      from points that any program has measured (view,row,col,u_px,v_px; X_mm,Y_mm in place of --square)

Ten pictures or more, the board tilted by 20 to 45 degrees about both axes, near and far, and into the picture's corners.
What the views cannot show is fixed and named; points and pictures that do not fit are left out and named.

Exit codes: 0 done; 2 bad input, or views that cannot support a calibration.)";
constexpr const char* kStereoExamples = R"(Examples:
  scribecell calibrate stereo --left left*.jpg --right right*.jpg --board 9x6 --square 25
      both cameras and right_from_left from pictures of a chessboard with 9 by 6 inner corners, 25 mm apart
  scribecell calibrate stereo --left left*.jpg --right right*.jpg --board 9x6 --square 0.025 --unit m
      --out pair.toml --overlays residuals --json
      the pair as a file for `scribecell vision stereo`; residuals drawn, 50 times as long; one JSON object
  scribecell calibrate stereo --left left.csv --right right.csv --square 25 --size 640x480
      from points that any program has measured (view,row,col,u_px,v_px; X_mm,Y_mm in place of --square)

Pictures are paired by the number at the end of their names, or by their order. The frame c is the left camera's.
What the views cannot show is fixed and named; points, pictures and pairs that do not fit are left out and named.

Exit codes: 0 done; 2 bad input, or views that cannot support a calibration.)";

struct Words {
    std::vector<std::string> left;
    std::vector<std::string> right;
    BoardWords board;
    std::vector<std::string> fixed;
    double focal = 0.0;
    std::string out;
    std::string overlays;
    std::string points;
    bool keep_all = false;
    bool json = false;
};

std::string now_text() {
    return fmt::format(
        "{:%Y-%m-%dT%H:%M:%SZ}",
        fmt::gmtime(std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now())));
}

CameraFitOptions options_of(const Words& words) {
    return {.find_wrong = !words.keep_all, .fixed = words.fixed, .focal = words.focal};
}

Json camera_json(const CameraRecord& camera, const std::array<double, CameraModel::kParameters>& sigma) {
    const CameraModel& m = camera.model;
    return {{"id", camera.id},
            {"width_px", camera.width},
            {"height_px", camera.height},
            {"fx_px", m.focal_x},
            {"fy_px", m.focal_y},
            {"cx_px", m.middle_x},
            {"cy_px", m.middle_y},
            {"k1_k2_p1_p2_k3", m.distortion},
            {"sigma", sigma},
            {"fixed", camera.fixed},
            {"rms_px", camera.rms},
            {"reach", camera.reach}};
}

std::string camera_text(const CameraRecord& camera, const std::array<double, CameraModel::kParameters>& sigma) {
    const CameraModel& m = camera.model;
    const std::array<double, CameraModel::kParameters> values{m.focal_x,       m.focal_y,       m.middle_x,
                                                              m.middle_y,      m.distortion[0], m.distortion[1],
                                                              m.distortion[2], m.distortion[3], m.distortion[4]};
    std::string out = fmt::format("{}: {}x{} px, rms {:.4f} px\n", camera.id, camera.width, camera.height, camera.rms);
    for (std::size_t k = 0; k < values.size(); ++k) {
        out += std::ranges::find(camera.fixed, kCameraParameters[k]) != camera.fixed.end()
                   ? fmt::format("  {:<3} {:>12.5f}    fixed\n", kCameraParameters[k], values[k])
                   : fmt::format("  {:<3} {:>12.5f} +- {:.5f}\n", kCameraParameters[k], values[k], sigma[k]);
    }
    return out;
}

Json views_json(const std::vector<ViewFit>& views, bool pair) {
    Json out = Json::array();
    for (const ViewFit& v : views) {
        out.push_back({{"view", v.name}, {"used", v.used}});
        Json& json = out.back();
        if (!v.used) {
            json["why"] = v.why;
        }
        if (pair) {
            json["points"] = v.points;
            json["rms_px"] = v.rms;
        } else {
            json["points"] = v.points[0];
            json["rms_px"] = v.rms[0];
        }
        json["tilt_deg"] = v.tilt / kDegree;
        json["distance_mm"] = v.translation.z * 1e3;
    }
    return out;
}

Json wrong_json(const std::vector<WrongPoint>& wrong) {
    Json out = Json::array();
    for (const WrongPoint& w : wrong) {
        out.push_back({{"view", w.view},
                       {"camera", w.camera == 0 ? "left" : "right"},
                       {"column", w.column},
                       {"row", w.row},
                       {"off_px", w.off},
                       {"text", w.text()}});
        if (w.swapped) {
            out.back()["swapped_with"] = *w.swapped;
        }
    }
    return out;
}

std::string views_text(const std::vector<ViewFit>& views, bool pair) {
    std::string out = fmt::format("{:<12} {:>7} {:>9}", "view", "points", "rms px");
    out += pair ? fmt::format(" {:>7} {:>9}", "right", "rms px") : "";
    out += fmt::format(" {:>9} {:>11}\n", "tilt deg", "distance mm");
    for (const ViewFit& v : views) {
        out += fmt::format("{:<12} {:>7} {:>9.4f}", v.name, v.points[0], v.rms[0]);
        out += pair ? fmt::format(" {:>7} {:>9.4f}", v.points[1], v.rms[1]) : "";
        out += fmt::format(" {:>9.1f} {:>11.1f}{}\n", v.tilt / kDegree, v.translation.z * 1e3,
                           v.used ? "" : "  left out: " + v.why);
    }
    return out;
}

std::string findings_text(const std::vector<WrongPoint>& wrong, const std::vector<std::string>& notes) {
    std::string out;
    for (const WrongPoint& w : wrong) {
        out += w.text() + "\n";
    }
    for (const std::string& note : notes) {
        out += "note: " + note + "\n";
    }
    return out;
}

/// One SVG a picture: VIEW.svg, or left_VIEW.svg and right_VIEW.svg.
void write_overlays(const std::string& folder, const std::vector<ViewFit>& views, const std::vector<PointFit>& points,
                    const std::vector<CameraRecord>& cameras) {
    std::filesystem::create_directories(folder);
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        for (std::size_t v = 0; v < views.size(); ++v) {
            const std::string name = (cameras.size() > 1 ? cameras[c].id + "_" : std::string()) + views[v].name;
            write_text_file(
                std::filesystem::path(folder) / (name + ".svg"),
                svg_of(residual_drawing(points, v, c, {.columns = cameras[c].width, .rows = cameras[c].height})));
        }
    }
}

/// What was seen, as read_board_points takes it.
void write_points(const std::filesystem::path& file, const std::vector<BoardView>& views) {
    std::string out = "view,row,col,X_mm,Y_mm,u_px,v_px\n";
    for (const BoardView& view : views) {
        for (const BoardPoint& p : view.points) {
            out += fmt::format("{},{},{},{:.6f},{:.6f},{:.6f},{:.6f}\n", view.name, p.row, p.column, p.place.x * 1e3,
                               p.place.y * 1e3, p.seen[0], p.seen[1]);
        }
    }
    std::filesystem::create_directories(file.parent_path());
    write_text_file(file, out);
}

int run_camera(const Words& words) {
    install_stop_signals();
    const auto files = expanded(words.left);
    const BoardInput input = read_boards(files, words.board);
    if (!words.points.empty()) {
        write_points(std::filesystem::path(words.points) / "points.csv", input.views);
    }
    CameraFit fit = fit_camera(files.front(), input.views, options_of(words));
    fit.notes.insert(fit.notes.begin(), input.notes.begin(), input.notes.end());
    if (!words.out.empty()) {
        write_cameras(words.out, {.id = std::filesystem::path(words.out).stem().string(),
                                  .time = now_text(),
                                  .parents = files,
                                  .noise = fit.noise,
                                  .cameras = {fit.camera},
                                  .right_from_left = std::nullopt,
                                  .covariance = fit.covariance});
    }
    if (!words.overlays.empty()) {
        write_overlays(words.overlays, fit.views, fit.points, {fit.camera});
    }
    if (words.json) {
        Json json{{"format", "scribecell-camera-fit"}, {"version", 1}};
        json["camera"] = camera_json(fit.camera, fit.sigma);
        json["noise_px"] = fit.noise;
        json["freedom"] = fit.freedom;
        json["views"] = views_json(fit.views, false);
        json["wrong_points"] = wrong_json(fit.wrong);
        json["notes"] = fit.notes;
        std::printf("%s\n", json.dump(2).c_str());
    } else {
        std::fputs(
            (camera_text(fit.camera, fit.sigma) + views_text(fit.views, false) + findings_text(fit.wrong, fit.notes))
                .c_str(),
            stdout);
    }
    return kDone;
}

Json stereo_json(const StereoFit& fit) {
    Json json{{"format", "scribecell-stereo-fit"}, {"version", 1}};
    json["left"] = camera_json(fit.set.cameras[0], fit.left_sigma);
    json["right"] = camera_json(fit.set.cameras[1], fit.right_sigma);
    Json rows = Json::array();
    for (const Vec3& row : fit.set.right_from_left->rotation.row) {
        rows.push_back(vector_json(row));
    }
    const auto& s = fit.pose_sigma;
    json["right_from_left"] = {
        {"rotation", rows},
        {"translation_mm", vector_json(1e3 * fit.set.right_from_left->translation)},
        {"sigma_rotation_mdeg", {s[0] / kDegree * 1e3, s[1] / kDegree * 1e3, s[2] / kDegree * 1e3}},
        {"sigma_translation_um", {s[3] * 1e6, s[4] * 1e6, s[5] * 1e6}}};
    json["baseline_mm"] = fit.baseline * 1e3;
    json["baseline_sigma_um"] = fit.baseline_sigma * 1e6;
    json["rms_px"] = fit.rms;
    json["epipolar_rms_px"] = fit.epipolar_rms;
    json["noise_px"] = fit.set.noise;
    json["freedom"] = fit.freedom;
    json["expected_error"] = {{"distance_mm", fit.expected.distance * 1e3},
                              {"noise_um", vector_json(1e6 * fit.expected.noise)},
                              {"calibration_um", vector_json(1e6 * fit.expected.calibration)}};
    Json boards = Json::array();
    for (const BoardCheck& b : fit.boards) {
        boards.push_back({{"view", b.view}, {"points", b.points}, {"rms_mm", b.rms * 1e3}, {"scale_error", b.scale}});
    }
    json["boards"] = boards;
    json["views"] = views_json(fit.views, true);
    json["wrong_points"] = wrong_json(fit.wrong);
    json["notes"] = fit.notes;
    return json;
}

std::string stereo_text(const StereoFit& fit) {
    std::string out =
        camera_text(fit.set.cameras[0], fit.left_sigma) + camera_text(fit.set.cameras[1], fit.right_sigma);
    out +=
        "right_from_left:\n" + transform_text(fit.set.right_from_left->rotation, fit.set.right_from_left->translation);
    out += fmt::format("baseline {:.4f} +- {:.4f} mm; rms {:.4f} px, epipolar {:.4f} px\n", fit.baseline * 1e3,
                       fit.baseline_sigma * 1e3, fit.rms, fit.epipolar_rms);
    const ExpectedError& e = fit.expected;
    out += fmt::format(
        "a place {:.0f} mm away, 1 sigma x, y, z: {:.3f}, {:.3f}, {:.3f} mm by the noise of one pair of points, "
        "{:.3f}, "
        "{:.3f}, {:.3f} mm by the calibration\n",
        e.distance * 1e3, e.noise.x * 1e3, e.noise.y * 1e3, e.noise.z * 1e3, e.calibration.x * 1e3,
        e.calibration.y * 1e3, e.calibration.z * 1e3);
    out += views_text(fit.views, true);
    for (const BoardCheck& b : fit.boards) {
        out += fmt::format("board of view {}: {} points triangulated, {:.3f} mm rms off it, {:+.3f} % long\n", b.view,
                           b.points, b.rms * 1e3, b.scale * 100.0);
    }
    return out + findings_text(fit.wrong, fit.notes);
}

int run_stereo(const Words& words) {
    install_stop_signals();
    const auto left_files = expanded(words.left);
    const auto right_files = expanded(words.right);
    BoardInput left = read_boards(left_files, words.board);
    BoardInput right = read_boards(right_files, words.board);
    pair_names(left_files, left.views, right_files, right.views);
    if (!words.points.empty()) {
        write_points(std::filesystem::path(words.points) / "left.csv", left.views);
        write_points(std::filesystem::path(words.points) / "right.csv", right.views);
    }
    StereoFit fit = fit_stereo(left_files.front(), left.views, right_files.front(), right.views, options_of(words));
    fit.notes.insert(fit.notes.begin(), right.notes.begin(), right.notes.end());
    fit.notes.insert(fit.notes.begin(), left.notes.begin(), left.notes.end());
    if (!words.out.empty()) {
        fit.set.id = std::filesystem::path(words.out).stem().string();
        fit.set.time = now_text();
        fit.set.parents = left_files;
        fit.set.parents.insert(fit.set.parents.end(), right_files.begin(), right_files.end());
        write_cameras(words.out, fit.set);
    }
    if (!words.overlays.empty()) {
        write_overlays(words.overlays, fit.views, fit.points, fit.set.cameras);
    }
    if (words.json) {
        std::printf("%s\n", stereo_json(fit).dump(2).c_str());
    } else {
        std::fputs(stereo_text(fit).c_str(), stdout);
    }
    return kDone;
}

void add_common(CLI::App& sub, Words& words) {
    add_board_options(sub, words.board);
    sub.add_option("--fix", words.fixed,
                   "parameters that stay: distortion 0, cx and cy the picture's middle, fx and fy")
        ->delimiter(',')
        ->type_name("fx,fy,cx,cy,k1,k2,p1,p2,k3");
    sub.add_option("--focal-px", words.focal, "focal length to start with, or to stay at")->check(CLI::Range(1.0, 1e6));
    sub.add_flag("--keep-all", words.keep_all, "leave nothing out");
    sub.add_option("--out", words.out, "file of the cameras to write (scribecell-cameras)")->type_name("FILE");
    sub.add_option("--points", words.points, "folder for the points that were found, as CSV")->type_name("DIR");
    sub.add_option("--overlays", words.overlays, "folder for a drawing of each picture's residuals")->type_name("DIR");
    sub.add_flag("--json", words.json, "one JSON object");
}

}  // namespace

void add_calibrate_cameras(CLI::App& calibrate, int& exit_code) {
    CLI::App* camera = calibrate.add_subcommand("camera", "One camera, from pictures of a board.");
    camera->footer(kCameraExamples);
    const auto one = std::make_shared<Words>();
    camera->add_option("--pictures", one->left, "pictures, or one CSV of points")->required()->type_name("FILE...");
    add_common(*camera, *one);
    camera->callback([one, &exit_code] { exit_code = guarded(one->json, [&one] { return run_camera(*one); }); });
    CLI::App* stereo = calibrate.add_subcommand("stereo", "A pair of cameras, from pictures of a board.");
    stereo->footer(kStereoExamples);
    const auto two = std::make_shared<Words>();
    stereo->add_option("--left", two->left, "pictures, or one CSV of points")->required()->type_name("FILE...");
    stereo->add_option("--right", two->right, "pictures, or one CSV of points")->required()->type_name("FILE...");
    add_common(*stereo, *two);
    stereo->callback([two, &exit_code] { exit_code = guarded(two->json, [&two] { return run_stereo(*two); }); });
}

}  // namespace sc::host::cli
