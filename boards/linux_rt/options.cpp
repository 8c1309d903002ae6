// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/options.hpp"

#include <optional>
#include <stdexcept>
#include <string_view>

namespace sc::linux_rt {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell-rt --drive-bus can:can1 --link can:can0?fd=1 --events /run/scribecell/events \
      --gpio gpiochip0:estop=3,interlock=4,key-setup=5,key-production=6,red=10,yellow=11,green=12
      drives on can1, the host on can0, laser events to the device that listens there
  scribecell-rt --drive-bus can:can1,can:can2 --link tcp:7000 --gpio gpiochip0:estop=3,interlock=4
      axes and sensors alone, two drive buses; no laser: arming is refused
  scribecell-rt --drive-bus can:vcan1 --link can:vcan0 --events e.socket --lines-closed --pace drives --no-rt
      on a PC without real time and without wired lines, for tests: a tick waits until all drives have answered

Lines of --gpio, in any order, !NAME=N for one that is low when healthy or on: inputs estop interlock laser-ready
laser-no-alarm shutter-open shutter-closed key-setup key-production; outputs mo guide red yellow green shutter gate.

SIGTERM and SIGINT bring the axes to rest and take their power away; SIGUSR1 prints what was measured so far.
Exit codes: 0 ended as asked; 1 the loop could not keep its period, or the axes did not come to rest; 2 bad input or
usage, or no right to run in real time.)";

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

}  // namespace

void describe(CLI::App& app, Options& o) {
    app.footer(kExamples);
    app.add_option("--drive-bus", o.drive_bus, "CAN interfaces of the drives: can:IFACE or can:IFACE,can:IFACE")
        ->required()
        ->type_name("BUS");
    app.add_option(
           "--link", o.link,
           "where the host plugs in: can:IFACE, can:IFACE?fd=1, serial:DEV?baud=N, tcp:PORT or tcp:ADDRESS:PORT")
        ->required()
        ->type_name("LINK");
    app.add_option("--machine", o.machine, "machine file (default: the reference cell)")->type_name("FILE");
    app.add_option("--sensors", o.sensors, "serial port of a Modbus bus, e.g. 0=/dev/ttyUSB1; once a bus")
        ->type_name("BUS=DEV");
    auto* lines = app.add_option_group("lines", "digital inputs and outputs");
    lines->add_option("--gpio", o.gpio, "chip and offsets of the wired lines")->type_name("CHIP:NAME=N,...");
    lines->add_flag(
        "--lines-closed", o.lines_closed,
        "no lines: all chains read closed, the key at production. For tests; never with a laser that burns");
    lines->require_option(1);
    app.add_option("--events", o.events, "socket of the event device that fires the laser (default: no laser)")
        ->type_name("SOCKET");
    app.add_option("--gate", o.gate, "gpio: the laser is gated by the line `gate` of --gpio, to a tick's precision")
        ->check(CLI::IsMember({"gpio"}));
    app.add_option("--pace", o.pace,
                   "time: the clock alone; drives: no tick before drives and event device have answered the last")
        ->check(CLI::IsMember({"time", "drives"}))
        ->capture_default_str();
    app.add_option("--slow", o.slow, "seconds that a second of the cell takes, with --pace drives")
        ->check(CLI::Range(1.0, 100.0))
        ->capture_default_str();
    app.add_option("--answer-timeout", o.answer_timeout_ms, "ms that a tick waits, with --pace drives")
        ->check(CLI::Range(1, 60'000))
        ->capture_default_str();
    app.add_option("--most-overruns", o.most_overruns, "so many periods missed in a row end the run, 0: never")
        ->capture_default_str();
    app.add_option("--priority", o.real_time.priority, "of SCHED_FIFO")
        ->check(CLI::Range(1, 98))
        ->capture_default_str();
    app.add_option("--cpu", o.cpu, "processor of the loop (default: any)")->check(CLI::Range(0, 1023));
    app.add_flag("--no-rt", o.no_real_time, "run without real time, with a warning");
    app.add_option("--memory", o.memory, "file of what the controller keeps without power (default: nothing)")
        ->type_name("FILE");
    app.add_option("--key", o.key, "file of 32 hex digits: only commands sealed with this key are taken")
        ->type_name("FILE");
    app.add_option("--boot-id", o.boot_id, "number of this start (default: from the time of day)");
    app.add_flag("--json", o.json, "what was measured as one JSON object a line");
}

void check(const Options& o) {
    if (!o.events.empty() && !o.gate.empty()) {
        refuse("--events and --gate: the laser hangs on one of them");
    }
    if (o.gate == "gpio" && o.gpio.find("gate=") == std::string::npos) {
        refuse("--gate gpio needs the line `gate` in --gpio");
    }
    if (o.slow != 1.0 && o.pace != "drives") {
        refuse("--slow needs --pace drives: real drives keep real time");
    }
}

std::vector<socketcan::CanSocket> open_drive_buses(const std::string& text) {
    std::vector<socketcan::CanSocket> buses;
    std::string_view rest = text;
    while (true) {
        const std::size_t comma = rest.find(',');
        const std::string_view one = rest.substr(0, comma);
        const bool named = one.starts_with("can:") && one.size() > 4;
        const std::optional<int> file = inherited_file(one);
        if (buses.size() == 2 || (!named && !file)) {
            refuse("--drive-bus " + text + ": use can:IFACE, or can:IFACE,can:IFACE for two");
        }
        if (named) {
            buses.emplace_back(std::string(one.substr(4)));
        } else {
            buses.emplace_back(*file);
        }
        if (comma == std::string_view::npos) {
            return buses;
        }
        rest.remove_prefix(comma + 1);
    }
}

std::vector<SensorPort> sensor_ports(const std::vector<std::string>& words) {
    std::vector<SensorPort> ports;
    for (const std::string& word : words) {
        const bool good =
            word.size() > 2 && word[1] == '=' && word[0] >= '0' && word[0] < '0' + static_cast<char>(kSensorBuses);
        if (!good) {
            refuse("--sensors " + word + ": use BUS=DEVICE with a bus of 0 to " + std::to_string(kSensorBuses - 1));
        }
        ports.push_back({static_cast<std::size_t>(word[0] - '0'), word.substr(2)});
        for (std::size_t i = 0; i + 1 < ports.size(); ++i) {
            if (ports[i].bus == ports.back().bus) {
                refuse("--sensors " + word + ": that bus has a port already");
            }
        }
    }
    return ports;
}

}  // namespace sc::linux_rt
