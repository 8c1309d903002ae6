// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/calibration/axis_map_fit.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/formats/error.hpp"
#include "shared/link/map_codec.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate axes --measurements axes.csv --calibration old.toml --out new.toml
      squareness, scale, straightness, pitch and backlash of X, Y and Z
  scribecell calibrate axes --table-measurements table.csv --calibration old.toml --out new.toml
      pitch, shift, tilt and backlash of the turntable, about the axis that old.toml has
  scribecell calibrate axes --measurements axes.csv --table-measurements table.csv --calibration old.toml
      --out new.toml --link serial:/dev/ttyUSB0
      both, for the travel and limits of a cell

axes.csv: x,y,z,dir_x,dir_y,dir_z,true_x,true_y,true_z: readings, the way of the last motion (-1, 1; 0 or no column:
not known) and the true place, mm in h. table.csv: c,dir_c,target,true_x,true_y,true_z: the reading of C in degrees, and
the true place of a numbered target on the table. Data that do not support a map are refused.)";

struct CalibrateOptions {
    std::string measurements;
    std::string table_measurements;
    std::string calibration;
    std::string out;
    std::string link = "sim:";
    LinkOptions link_options;
    bool json = false;
};

Json quality_json(const FitQuality& q) {
    return {{"points", q.points},
            {"before_rms_um", q.before_rms * 1e6},
            {"residual_rms_um", q.residual_rms * 1e6},
            {"residual_max_um", q.residual_max * 1e6},
            {"worst_sigma_um", q.worst_sigma * 1e6}};
}

std::string quality_text(const char* name, const FitQuality& q) {
    return fmt::format(
        "{:<6} {} points: {:.1f} um rms before, {:.2f} um after (largest {:.2f}); least certain {:.2f}\n", name,
        q.points, q.before_rms * 1e6, q.residual_rms * 1e6, q.residual_max * 1e6, q.worst_sigma * 1e6);
}

/// The simulated cell is the reference machine: nothing need be started for it.
MachineConfig machine_of(const std::string& link, const LinkOptions& options) {
    if (is_simulated(link)) {
        return reference_machine();
    }
    const auto transport = open_transport(link, options);
    CellClient client(*transport, client_options(options, std::random_device{}()));
    client.connect();
    return client.read_config();
}

int run(const CalibrateOptions& options) {
    if (options.measurements.empty() && options.table_measurements.empty()) {
        throw InputError({.file = {},
                          .problem = "there is nothing to calibrate from",
                          .value = {},
                          .action = "give --measurements, --table-measurements or both"});
    }
    CalibrationSet set = read_calibration(options.calibration);
    const MachineConfig machine = machine_of(options.link, options.link_options);
    set.parents = {set.id};
    set.id += "+axes";
    set.time = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::now()));
    Json json;
    std::string text;
    if (!options.measurements.empty()) {
        const FitQuality q = fit_axes(set, machine, read_axes_points(options.measurements), options.measurements);
        json["axes"] = quality_json(q);
        text += quality_text("axes", q);
    }
    if (!options.table_measurements.empty()) {
        const FitQuality q =
            fit_table(set, machine, read_table_points(options.table_measurements), options.table_measurements);
        json["table"] = quality_json(q);
        text += quality_text("table", q);
    }
    const AxisMap map = axis_map_of(set);
    json["backlash_um"] = {map.backlash[0] * 1e-6, map.backlash[1] * 1e-6, map.backlash[2] * 1e-6};
    json["backlash_c_mdeg"] = map.backlash[3] * 1e-6;
    json["map_crc"] = fmt::format("{:08x}", link::map_crc(map));
    json["sha256"] = write_calibration(options.out, set);
    json["out"] = options.out;
    if (options.json) {
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    text += fmt::format("backlash X {:.2f}, Y {:.2f}, Z {:.2f} um, C {:.3f} mdeg\n", map.backlash[0] * 1e-6,
                        map.backlash[1] * 1e-6, map.backlash[2] * 1e-6, map.backlash[3] * 1e-6);
    text += fmt::format("map {}, set {}: {}\n", json["map_crc"].get<std::string>(),
                        json["sha256"].get<std::string>().substr(0, 12), options.out);
    std::fputs(text.c_str(), stdout);
    return 0;
}

}  // namespace

void add_calibrate_axes(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand("axes", "Errors of the axes and the turntable, from measured places.");
    sub->footer(kExamples);
    const auto options = std::make_shared<CalibrateOptions>();
    sub->add_option("--measurements", options->measurements, "where the focus truly stood")->type_name("FILE");
    sub->add_option("--table-measurements", options->table_measurements, "where targets on the table truly stood")
        ->type_name("FILE");
    sub->add_option("--calibration", options->calibration, "calibration set to start from")
        ->type_name("FILE")
        ->required();
    sub->add_option("--out", options->out, "calibration set to write")->type_name("FILE")->required();
    sub->add_option("--link", options->link, "the cell whose travel and limits count")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_flag("--json", options->json, "one JSON object on stdout");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
