// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/stand_pictures.hpp"
#include "host/formats/error.hpp"
#include "host/measurement/reference_fit.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kParallelismExamples = R"(Examples:
  scribecell calibrate parallelism stand.toml --out head.toml
      camera scale, beams, gains and zeros of the triple-laser head; which screw to turn; the rest goes into head.toml
  scribecell calibrate parallelism stand.toml --calibration cell.toml --out cell2.toml --json
      the same, added to a calibration set; where it has h_from_d, the rays in h too

stand.toml: docs/formats.md. Equal triangles at all heights say that the beams are parallel; that the triangle stays in
place says that they are perpendicular to the plates.)";
constexpr const char* kReferenceExamples = R"(Examples:
  scribecell calibrate reference --readings known_readings.csv --known known.csv --calibration head.toml --out head2.toml
      where the reference plane lies, from stations whose angle (yaw, distance) is known from elsewhere
  ... --seat-deg 0.02 --seat-mm 0.05
      the base was put down again for each station)";

struct Words {
    std::string stand;
    std::string readings;
    std::string known;
    std::string calibration;
    std::string out;
    double seat_deg = 0.0;
    double seat_mm = 0.0;
    bool json = false;
};

std::string now_text() {
    return fmt::format(
        "{:%Y-%m-%dT%H:%M:%SZ}",
        fmt::gmtime(std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now())));
}

CalibrationSet next_set(const std::string& file, const std::string& what) {
    CalibrationSet set;
    if (file.empty()) {
        set.id = what;
    } else {
        set = read_calibration(file);
        set.parents = {set.id};
        set.id += "+" + what;
    }
    set.time = now_text();
    return set;
}

Json json_of(const Parallelism& p) {
    Json plates = Json::array();
    for (const PlateScale& plate : p.plates) {
        plates.push_back({{"z_mm", plate.z * 1e3},
                          {"px_per_mm", plate.px_per_mm},
                          {"dots_rms_um", plate.residual * 1e6},
                          {"side_mm", {plate.side[0] * 1e3, plate.side[1] * 1e3, plate.side[2] * 1e3}},
                          {"middle_mm", {plate.middle[0] * 1e3, plate.middle[1] * 1e3}}});
    }
    Json beams = Json::array();
    for (std::size_t i = 0; i < 3; ++i) {
        const TripleRay& ray = p.head.rays[i];
        beams.push_back({{"id", ray.id},
                         {"origin_mm", {ray.origin[0] * 1e3, ray.origin[1] * 1e3}},
                         {"tilt_mrad", {ray.tilt[0] * 1e3, ray.tilt[1] * 1e3}},
                         {"tilt_sigma_mrad", {p.tilt_sigma[i][0] * 1e3, p.tilt_sigma[i][1] * 1e3}},
                         {"zero_mm", ray.zero * 1e3},
                         {"gain_ppm", ray.gain * 1e6},
                         {"sigma_um", ray.sigma * 1e6}});
    }
    Json turns = Json::array();
    for (const MountTurn& turn : p.turns) {
        turns.push_back({{"sensor", turn.sensor},
                         {"screw", std::string(1, turn.axis)},
                         {"tilt_mrad", turn.tilt * 1e3},
                         {"turns_clockwise", turn.turns}});
    }
    return {{"plates", plates},
            {"beams", beams},
            {"parallelism",
             {{"between_mrad", {p.between[0] * 1e3, p.between[1] * 1e3, p.between[2] * 1e3}},
              {"side_drift_um_per_mm", {p.side_drift[0] * 1e3, p.side_drift[1] * 1e3, p.side_drift[2] * 1e3}},
              {"sigma_um_per_mm",
               {p.side_drift_sigma[0] * 1e3, p.side_drift_sigma[1] * 1e3, p.side_drift_sigma[2] * 1e3}}}},
            {"perpendicularity",
             {{"drift_um_per_mm", {p.drift[0] * 1e3, p.drift[1] * 1e3}}, {"sigma_um_per_mm", p.drift_sigma * 1e3}}},
            {"spots_rms_um", p.place_rms * 1e6},
            {"screws", turns}};
}

std::string text_of(const Parallelism& p) {
    std::string out =
        fmt::format("{:>9} {:>16} {:>9} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "height mm", "px per mm x, y", "dots um",
                    "side 1-2", "side 2-3", "side 3-1", "middle x", "middle y");
    for (const PlateScale& plate : p.plates) {
        out += fmt::format("{:>9.3f} {:>8.4f}{:>8.4f} {:>9.1f} {:>10.3f} {:>10.3f} {:>10.3f} {:>10.3f} {:>10.3f}\n",
                           plate.z * 1e3, plate.px_per_mm[0], plate.px_per_mm[1], plate.residual * 1e6,
                           plate.side[0] * 1e3, plate.side[1] * 1e3, plate.side[2] * 1e3, plate.middle[0] * 1e3,
                           plate.middle[1] * 1e3);
    }
    out += "parallelism: sides change by";
    for (std::size_t i = 0; i < 3; ++i) {
        out += fmt::format(" {:.3f} +- {:.3f}", p.side_drift[i] * 1e3, 1.96 * p.side_drift_sigma[i] * 1e3);
    }
    out +=
        fmt::format(" um a mm of height\nperpendicularity: the triangle drifts by {:.3f}, {:.3f} +- {:.3f} um a mm\n",
                    p.drift[0] * 1e3, p.drift[1] * 1e3, 1.96 * p.drift_sigma * 1e3);
    for (std::size_t i = 0; i < 3; ++i) {
        const TripleRay& ray = p.head.rays[i];
        out += fmt::format("{}: tilt {:.3f}, {:.3f} +- {:.3f} mrad; zero {:.4f} mm, gain {:.0f} ppm, noise {:.1f} um\n",
                           ray.id, ray.tilt[0] * 1e3, ray.tilt[1] * 1e3, 1.96 * p.tilt_sigma[i][0] * 1e3,
                           ray.zero * 1e3, ray.gain * 1e6, ray.sigma * 1e6);
    }
    for (const MountTurn& turn : p.turns) {
        out += fmt::format("to bring {} upright: screw {} {:.2f} turns {}\n", turn.sensor, turn.axis,
                           turn.turns < 0.0 ? -turn.turns : turn.turns,
                           turn.turns < 0.0 ? "counter-clockwise" : "clockwise");
    }
    return out;
}

