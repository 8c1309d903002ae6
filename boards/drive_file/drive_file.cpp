// SPDX-License-Identifier: Apache-2.0
#include "boards/drive_file/drive_file.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <toml++/toml.h>

#include "shared/drives/bus_terms.hpp"

namespace sc::drive_file {
namespace {

constexpr std::array<std::string_view, kAxisCount> kAxes{"x", "y", "z", "c"};
constexpr std::array<std::pair<std::string_view, std::uint16_t>, 8> kObjects{{{"6007", drive_object::k6007},
                                                                              {"1006", drive_object::k1006},
                                                                              {"6065", drive_object::k6065},
                                                                              {"6066", drive_object::k6066},
                                                                              {"6085", drive_object::k6085},
                                                                              {"609A", drive_object::k609A},
                                                                              {"140x", drive_object::kRpdos},
                                                                              {"180x", drive_object::kTpdos}}};

class Reader {
public:
    explicit Reader(std::filesystem::path file) : file_(std::move(file)) {}

    [[noreturn]] void refuse(const toml::node& node, const std::string& why) const {
        throw std::invalid_argument(file_.string() + ":" + std::to_string(node.source().begin.line) + ": " + why);
    }
    std::int64_t number(const toml::node& node, const std::string& key, std::int64_t least, std::int64_t most) const {
        const auto value = node.value_exact<std::int64_t>();
        if (!value || *value < least || *value > most) {
            refuse(node, key + " wants a whole number of " + std::to_string(least) + " to " + std::to_string(most));
        }
        return *value;
    }
    void drive(const toml::table& table, std::size_t axis, DriveFile& out, MachineConfig& machine) const;
    [[nodiscard]] std::uint16_t absent(const toml::node& node) const;

private:
    std::filesystem::path file_;
};

std::uint16_t Reader::absent(const toml::node& node) const {
    const toml::array* list = node.as_array();
    if (list == nullptr) {
        refuse(node, "absent wants a list of objects, as [\"6007\", \"1006\"]");
    }
    unsigned bits = 0;
    for (const toml::node& one : *list) {
        const auto name = one.value_or(std::string_view{});
        const auto* const found = std::ranges::find(kObjects, name, &std::pair<std::string_view, std::uint16_t>::first);
        if (found == kObjects.end()) {
            refuse(one, "'" + std::string(name) +
                            "' is no object that may be absent: 6007, 1006, 6065, 6066, 6085, 609A, "
                            "140x, 180x");
        }
        bits |= found->second;
    }
    return static_cast<std::uint16_t>(bits);
}

void Reader::drive(const toml::table& table, std::size_t axis, DriveFile& out, MachineConfig& machine) const {
    DriveOptions& drive = out.plan.drive.at(axis);
    constexpr std::int64_t kU32 = 0xFFFF'FFFF;
    constexpr std::int64_t kLongestBrakeMs = 5000;
    for (const auto& [word, node] : table) {
        const std::string key(word.str());
        if (key == "node") {
            machine.axis.at(axis).drive_node = static_cast<std::uint8_t>(number(node, key, 1, 126));
        } else if (key == "bus") {
            drive.bus = static_cast<std::uint8_t>(number(node, key, 0, 1));
        } else if (key == "status_every") {
            drive.status_every = static_cast<std::uint8_t>(number(node, key, 1, 16));
        } else if (key == "paired") {
            const auto on = node.value_exact<bool>();
            if (!on) {
                refuse(node, "paired wants true or false");
            }
            drive.paired = *on;
        } else if (key == "homing_method") {
            drive.homing_method = static_cast<std::int8_t>(number(node, key, -128, 37));
        } else if (key == "absent") {
            drive.absent = absent(node);
        } else if (key == "brake_release_ms") {
            drive.brake_release_ms = static_cast<std::uint16_t>(number(node, key, 0, kLongestBrakeMs));
        } else if (key == "brake_apply_ms") {
            drive.brake_apply_ms = static_cast<std::uint16_t>(number(node, key, 0, kLongestBrakeMs));
        } else if (key == "vendor") {
            drive.vendor = static_cast<std::uint32_t>(number(node, key, 0, kU32));
        } else if (key == "product") {
            drive.product = static_cast<std::uint32_t>(number(node, key, 0, kU32));
        } else if (key == "quirks") {
            out.quirks.at(axis) = node.value_or(std::string());
        } else if (key != "eds") {
            refuse(node, "no key of a drive: '" + key +
                             "'; there are: node, bus, status_every, paired, homing_method, absent, brake_release_ms, "
                             "brake_apply_ms, vendor, product, quirks, eds");
        }
    }
}

const char* name_of(drives::BusFrame frame) {
    switch (frame) {
        case drives::BusFrame::sync: return "SYNC";
        case drives::BusFrame::target: return "target and controlword (6 bytes)";
        case drives::BusFrame::pair_of_targets: return "two targets (8 bytes)";
        case drives::BusFrame::status: return "status and place (6 bytes)";
        case drives::BusFrame::controlword: return "controlword (2 bytes)";
        case drives::BusFrame::sdo: return "SDO (8 bytes)";
        case drives::BusFrame::emergency: return "EMCY (8 bytes)";
        case drives::BusFrame::heartbeat: break;
    }
    return "heartbeat (1 byte)";
}

}  // namespace

DriveFile read_drive_file(const std::filesystem::path& file, MachineConfig& machine) {
    toml::table root;
    try {
        root = toml::parse_file(file.string());
    } catch (const toml::parse_error& error) {
        throw std::invalid_argument(file.string() + ":" + std::to_string(error.source().begin.line) + ": " +
                                    std::string(error.description()));
    }
    DriveFile result;
    const Reader reader(file);
    const toml::node* const drives = root.get("drives");
    if (drives == nullptr) {
        return result;
    }
    const toml::table* const table = drives->as_table();
    if (table == nullptr) {
        reader.refuse(*drives, "drives wants tables [drives.x] to [drives.c]");
    }
    for (const auto& [word, node] : *table) {
        if (word.str() == "cycle_ms") {
            machine.drive_cycle_ticks = static_cast<std::uint32_t>(reader.number(node, "cycle_ms", 1, 20) * 1'000'000 /
                                                                   machine.control_period_ns);
            continue;
        }
        const auto* const axis = std::ranges::find(kAxes, word.str());
        if (axis == kAxes.end() || node.as_table() == nullptr) {
            reader.refuse(node, "no axis: '" + std::string(word.str()) + "'; there are: x, y, z, c (and cycle_ms)");
        }
        reader.drive(*node.as_table(), static_cast<std::size_t>(axis - kAxes.begin()), result, machine);
    }
    return result;
}

std::string budget_text(const MachineConfig& machine, const DrivePlan& plan) {
    std::string text;
    std::array<char, 160> line{};
    for (std::uint8_t bus = 0; bus < kDriveBuses; ++bus) {
        const auto terms = drives::bus_terms(machine, plan, bus);
        if (!terms) {
            return "the plan of the drives is none: a bus beyond 1, a status too rare, or no cycle\n";
        }
        if (terms->size == 0) {
            continue;
        }
        for (const drives::BusTerm& term : terms->all()) {
            std::snprintf(line.data(), line.size(), "bus %d  %-34s %2u x %3u bits in %5.1f ms  %6.2f %%%s\n", int{bus},
                          name_of(term.frame), term.count, term.bits, static_cast<double>(term.period_ns) * 1e-6,
                          100.0 * term.share(terms->bitrate), term.cyclic ? "" : "  reserve");
            text += line.data();
        }
        const drives::BusBudget sum = drives::sum_of(*terms);
        std::snprintf(line.data(), line.size(),
                      "bus %d  cyclic %.2f %% + reserve %.2f %% = %.2f %% of %.1f Mbit/s: %s\n", int{bus},
                      100.0 * sum.cyclic, 100.0 * sum.reserve, 100.0 * sum.total(),
                      static_cast<double>(terms->bitrate) * 1e-6, sum.total() <= 1.0 ? "fits" : "does NOT fit");
        text += line.data();
    }
    return text;
}

}  // namespace sc::drive_file
