// SPDX-License-Identifier: Apache-2.0
// scribecell-rig: robots, targets and turntables whose truth is known, as the files that calibrations take.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>

#include "boards/sim/rig/chain_sets.hpp"
#include "boards/sim/rig/hand_eye_sets.hpp"
#include "boards/sim/rig/place_sets.hpp"
#include "boards/sim/rig/stereo_sets.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr double kDegree = 0.017453292519943295;
constexpr const char* kExamples = R"(Examples:
  scribecell-rig hand-eye --out sets --sets 50 --seed 3
      50 sets of robot poses and marker clouds of a fixed target (set_0001/robot.csv, target.csv), and truth.csv
  scribecell-rig hand-eye --out bad --bad-mm 1 --bad-deg 0.2 --swapped-views 5
      one pose is wrong, and in five views two markers have each other's number
  scribecell-rig rigid --out sets --markers 5 --pointing-um 50
      a mobile target in two frames
  scribecell-rig axis --out sets --angles 8 --arc-deg 90
      markers on a turntable
  scribecell-rig chain --out sets --references ring --robot dh --pointing-um 10
      a whole cell: scan set, targets, places pointed at; 36 marks on four faces for those who judge
  scribecell-rig stereo --out sets --sets 20 --noise-px 0.1
      a pair of cameras before a board of 9 by 6 points, 1280x960 pixels

Exit codes: 0 done; 1 a file cannot be written; 2 bad usage.)";

struct Words {
    std::string out;
    std::uint64_t seed = 1;
    int sets = 1;
    sc::sim::HandEyeSetOptions hand_eye;
    sc::sim::RigidSetOptions rigid;
    sc::sim::AxisSetOptions axis;
    sc::sim::StereoSetOptions stereo;
    double tilt_deg = 25.0;
    double roll_deg = 60.0;
    double robot_um = 6.7;
    double robot_mdeg = 1.5;
    double bad_mm = 0.0;
    double bad_deg = 0.0;
    double pointing_um = 10.0;
    double arc_deg = 360.0;
    sc::sim::ChainSetOptions chain;
    std::string references = "ring";
    std::string robot = "repeatable";
    double sensor_um = 7.5;
    double table_mdeg = 0.5;
    double wrong_angle_deg = 0.0;
};

CLI::App* add_kind(CLI::App& app, const char* name, const char* what, Words& words) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option("--out", words.out, "folder to write to")->required()->type_name("DIR");
    sub->add_option("--seed", words.seed, "of all that is random")->capture_default_str();
    sub->add_option("--sets", words.sets, "how many")->check(CLI::Range(1, 9999))->capture_default_str();
    return sub;
}

void add_hand_eye(CLI::App& app, Words& words) {
    CLI::App* sub = add_kind(app, "hand-eye", "A sensor on a robot before a fixed target.", words);
    sub->add_option("--views", words.hand_eye.views, "poses of a set")
        ->check(CLI::Range(3, 500))
        ->capture_default_str();
    sub->add_option("--markers", words.hand_eye.markers, "of the target")
        ->check(CLI::Range(3, 500))
        ->capture_default_str();
    sub->add_option("--tilt-deg", words.tilt_deg, "of a view, either way")->check(CLI::Range(0.0, 80.0));
    sub->add_option("--roll-deg", words.roll_deg, "of a view, either way")->check(CLI::Range(0.0, 180.0));
    sub->add_option("--depth-factor", words.hand_eye.depth_factor, "noise in depth over that across")
        ->check(CLI::Range(0.1, 100.0));
    sub->add_option("--robot-um", words.robot_um, "noise of a robot pose")->check(CLI::Range(1e-3, 1e5));
    sub->add_option("--robot-mdeg", words.robot_mdeg, "noise of a robot pose")->check(CLI::Range(1e-3, 1e5));
    sub->add_option("--bad-mm", words.bad_mm, "one pose is so far off")->check(CLI::Range(0.0, 1000.0));
    sub->add_option("--bad-deg", words.bad_deg, "and turned")->check(CLI::Range(0.0, 180.0));
    sub->add_option("--swapped-views", words.hand_eye.swapped_views, "in which two markers are swapped")
        ->check(CLI::Range(0, 500));
    sub->callback([&words] {
        sc::sim::HandEyeSetOptions set = words.hand_eye;
        set.seed = words.seed;
        set.sets = words.sets;
        set.tilt = words.tilt_deg * kDegree;
        set.roll = words.roll_deg * kDegree;
        set.robot_place = words.robot_um * 1e-6;
        set.robot_turn = words.robot_mdeg * 1e-3 * kDegree;
        set.bad_place = words.bad_mm * 1e-3;
        set.bad_turn = words.bad_deg * kDegree;
        set.swapped_views = std::min(set.swapped_views, set.views);
        sc::sim::write_hand_eye_sets(words.out, set);
    });
}