int run_parallelism(const Words& words) {
    install_stop_signals();
    const Stand stand = read_stand(words.stand);
    CalibrationSet set = next_set(words.calibration, "parallelism");
    const Parallelism result = fit_parallelism(stand, pixels_of(stand), readings_of(stand));
    set.triple = result.head;
    set.triple->provenance.time = set.time;
    if (const TransformRecord* h_from_d = set.find("h_from_d")) {
        set.triple_head = rays_in_h(result.head, *h_from_d, stand.heights.front().z);
    }
    const std::string hash = write_calibration(words.out, set);
    if (words.json) {
        Json json = json_of(result);
        json["out"] = words.out;
        json["sha256"] = hash;
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    std::fputs(text_of(result).c_str(), stdout);
    std::printf("what is left is taken out by the software: %s\n", words.out.c_str());
    return 0;
}

int run_reference(const Words& words) {
    CalibrationSet set = next_set(words.calibration, "reference");
    if (!set.triple) {
        throw InputError({.file = words.calibration,
                          .problem = "has no triple-laser head",
                          .value = {},
                          .action = "run scribecell calibrate parallelism first"});
    }
    StationOptions options;
    options.seat = {.angle = words.seat_deg * kDegree, .place = words.seat_mm * 1e-3};
    const ReferenceFit fit =
        fit_reference(*set.triple, read_stations(words.readings), read_known(words.known), options);
    set.triple = fit.head;
    set.triple->provenance.time = set.time;
    const std::string hash = write_calibration(words.out, set);
    Json rows = Json::array();
    for (const KnownResidual& r : fit.residuals) {
        rows.push_back(
            {{"station", r.station}, {"before_deg", r.angle_before / kDegree}, {"after_deg", r.angle_after / kDegree}});
    }
    if (words.json) {
        const Json json{{"stations", rows},
                        {"angle_sigma_before_deg", fit.angle_sigma_before / kDegree},
                        {"angle_sigma_after_deg", fit.angle_sigma_after / kDegree},
                        {"misfit", fit.misfit},
                        {"out", words.out},
                        {"sha256", hash}};
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    for (const KnownResidual& r : fit.residuals) {
        std::printf("%-16s off by %8.4f deg before, %8.4f after\n", r.station.c_str(), r.angle_before / kDegree,
                    r.angle_after / kDegree);
    }
    std::printf("an angle is now uncertain by %.4f deg (95 %%) from the geometry, %.4f before: %s\n",
                1.96 * fit.angle_sigma_after / kDegree, 1.96 * fit.angle_sigma_before / kDegree, words.out.c_str());
    return 0;
}

}  // namespace

void add_calibrate_triple(CLI::App& calibrate, int& exit_code) {
    CLI::App* parallelism =
        calibrate.add_subcommand("parallelism", "Beams of the triple-laser head, from pictures of its spots.");
    parallelism->footer(kParallelismExamples);
    const auto words = std::make_shared<Words>();
    parallelism->add_option("stand", words->stand, "plates, pictures, readings")->required()->type_name("FILE");
    parallelism->add_option("--calibration", words->calibration, "calibration set to add to")->type_name("FILE");
    parallelism->add_option("--out", words->out, "calibration set to write")->required()->type_name("FILE");
    parallelism->add_flag("--json", words->json, "one JSON object on stdout");
    parallelism->callback(
        [words, &exit_code] { exit_code = guarded(words->json, [&words] { return run_parallelism(*words); }); });

    CLI::App* reference =
        calibrate.add_subcommand("reference", "Reference plane of the triple-laser head, from known stations.");
    reference->footer(kReferenceExamples);
    reference->add_option("--readings", words->readings, "readings of the known stations")
        ->required()
        ->type_name("FILE");
    reference->add_option("--known", words->known, "their true poses")->required()->type_name("FILE");
    reference->add_option("--calibration", words->calibration, "set with the head")->required()->type_name("FILE");
    reference->add_option("--out", words->out, "calibration set to write")->required()->type_name("FILE");
    reference->add_option("--seat-deg", words->seat_deg, "how the base sits when put down again, 1 sigma")
        ->check(CLI::Range(0.0, 10.0));
    reference->add_option("--seat-mm", words->seat_mm, "the same as a place")->check(CLI::Range(0.0, 100.0));
    reference->add_flag("--json", words->json, "one JSON object on stdout");
    reference->callback(
        [words, &exit_code] { exit_code = guarded(words->json, [&words] { return run_reference(*words); }); });
}

}  // namespace sc::host::cli
