// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/register_view.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate chain --scan-set scan.toml --target ring.toml --target mobile.toml --pointing pointing.csv \
      --out cell.toml --map ring_in_c.toml
      h_from_c and the turntable's axis from one joint fit over all views, markers that stand still, markers on the table,
      and places pointed at in h (id,x_mm,y_mm,z_mm and sigma_x_um,sigma_y_um,sigma_z_um; turn_deg for markers on the
      table); ring_in_c.toml is what later scans are registered to
  scribecell calibrate chain --scan-set scan.toml --target ring.toml --target mobile.toml --pointing pointing.csv \
      --predict marks.csv --json
      and where marks (id,face_deg) will stand before the laser, with the covariance of the beam's miss

Markers of targets and of --still stand still; all others turn with the table. Robot poses count by the noise that they
turn out to have: a robot with errors of its own geometry does no harm.
Exit codes: 0 done; 2 bad input, or data that cannot support h_from_c or the axis.)";

struct Words {
    ChainWords chain;
    std::string pointing;
    std::string unit;
    double pointing_um = 10.0;
    double axes_um = 2.5;
    std::string predict;
    std::string calibration;
    std::string out;
};

std::vector<ChainPrediction> predictions(const std::string& file) {
    std::vector<ChainPrediction> out;
    if (file.empty()) {
        return out;
    }
    const CsvTable csv = CsvTable::read(file);
    const std::size_t id = csv.column("id");
    const std::size_t face = csv.column("face_deg");
    for (std::size_t row = 0; row < csv.size(); ++row) {
        out.push_back({csv.integer(row, id), csv.number(row, face)});
    }
    return out;
}

std::string save(const Words& words, const ChainResult& chain) {
    TransformRecord record;
    record.id = "h_from_c";
    record.rotation = chain.h_from_c->rotation;
    record.translation = chain.h_from_c->translation;
    record.covariance = chain.h_from_c->covariance;
    record.provenance.parents = {words.chain.scan_set, words.pointing};
    record.provenance.residual_rms = chain.pointing_rms;
    std::optional<AxisRecord> axis;
    if (chain.axis_in_h) {
        axis.emplace();
        axis->line = chain.axis_in_h->line;
        axis->covariance = chain.axis_in_h->covariance;
        axis->provenance.parents = {words.chain.scan_set, words.pointing};
        axis->provenance.residual_rms = chain.rms;
    }
    std::vector<CrossCovariance> cross;
    if (axis && chain.together) {
        CrossCovariance both{.between = {"h_from_c", "turntable"}, .at = {}};
        for (std::size_t i = 0; i < 6; ++i) {
            const auto& row = chain.together->at.at(i);
            both.at.emplace_back(row.begin() + 6, row.end());
        }
        cross.push_back(std::move(both));
    }
    return save_records({.calibration = words.calibration, .out = words.out}, "chain", {record}, axis, cross);
}

int run(const Words& words) {
    ChainInput input = chain_input(read_scan_set(words.chain.scan_set), targets_of(words.chain));
    input.pointing_file = words.pointing;
    input.pointing = read_marker_views(words.pointing, {.columns = {}, .unit = words.unit}).views;
    ChainOptions options = options_of(words.chain);
    options.pointing = words.pointing_um * 1e-6;
    options.axes = words.axes_um * 1e-6;
    options.predict = predictions(words.predict);
    const ChainResult chain = fit_chain(input, options);
    if (chain.places.size() != options.predict.size()) {
        throw InputError({.file = words.predict,
                          .problem = "marks are among those asked for that no view shows",
                          .value = std::to_string(options.predict.size() - chain.places.size()),
                          .action = "ask for ids of the scan set"});
    }
    nlohmann::ordered_json json = chain_json(chain);
    write_chain_files(words.chain, chain);
    if (!words.out.empty()) {
        json["sha256"] = save(words, chain);
        json["out"] = words.out;
    }
    std::fputs((words.chain.json ? json.dump(2) + "\n" : chain_text(chain)).c_str(), stdout);
    return 0;
}

}  // namespace

void add_calibrate_chain(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand(
        "chain", "h_from_c and the turntable's axis, from one joint fit over a whole scan set and places pointed at.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    add_chain_words(*sub, words->chain);
    const CLI::Range some(1e-6, 1e9);
    sub->add_option("--pointing", words->pointing, "places in h by the markers' ids")->type_name("FILE")->required();
    sub->add_option("--unit", words->unit, "of x,y,z there without one: mm, m, inch")->type_name("UNIT");
    sub->add_option("--pointing-um", words->pointing_um, "noise of a place pointed at that states none")
        ->check(some)
        ->capture_default_str();
    sub->add_option("--axes-um", words->axes_um, "noise of a beam sent to a place")->check(some)->capture_default_str();
    sub->add_option("--predict", words->predict, "marks (id,face_deg) whose places before the laser are wanted")
        ->type_name("FILE");
    sub->add_option("--calibration", words->calibration, "set to extend")->type_name("FILE");
    sub->add_option("--out", words->out, "calibration set to write")->type_name("FILE");
    sub->callback([words, &exit_code] { exit_code = guarded(words->chain.json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
