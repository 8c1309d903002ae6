// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "boards/linux_rt/real_time.hpp"
#include "boards/linux_rt/runner.hpp"

namespace sc::linux_rt {

struct Options {
    std::filesystem::path machine;     ///< empty: the reference cell
    std::string drive_bus;             ///< can:IFACE[,can:IFACE]
    std::string link;                  ///< of the host
    std::vector<std::string> sensors;  ///< BUS=DEVICE
    std::string gpio;                  ///< CHIP:line=offset,…
    bool lines_closed = false;         ///< no lines are wired
    std::string events;                ///< socket of the event device
    std::string gate;                  ///< "gpio", or empty
    std::string pace = "time";
    double slow = 1.0;
    int answer_timeout_ms = 1000;
    std::uint64_t most_overruns = 20;
    RealTimeOptions real_time;
    int cpu = -1;
    bool no_real_time = false;
    std::filesystem::path memory;
    std::filesystem::path key;
    std::uint32_t boot_id = 0;
    bool json = false;
};

void describe(CLI::App& app, Options& options);
/// Throws std::invalid_argument for options that do not go together.
void check(const Options& options);
/// The buses of `--drive-bus`. Throws std::invalid_argument, std::system_error.
[[nodiscard]] std::vector<socketcan::CanSocket> open_drive_buses(const std::string& text);
/// Ports of `--sensors`, by bus. Throws std::invalid_argument, std::system_error.
struct SensorPort {
    std::size_t bus = 0;
    std::string device;
};
[[nodiscard]] std::vector<SensorPort> sensor_ports(const std::vector<std::string>& words);

}  // namespace sc::linux_rt
