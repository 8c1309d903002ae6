// SPDX-License-Identifier: Apache-2.0
#include "host/formats/eds.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/drives/drive_plan_file.hpp"
#include "host/drives/drive_report.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell eds drive.eds
      can this drive carry an axis of the cell? what it lacks, and how it would be set up
  scribecell eds drive.eds --axis z --node 3 --cycle-ms 4
      as the Z axis, with another node number and drive cycle
  scribecell eds drive.eds --axis z --brake 80,60 --status-every 2 --write-machine machine.toml
      the Z axis with a brake, its status with every 2nd SYNC; the drive's table goes into a machine file
  scribecell eds drive.eds --json
      one JSON object

Exit codes: 0 the drive can be used; 1 something that is needed is missing or wrong; 2 bad input or usage.)";

struct Words {
    std::filesystem::path file;
    std::string axis = "x";
    int node = 0;
    int cycle_ms = 0;
    int bus = 0;
    int status_every = 1;
    int homing_method = kHomeSwitchMethod;
    std::vector<int> brake;
    std::filesystem::path machine;
    bool paired = false;
    bool json = false;
};

const std::map<std::string, std::size_t> kAxes{{"x", 0}, {"y", 1}, {"z", 2}, {"c", 3}};

const char* name_of(DriveStep::Kind kind) {
    switch (kind) {
        case DriveStep::Kind::expect_bits: return "read, these bits set";
        case DriveStep::Kind::expect_value: return "read, must be this";
        case DriveStep::Kind::write: return "write";
        case DriveStep::Kind::write_if_there: return "write if it is there";
        case DriveStep::Kind::write_and_read_back: break;
    }
    return "write and read back";
}

std::string hex(std::uint32_t value, int bytes) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "0x%0*X", bytes * 2, value);
    return text.data();
}

nlohmann::ordered_json json_of(const Eds& eds, const DriveReport& report) {
    nlohmann::ordered_json json{
        {"file", eds.file.string()},       {"vendor", eds.vendor},          {"product", eds.product},
        {"usable", report.usable()},       {"modes", report.modes},         {"paired_targets", report.paired_targets},
        {"nth_sync", report.nth_sync},     {"objects", eds.objects.size()}, {"findings", nlohmann::json::array()},
        {"setup", nlohmann::json::array()}};
    for (const DriveFinding& finding : report.findings) {
        nlohmann::ordered_json one{{"kind", sc::host::name_of(finding.kind)}, {"text", finding.text}};
        if (finding.key.index != 0) {
            one["object"] = eds_text(finding.key);
        }
        if (finding.line > 0) {
            one["line"] = finding.line;
        }
        json["findings"].push_back(one);
    }
    for (const DriveStep& step : report.steps) {
        if (step.sent) {
            json["setup"].push_back({{"object", eds_text(step.key)},
                                     {"bytes", step.size},
                                     {"value", step.value},
                                     {"how", name_of(step.kind)}});
        }
    }
    return json;
}

void print(const Eds& eds, const DriveReport& report) {
    std::printf("%s: %s %s, %zu objects\n", eds.file.string().c_str(), eds.vendor.c_str(), eds.product.c_str(),
                eds.objects.size());
    std::string modes;
    for (const std::string& mode : report.modes) {
        modes += (modes.empty() ? "" : ", ") + mode;
    }
    std::printf("modes: %s\ntargets of two axes in one PDO: %s; status with every n-th SYNC: %s\n\n",
                modes.empty() ? "not said in the file" : modes.c_str(), report.paired_targets ? "yes" : "no",
                report.nth_sync ? "yes" : "no");
    for (const DriveFinding& finding : report.findings) {
        std::printf("%-9s %-7s %s", sc::host::name_of(finding.kind),
                    finding.key.index == 0 ? "" : eds_text(finding.key).c_str(), finding.text.c_str());
        std::printf(finding.line > 0 ? " (line %d)\n" : "\n", finding.line);
    }
    std::printf("\nset-up:\n");
    for (const DriveStep& step : report.steps) {
        if (step.sent) {
            std::printf("  %-7s %-10s %s\n", eds_text(step.key).c_str(), hex(step.value, step.size).c_str(),
                        name_of(step.kind));
        }
    }
    std::printf("\n%s\n", report.usable() ? "This drive can be used."
                                          : "This drive cannot be used: see what is missing or wrong above.");
}

