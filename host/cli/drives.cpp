// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/drives/bus_text.hpp"
#include "host/drives/drive_plan_file.hpp"
#include "host/drives/emergency_text.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell drives
      what the drives of the reference cell take of their bus, term by term
  scribecell drives machine.toml --cycle-ms 1
      do the drives of this machine file fit on their buses at 1 kHz?
  scribecell drives --error 8611
      what a drive means by this error code (EMCY, 603F)

Exit codes: 0 the drives fit; 1 they do not; 2 bad input or usage.)";

struct Words {
    std::filesystem::path file;
    std::string error;
    int cycle_ms = 0;
    bool json = false;
};

int print_error(const std::string& word, bool json) {
    constexpr int kHex = 16;
    std::uint16_t code = 0;
    const char* const begin = word.data() + (word.starts_with("0x") || word.starts_with("0X") ? 2 : 0);
    const auto end = std::from_chars(begin, word.data() + word.size(), code, kHex);
    if (end.ec != std::errc() || end.ptr != word.data() + word.size()) {
        throw InputError({.problem = "no error code", .value = word, .action = "give four hexadecimal digits: 8611"});
    }
    const std::string text = emergency_text(code);
    std::printf("%s\n", json ? nlohmann::ordered_json{{"code", code}, {"text", text}}.dump().c_str() : text.c_str());
    return kDone;
}

int run(const Words& words) {
    if (!words.error.empty()) {
        return print_error(words.error, words.json);
    }
    MachineConfig machine = reference_machine();
    const DrivePlan plan = words.file.empty() ? DrivePlan{} : read_drive_plan(words.file, machine);
    if (words.cycle_ms > 0) {
        machine.drive_cycle_ticks =
            static_cast<decltype(machine.drive_cycle_ticks)>(words.cycle_ms * 1'000'000 / machine.control_period_ns);
    }
    const BusSheet sheet = bus_sheet(machine, plan);
    if (!words.json) {
        std::printf("%s", text_of(sheet).c_str());
        return sheet.fits() ? kDone : kFailed;
    }
    nlohmann::ordered_json json{{"fits", sheet.fits()},
                                {"cycle_ms", machine.drive_cycle_ticks * machine.control_period_ns / 1'000'000},
                                {"buses", nlohmann::json::array()},
                                {"terms", nlohmann::json::array()}};
    for (const BusSheet::Sum& sum : sheet.sums) {
        json["buses"].push_back(
            {{"bus", sum.bus}, {"cyclic", sum.cyclic}, {"reserve", sum.reserve}, {"total", sum.total()}});
    }
    for (const BusLine& line : sheet.lines) {
        json["terms"].push_back({{"bus", line.bus},
                                 {"frames", line.frames},
                                 {"count", line.count},
                                 {"bits", line.bits},
                                 {"period_ms", line.period_ms},
                                 {"share", line.share},
                                 {"reserve", line.reserve}});
    }
    std::printf("%s\n", json.dump(2).c_str());
    return sheet.fits() ? kDone : kFailed;
}

}  // namespace

void add_drives(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("drives", "What the drives take of their bus; what their error codes mean.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    constexpr int kMostCycle = 20;
    sub->add_option("file", words->file, "machine file with [drives.*] tables (default: the reference cell)")
        ->type_name("FILE.toml");
    sub->add_option("--cycle-ms", words->cycle_ms, "drive cycle (default: as the machine has it)")
        ->check(CLI::Range(1, kMostCycle));
    sub->add_option("--error", words->error, "say what this error code means, and no more")->type_name("CODE");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
