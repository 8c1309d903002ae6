// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "boards/drive_file/drive_file.hpp"
#include "boards/mps2_an500/pc/m7_controller.hpp"
#include "boards/port/port.hpp"
#include "boards/replay/key_file.hpp"
#include "boards/sim/cell.hpp"
#include "boards/sim/lock_step.hpp"
#include "boards/sim/machine_keys.hpp"
#include "boards/sim/plant/fault_script.hpp"
#include "boards/sim/real_time.hpp"
#include "boards/sim/world/world_error.hpp"
#include "shared/drives/bus_budget.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kDefaultWorld = "boards/sim/world/default/world.toml";
constexpr const char* kExamples = R"(Examples:
  scribecell-cell --pty --out run1
      a cell on a pseudo-terminal in real time; prints its path. Ctrl-C ends it and writes run1/cell.json
  scribecell-cell --tcp 0 --speed 2 --world my_world.toml
      a cell on a free loopback port, at twice real time
  scribecell-cell --lockstep-fd 3 --out run2 --script faults.txt
      as the host starts it: virtual time, over the inherited socket 3
  scribecell-cell --lockstep cell.socket --memory retained.bin --out run3
      virtual time for one host after another (scribecell ... --link lockstep:cell.socket)
  scribecell-cell --tcp 7000 --key cell.key
      a cell that takes sealed commands only (scribecell ... --link tcp:127.0.0.1:7000 --key cell.key)
  scribecell-cell --lockstep-fd 3 --controller m7
      the same, with the controller on a Cortex-M7 in QEMU

A fault script has one event a line:
  at 3.5 estop open
  pulse 1000 interlock open
  at 4 drive x fault 0x2310)";

volatile bool stop_asked = false;

void ask_stop(int) { stop_asked = true; }

struct Arguments {
    std::string world;
    std::string out;
    std::string script;
    std::uint32_t baud = 921'600;
    std::string carrier = "serial";
    std::uint32_t seed = 1;
    int lockstep = -1;
    std::string lockstep_at;
    std::string memory;
    double kill_host_s = 0.0;
    std::int64_t kill_delay_us = 0;
    double power_off_s = 0.0;
    double gap_s = 0.0;
    bool pty = false;
    int tcp = -1;
    double speed = 1.0;
    bool command_trace = false;
    std::string controller = "local";
    std::string drives;
    std::string m7_image;
    std::string record;
    std::string key;
    double record_limit_mb = 100.0;
    double prr_nominal_hz = 0.0;
    std::vector<std::string> machine;
};

