// SPDX-License-Identifier: Apache-2.0
#include "host/cli/calibrate.hpp"

#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate all --out cell1
      the whole simulated cell, from nothing to one set, and what it is worth on 36 markers
  scribecell calibrate axes --measurements axes.csv --calibration old.toml --out new.toml
      squareness, scale, straightness, pitch and backlash of X, Y and Z
  scribecell calibrate galvo-field --out field1
      field correction of the galvo, from crosses burnt in the simulated cell
  scribecell calibrate plate --out plate1
      h_from_c and the galvo's field together, from crosses burnt on a stepped block that the 3-D sensor measures
  scribecell calibrate focus --out focus1
      where the focus is, and the beam's waist, from a burnt ladder
  scribecell calibrate pointing --out pointed
      markers of the stepped mobile target in h, pointed at with the guide spot
  scribecell calibrate y-sensor --out y1
      where the Y sensor looks, from a scan over planes that the 3-D sensor has measured
  scribecell calibrate triple-head --cell cell1 --out t1
      where the three beams of the triple head lie in h, from faces turned before it
  scribecell calibrate galvo-lag --out lag1
      how the mirrors follow: latency, natural frequency and damping, from lines burnt in the simulated cell
  scribecell calibrate stereo --left left*.png --right right*.png --board 9x6 --square 25
      a pair of cameras, from pictures of a chessboard or a grid of dots; calibrate camera: one
  scribecell calibrate hand-eye --robot-poses robot.csv --target clouds.csv
      where the 3-D sensor sits on the robot, from views of a fixed target
  scribecell calibrate rigid --from c.csv --to h.csv --name h_from_c
      the transform between two frames, from markers measured in both
  scribecell calibrate axis --poses markers.csv
      the axis of a turntable, from markers or poses at known angles
  scribecell calibrate chain --scan-set scan.toml --target ring.toml --target mobile.toml --pointing p.csv --out cell.toml
      h_from_c and the axis from one joint fit over all views, reference markers, and places pointed at
  scribecell calibrate parallelism stand.toml --out head.toml
      beams of the triple-laser head, from pictures of its spots at three heights or more
  scribecell calibrate reference --readings r.csv --known known.csv --calibration head.toml --out head2.toml
      where the reference plane lies, from stations of known pose

`scribecell calibrate axes --help` and so on say more.)";

}  // namespace

void add_calibrate(CLI::App& app, int& exit_code) {
    CLI::App* calibrate =
        app.add_subcommand("calibrate", "Work out a calibration from measurements, and write it to a calibration set.");
    calibrate->require_subcommand(1);
    calibrate->footer(kExamples);
    add_calibrate_all(*calibrate, exit_code);
    add_calibrate_axes(*calibrate, exit_code);
    add_calibrate_galvo_field(*calibrate, exit_code);
    add_calibrate_plate(*calibrate, exit_code);
    add_calibrate_focus(*calibrate, exit_code);
    add_calibrate_pointing(*calibrate, exit_code);
    add_calibrate_y_sensor(*calibrate, exit_code);
    add_calibrate_triple_head(*calibrate, exit_code);
    add_calibrate_galvo_lag(*calibrate, exit_code);
    add_calibrate_cameras(*calibrate, exit_code);
    add_calibrate_hand_eye(*calibrate, exit_code);
    add_calibrate_rigid(*calibrate, exit_code);
    add_calibrate_axis(*calibrate, exit_code);
    add_calibrate_chain(*calibrate, exit_code);
    add_calibrate_triple(*calibrate, exit_code);
}

}  // namespace sc::host::cli
