// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibration/rigid_fit.hpp"
#include "host/calibration/turntable_fit.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSameTilt = 0.01 * kDegree;  ///< readings of a tilt that stands still
constexpr const char* kRigidExamples = R"(Examples:
  scribecell calibrate rigid --from c.csv --to h.csv --name h_from_c
      the transform between two frames from markers measured in both (id,x_mm,y_mm,z_mm and sigma_um, or sigma_x_um,
      sigma_y_um, sigma_z_um)
  scribecell calibrate rigid --from c.csv --to h.csv --name h_from_c --calibration old.toml --out new.toml --json
      the same, as a record of a calibration set

Markers that do not match are named and left out.
Exit codes: 0 done; 2 bad input, or markers that cannot support a transform.)";
constexpr const char* kAxisExamples = R"(Examples:
  scribecell calibrate axis --poses markers.csv
      axis of a turntable from markers at known angles (view,turn_deg,id,x_mm,y_mm,z_mm,sigma_um); arcs of 90 degrees do
  scribecell calibrate axis --poses poses.csv --fit-noise --json
      from poses of a target on the table (turn_deg, x_mm, y_mm, z_mm and a rotation; tilt_deg or tilt_rad: an axis for
      each tilt, within 0.01 degrees)

Exit codes: 0 done; 2 bad input, or data that cannot support an axis.)";

struct RigidWords {
    std::string from;
    std::string to;
    std::string name = "to_from_from";
    std::string unit;
    std::string calibration;
    std::string out;
    double sigma_um = 7.5;
    bool keep_all = false;
    bool json = false;
};

std::vector<SeenMarker> cloud_of(const std::string& file, const std::string& unit) {
    const MarkerFile markers = read_marker_views(file, {.columns = {}, .unit = unit});
    if (markers.views.size() != 1) {
        throw InputError({.file = file,
                          .problem = "has several views where one cloud is meant",
                          .value = std::to_string(markers.views.size()),
                          .action = "give one view, or no column view"});
    }
    return markers.views.front().markers;
}

Json json_of(const RigidFit& fit, const std::string& name) {
    Json markers = Json::array();
    Json wrong = Json::array();
    for (const RigidMarker& m : fit.markers) {
        markers.push_back({{"id", m.id},
                           {"used", m.used},
                           {"residual_um", vector_json(1e6 * m.residual)},
                           {"chi_squared", m.surprise}});
        if (!m.used) {
            wrong.push_back(m.id);
        }
    }
    return {{"format", "scribecell-rigid"},
            {"version", 1},
            {name, transform_json(fit.rotation, fit.translation, fit.covariance)},
            {"rms_um", fit.rms * 1e6},
            {"chi_squared", fit.chi_squared},
            {"freedom", fit.freedom},
            {"sigma_raised", fit.raised},
            {"wrong_markers", wrong},
            {"markers", markers}};
}

std::string text_of(const RigidFit& fit, const std::string& name) {
    std::string out = name + ":\n" + transform_text(fit.rotation, fit.translation) +
                      fmt::format("rms {:.2f} um each coordinate, chi-squared {:.1f} of {:.0f}\n", fit.rms * 1e6,
                                  fit.chi_squared, fit.freedom);
    if (fit.raised > 1.0) {
        out += fmt::format("note: the markers scatter more than stated: the uncertainty is raised by {:.2f}\n",
                           fit.raised);
    }
    out += fmt::format("{:>6} {:>10} {:>10} {:>10} {:>10}\n", "marker", "dx um", "dy um", "dz um", "chi2 of 3");
    for (const RigidMarker& m : fit.markers) {
        out +=
            fmt::format("{:>6} {:>10.2f} {:>10.2f} {:>10.2f} {:>10.1f}{}\n", m.id, m.residual.x * 1e6,
                        m.residual.y * 1e6, m.residual.z * 1e6, m.surprise, m.used ? "" : "  left out: does not match");
    }
    return out;
}

