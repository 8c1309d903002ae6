// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <optional>
#include <ranges>

#include <nlohmann/json.hpp>

#include "host/cli/casting_run.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/inspect_lines.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/run_folder.hpp"
#include "host/cli/scribe_output.hpp"
#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell casting
      a casting at a random pose: scanned, inspected, borrowed, its datum lines burnt and measured
  scribecell casting --seed 7 --out run7
      another pose; everything that was made stays in run7
  scribecell casting --json
      one JSON object

Exit codes: 0 burnt; 1 the cell or the job failed; 2 bad input.)";

constexpr double kViewSeconds = 25.0;  ///< of a sensor and its robot, a view: modelled, not measured
constexpr std::ptrdiff_t kWorst = 5;   ///< stretches named in the JSON

struct Words {
    std::uint64_t seed = 1;
    std::optional<std::string> out;
    std::string board = "sim";
    bool plain = false;
    bool json = false;
};

void print(const Words& words, const CastingRun& run) {
    const Inspection& inspection = run.inspection;
    const LineJob& lines = run.lines;
    const Burnt& found = run.burnt;
    const double scan = kViewSeconds * static_cast<double>(run.views);
    const AllowanceReport& verdict = inspection.after ? *inspection.after : inspection.before;
    if (words.json) {
        auto worst = nlohmann::ordered_json::array();
        for (const Burnt::Worst& w : found.worst | std::views::take(kWorst)) {
            worst.push_back({{"datum", w.datum},
                             {"off_um", 1e6 * w.off},
                             {"place_mm", {1e3 * w.place.x, 1e3 * w.place.y, 1e3 * w.place.z}}});
        }
        const nlohmann::ordered_json out{{"seed", words.seed},
                                         {"points", inspection.points},
                                         {"enough", verdict.enough()},
                                         {"least_margin_mm", 1e3 * verdict.least_margin},
                                         {"line_job", line_job_json(lines)},
                                         {"pulses", found.off.size()},
                                         {"missed_pulses", found.missed},
                                         {"burnt_50_um", 1e6 * found.share(0.5)},
                                         {"burnt_95_um", 1e6 * found.share(0.95)},
                                         {"burnt_max_um", 1e6 * found.share(1.0)},
                                         {"worst", std::move(worst)},
                                         {"limit_violations", run.scribed.report->samples.limit_violations},
                                         {"board", words.board},
                                         {"command_trace_sha256", run.scribed.report->run.command_trace_sha256},
                                         {"scan_s_modelled", scan},
                                         {"inspect_s", run.inspect_seconds},
                                         {"burn_s", run.burn_seconds}};
        std::printf("%s\n", out.dump(2).c_str());
        return;
    }
    std::printf("casting at the pose of seed %llu: %zu points in %zu views; %s, smallest margin %.3f mm\n",
                static_cast<unsigned long long>(words.seed), inspection.points, run.views,
                verdict.enough() ? "metal everywhere" : "NOT enough metal", 1e3 * verdict.least_margin);
    std::printf("%.1f mm of datum lines burnt in %zu paths, %.1f mm not reached\n", 1e3 * lines.burnt_length,
                lines.burnt.size(), 1e3 * lines.missed_length);
    std::printf(
        "%zu pulses; distance from the true datum plane: half within %.1f um, 95 %% within %.1f um, all within "
        "%.1f um; %zu met nothing\n",
        found.off.size(), 1e6 * found.share(0.5), 1e6 * found.share(0.95), 1e6 * found.share(1.0), found.missed);
    std::fputs(board_text(run.scribed).c_str(), stdout);
    std::printf("\n%-34s %10s %12s\n", "stage", "here", "the paper");
    std::printf("%-34s %8.1f s %10s\n", "scan (modelled, 25 s a view)", scan, "10 min");
    std::printf("%-34s %8.1f s %10s\n", "inspection, borrowing, lines", run.inspect_seconds, "3 min");
    std::printf("%-34s %8.1f s %10s\n", "burning (the cell's time)", run.burn_seconds, "5 min");
    std::printf("%-34s %8.1f s %10s; a fitter: 90 min\n", "all", scan + run.inspect_seconds + run.burn_seconds,
                "18 min");
}

int run(const Words& words) {
    ProgressPrinter printer(stderr_is_terminal());
    const RunFolder folder(words.out ? std::optional<std::filesystem::path>(*words.out) : std::nullopt);
    const CastingRun run = run_casting(folder.path(), {.seed = words.seed,
                                                       .board = words.board,
                                                       .plain = words.plain,
                                                       .say = [&](const std::string& text) { printer.step(text); }});
    if (run.scribed.failure) {
        print_failure(*run.scribed.failure);
        return run.scribed.failure->exit_code;
    }
    print(words, run);
    return run.scribed.report->samples.limit_violations > 0 || run.burnt.missed > 0 ? kFailed : kDone;
}

}  // namespace

void add_casting(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("casting", "From a casting to its datum lines, on the simulated cell.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--seed", words->seed, "of the casting's pose and of all noise")->capture_default_str();
    sub->add_option("--out", words->out, "folder for everything that is made (default: nothing is kept)")
        ->type_name("DIR");
    sub->add_flag("--plain", words->plain, "for comparison: faces every 45 degrees alone, nothing kept from edges");
    sub->add_option("--board", words->board, "where the controller runs")
        ->check(CLI::IsMember({"sim", "m7"}))
        ->capture_default_str();
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
