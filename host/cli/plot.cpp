// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/cli/check_run.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/file.hpp"
#include "host/verification/motion_report.hpp"
#include "host/verification/motion_svg.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell plot motion.csv --path line.csv -o motion.svg
      speed, acceleration, jerk and deviation over time, with their limits; what is broken is marked
  scribecell plot run1/samples.trace
      a whole run of a cell, as run1/samples.trace.svg
  scribecell plot run1/samples.trace --ticks 5317:5592 -o line.svg
      a stretch of it

Exit codes: 0 drawn (also if a limit is broken: ask `scribecell check`); 2 bad input or usage.)";

struct Words {
    CheckOptions check;
    std::filesystem::path out;
};

int run(const Words& words) {
    const CheckOutcome outcome = run_check(words.check);
    const std::filesystem::path out =
        words.out.empty() ? std::filesystem::path(words.check.trace.string() + ".svg") : words.out;
    write_text_file(out,
                    motion_svg(words.check.trace.filename().string(), outcome.trace, outcome.limits, outcome.report));
    if (words.check.json) {
        nlohmann::ordered_json json{{"svg", out.string()}};
        json.update(motion_json(outcome.report));
        std::printf("%s\n", json.dump(2).c_str());
    } else {
        std::printf("%s: %s\n", out.string().c_str(), motion_verdict(outcome.report).c_str());
    }
    return kDone;
}

}  // namespace

void add_plot(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("plot", "Draw emitted set-points: speed, acceleration, jerk, deviation (SVG).");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    describe_check(*sub, words->check);
    sub->add_option("-o,--out", words->out, "picture to write (default: the trace's name with .svg added)")
        ->type_name("FILE.svg");
    sub->callback([words, &exit_code] { exit_code = guarded(words->check.json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
