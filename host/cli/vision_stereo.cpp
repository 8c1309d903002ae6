// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/calibration/marker_identity.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/vision/stereo_markers.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell vision stereo --left left.png --right right.png --calibration pair.toml
      places of all circular markers that both pictures show, in c (the left camera's frame), as CSV with 1 sigma
  scribecell vision stereo --left left.png --right right.png --calibration pair.toml --target fixed.toml
      --view pose7 --out clouds.csv --json
      only those of the target, with its numbers; the file is for `scribecell calibrate hand-eye --target`, and so on
  scribecell vision stereo --left left.png --right right.png --calibration pair.toml --radius-mm 3 --near-mm 400
      the markers' size and the least distance are known: fewer may be taken for each other

Markers are paired by epipolar lines and by their size; the target's are told apart by their mutual distances, however
many are missing or false. What is ambiguous is refused and named.
Exit codes: 0 done; 1 no markers, or the target is not recognised; 2 bad input or usage.)";

struct Words {
    std::string left;
    std::string right;
    std::string calibration;
    std::string target;
    std::string view;
    std::string out;
    double radius_mm = 0.0;
    double near_mm = 50.0;
    double far_mm = 20000.0;
    double tolerance_um = 50.0;
    bool uncorrected = false;
    bool json = false;
};

/// A marker's place with its number.
struct Numbered {
    int id = 0;
    const StereoMarker* marker = nullptr;
};

CameraSet pair_of(const Words& words) {
    CameraSet set = read_cameras(words.calibration);
    if (!set.right_from_left) {
        throw InputError({.file = words.calibration,
                          .problem = "one camera alone shows no places",
                          .value = set.id,
                          .action = "give a pair, from `scribecell calibrate stereo --out`"});
    }
    return set;
}

std::vector<Marker> markers_of(const std::string& file, const CameraRecord& camera) {
    const GreyImage image = read_image(file);
    if (image.width != camera.width || image.height != camera.height) {
        throw InputError(
            {.file = file,
             .problem = "the picture has not the size that the camera was calibrated with",
             .value = fmt::format("{}x{}, not {}x{}", image.width, image.height, camera.width, camera.height),
             .action = "give the whole picture of the " + camera.id + " camera"});
    }
    return find_markers(image).markers;
}

std::string csv_of(const std::vector<Numbered>& all, const std::string& view) {
    std::string out = view.empty() ? "" : "view,";
    out += "id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
    for (const Numbered& n : all) {
        const Vec3& p = n.marker->at.place;
        const Vec3 s = n.marker->at.sigma();
        out += view.empty() ? "" : view + ",";
        out += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f},{:.4f}\n", n.id, p.x * 1e3, p.y * 1e3, p.z * 1e3,
                           s.x * 1e6, s.y * 1e6, s.z * 1e6);
    }
    return out;
}

Json json_of(const Numbered& n) {
    const Triangulated& at = n.marker->at;
    const Vec3 s = at.sigma();
    return {{"id", n.id},
            {"place_mm", {at.place.x * 1e3, at.place.y * 1e3, at.place.z * 1e3}},
            {"sigma_um", {s.x * 1e6, s.y * 1e6, s.z * 1e6}},
            {"covariance_noise_m2", at.noise},
            {"covariance_calibration_m2", at.calibration},
            {"epipolar_px", at.epipolar},
            {"radius_mm", n.marker->radius * 1e3},
            {"normal", {n.marker->normal.x, n.marker->normal.y, n.marker->normal.z}}};
}

double worst(const PlaceCovariance& c) { return std::sqrt(std::max({c[0][0], c[1][1], c[2][2], 0.0})); }

struct Outcome {
    std::vector<Numbered> markers;
    std::optional<MarkerIdentity> identity;
    std::size_t strangers = 0;
    std::string refusal;
};

Outcome numbered(const Words& words, const StereoMarkers& found) {
    Outcome out;
    if (words.target.empty()) {
        int id = 0;
        for (const StereoMarker& m : found.markers) {
            out.markers.push_back({.id = ++id, .marker = &m});
        }
        return out;
    }
    std::vector<PlacedMarker> places;
    for (const StereoMarker& m : found.markers) {
        places.push_back({.place = m.at.place, .sigma = std::hypot(worst(m.at.noise), worst(m.at.calibration))});
    }
    const auto identity = identify_markers(read_target(words.target), places, {.tolerance = words.tolerance_um * 1e-6});
    if (!identity) {
        out.refusal = identity.error();
        return out;
    }
    out.identity = *identity;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (identity->ids[i]) {
            out.markers.push_back({.id = *identity->ids[i], .marker = &found.markers[i]});
        } else {
            ++out.strangers;
        }
    }
    std::ranges::sort(out.markers, {}, &Numbered::id);
    return out;
}