int run_rigid(const RigidWords& words) {
    RigidOptions options;
    options.sigma = words.sigma_um * 1e-6;
    options.find_wrong = !words.keep_all;
    const RigidFit fit = fit_rigid(words.to, cloud_of(words.to, words.unit), cloud_of(words.from, words.unit), options);
    std::string hash;
    if (!words.out.empty()) {
        TransformRecord record;
        record.id = words.name;
        record.rotation = fit.rotation;
        record.translation = fit.translation;
        record.covariance = fit.covariance;
        record.provenance.parents = {words.from, words.to};
        record.provenance.residual_rms = fit.rms;
        hash = save_transform({.calibration = words.calibration, .out = words.out}, "rigid", std::move(record));
    }
    if (words.json) {
        Json json = json_of(fit, words.name);
        if (!hash.empty()) {
            json["out"] = words.out;
            json["sha256"] = hash;
        }
        std::printf("%s\n", json.dump(2).c_str());
    } else {
        std::fputs(text_of(fit, words.name).c_str(), stdout);
    }
    return 0;
}

struct AxisWords {
    std::string poses;
    std::string unit;
    double target_um = 7.5;
    double target_mdeg = 1.5;
    double table_mdeg = 0.5;
    bool fit_noise = false;
    bool keep_all = false;
    bool json = false;
};

/// One axis, at one tilt.
struct Axis {
    std::optional<double> tilt;
    TurntableFit fit;
};

std::vector<Axis> axes_of(const AxisWords& words) {
    TurntableOptions options;
    options.sigma = words.target_um * 1e-6;
    options.table = words.table_mdeg * 1e-3 * kDegree;
    options.fit_noise = words.fit_noise;
    options.find_wrong = !words.keep_all;
    const PoseFileWords file{.columns = {}, .unit = words.unit};
    std::vector<Axis> out;
    if (holds_markers(words.poses, file)) {
        out.push_back({std::nullopt, fit_turntable(words.poses, read_marker_views(words.poses, file).views, options)});
        return out;
    }
    std::vector<NamedPose> left = read_poses(words.poses, file).poses;
    while (!left.empty()) {
        const std::optional<double> tilt = left.front().tilt;
        std::vector<NamedPose> here;
        std::vector<NamedPose> rest;
        for (NamedPose& pose : left) {
            const bool same = !tilt || std::abs(*pose.tilt - *tilt) <= kSameTilt;
            (same ? here : rest).push_back(std::move(pose));
        }
        out.push_back({tilt, fit_turntable_poses(words.poses, here, words.target_mdeg * 1e-3 * kDegree, options)});
        left = std::move(rest);
    }
    return out;
}

Json json_of(const Axis& axis) {
    const TurntableFit& fit = axis.fit;
    Json views = Json::array();
    for (const TurntableView& v : fit.views) {
        views.push_back({{"view", v.name},
                         {"turn_deg", v.turn / kDegree},
                         {"used", v.used},
                         {"turn_off_mdeg", v.turn_off / kDegree * 1e3},
                         {"rms_um", v.rms * 1e6}});
    }
    Json markers = Json::array();
    for (const MarkerFinding& m : fit.markers) {
        markers.push_back({{"view", m.view}, {"id", m.id}, {"text", m.text()}});
    }
    Json json{{"point_mm", vector_json(1e3 * fit.point)}, {"direction", vector_json(fit.direction)}};
    if (axis.tilt) {
        json["tilt_deg"] = *axis.tilt / kDegree;
    }
    json["direction_sigma_mdeg"] = fit.turn_sigma() / kDegree * 1e3;
    json["place_sigma_um"] = fit.place_sigma() * 1e6;
    json["across"] = {vector_json(fit.across[0]), vector_json(fit.across[1])};
    json["covariance"] = fit.covariance.at;
    json["radius_mm"] = fit.radius * 1e3;
    json["arc_deg"] = fit.arc / kDegree;
    json["rms_um"] = fit.rms * 1e6;
    json["chi_squared"] = fit.chi_squared;
    json["freedom"] = fit.freedom;
    json["noise_ratio"] = fit.noise_ratio;
    json["markers"] = markers;
    json["notes"] = fit.notes;
    json["views"] = views;
    return json;
}