DriveOptions wanted(const Words& words) {
    DriveOptions options;
    options.bus = static_cast<std::uint8_t>(words.bus);
    options.status_every = static_cast<std::uint8_t>(words.status_every);
    options.paired = words.paired;
    options.homing_method = static_cast<std::int8_t>(words.homing_method);
    if (words.brake.size() == 2) {
        options.brake_release_ms = static_cast<std::uint16_t>(words.brake[0]);
        options.brake_apply_ms = static_cast<std::uint16_t>(words.brake[1]);
    }
    return options;
}

int run(const Words& words) {
    MachineConfig machine = reference_machine();
    const std::size_t axis = kAxes.at(words.axis);
    if (words.node > 0) {
        machine.axis.at(axis).drive_node = static_cast<std::uint8_t>(words.node);
    }
    if (words.cycle_ms > 0) {
        machine.drive_cycle_ticks =
            static_cast<decltype(machine.drive_cycle_ticks)>(words.cycle_ms * 1'000'000 / machine.control_period_ns);
    }
    const Eds eds = read_eds(words.file);
    DrivePlan plan;
    if (!words.machine.empty() && std::filesystem::exists(words.machine)) {
        plan = read_drive_plan(words.machine, machine);
        if (words.node > 0) {
            machine.axis.at(axis).drive_node = static_cast<std::uint8_t>(words.node);
        }
    }
    if (words.paired && words.machine.empty()) {
        // Without a file nobody says who the partner is: the neighbour.
        plan.drive.at(axis ^ 1U).paired = true;
    }
    plan.drive.at(axis) = options_by(eds, wanted(words));
    const DriveReport report = judge_drive(eds, machine, axis, plan);
    if (!words.machine.empty() && report.usable()) {
        write_drive_table(words.machine, axis, machine.axis.at(axis).drive_node, plan.drive.at(axis),
                          words.file.filename().string());
    }
    if (words.json) {
        std::printf("%s\n", json_of(eds, report).dump(2).c_str());
    } else {
        print(eds, report);
    }
    return report.usable() ? kDone : kFailed;
}

}  // namespace

void add_eds(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("eds", "Read a drive's data sheet (EDS): what it can do, and its set-up.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    constexpr int kMostNodes = 126;
    constexpr int kMostCycle = 20;
    sub->add_option("file", words->file, "electronic data sheet of the drive")->required()->type_name("FILE.eds");
    sub->add_option("--axis", words->axis, "axis of the cell that it is to drive: x, y, z or c")
        ->capture_default_str()
        ->check(CLI::IsMember(kAxes));
    sub->add_option("--node", words->node, "its node number (default: as the axis has it)")
        ->check(CLI::Range(1, kMostNodes));
    sub->add_option("--cycle-ms", words->cycle_ms, "drive cycle (default: as the machine has it)")
        ->check(CLI::Range(1, kMostCycle));
    constexpr int kMostEvery = 16;
    constexpr int kLongestBrakeMs = 5000;
    sub->add_option("--bus", words->bus, "drive bus that it hangs on: 0 or 1")->check(CLI::Range(0, 1));
    sub->add_option("--status-every", words->status_every, "its status comes with every n-th SYNC")
        ->check(CLI::Range(1, kMostEvery));
    sub->add_flag("--paired", words->paired, "its target travels in one frame with the next axis'");
    sub->add_option("--homing", words->homing_method, "method of homing (6098): 1, 2, 17..22, 33..35, 37, or -1..-4")
        ->check(CLI::Range(-128, 37))
        ->capture_default_str();
    sub->add_option("--brake", words->brake, "an axis that would fall: ms until its brake is open, and closed")
        ->expected(2)
        ->delimiter(',')
        ->check(CLI::Range(0, kLongestBrakeMs))
        ->type_name("OPEN,CLOSE");
    sub->add_option("--write-machine", words->machine,
                    "put the drive's table into this machine file, if it can be used")
        ->type_name("FILE.toml");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
