// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/focus_fit.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/plate.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSurvey = "scribecell-survey";
constexpr const char* kExamples = R"(Examples:
  scribecell calibrate focus --out focus1
      a ladder of 21 crosses on the plate of the simulated cell, 0.2 mm apart in y; widths of their strokes; where the
      focus is, and the beam's waist
  scribecell calibrate focus --burn-only --at-mm -225,-210,-250 --link serial:/dev/ttyUSB0 --out focus1
      a real ladder on a surface there: burns it and writes focus1/plan.csv; each cross is two strokes, numbered from 1
  scribecell calibrate focus --plan focus1/plan.csv --widths widths.csv --calibration old.toml --out focus1
      fits what was measured (line,width_mm,sigma_mm) and puts [beam] into a set

By eye: `scribecell calibrate pointing` finds the focus with the guide light.
Exit codes: 0 done; 1 the cell failed; 2 bad input, or widths that cannot show the focus; 130 Ctrl-C.)";

struct Asked {
    std::optional<std::filesystem::path> out;
    std::optional<std::filesystem::path> plan;
    std::optional<std::filesystem::path> widths;
    std::optional<std::filesystem::path> calibration;
    std::optional<std::filesystem::path> world;
    std::string link = "sim:";
    std::optional<std::filesystem::path> key{};  ///< file of the cell's key
    std::vector<double> at_mm{-225.0, -210.0, -250.0};
    double half_mm = 2.0;
    int rungs = 21;
    double width_um = 3.0;
    std::uint64_t seed = 1;
    bool burn_only = false;
    bool json = false;
};

