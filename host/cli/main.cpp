// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "host/cli/exit_codes.hpp"
#include "host/cli/subcommands.hpp"

namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell scribe                     the main job, on the simulated cell
  scribecell scribe --dry-run           what it would burn
  scribecell inspect --cad PART.stl --scan CLOUD.ply
                                        is there metal everywhere, where should the part lie
  scribecell replay inputs.rec          the controller again, with recorded inputs
  scribecell calibrate galvo-field      the galvo's field correction, from burnt crosses
  scribecell calibration list           calibration sets: store, compare, export, budget, drift
  scribecell measure stations.csv --calibration head.toml
                                        workpieces against their reference, by three lasers
  scribecell vision spot beam.png       centre of a laser spot in a picture
  scribecell pendant --link can:can0    jog a cell with the wheel of a USB pendant
  scribecell monitor --once             state of a cell
  scribecell sensors                    what the distance sensors say
  scribecell telemetry --rate 50        channels of a cell over time, as CSV
  scribecell blackbox                   the last 10 s before a fault
  scribecell check run1/samples.trace   whether the motion kept its limits
  scribecell verify --table FILE.csv    figures of a table of measured and true places, and what is odd about it
  scribecell protocol --decode job.pcap what passed over a link; its files for Wireshark and CAN tools
  scribecell key --out cell.key         a key, for a cell that takes commands from its holders alone
  scribecell doctor                     what is installed, connected, missing

Exit codes: 0 done; 1 the cell or the job failed; 2 bad input or usage; 130 Ctrl-C.)";

}  // namespace

int main(int argc, char** argv) {
    try {
        CLI::App app{"Host of a laser scribing cell.", "scribecell"};
        app.footer(kExamples);
        app.require_subcommand(1);
        int exit_code = sc::host::cli::kDone;
        sc::host::cli::add_scribe(app, exit_code);
        sc::host::cli::add_cell(app, exit_code);
        sc::host::cli::add_replay(app, exit_code);
        sc::host::cli::add_inspect(app, exit_code);
        sc::host::cli::add_register(app, exit_code);
        sc::host::cli::add_casting(app, exit_code);
        sc::host::cli::add_jog(app, exit_code);
        sc::host::cli::add_pendant(app, exit_code);
        sc::host::cli::add_override(app, exit_code);
        sc::host::cli::add_calibrate(app, exit_code);
        sc::host::cli::add_calibration(app, exit_code);
        sc::host::cli::add_measure(app, exit_code);
        sc::host::cli::add_vision(app, exit_code);
        sc::host::cli::add_monitor(app, exit_code);
        sc::host::cli::add_key(app, exit_code);
        sc::host::cli::add_params(app, exit_code);
        sc::host::cli::add_sensors(app, exit_code);
        sc::host::cli::add_telemetry(app, exit_code);
        sc::host::cli::add_blackbox(app, exit_code);
        sc::host::cli::add_check(app, exit_code);
        sc::host::cli::add_plot(app, exit_code);
        sc::host::cli::add_protocol(app, exit_code);
        sc::host::cli::add_drives(app, exit_code);
        sc::host::cli::add_ports(app, exit_code);
        sc::host::cli::add_eds(app, exit_code);
        sc::host::cli::add_doctor(app, exit_code);
        sc::host::cli::add_verify(app, exit_code);
        sc::host::cli::add_version(app, exit_code);
        sc::host::cli::add_bench(app, exit_code);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? sc::host::cli::kDone : sc::host::cli::kBadInput;
        }
        return exit_code;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell: %s\n", error.what());
        return sc::host::cli::kFailed;
    }
}
