// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/vision/circle_pose.hpp"
#include "host/vision/marker.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell vision markers target.png
      each circular marker: middle of its ellipse, semi-axes, angle, 1 sigma; what was refused, and why
  scribecell vision markers target.png --expect 12
      the same; exit code 1 if there are more or fewer than 12
  scribecell vision markers target.png --json --svg overlay.svg --png overlay.png
      one JSON object, and the ellipses drawn
  scribecell vision markers left.png --camera 2232,2232,959.5,599.5 --radius-mm 5
      where the middles of the circles are seen and lie, all of them on one plane (fx,fy,cx,cy in pixels)
  scribecell vision markers left.png --camera 2232,2232,959.5,599.5 --normal 0,0.7,-0.7
      the same, the plane's normal known (camera frame: x right, y down, z along the view)

Pixels: (0, 0) is the middle of the first pixel, y down. The camera has no distortion, or the picture none left.
What looks like a marker and is none (clutter of a real picture) is listed as refused; that is no failure.
Exit codes: 0 each picture has markers (with --expect: so many); 1 one has not, or the circles tell no plane; 2 bad
input or usage.)";

struct Words {
    std::vector<std::string> images;
    std::vector<double> camera;
    std::vector<double> normal;
    std::optional<double> radius_mm;
    std::optional<std::size_t> expect;
    std::string svg;
    std::string png;
    bool json = false;
};

/// The circles' plane, if the camera is known.
struct Plane {
    Pinhole camera;
    Vec3 normal;
};

[[noreturn]] void refuse(const std::string& problem, const std::string& value, const std::string& action) {
    throw InputError({.file = {}, .problem = problem, .value = value, .action = action});
}

void check(const Words& words) {
    if (words.camera.empty() && (!words.normal.empty() || words.radius_mm)) {
        refuse("--normal and --radius-mm need the camera", words.normal.empty() ? "--radius-mm" : "--normal",
               "give --camera fx,fy,cx,cy too");
    }
    if (!words.camera.empty() && !(words.camera[0] > 0.0 && words.camera[1] > 0.0)) {
        refuse("a focal length is not above zero", fmt::format("{},{}", words.camera[0], words.camera[1]),
               "give --camera fx,fy,cx,cy in pixels");
    }
    if (!words.normal.empty() && !(std::hypot(words.normal[0], words.normal[1], words.normal[2]) > 0.0)) {
        refuse("the normal has no direction", "0,0,0", "give --normal x,y,z in the camera frame");
    }
    if ((!words.svg.empty() || !words.png.empty()) && words.images.size() != 1) {
        refuse("one overlay is for one picture", fmt::format("{} pictures", words.images.size()),
               "give one picture at a time with --svg or --png");
    }
}

std::optional<Plane> plane_of(const Words& words, const std::vector<Marker>& markers, std::string& why) {
    if (words.camera.empty() || markers.empty()) {
        return std::nullopt;
    }
    Plane out{.camera = {.focal_x = words.camera[0],
                         .focal_y = words.camera[1],
                         .middle_x = words.camera[2],
                         .middle_y = words.camera[3]},
              .normal = {}};
    if (!words.normal.empty()) {
        const Vec3 given{words.normal[0], words.normal[1], words.normal[2]};
        out.normal = (1.0 / norm(given)) * given;
        return out;
    }
    std::vector<Ellipse> ellipses;
    for (const Marker& marker : markers) {
        ellipses.push_back(marker.ellipse);
    }
    const auto normal = common_normal(ellipses, out.camera);
    if (!normal) {
        why = normal.error();
        return std::nullopt;
    }
    out.normal = *normal;
    return out;
}

Json json_of(const Marker& m, const std::optional<Plane>& plane, const Words& words) {
    Json out{{"x_px", m.ellipse.x},
             {"y_px", m.ellipse.y},
             {"major_px", m.ellipse.major},
             {"minor_px", m.ellipse.minor},
             {"angle_deg", m.ellipse.angle / kDegree},
             {"dark", m.dark},
             {"sigma_px", m.sigma},
             {"covariance_px2", m.covariance},
             {"quality", {{"misfit_px", m.misfit}, {"contrast", m.contrast}, {"saturated", m.saturated}}}};
    if (plane) {
        const auto centre = circle_centre(m.ellipse, plane->camera, plane->normal);
        out["circle"] = {{"x_px", centre[0]}, {"y_px", centre[1]}};
        if (words.radius_mm) {
            const Vec3 place = circle_place(m.ellipse, plane->camera, plane->normal, *words.radius_mm);
            out["circle"]["place_mm"] = {place.x, place.y, place.z};
        }
    }
    return out;
}