std::string text_of(const Axis& axis) {
    const TurntableFit& fit = axis.fit;
    std::string out = axis.tilt ? fmt::format("at tilt {:.4f} deg\n", *axis.tilt / kDegree) : std::string();
    out += fmt::format(
        "axis through ({:.4f}, {:.4f}, {:.4f}) mm along ({:.7f}, {:.7f}, {:.7f})\n"
        "1 sigma: {:.4g} um across, {:.4g} mdeg; {} angles over {:.1f} deg, radius {:.1f} mm; rms {:.4g} um, noise "
        "{:.3g} "
        "times that stated\n",
        fit.point.x * 1e3, fit.point.y * 1e3, fit.point.z * 1e3, fit.direction.x, fit.direction.y, fit.direction.z,
        fit.place_sigma() * 1e6, fit.turn_sigma() / kDegree * 1e3, fit.views.size(), fit.arc / kDegree,
        fit.radius * 1e3, fit.rms * 1e6, fit.noise_ratio);
    for (const MarkerFinding& m : fit.markers) {
        out += m.text() + "\n";
    }
    for (const std::string& note : fit.notes) {
        out += "note: " + note + "\n";
    }
    return out;
}

int run_axis(const AxisWords& words) {
    const std::vector<Axis> axes = axes_of(words);
    if (words.json) {
        Json list = Json::array();
        for (const Axis& axis : axes) {
            list.push_back(json_of(axis));
        }
        std::printf("%s\n", Json{{"format", "scribecell-axis"}, {"version", 1}, {"axes", list}}.dump(2).c_str());
        return 0;
    }
    for (const Axis& axis : axes) {
        std::fputs(text_of(axis).c_str(), stdout);
    }
    return 0;
}

}  // namespace

void add_calibrate_rigid(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand("rigid", "Transform between two frames, from markers measured in both.");
    sub->footer(kRigidExamples);
    const auto words = std::make_shared<RigidWords>();
    sub->add_option("--from", words->from, "markers in the frame to come from")->type_name("FILE")->required();
    sub->add_option("--to", words->to, "the same markers in the frame to go to")->type_name("FILE")->required();
    sub->add_option("--name", words->name, "of the transform, e.g. h_from_c")->type_name("NAME")->capture_default_str();
    sub->add_option("--unit", words->unit, "of x,y,z without one: mm, m, inch")->type_name("UNIT");
    sub->add_option("--sigma-um", words->sigma_um, "noise of a coordinate that states none")
        ->check(CLI::Range(1e-6, 1e9))
        ->capture_default_str();
    sub->add_flag("--keep-all", words->keep_all, "leave nothing out");
    sub->add_option("--calibration", words->calibration, "set to extend")->type_name("FILE");
    sub->add_option("--out", words->out, "calibration set to write")->type_name("FILE");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run_rigid(*words); }); });
}

void add_calibrate_axis(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand("axis", "Axis of a turntable, from markers or poses at known angles.");
    sub->footer(kAxisExamples);
    const auto words = std::make_shared<AxisWords>();
    sub->add_option("--poses", words->poses, "markers, or poses of a target, with the table's angle")
        ->type_name("FILE")
        ->required();
    const CLI::Range some(1e-6, 1e9);
    sub->add_option("--unit", words->unit, "of x,y,z without one: mm, m, inch")->type_name("UNIT");
    sub->add_option("--target-um", words->target_um, "noise of a marker that states none, or of a target's place")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--target-mdeg", words->target_mdeg, "noise of a target's rotation")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--table-mdeg", words->table_mdeg, "noise of an angle")->check(some)->capture_default_str();
    sub->add_flag("--fit-noise", words->fit_noise, "how large the noise is comes from the data");
    sub->add_flag("--keep-all", words->keep_all, "leave nothing out");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run_axis(*words); }); });
}

}  // namespace sc::host::cli
