// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/cli/failure.hpp"
#include "host/cli/register_view.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExamples = R"(Examples:
  scribecell register --scan-set scan.toml --still 101,102,103,104,105
      brings all views into one c by the markers in common; 101 to 105 stand still, all others turn with the table
  scribecell register --scan-set scan.toml --target ring.toml --out stitched.toml
      the same with the reference markers of a target; markers and clouds of all views in one c, with the table at C = 0
  scribecell register --scan-set scan.toml --target ring_in_c.toml --calibration cell.toml --out stitched.toml
      c is that of an earlier `calibrate chain --map ring_in_c.toml`, and the table's axis comes from its set
  scribecell register --scan-set scan.toml --ids-unknown --json
      numbers mean nothing: markers are matched by their mutual distances

Four or five markers in common do; with three, none can be found wrong. Wrong and swapped markers, and angles that were
read wrong, are named.
Exit codes: 0 done; 2 bad input, or views that cannot be brought together.)";

struct Words {
    ChainWords chain;
    std::string calibration;
    std::string out;
    std::string cloud_unit = "mm";
};

LengthUnit unit_of(const std::string& name) {
    const auto unit = length_unit(name);
    if (!unit) {
        throw InputError(
            {.problem = "--cloud-unit is no unit", .value = name, .action = "give " + length_unit_names()});
    }
    return *unit;
}

/// The axis of a calibration in its c, which must be that of the known places.
ChainInput::Axis known_axis(const Words& words, const ChainInput& input) {
    const CalibrationSet set = read_calibration(words.calibration);
    if (input.known.empty()) {
        throw InputError({.file = words.calibration,
                          .problem = "the axis is known in the calibration's c, but the views are in none of their own",
                          .action = "give the target that was written with it (calibrate chain --map)"});
    }
    const Rigid<frame::C, frame::H> c_from_h = h_from_c(set).inverse();
    const AxisLine& line = turntable_axis(set);
    return {(c_from_h * line.point).v, (c_from_h * line.direction).v};
}

/// One view with everything in it.
ScanSet stitched_set(const ScanSet& set, const ChainResult& chain, const fs::path& cloud) {
    ScanSet out;
    out.id = set.id + ", stitched";
    out.time = set.time;
    out.note = fmt::format("{} views in one c, table at C = 0", chain.views.size());
    ScanView view;
    view.id = "stitched";
    for (const ChainMarkerResult& m : chain.markers) {
        const auto& c = m.covariance.at;
        view.markers.push_back({m.id, m.place, std::sqrt((c[0][0] + c[1][1] + c[2][2]) / 3.0)});
    }
    view.cloud = cloud;
    out.views.push_back(std::move(view));
    return out;
}

int run(const Words& words) {
    const ScanSet set = read_scan_set(words.chain.scan_set);
    ChainInput input = chain_input(set, targets_of(words.chain));
    if (!words.calibration.empty()) {
        input.axis = known_axis(words, input);
    }
    const LengthUnit unit = unit_of(words.cloud_unit);
    const ChainResult chain = fit_chain(input, options_of(words.chain));
    nlohmann::ordered_json json = chain_json(chain);
    std::string text = chain_text(chain);
    if (!words.out.empty()) {
        fs::path cloud;
        const PointCloud points = stitch_clouds(set, chain, unit);
        if (!points.points.empty()) {
            cloud = fs::path(words.out).replace_extension(".ply");
            write_ply(cloud, points);
            json["cloud"] = cloud.string();
            json["points"] = points.points.size();
            text += fmt::format("{} points: {}\n", points.points.size(), cloud.string());
        }
        write_scan_set(words.out, stitched_set(set, chain, cloud));
        json["out"] = words.out;
    }
    write_chain_files(words.chain, chain);
    std::fputs((words.chain.json ? json.dump(2) + "\n" : text).c_str(), stdout);
    return 0;
}

}  // namespace

void add_register(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("register", "Bring the views of a scan set into one frame, by common markers.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    add_chain_words(*sub, words->chain);
    sub->add_option("--calibration", words->calibration, "set with h_from_c and the axis: the axis is not looked for")
        ->type_name("FILE");
    sub->add_option("--out", words->out, "scan set to write: one view with all markers, and a PLY beside it")
        ->type_name("FILE");
    sub->add_option("--cloud-unit", words->cloud_unit, "of clouds that state none")
        ->type_name("UNIT")
        ->capture_default_str();
    sub->callback([words, &exit_code] { exit_code = guarded(words->chain.json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
