// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "boards/sim/survey/cell_truth.hpp"
#include "boards/sim/survey/crosses.hpp"
#include "boards/sim/survey/sides.hpp"
#include "boards/sim/survey/targets.hpp"
#include "boards/sim/survey/workpiece.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-survey crosses run/pulses.trace --world steps/world.toml --out run --seed 3
      burnt crosses as the 3-D sensor sees them in c, with the widths of their strokes
  scribecell-survey fixed --out f --seed 3
      views of a fixed target and the robot's poses
  scribecell-survey ring --out r --seed 3
      reference markers that stand round the table, view by view
  scribecell-survey table --world steps/world.toml --out t --angles 24 --arc-deg 360
      markers on the turntable
  scribecell-survey mobile --world steps/world.toml --out m
      the stepped mobile target: target.toml, what the sensor sees of it, and a world with it
  scribecell-survey roof --world steps/world.toml --out r
      five faces that lean, as the sensor sees them, and a world with them
  scribecell-survey sides --world default/world.toml --out s
      four sides on the table, for the head of three lasers, as the sensor sees them, and a world with them
  scribecell-survey spot --world m/world.toml --marker 4 --at-mm -200,-250,-260 --look 17
      how far the guide spot is from a marker, in um: x, y (focus beyond the surface), z
  scribecell-survey workpiece --world default/world.toml --out w
      a box with 36 markers on the table
  scribecell-survey judge --world w/world.toml --measured measured.csv --out table.csv
      where these markers truly are, beside where they were measured

The same seed is the same cell. Exit codes: 0 done; 1 it cannot be done; 2 bad usage.)";

struct Words {
    std::string world;
    std::string out;
    std::string trace;
    std::string measured;
    std::uint64_t seed = 1;
    double sigma_um = 7.5;
    double robot_bias_mm = 0.35;
    double width_um = 3.0;
    int angles = 24;
    double arc_deg = 360.0;
    int marker = 1;
    std::uint64_t look = 0;
    std::vector<double> at_mm{0.0, 0.0, 0.0};
    double pointing_um = 10.0;
    double focusing_um = 60.0;

    [[nodiscard]] sc::sim::CellTruth truth() const {
        sc::sim::SurveyNoise noise;
        noise.marker = sigma_um * 1e-6;
        noise.robot_bias = robot_bias_mm * 1e-3;
        noise.width = width_um * 1e-6;
        return {seed, noise};
    }
};

CLI::App* add(CLI::App& app, const char* name, const char* what, Words& words, bool with_world) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option("--seed", words.seed, "of the cell and of all noise")->capture_default_str();
    sub->add_option("--sigma-um", words.sigma_um, "noise of the sensor, each coordinate")
        ->check(CLI::Range(0.0, 1e4))
        ->capture_default_str();
    sub->add_option("--robot-bias-mm", words.robot_bias_mm, "errors of the robot's arms")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    if (with_world) {
        sub->add_option("--world", words.world, "the true world")->required()->type_name("FILE");
    }
    return sub;
}
void add_out(CLI::App* sub, Words& words, const char* what) {
    sub->add_option("--out", words.out, what)->required()->type_name("PATH");
}