void add_places(CLI::App& app, Words& words) {
    CLI::App* rigid = add_kind(app, "rigid", "A mobile target in two frames.", words);
    rigid->add_option("--markers", words.rigid.markers, "of the target")->check(CLI::Range(3, 500));
    rigid->add_option("--pointing-um", words.pointing_um, "noise across the beam")->check(CLI::Range(0.0, 1e4));
    rigid->add_option("--wrong", words.rigid.wrong, "markers that are somewhere else")->check(CLI::Range(0, 500));
    rigid->callback([&words] {
        sc::sim::RigidSetOptions set = words.rigid;
        set.seed = words.seed;
        set.sets = words.sets;
        set.pointing = words.pointing_um * 1e-6;
        sc::sim::write_rigid_sets(words.out, set);
    });
    CLI::App* axis = add_kind(app, "axis", "Markers on a turntable.", words);
    axis->add_option("--markers", words.axis.markers, "on the board")->check(CLI::Range(1, 500));
    axis->add_option("--angles", words.axis.angles, "of the table")->check(CLI::Range(2, 500));
    axis->add_option("--arc-deg", words.arc_deg, "from the first to the last; 360: all round")
        ->check(CLI::Range(0.01, 360.0));
    axis->callback([&words] {
        sc::sim::AxisSetOptions set = words.axis;
        set.seed = words.seed;
        set.sets = words.sets;
        set.arc = words.arc_deg * kDegree;
        sc::sim::write_axis_sets(words.out, set);
    });
}

void add_chain(CLI::App& app, Words& words) {
    CLI::App* sub = add_kind(app, "chain", "A whole cell: sensor on a robot, turntable, references, targets.", words);
    sub->add_option("--references", words.references, "ring of 24, or a corner target with 5 markers")
        ->check(CLI::IsMember({"ring", "corner"}))
        ->capture_default_str();
    sub->add_option("--robot", words.robot, "repeatable, or with errors of its own geometry (some 0.35 mm)")
        ->check(CLI::IsMember({"repeatable", "dh"}))
        ->capture_default_str();
    sub->add_option("--pointing-um", words.pointing_um, "noise across the beam")->check(CLI::Range(0.0, 1e4));
    sub->add_option("--sensor-um", words.sensor_um, "noise of a coordinate")->check(CLI::Range(1e-3, 1e4));
    sub->add_option("--table-mdeg", words.table_mdeg, "noise of an angle")->check(CLI::Range(1e-4, 1e4));
    sub->add_option("--angles", words.chain.angles, "of the table, with the board")->check(CLI::Range(3, 60));
    sub->add_option("--mobile", words.chain.mobile, "markers of the mobile target")->check(CLI::Range(3, 99));
    sub->add_option("--wrong", words.chain.wrong, "sightings that are somewhere else")->check(CLI::Range(0, 99));
    sub->add_option("--swapped", words.chain.swapped, "views with two numbers swapped")->check(CLI::Range(0, 99));
    sub->add_option("--wrong-angle-deg", words.wrong_angle_deg, "one angle is read so far off")
        ->check(CLI::Range(-180.0, 180.0));
    sub->add_flag("--clouds", words.chain.clouds, "clouds of the workpiece too");
    sub->callback([&words] {
        sc::sim::ChainSetOptions set = words.chain;
        set.seed = words.seed;
        set.sets = words.sets;
        set.references = words.references == "ring" ? sc::sim::ChainSetOptions::References::ring
                                                    : sc::sim::ChainSetOptions::References::corner;
        set.pointing = words.pointing_um * 1e-6;
        set.sensor = words.sensor_um * 1e-6;
        set.table = words.table_mdeg * 1e-3 * kDegree;
        set.wrong_angle = words.wrong_angle_deg * kDegree;
        if (words.robot == "dh") {
            set.dh_length = 2.8e-4;
            set.dh_angle = 0.028 * kDegree;
        }
        sc::sim::write_chain_sets(words.out, set);
    });
}

void add_stereo(CLI::App& app, Words& words) {
    CLI::App* sub = add_kind(app, "stereo", "A pair of cameras before a flat board.", words);
    sub->add_option("--views", words.stereo.views, "poses of the board")
        ->check(CLI::Range(1, 500))
        ->capture_default_str();
    sub->add_option("--noise-px", words.stereo.noise_px, "of a coordinate")->check(CLI::Range(1e-6, 100.0));
    sub->add_option("--tilt-deg", words.tilt_deg, "of the board, either way")->check(CLI::Range(0.0, 60.0));
    sub->add_option("--swapped-views", words.stereo.swapped_views, "in which two points are swapped")
        ->check(CLI::Range(0, 500));
    sub->callback([&words, sub] {
        sc::sim::StereoSetOptions set = words.stereo;
        set.seed = words.seed;
        set.sets = words.sets;
        if (sub->count("--tilt-deg") > 0) {
            set.tilt = words.tilt_deg * kDegree;
        }
        sc::sim::write_stereo_sets(words.out, set);
    });
}

}  // namespace

int main(int argc, char** argv) {
    try {
        CLI::App app{"Simulated robots, targets and turntables, as files for calibrations.", "scribecell-rig"};
        app.footer(kExamples);
        app.require_subcommand(1);
        Words words;
        add_hand_eye(app, words);
        add_places(app, words);
        add_chain(app, words);
        add_stereo(app, words);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-rig: %s\n", error.what());
        return kFailed;
    }
}