[[noreturn]] void refuse(const std::filesystem::path& file, std::string problem, std::string value,
                         std::string action) {
    throw InputError(
        {.file = file.string(), .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

/// Rungs stand beside each other in an order of their own: a surface that leans then looks like noise, not like a
/// shift.
PlatePlan ladder(const Asked& asked, const MachineConfig& machine) {
    constexpr int kAcross = 7;
    constexpr double kApart = 2e-3;
    constexpr double kArm = 0.7e-3;
    int stride = std::max(1, asked.rungs * 3 / 8);
    const auto divides = [&](int k) {
        for (int d = 2; d <= k; ++d) {
            if (k % d == 0 && asked.rungs % d == 0) {
                return true;
            }
        }
        return false;
    };
    while (divides(stride)) {
        ++stride;
    }
    std::vector<PlateStand> stands;
    for (int i = 0; i < asked.rungs; ++i) {
        const int at = (i * stride) % asked.rungs;
        const double y = asked.at_mm[1] + asked.half_mm * (2.0 * i / (asked.rungs - 1) - 1.0);
        const int column = at % kAcross - kAcross / 2;
        const int row = at / kAcross - 1;
        stands.push_back(
            {{asked.at_mm[0] * 1e-3 + kApart * column, y * 1e-3, asked.at_mm[2] * 1e-3 + kApart * row}, {{0.0, 0.0}}});
    }
    return plan_stands(stands, kArm, machine);
}

std::vector<Rung> rungs_of(const std::filesystem::path& plan, const std::filesystem::path& widths) {
    const std::vector<PlateCross> crosses = read_plate_plan(plan);
    const CsvTable csv = CsvTable::read(widths);
    csv.refuse_columns_beyond({"line", "width_mm", "sigma_mm"});
    std::vector<Rung> out;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const int line = csv.integer(i, csv.column("line"));
        const double width = csv.number(i, csv.column("width_mm")) * 1e-3;
        const double sigma = csv.number(i, csv.column("sigma_mm")) * 1e-3;
        const auto cross = std::ranges::find(crosses, (line + 1) / 2, &PlateCross::no);
        if (line < 1 || cross == crosses.end() || !(width > 0.0) || !(sigma > 0.0)) {
            throw InputError({.file = widths.string(),
                              .line = csv.line(i),
                              .problem = "a stroke that is not in the plan, or a width or sigma that is not above zero",
                              .value = std::to_string(line),
                              .action = "number strokes from 1, two a cross of " + plan.string() +
                                        ", and leave out those that left no mark"});
        }
        out.push_back({line, cross->anchor.y, width, sigma});
    }
    return out;
}

void burn(const Asked& asked, const std::filesystem::path& folder) {
    CrossBurn where{.link = asked.link, .world = {}, .seed = asked.seed, .key = asked.key};
    const bool simulated = is_simulated(asked.link);
    if (simulated) {
        where.world = asked.world.value_or(in_project("boards/sim/world/plate/world.toml"));
    }
    const CalibrationSet set =
        read_calibration(asked.calibration.value_or(in_project("examples/ras3dm/calibration.toml")));
    burn_crosses(where, set, [&asked](const MachineConfig& machine) { return ladder(asked, machine); }, folder);
    if (simulated && !asked.burn_only) {
        const ProgramOutput seen = run_program(
            required_program(kSurvey), {"widths", (folder / "pulses.trace").string(), "--world", where.world.string(),
                                        "--out", (folder / "widths.csv").string(), "--width-um",
                                        fmt::format("{}", asked.width_um), "--seed", std::to_string(asked.seed)});
        if (seen.exit_code != 0) {
            throw CellError(fmt::format("{} ended with {}", kSurvey, seen.exit_code));
        }
    }
}

void check(const Asked& asked) {
    if (asked.plan.has_value() != asked.widths.has_value()) {
        refuse({}, "widths need the plan that they were burnt by, and the plan the widths",
               asked.plan ? "--plan" : "--widths", "give --plan and --widths together");
    }
    if (!asked.widths && !asked.burn_only && !is_simulated(asked.link)) {
        refuse({}, "real strokes are measured by a person", asked.link,
               "burn with --burn-only --out DIR, measure the widths, then give --plan and --widths");
    }
    if (asked.burn_only && !asked.out) {
        refuse({}, "the plan has no place to go", "--burn-only", "give --out DIR");
    }
}

int run(const Asked& asked) {
    check(asked);
    install_stop_signals();
    const RunFolder folder(asked.out);
    const std::filesystem::path plan = asked.plan.value_or(folder.path() / "plan.csv");
    const std::filesystem::path widths = asked.widths.value_or(folder.path() / "widths.csv");
    if (!asked.widths) {
        burn(asked, folder.path());
        if (asked.burn_only) {
            std::printf("%s\n", asked.json ? Json{{"plan", plan.string()}}.dump(2).c_str() : plan.string().c_str());
            return kDone;
        }
    }
    const FocusFit fit = fit_focus(widths, rungs_of(plan, widths));
    std::string saved;
    if (folder.named()) {
        CalibrationSet set =
            read_calibration(asked.calibration.value_or(in_project("examples/ras3dm/calibration.toml")));
        set.parents = {set.id};
        set.id += "+focus";
        set.time = now_text();
        set.beam = BeamRecord{.waist = fit.mark.waist,
                              .rayleigh_length = fit.mark.rayleigh,
                              .time = set.time,
                              .note = fmt::format("widths of {} strokes over depth", fit.rungs)};
        saved = (folder.path() / "calibration.toml").string();
        static_cast<void>(write_calibration(saved, set));
    }
    if (asked.json) {
        std::printf("%s\n", Json{{"format", "scribecell-focus"},
                                 {"version", 1},
                                 {"y_mm", fit.y * 1e3},
                                 {"sigma_um", fit.sigma * 1e6},
                                 {"waist_um", fit.mark.waist * 1e6},
                                 {"waist_sigma_um", fit.waist_sigma * 1e6},
                                 {"rayleigh_mm", fit.mark.rayleigh * 1e3},
                                 {"rayleigh_sigma_mm", fit.rayleigh_sigma * 1e3},
                                 {"rms_um", fit.rms * 1e6},
                                 {"rungs", fit.rungs},
                                 {"wrong", fit.wrong},
                                 {"file", saved}}
                                .dump(2)
                                .c_str());
    } else {
        std::fputs(
            fmt::format("in focus at y = {:.4f} mm, 1 sigma {:.1f} um\nwaist {:.2f} +- {:.2f} um, Rayleigh length "
                        "{:.3f} +- {:.3f} mm\n{} strokes, {:.2f} um rms; {} left out\n{}\n",
                        fit.y * 1e3, fit.sigma * 1e6, fit.mark.waist * 1e6, fit.waist_sigma * 1e6,
                        fit.mark.rayleigh * 1e3, fit.rayleigh_sigma * 1e3, fit.rungs, fit.rms * 1e6, fit.wrong.size(),
                        saved.empty() ? "nothing was kept: --out names a folder" : saved)
                .c_str(),
            stdout);
    }
    return kDone;
}

}  // namespace

void add_calibrate_focus(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand("focus", "Where the focus is, and the beam's waist, from a burnt ladder.");
    sub->footer(kExamples);
    const auto asked = std::make_shared<Asked>();
    sub->add_option("--out", asked->out, "folder for plan.csv, widths.csv and calibration.toml")->type_name("DIR");
    sub->add_option("--calibration", asked->calibration, "set to extend (default: the example's)")->type_name("FILE");
    sub->add_option("--plan", asked->plan, "plan that a measured ladder was burnt by")->type_name("FILE");
    sub->add_option("--widths", asked->widths, "of its strokes")->type_name("FILE");
    sub->add_option("--world", asked->world, "of the simulated cell (default: a plate)")->type_name("FILE");
    sub->add_option("--link", asked->link, "the cell: sim:, can:IFACE[?fd=1], serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*sub, asked->key);
    sub->add_option("--at-mm", asked->at_mm, "middle of the ladder on the surface, h")
        ->delimiter(',')
        ->expected(3)
        ->capture_default_str();
    sub->add_option("--half-mm", asked->half_mm, "how far it reaches either way in y")
        ->check(CLI::Range(0.2, 20.0))
        ->capture_default_str();
    sub->add_option("--rungs", asked->rungs, "how many")->check(CLI::Range(7, 21))->capture_default_str();
    sub->add_option("--width-um", asked->width_um, "noise of a simulated width")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    sub->add_option("--seed", asked->seed, "of everything random")->type_name("N")->capture_default_str();
    sub->add_flag("--burn-only", asked->burn_only, "burn the ladder and write its plan, no more");
    sub->add_flag("--json", asked->json, "one JSON object");
    sub->callback([asked, &exit_code] { exit_code = guarded(asked->json, [&asked] { return run(*asked); }); });
}

}  // namespace sc::host::cli