void describe(CLI::App& app, Arguments& a) {
    app.footer(kExamples);
    app.add_option("--world", a.world, "world file (default: the reference cell)");
    app.add_option("--out", a.out, "directory for pulses.trace, samples.trace and cell.json (default: none written)");
    app.add_option("--script", a.script, "fault script");
    app.add_option("--baud", a.baud, "rate of the serial link")
        ->check(CLI::Range(9600, 10'000'000))
        ->capture_default_str();
    app.add_option("--carrier", a.carrier,
                   "of the link, with --lockstep or --lockstep-fd: serial, can (1 Mbit/s) or canfd (1 and 5 Mbit/s)")
        ->check(CLI::IsMember({"serial", "can", "canfd"}))
        ->capture_default_str();
    app.add_option("--seed", a.seed, "number of this start of the controller")->capture_default_str();
    app.add_flag("--command-trace", a.command_trace, "write command.trace too: the records under the command hash");
    app.add_option("--controller", a.controller,
                   "where the controller runs: local (in this process) or m7 (Cortex-M7 in QEMU)")
        ->check(CLI::IsMember({"local", "m7"}))
        ->capture_default_str();
    app.add_option("--m7-image", a.m7_image, "image for --controller m7 (default: what the preset m7 builds)")
        ->type_name("FILE");
    app.add_option("--record", a.record, "log of the controller's inputs, for scribecell-replay (default: none)");
    app.add_option("--key", a.key,
                   "file of 32 hex digits: the controller takes commands sealed with this key only (default: any)")
        ->type_name("FILE");
    app.add_option("--record-limit", a.record_limit_mb, "MB; the log ends there, the cell goes on")
        ->check(CLI::Range(0.1, 1e6))
        ->capture_default_str();
    app.add_option("--prr-nominal", a.prr_nominal_hz,
                   "Hz; nominal pulse rate of the laser (default: the reference cell's)")
        ->check(CLI::Range(20e3, 1.5e6))
        ->type_name("HZ");
    app.add_option("--drives", a.drives, "machine file with [drives.*] tables: plan and quirks of the drives")
        ->type_name("FILE");
    app.add_option("--machine", a.machine,
                   "what the controller is told of its machine in place of the truth, e.g. galvo.latency_us=0")
        ->type_name("KEY=VALUE");
    auto* mode = app.add_option_group("mode", "who drives the cell");
    mode->add_option("--lockstep-fd", a.lockstep, "inherited socket: virtual time in lock-step with the host")
        ->check(CLI::Range(0, 1'000'000));
    mode->add_option("--lockstep", a.lockstep_at,
                     "listen at this path: virtual time in lock-step with one host after another")
        ->type_name("PATH");
    mode->add_flag("--pty", a.pty, "a pseudo-terminal in real time; prints its path");
    mode->add_option("--tcp", a.tcp, "a TCP port on 127.0.0.1 in real time, 0 = any; prints it")
        ->check(CLI::Range(0, 65535));
    mode->require_option(1);
    app.add_option("--memory", a.memory, "file of what the controller keeps without power (default: it keeps nothing)")
        ->type_name("FILE");
    app.add_option("--kill-host-at", a.kill_host_s, "s; --lockstep: SIGKILL to the host at this time of the cell")
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--kill-delay-us", a.kill_delay_us, "real time between the answer and the SIGKILL")
        ->check(CLI::Range(0, 1'000'000));
    app.add_option("--power-off-at", a.power_off_s, "s; --lockstep: the cell loses its power")
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--gap", a.gap_s, "s; --lockstep: the cell lives alone so long between two hosts")
        ->check(CLI::Range(0.0, 1e4));
    app.add_option("--speed", a.speed, "seconds of the cell's time a second (--pty, --tcp)")
        ->check(CLI::Range(0.01, 1000.0))
        ->capture_default_str();
}

/// The reference world: below $SCRIBECELL_ROOT, or below the nearest folder above this program that has it.
std::filesystem::path default_world() {
    if (const char* root = std::getenv("SCRIBECELL_ROOT"); root != nullptr) {
        return std::filesystem::path(root) / kDefaultWorld;
    }
    std::error_code ignored;
    std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
    while (folder.has_relative_path() && !std::filesystem::exists(folder / kDefaultWorld)) {
        folder = folder.parent_path();
    }
    return folder / kDefaultWorld;
}

sc::sim::LinkCarrier carrier_of(const Arguments& a) {
    if (a.carrier == "serial") {
        return sc::sim::LinkCarrier::serial;
    }
    if (a.pty || a.tcp >= 0) {
        throw std::invalid_argument("--carrier " + a.carrier +
                                    " needs --lockstep or --lockstep-fd: a terminal or a TCP port has no frames");
    }
    return a.carrier == "can" ? sc::sim::LinkCarrier::can : sc::sim::LinkCarrier::canfd;
}

/// Plan, nodes and cycle for controller and drives, quirks for the drives.
void take_drives(const Arguments& a, sc::sim::CellOptions& options) {
    if (a.controller != "local") {
        throw std::invalid_argument("--drives: only the controller in this process takes another plan");
    }
    const sc::drive_file::DriveFile file = sc::drive_file::read_drive_file(a.drives, options.machine);
    for (std::size_t i = 0; i < sc::kAxisCount; ++i) {
        options.drives.quirks.at(i) = sc::sim::drive_quirks(file.quirks.at(i));
        options.drives.second_bus.at(i) = file.plan.drive.at(i).bus == 1;
    }
    if (!sc::drives::bus_budget(options.machine, file.plan)) {
        throw std::invalid_argument("--drives " + a.drives + ":\n" +
                                    sc::drive_file::budget_text(options.machine, file.plan));
    }
    options.controller = [plan = file.plan](const sc::MachineConfig& machine, std::uint32_t boot_id,
                                            sc::RetainedMemory* retained) -> std::unique_ptr<sc::sim::ControllerHost> {
        return std::make_unique<sc::sim::LocalController>(machine, boot_id, retained, plan);
    };
}

