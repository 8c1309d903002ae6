// SPDX-License-Identifier: Apache-2.0
#include "host/drives/drive_plan_file.hpp"

#include <algorithm>
#include <array>
#include <iomanip>
#include <sstream>
#include <string_view>
#include <utility>

#include <toml++/toml.h>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host {
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

[[noreturn]] void refuse(const std::filesystem::path& file, const toml::node& node, const std::string& problem,
                         const std::string& value, const std::string& action) {
    throw InputError({.file = file.string(),
                      .line = static_cast<int>(node.source().begin.line),
                      .problem = problem,
                      .value = value,
                      .action = action});
}

template <typename T>
T number(const std::filesystem::path& file, const std::string& key, const toml::node& node, std::int64_t least,
         std::int64_t most) {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < least || *value > most) {
        refuse(file, node, "the value of a drive's key is not in its range", key,
               "give a whole number of " + std::to_string(least) + " to " + std::to_string(most));
    }
    return static_cast<T>(*value);
}

std::uint16_t absent_of(const std::filesystem::path& file, const toml::node& node) {
    const toml::array* const list = node.as_array();
    if (list == nullptr) {
        refuse(file, node, "absent is no list", "", "write it as [\"6007\", \"1006\"]");
    }
    unsigned bits = 0;
    for (const toml::node& one : *list) {
        const auto name = one.value_or(std::string_view{});
        const auto* const found = std::ranges::find(kObjects, name, &std::pair<std::string_view, std::uint16_t>::first);
        if (found == kObjects.end()) {
            refuse(file, one, "no object that may be absent", std::string(name),
                   "choose of 6007, 1006, 6065, 6066, 6085, 609A, 140x, 180x");
        }
        bits |= found->second;
    }
    return static_cast<std::uint16_t>(bits);
}

void read_table(const std::filesystem::path& file, const toml::table& table, DriveOptions& drive, AxisConfig& axis) {
    constexpr std::int64_t kU32 = 0xFFFF'FFFF;
    constexpr std::int64_t kLongestBrakeMs = 5000;
    for (const auto& [word, node] : table) {
        const std::string key(word.str());
        if (key == "node") {
            axis.drive_node = number<std::uint8_t>(file, key, node, 1, 126);
        } else if (key == "bus") {
            drive.bus = number<std::uint8_t>(file, key, node, 0, 1);
        } else if (key == "status_every") {
            drive.status_every = number<std::uint8_t>(file, key, node, 1, 16);
        } else if (key == "paired") {
            if (!node.is_boolean()) {
                refuse(file, node, "the value of a drive's key is not in its range", key, "give true or false");
            }
            drive.paired = node.value_or(false);
        } else if (key == "homing_method") {
            drive.homing_method = number<std::int8_t>(file, key, node, -128, 37);
        } else if (key == "absent") {
            drive.absent = absent_of(file, node);
        } else if (key == "brake_release_ms") {
            drive.brake_release_ms = number<std::uint16_t>(file, key, node, 0, kLongestBrakeMs);
        } else if (key == "brake_apply_ms") {
            drive.brake_apply_ms = number<std::uint16_t>(file, key, node, 0, kLongestBrakeMs);
        } else if (key == "vendor") {
            drive.vendor = number<std::uint32_t>(file, key, node, 0, kU32);
        } else if (key == "product") {
            drive.product = number<std::uint32_t>(file, key, node, 0, kU32);
        } else if (key != "quirks" && key != "eds") {
            refuse(file, node, "no key of a drive", key,
                   "choose of node, bus, status_every, paired, homing_method, absent, brake_release_ms, "
                   "brake_apply_ms, vendor, product, quirks, eds");
        }
    }
}

std::string table_text(std::size_t axis, std::uint8_t node, const DriveOptions& options, const std::string& eds) {
    std::ostringstream out;
    out << "[drives." << kAxes.at(axis) << "]\neds = " << std::quoted(eds) << "\nnode = " << int{node}
        << "\nbus = " << int{options.bus} << "\nstatus_every = " << int{options.status_every}
        << "\npaired = " << (options.paired ? "true" : "false") << "\nhoming_method = " << int{options.homing_method}
        << "\nabsent = [";
    bool first = true;
    for (const auto& [name, bit] : kObjects) {
        if ((options.absent & bit) != 0) {
            out << (first ? "" : ", ") << '"' << name << '"';
            first = false;
        }
    }
    out << "]\nbrake_release_ms = " << options.brake_release_ms << "\nbrake_apply_ms = " << options.brake_apply_ms
        << "\nvendor = " << options.vendor << "\nproduct = " << options.product << "\n";
    return out.str();
}

}  // namespace

DrivePlan read_drive_plan(const std::filesystem::path& file, MachineConfig& machine) {
    toml::table root;
    try {
        root = toml::parse(read_text_file(file), file.string());
    } catch (const toml::parse_error& error) {
        throw InputError({.file = file.string(),
                          .line = static_cast<int>(error.source().begin.line),
                          .problem = std::string(error.description()),
                          .action = "correct the file"});
    }
    DrivePlan plan;
    const toml::node* const drives = root.get("drives");
    if (drives == nullptr) {
        return plan;
    }
    if (!drives->is_table()) {
        refuse(file, *drives, "drives is no table", "", "write tables [drives.x] to [drives.c]");
    }
    for (const auto& [word, node] : *drives->as_table()) {
        if (word.str() == "cycle_ms") {
            const auto ms = number<std::int64_t>(file, "cycle_ms", node, 1, 20);
            machine.drive_cycle_ticks = static_cast<std::uint32_t>(ms * 1'000'000 / machine.control_period_ns);
            continue;
        }
        const auto* const axis = std::ranges::find(kAxes, word.str());
        if (axis == kAxes.end() || !node.is_table()) {
            refuse(file, node, "no axis", std::string(word.str()), "choose of x, y, z, c");
        }
        const auto index = static_cast<std::size_t>(axis - kAxes.begin());
        read_table(file, *node.as_table(), plan.drive.at(index), machine.axis.at(index));
    }
    return plan;
}

void write_drive_table(const std::filesystem::path& file, std::size_t axis, std::uint8_t node,
                       const DriveOptions& options, const std::string& eds) {
    std::string before;
    std::string after;
    if (std::filesystem::exists(file)) {
        MachineConfig machine = reference_machine();
        static_cast<void>(read_drive_plan(file, machine));  // what is broken is not written to
        std::istringstream lines(read_text_file(file));
        const std::string head = "[drives." + std::string(kAxes.at(axis)) + "]";
        bool inside = false;
        bool met = false;
        for (std::string line; std::getline(lines, line);) {
            const std::size_t begin = line.find_first_not_of(" \t");
            const bool table = begin != std::string::npos && line[begin] == '[';
            if (table) {
                inside = line.compare(begin, head.size(), head) == 0;
                met = met || inside;
            }
            if (!inside) {
                (met ? after : before) += line + "\n";
            }
        }
    }
    if (!before.empty() && !before.ends_with("\n\n")) {
        before += "\n";
    }
    write_text_file(file, before + table_text(axis, node, options, eds) + (after.empty() ? "" : "\n" + after));
}

}  // namespace sc::host
