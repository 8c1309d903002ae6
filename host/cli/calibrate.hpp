// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

/// The subcommands of `scribecell calibrate`, as those of subcommands.hpp.

namespace sc::host::cli {

void add_calibrate_all(CLI::App& calibrate, int& exit_code);
void add_calibrate_axes(CLI::App& calibrate, int& exit_code);
void add_calibrate_triple(CLI::App& calibrate, int& exit_code);
void add_calibrate_rigid(CLI::App& calibrate, int& exit_code);
void add_calibrate_axis(CLI::App& calibrate, int& exit_code);
void add_calibrate_cameras(CLI::App& calibrate, int& exit_code);  ///< camera and stereo
void add_calibrate_chain(CLI::App& calibrate, int& exit_code);
void add_calibrate_hand_eye(CLI::App& calibrate, int& exit_code);
void add_calibrate_galvo_field(CLI::App& calibrate, int& exit_code);
void add_calibrate_plate(CLI::App& calibrate, int& exit_code);
void add_calibrate_pointing(CLI::App& calibrate, int& exit_code);
void add_calibrate_focus(CLI::App& calibrate, int& exit_code);
void add_calibrate_triple_head(CLI::App& calibrate, int& exit_code);
void add_calibrate_y_sensor(CLI::App& calibrate, int& exit_code);
void add_calibrate_galvo_lag(CLI::App& calibrate, int& exit_code);

}  // namespace sc::host::cli
