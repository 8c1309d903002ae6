// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/calibration/board_pose.hpp"
#include "host/cli/board_input.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/measurement/robot_frames.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell vision board --pictures view*.png --board 10x10 --square 20 --dots --camera camera.toml --out poses.csv
      where the board stands in each picture (c_from_g), as poses for `scribecell calibrate hand-eye --target`
  scribecell vision board --pictures centres.csv --size 640x480 --pinhole 550,550,320,240 --out poses.csv --json
      from points that any program has measured (view,row,col,X_mm,Y_mm,u_px,v_px), the camera by four numbers

Views are named as in the file, or as the pictures without their ending. The board's frame has x along its columns, y
along its rows, or as the file's X and Y say.
Exit codes: 0 every view has a pose; 1 one has none; 2 bad input or usage.)";

struct Words {
    std::vector<std::string> pictures;
    BoardWords board;
    std::string camera;
    std::string id;
    std::vector<double> pinhole;
    std::string out;
    bool keep_all = false;
    bool json = false;
};

CameraModel camera_of(const Words& words, BoardWords& board) {
    if (words.camera.empty() == words.pinhole.empty()) {
        throw InputError({.file = {},
                          .problem = "the camera must be given once",
                          .value = words.camera.empty() ? "neither" : "both",
                          .action = "give --camera FILE, or --pinhole fx,fy,cx,cy"});
    }
    if (!words.pinhole.empty()) {
        const auto& p = words.pinhole;
        if (!(p[0] > 0.0 && p[1] > 0.0)) {
            throw InputError({.file = {},
                              .problem = "a focal length is not above zero",
                              .value = fmt::format("{},{}", p[0], p[1]),
                              .action = "give --pinhole fx,fy,cx,cy in pixels"});
        }
        return {.focal_x = p[0], .focal_y = p[1], .middle_x = p[2], .middle_y = p[3]};
    }
    const CameraSet set = read_cameras(words.camera);
    for (const CameraRecord& camera : set.cameras) {
        if (camera.id == words.id || (words.id.empty() && &camera == &set.cameras.front())) {
            board.size = board.size.empty() ? fmt::format("{}x{}", camera.width, camera.height) : board.size;
            return camera.model;
        }
    }
    throw InputError({.file = words.camera,
                      .problem = "no camera is called so",
                      .value = words.id,
                      .action = "give --id left or right"});
}

std::string poses_csv(const std::vector<BoardPose>& poses) {
    std::string out = "view,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
    for (const BoardPose& p : poses) {
        const auto q = quaternion_of(p.fit.rotation);
        const Vec3& t = p.fit.translation;
        out += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.12f},{:.12f},{:.12f},{:.12f}\n", p.fit.name, t.x * 1e3,
                           t.y * 1e3, t.z * 1e3, q[0], q[1], q[2], q[3]);
    }
    return out;
}

int run(const Words& words) {
    install_stop_signals();
    BoardWords board = words.board;
    const CameraModel camera = camera_of(words, board);
    const auto files = expanded(words.pictures);
    const BoardInput input = read_boards(files, board);
    BoardPoses found = find_board_poses(files.front(), input.views, camera, !words.keep_all);
    found.notes.insert(found.notes.begin(), input.notes.begin(), input.notes.end());
    const std::string csv = poses_csv(found.poses);
    if (!words.out.empty()) {
        write_text_file(words.out, csv);
    }
    if (words.json) {
        Json views = Json::array();
        for (const BoardPose& p : found.poses) {
            const auto& s = p.fit.sigma;
            views.push_back(
                {{"view", p.fit.name},
                 {"points", p.fit.points[0]},
                 {"rms_px", p.fit.rms[0]},
                 {"translation_mm", {p.fit.translation.x * 1e3, p.fit.translation.y * 1e3, p.fit.translation.z * 1e3}},
                 {"quaternion_wxyz", quaternion_of(p.fit.rotation)},
                 {"sigma_rotation_mdeg", {s[0] / kDegree * 1e3, s[1] / kDegree * 1e3, s[2] / kDegree * 1e3}},
                 {"sigma_translation_um", {s[3] * 1e6, s[4] * 1e6, s[5] * 1e6}},
                 {"tilt_deg", p.fit.tilt / kDegree},
                 {"mirrored_rms_px", p.mirrored}});
        }
        Json wrong = Json::array();
        for (const WrongPoint& w : found.wrong) {
            wrong.push_back(w.text());
        }
        std::printf("%s\n",
                    Json{{"noise_px", found.noise}, {"views", views}, {"wrong_points", wrong}, {"notes", found.notes}}
                        .dump(2)
                        .c_str());
    } else {
        if (words.out.empty()) {
            std::fputs(csv.c_str(), stdout);
        }
        for (const WrongPoint& w : found.wrong) {
            std::fprintf(stderr, "%s\n", w.text().c_str());
        }
        for (const std::string& note : found.notes) {
            std::fprintf(stderr, "note: %s\n", note.c_str());
        }
    }
    return found.poses.size() == input.views.size() ? kDone : kFailed;
}

}  // namespace

void add_vision_board(CLI::App& vision, int& exit_code) {
    CLI::App* sub = vision.add_subcommand("board", "Poses of a board before a calibrated camera.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--pictures", words->pictures, "pictures, or one CSV of points")->required()->type_name("FILE...");
    add_board_options(*sub, words->board);
    sub->add_option("--camera", words->camera, "calibrated cameras (scribecell-cameras)")->type_name("FILE");
    sub->add_option("--id", words->id, "which of them; the first without it")->type_name("left|right");
    sub->add_option("--pinhole", words->pinhole, "focal lengths and middle, px; no distortion")
        ->delimiter(',')
        ->expected(4)
        ->type_name("FX,FY,CX,CY");
    sub->add_option("--out", words->out, "file of poses to write; else they are printed")->type_name("FILE");
    sub->add_flag("--keep-all", words->keep_all, "leave no point out");
    sub->add_flag("--json", words->json, "one JSON object on stdout");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
