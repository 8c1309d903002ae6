// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/ports.hpp"

#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell ports
      CAN interfaces, serial ports, pendants and GPIO chips of this PC, and what is missing to use each
  scribecell ports --json
      one JSON object

--link takes can:NAME (can:NAME?fd=1) and serial:DEVICE of what is listed. Nothing is opened for use.)";

using Json = nlohmann::ordered_json;

Json json_of(const CanInterface& one) {
    Json json{{"name", one.name},
              {"kind", one.details.kind},
              {"up", one.up},
              {"fd", one.fd},
              {"state", one.details.state},
              {"queue_length", one.details.queue_length},
              {"restart_ms", one.details.restart_ms}};
    if (one.details.bitrate) {
        json["bitrate"] = *one.details.bitrate;
    }
    if (one.details.data_bitrate) {
        json["data_bitrate"] = *one.details.data_bitrate;
    }
    json["missing"] = one.missing;
    return json;
}

Json json_of(const Ports& ports) {
    Json json{{"can", Json::array()},
              {"serial", Json::array()},
              {"hid", Json::array()},
              {"gpio", Json::array()},
              {"missing", ports.missing}};
    for (const CanInterface& one : ports.can) {
        json["can"].push_back(json_of(one));
    }
    for (const SerialPortName& one : ports.serial) {
        json["serial"].push_back(
            {{"device", one.device}, {"by_id", one.by_id}, {"driver", one.driver}, {"missing", one.missing}});
    }
    for (const HidDevice& one : ports.hid) {
        json["hid"].push_back({{"device", one.device},
                               {"name", one.name},
                               {"vendor", fmt::format("{:04X}", one.vendor)},
                               {"product", fmt::format("{:04X}", one.product)},
                               {"pendant", one.pendant},
                               {"missing", one.missing}});
    }
    for (const GpioChip& one : ports.gpio) {
        json["gpio"].push_back(
            {{"device", one.device}, {"label", one.label}, {"lines", one.lines}, {"missing", one.missing}});
    }
    return json;
}

void print_missing(const std::vector<std::string>& missing) {
    for (const std::string& one : missing) {
        fmt::print("    {}\n", one);
    }
}

std::string rate_text(const CanInterface& one) {
    std::string text;
    if (one.details.bitrate) {
        text += fmt::format(", {} kbit/s", *one.details.bitrate / 1000);
    }
    if (one.details.data_bitrate) {
        text += fmt::format(" and {} kbit/s", *one.details.data_bitrate / 1000);
    }
    return text;
}

void print(const Ports& ports) {
    print_missing(ports.missing);
    for (const CanInterface& one : ports.can) {
        fmt::print("can:{}{}  {}{}{}{}\n", one.name, one.fd ? "?fd=1" : "", one.up ? "up" : "down", rate_text(one),
                   one.details.state.empty() ? "" : ", " + one.details.state,
                   one.details.kind.empty() ? "" : " (" + one.details.kind + ")");
        print_missing(one.missing);
    }
    for (const SerialPortName& one : ports.serial) {
        fmt::print("serial:{}  {}{}\n", one.device, one.driver, one.by_id.empty() ? "" : "  " + one.by_id);
        print_missing(one.missing);
    }
    for (const HidDevice& one : ports.hid) {
        fmt::print("{}  {:04X}:{:04X} {}{}\n", one.device, one.vendor, one.product, one.name,
                   one.pendant ? "  (pendant)" : "");
        print_missing(one.missing);
    }
    for (const GpioChip& one : ports.gpio) {
        fmt::print("{}  {}, {} lines\n", one.device, one.label, one.lines);
        print_missing(one.missing);
    }
    if (ports.can.empty() && ports.serial.empty() && ports.hid.empty() && ports.gpio.empty()) {
        fmt::print("no CAN interface, serial port, HID device or GPIO chip\n");
    }
}

}  // namespace

void add_ports(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("ports", "What a cell, its sensors and its pendant can be plugged in to here.");
    sub->footer(kExamples);
    const auto json = std::make_shared<bool>(false);
    sub->add_flag("--json", *json, "one JSON object");
    sub->callback([json, &exit_code] {
        exit_code = guarded(*json, [&json] {
            const Ports ports = find_ports();
            if (*json) {
                fmt::print("{}\n", json_of(ports).dump(2));
            } else {
                print(ports);
            }
            return kDone;
        });
    });
}

}  // namespace sc::host::cli