sc::sim::CellOptions options_of(const Arguments& a) {
    sc::sim::CellOptions options;
    options.world = a.world.empty() ? default_world() : std::filesystem::path(a.world);
    options.out = a.out;
    if (!a.script.empty()) {
        options.script = sc::sim::read_fault_script(a.script);
    }
    options.baud = a.baud;
    options.carrier = carrier_of(a);
    options.boot_id = a.seed;
    options.command_trace = a.command_trace;
    if (a.controller == "m7") {
        options.controller = sc::mps2_an500::make_m7_controller(
            {.image = a.m7_image.empty() ? sc::mps2_an500::find_image() : std::filesystem::path(a.m7_image)});
    }
    if (a.prr_nominal_hz > 0.0) {
        options.machine.laser.prr_nominal = sc::Frequency::from_si(a.prr_nominal_hz);
    }
    sc::sim::set_machine(options.machine, a.machine);
    if (!a.drives.empty()) {
        take_drives(a, options);
    }
    if (!a.key.empty()) {
        options.seal = sc::replay::secret_of(sc::replay::read_key_file(a.key));
    }
    options.memory = a.memory;
    options.record = a.record;
    options.record_limit_bytes = static_cast<std::uint64_t>(a.record_limit_mb * 1e6);
    return options;
}

void catch_signals() {
    struct sigaction action{};
    action.sa_handler = ask_stop;
    ::sigaction(SIGTERM, &action, nullptr);
    ::sigaction(SIGINT, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
}

void serve_port(sc::sim::SimCell& cell, const Arguments& a) {
    const auto port = a.pty ? sc::port::open_pty() : sc::port::open_tcp(static_cast<std::uint16_t>(a.tcp));
    std::printf("%s\n", port->name().c_str());
    std::fflush(stdout);
    sc::sim::serve_real_time(cell, *port, a.speed, &stop_asked);
}

void tell_of(const sc::replay::LogFile* record) {
    if (record == nullptr) {
        return;
    }
    if (!record->error().empty()) {
        spdlog::error("recording ended early, the cell went on: {}", record->error());
    } else if (record->full()) {
        spdlog::warn("recording ended at its limit, after {} ticks; --record-limit raises it", record->ticks());
    }
}

int run(const Arguments& a) {
    sc::sim::SimCell cell(options_of(a));
    if (a.lockstep >= 0) {
        sc::sim::serve_lock_step(cell, a.lockstep, &stop_asked);
        cell.run_out();
    } else if (!a.lockstep_at.empty()) {
        const auto ns = [](double seconds) { return static_cast<std::int64_t>(seconds * 1e9); };
        const sc::sim::LockStepTroubles troubles{ns(a.kill_host_s), a.kill_delay_us, ns(a.power_off_s), ns(a.gap_s)};
        if (sc::sim::serve_lock_step(cell, a.lockstep_at, troubles, &stop_asked)) {
            cell.run_out();
        }
    } else {
        serve_port(cell, a);
    }
    cell.close();
    tell_of(cell.record());
    spdlog::info("cell ends in state {} after {:.3f} s, {} pulses", sc::name_of(cell.state()),
                 static_cast<double>(cell.now_ns()) * 1e-9, cell.plant().pulses());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"The simulated scribing cell: controller, drives, head, laser and the true world.", "scribecell-cell"};
    try {
        Arguments arguments;
        describe(app, arguments);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        spdlog::set_default_logger(spdlog::stderr_logger_st("scribecell-cell"));
        catch_signals();
        return run(arguments);
    } catch (const sc::sim::WorldError& error) {
        std::fprintf(stderr, "scribecell-cell: %s\n", error.what());
        return kBadInput;
    } catch (const sc::mps2_an500::SetupError& error) {
        std::fprintf(stderr, "scribecell-cell: %s\n", error.what());
        return kBadInput;
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "scribecell-cell: %s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-cell: %s\n", error.what());
        return kFailed;
    }
}