void add_all(CLI::App& app, Words& words) {
    CLI::App* crosses = add(app, "crosses", "Burnt crosses in c.", words, true);
    add_out(crosses, words, "folder");
    crosses->add_option("trace", words.trace, "pulse trace of the run")->required()->type_name("FILE");
    crosses->add_option("--width-um", words.width_um, "noise of a width")->check(CLI::Range(0.0, 1e3));
    crosses->callback(
        [&words] { sc::sim::write_crosses(words.truth(), sc::sim::World(words.world), words.trace, words.out); });
    CLI::App* widths = add(app, "widths", "Widths of burnt strokes.", words, true);
    add_out(widths, words, "file");
    widths->add_option("trace", words.trace, "pulse trace of the run")->required()->type_name("FILE");
    widths->add_option("--width-um", words.width_um, "noise of a width")->check(CLI::Range(0.0, 1e3));
    widths->callback(
        [&words] { sc::sim::write_widths(words.truth(), sc::sim::World(words.world), words.trace, words.out); });
    CLI::App* fixed = add(app, "fixed", "Views of the fixed target.", words, false);
    add_out(fixed, words, "folder");
    fixed->callback([&words] { sc::sim::write_fixed_target(words.truth(), words.out); });
    CLI::App* ring = add(app, "ring", "Views of the reference markers round the table.", words, false);
    add_out(ring, words, "folder");
    ring->callback([&words] { sc::sim::write_ring(words.truth(), words.out); });
    CLI::App* table = add(app, "table", "Markers on the turntable.", words, true);
    add_out(table, words, "folder");
    table->add_option("--angles", words.angles, "of the table")->check(CLI::Range(2, 500))->capture_default_str();
    table->add_option("--arc-deg", words.arc_deg, "over which they lie")
        ->check(CLI::Range(0.01, 360.0))
        ->capture_default_str();
    table->callback([&words] {
        sc::sim::write_table_markers(words.truth(), sc::sim::World(words.world), words.angles, words.arc_deg,
                                     words.out);
    });
    CLI::App* axes = add(app, "axes", "An instrument at the axes.", words, true);
    add_out(axes, words, "file");
    axes->callback([&words] { sc::sim::write_axes(words.truth(), sc::sim::World(words.world), words.out); });
    CLI::App* mobile = add(app, "mobile", "The stepped mobile target.", words, true);
    add_out(mobile, words, "folder");
    mobile->callback([&words] { sc::sim::write_mobile_target(words.truth(), words.world, words.out); });
    CLI::App* roof = add(app, "roof", "A roof of five faces, for the Y sensor.", words, true);
    add_out(roof, words, "folder");
    roof->callback([&words] { sc::sim::write_roof(words.truth(), words.world, words.out); });
    CLI::App* sides = add(app, "sides", "Four sides on the table, for the triple head.", words, true);
    add_out(sides, words, "folder");
    sides->callback([&words] { sc::sim::write_sides(words.truth(), words.world, words.out); });
    CLI::App* spot = add(app, "spot", "Where the guide spot lies relative to a marker.", words, true);
    spot->add_option("--marker", words.marker, "its number")->required();
    spot->add_option("--at-mm", words.at_mm, "readings of X, Y, Z")->required()->delimiter(',')->expected(3);
    spot->add_option("--look", words.look, "number of this look: another one, other noise")->capture_default_str();
    spot->add_option("--pointing-um", words.pointing_um, "noise of the eye across the beam")
        ->check(CLI::Range(0.0, 1e4))
        ->capture_default_str();
    spot->add_option("--focusing-um", words.focusing_um, "and along it")
        ->check(CLI::Range(0.0, 1e4))
        ->capture_default_str();
    spot->callback([&words] {
        const sc::Vec3 at{words.at_mm[0] * 1e-3, words.at_mm[1] * 1e-3, words.at_mm[2] * 1e-3};
        const auto seen = sc::sim::see_spot(words.truth(), sc::sim::World(words.world), words.marker, at,
                                            words.pointing_um * 1e-6, words.focusing_um * 1e-6, words.look);
        std::printf("%.4f %.4f %.4f\n", seen.off.x * 1e6, seen.off.y * 1e6, seen.off.z * 1e6);
    });
    CLI::App* workpiece = add(app, "workpiece", "A box with 36 markers.", words, true);
    add_out(workpiece, words, "folder");
    workpiece->callback([&words] { sc::sim::write_workpiece(words.truth(), words.world, words.out); });
    CLI::App* judge = add(app, "judge", "Measured places beside the true ones.", words, true);
    add_out(judge, words, "file");
    judge->add_option("--measured", words.measured, "face_deg,no,mx,my,mz")->required()->type_name("FILE");
    judge->callback([&words] { sc::sim::write_judged(words.truth(), words.world, words.measured, words.out); });
}

}  // namespace

int main(int argc, char** argv) {
    try {
        CLI::App app{"The instruments that calibrate the simulated cell.", "scribecell-survey"};
        app.footer(kExamples);
        app.require_subcommand(1);
        Words words;
        add_all(app, words);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-survey: %s\n", error.what());
        return kFailed;
    }
}
