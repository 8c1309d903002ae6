// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/can_netlink.hpp"

/// What a cell, its sensors and its pendant can be plugged in to on this PC. Nothing is opened for use.

namespace sc::host {

struct CanInterface {
    std::string name;
    bool up = false;
    bool fd = false;  ///< set up for FD frames
    CanDetails details;
    std::vector<std::string> missing;  ///< each with what to do
};
struct SerialPortName {
    std::string device;
    std::string by_id;  ///< name that stays with the adapter, where there is one
    std::string driver;
    std::vector<std::string> missing;
};
struct HidDevice {
    std::string device;
    std::string name;
    unsigned vendor = 0;
    unsigned product = 0;
    bool pendant = false;  ///< XHC WHB04B-6 or a clone
    std::vector<std::string> missing;
};
struct GpioChip {
    std::string device;
    std::string label;
    unsigned lines = 0;
    std::vector<std::string> missing;
};
struct Ports {
    std::vector<CanInterface> can;
    std::vector<SerialPortName> serial;
    std::vector<HidDevice> hid;
    std::vector<GpioChip> gpio;
    std::vector<std::string> missing;  ///< of the kernel as a whole
};

/// Where to look and whom to ask; tests have their own.
struct PortSources {
    std::filesystem::path root = "/";  ///< below which are sys and dev
    std::function<std::optional<CanDetails>(unsigned index)> can_details = ask_can_link;
    std::function<bool(const std::string& path)> may_use;  ///< read and write; default: access(2)
    bool kernel_has_can = true;
};

/// Everything that is there, each kind sorted by name. Never throws.
[[nodiscard]] Ports find_ports(const PortSources& sources);
/// Of this PC.
[[nodiscard]] Ports find_ports();

}  // namespace sc::host
