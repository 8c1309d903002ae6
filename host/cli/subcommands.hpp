// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

/// One function a subcommand: adds its options to the program and, when it was asked for, runs it and leaves its exit
/// code in `exit_code`. Nothing escapes but CLI11's own errors.

namespace sc::host::cli {

void add_scribe(CLI::App& app, int& exit_code);
void add_cell(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_casting(CLI::App& app, int& exit_code);
void add_inspect(CLI::App& app, int& exit_code);
void add_register(CLI::App& app, int& exit_code);
void add_jog(CLI::App& app, int& exit_code);
void add_pendant(CLI::App& app, int& exit_code);
void add_override(CLI::App& app, int& exit_code);
void add_calibrate(CLI::App& app, int& exit_code);
void add_calibration(CLI::App& app, int& exit_code);
void add_measure(CLI::App& app, int& exit_code);
void add_vision(CLI::App& app, int& exit_code);
void add_vision_markers(CLI::App& vision, int& exit_code);  ///< this and the next two: below `vision`
void add_vision_board(CLI::App& vision, int& exit_code);
void add_vision_stereo(CLI::App& vision, int& exit_code);
void add_monitor(CLI::App& app, int& exit_code);
void add_key(CLI::App& app, int& exit_code);
void add_params(CLI::App& app, int& exit_code);
void add_sensors(CLI::App& app, int& exit_code);
void add_telemetry(CLI::App& app, int& exit_code);
void add_blackbox(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_plot(CLI::App& app, int& exit_code);
void add_protocol(CLI::App& app, int& exit_code);
void add_drives(CLI::App& app, int& exit_code);
void add_ports(CLI::App& app, int& exit_code);
void add_eds(CLI::App& app, int& exit_code);
void add_doctor(CLI::App& app, int& exit_code);
void add_verify(CLI::App& app, int& exit_code);
void add_version(CLI::App& app, int& exit_code);
void add_bench(CLI::App& app, int& exit_code);

}  // namespace sc::host::cli