Json json_of(const MarkerRefusal& r) {
    return {{"problem", name_of(r.problem)}, {"text", r.text},           {"x_px", r.where.x}, {"y_px", r.where.y},
            {"major_px", r.where.major},     {"minor_px", r.where.minor}};
}

Json json_of(const std::string& file, const MarkersFound& found, const Words& words, std::string& why) {
    const auto plane = plane_of(words, found.markers, why);
    Json markers = Json::array();
    for (const Marker& m : found.markers) {
        markers.push_back(json_of(m, plane, words));
    }
    Json refused = Json::array();
    for (const MarkerRefusal& r : found.refused) {
        refused.push_back(json_of(r));
    }
    Json out{{"image", file}, {"markers", markers}, {"refused", refused}};
    if (plane) {
        out["normal"] = {plane->normal.x, plane->normal.y, plane->normal.z};
    } else if (!why.empty()) {
        out["no_plane"] = why;
    }
    return out;
}

void print_text(const std::string& file, const MarkersFound& found, const Words& words, std::string& why) {
    const auto plane = plane_of(words, found.markers, why);
    std::printf("%s: %zu markers, %zu refused\n", file.c_str(), found.markers.size(), found.refused.size());
    for (const Marker& m : found.markers) {
        fmt::print("  ({:.3f}, {:.3f}) px, sigma {:.4f} px, semi-axes {:.3f} and {:.3f} px at {:.2f} deg", m.ellipse.x,
                   m.ellipse.y, m.sigma, m.ellipse.major, m.ellipse.minor, m.ellipse.angle / kDegree);
        if (plane) {
            const auto centre = circle_centre(m.ellipse, plane->camera, plane->normal);
            fmt::print("; the circle's middle is seen at ({:.3f}, {:.3f})", centre[0], centre[1]);
            if (words.radius_mm) {
                const Vec3 place = circle_place(m.ellipse, plane->camera, plane->normal, *words.radius_mm);
                fmt::print(" and lies at ({:.3f}, {:.3f}, {:.3f}) mm", place.x, place.y, place.z);
            }
        }
        fmt::print("\n");
    }
    for (const MarkerRefusal& r : found.refused) {
        fmt::print("  refused, {}: {}\n", name_of(r.problem), r.text);
    }
    if (!why.empty()) {
        fmt::print("  no plane: {}\n", why);
    }
}

int run(const Words& words) {
    install_stop_signals();
    check(words);
    Json all = Json::array();
    bool complete = true;
    for (const std::string& file : words.images) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const GreyImage image = read_image(file);
        const MarkersFound found = find_markers(image);
        std::string no_plane;
        if (words.json) {
            all.push_back(json_of(file, found, words, no_plane));
        } else {
            print_text(file, found, words, no_plane);
        }
        const bool enough = words.expect ? found.markers.size() == *words.expect : !found.markers.empty();
        if (words.expect && !enough) {
            fmt::print(stderr, "{}: {} markers are found, {} are expected\n", file, found.markers.size(),
                       *words.expect);
        }
        complete = complete && enough && no_plane.empty();
        if (!words.svg.empty()) {
            write_text_file(words.svg, svg_of(overlay_of(image, found)));
        }
        if (!words.png.empty()) {
            write_png(words.png, pixels_of(overlay_of(image, found)));
        }
    }
    if (words.json) {
        std::printf("%s\n", Json{{"pictures", all}}.dump(2).c_str());
    }
    return complete ? kDone : kFailed;
}

}  // namespace

void add_vision_markers(CLI::App& vision, int& exit_code) {
    CLI::App* sub = vision.add_subcommand("markers", "Centres of circular markers.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("images", words->images, "pictures")->required()->type_name("IMAGE...");
    sub->add_option("--camera", words->camera, "focal lengths and principal point, px")
        ->delimiter(',')
        ->expected(4)
        ->type_name("FX,FY,CX,CY");
    sub->add_option("--normal", words->normal, "of the circles' plane, camera frame")
        ->delimiter(',')
        ->expected(3)
        ->type_name("X,Y,Z");
    sub->add_option("--radius-mm", words->radius_mm, "of the circles")->check(CLI::Range(1e-3, 1e4));
    sub->add_option("--expect", words->expect, "how many each picture must have")->check(CLI::Range(1, 100000));
    sub->add_option("--svg", words->svg, "overlay to write")->type_name("FILE");
    sub->add_option("--png", words->png, "the same as pixels")->type_name("FILE");
    sub->add_flag("--json", words->json, "one JSON object on stdout");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