void print_json(const Words& words, const StereoMarkers& found, const Outcome& outcome) {
    Json markers = Json::array();
    for (const Numbered& n : outcome.markers) {
        markers.push_back(json_of(n));
    }
    Json json{{"left", words.left}, {"right", words.right}, {"markers", markers}};
    json["epipolar_rms_px"] = found.epipolar_rms;
    json["radius_mm"] = found.radius * 1e3;
    json["unpaired"] = found.refused;
    if (outcome.identity) {
        json["target_rms_um"] = outcome.identity->rms * 1e6;
        json["missing"] = outcome.identity->missing;
        json["not_of_the_target"] = outcome.strangers;
    }
    if (!outcome.refusal.empty()) {
        json["refused"] = outcome.refusal;
    }
    std::printf("%s\n", json.dump(2).c_str());
}

int run(const Words& words) {
    install_stop_signals();
    const CameraSet pair = pair_of(words);
    const auto left = markers_of(words.left, pair.cameras[0]);
    const auto right = markers_of(words.right, pair.cameras[1]);
    const StereoMarkers found = match_markers(pair, left, right,
                                              {.nearest = words.near_mm * 1e-3,
                                               .farthest = words.far_mm * 1e-3,
                                               .radius = words.radius_mm * 1e-3,
                                               .correct_perspective = !words.uncorrected});
    const Outcome outcome = numbered(words, found);
    const std::string csv = csv_of(outcome.markers, words.view);
    if (!words.out.empty() && !outcome.markers.empty()) {
        write_text_file(words.out, csv);
    }
    if (words.json) {
        print_json(words, found, outcome);
    } else {
        if (words.out.empty() && !outcome.markers.empty()) {
            std::fputs(csv.c_str(), stdout);
        }
        fmt::print(stderr, "{} markers left, {} right, {} paired; epipolar {:.4f} px rms, radius {:.3f} mm\n",
                   left.size(), right.size(), found.markers.size(), found.epipolar_rms, found.radius * 1e3);
        if (outcome.identity) {
            fmt::print(stderr, "{} of the target, {:.1f} um rms off it; {} missing, {} are not of it\n",
                       outcome.markers.size(), outcome.identity->rms * 1e6, outcome.identity->missing.size(),
                       outcome.strangers);
        }
        for (const std::string& text : found.refused) {
            fmt::print(stderr, "note: {}\n", text);
        }
        if (!outcome.refusal.empty()) {
            fmt::print(stderr, "refused: {}\n", outcome.refusal);
        }
    }
    return outcome.markers.empty() ? kFailed : kDone;
}

}  // namespace

void add_vision_stereo(CLI::App& vision, int& exit_code) {
    CLI::App* sub = vision.add_subcommand("stereo", "Places of circular markers from a calibrated pair of cameras.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--left", words->left, "picture")->required()->type_name("PNG");
    sub->add_option("--right", words->right, "picture of the same moment")->required()->type_name("PNG");
    sub->add_option("--calibration", words->calibration, "the pair (scribecell-cameras)")
        ->required()
        ->type_name("FILE");
    sub->add_option("--target", words->target, "whose markers to find (scribecell-target)")->type_name("FILE");
    sub->add_option("--view", words->view, "name of the view, for the file")->type_name("NAME");
    sub->add_option("--out", words->out, "CSV to write; else it is printed")->type_name("FILE");
    sub->add_option("--radius-mm", words->radius_mm, "of the markers; else what most agree on")
        ->check(CLI::Range(1e-3, 1e4));
    sub->add_option("--near-mm", words->near_mm, "least distance")->check(CLI::Range(1.0, 1e6))->capture_default_str();
    sub->add_option("--far-mm", words->far_mm, "largest distance")->check(CLI::Range(1.0, 1e6))->capture_default_str();
    sub->add_option("--tolerance-um", words->tolerance_um, "of the target's places, besides five sigma")
        ->check(CLI::Range(0.0, 1e5))
        ->capture_default_str();
    sub->add_flag("--uncorrected", words->uncorrected, "leave in what perspective does to a circle's middle");
    sub->add_flag("--json", words->json, "one JSON object on stdout");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
