// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "boards/drive_file/drive_file.hpp"
#include "boards/drive_process/drive_process.hpp"
#include "shared/machine/machine.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-drive --can vcan1 --node 1 --node 2 --node 3 --node 4
      the four drives of the reference cell on one bus, until a signal ends it
  scribecell-drive --can vcan2 --node 3 --machine machine.toml
      one of them, with the nodes, cycle and quirks of a machine file
  scribecell-drive --can vcan1 --node 1 --quirks delta,no-6007
      a drive with peculiarities of real ones: lenze-931e, lenze-9400, infranor, delta, no-period, no-6007,
      event-driven, bit-30, no-dummy

Exit codes: 0 ended by a signal; 1 failed; 2 bad usage, or no such interface.)";

std::atomic<bool> stop{false};
void on_signal(int /*number*/) { stop.store(true); }

struct Words {
    std::string can;
    std::vector<int> nodes;
    std::string machine;
    std::string quirks;
};

std::vector<sc::sim::SimDriveOptions> options_of(const Words& words, const sc::MachineConfig& machine,
                                                 const sc::drive_file::DriveFile& file) {
    std::vector<sc::sim::SimDriveOptions> list;
    const std::int64_t cycle_ns = machine.drive_cycle_ticks * machine.control_period_ns;
    for (const int node : words.nodes) {
        const auto* const axis =
            std::ranges::find(machine.axis, node, [](const sc::AxisConfig& a) { return int{a.drive_node}; });
        if (axis == machine.axis.end()) {
            throw std::invalid_argument("--node " + std::to_string(node) + ": no axis of the machine has this node");
        }
        const auto index = static_cast<std::size_t>(axis - machine.axis.begin());
        sc::sim::SimDriveOptions options = sc::sim::drive_options(*axis, cycle_ns, sc::sim::kPowerUpPosition.at(index));
        options.quirks = sc::sim::drive_quirks(words.quirks.empty() ? file.quirks.at(index) : words.quirks);
        list.push_back(options);
    }
    return list;
}

int run(const Words& words) {
    sc::MachineConfig machine = sc::reference_machine();
    sc::drive_file::DriveFile file;
    if (!words.machine.empty()) {
        file = sc::drive_file::read_drive_file(words.machine, machine);
    }
    const auto options = options_of(words, machine, file);
    sc::drive_process::DriveProcess process(sc::socketcan::CanSocket(words.can), options,
                                            machine.drive_cycle_ticks * machine.control_period_ns);
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    std::printf("ready\n");
    std::fflush(stdout);
    process.run(stop);
    const sc::drive_process::Counters& counters = process.counters();
    std::printf("%llu SYNCs, %llu frames heard, %llu sent, %llu lost\n",
                static_cast<unsigned long long>(counters.syncs), static_cast<unsigned long long>(counters.received),
                static_cast<unsigned long long>(counters.sent), static_cast<unsigned long long>(counters.lost));
    return counters.lost == 0 ? 0 : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Simulated servo drives on a CAN bus.", "scribecell-drive"};
    Words words;
    try {
        app.footer(kExamples);
        app.add_option("--can", words.can, "CAN interface")->required()->type_name("IFACE");
        app.add_option("--node", words.nodes, "node number of a drive; may be repeated")
            ->required()
            ->check(CLI::Range(1, 126));
        app.add_option("--machine", words.machine, "machine file with [drives.*] tables (default: the reference cell)")
            ->type_name("FILE");
        app.add_option("--quirks", words.quirks, "of all these drives, with commas between");
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        return run(words);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-drive: %s\n", error.what());
        return kBadInput;
    }
}
