// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/cli/check_run.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/verification/motion_report.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell check run1/samples.trace
      all that a cell's controller emitted: speed, acceleration, jerk of axes and mirrors, travel, keep-out, states
  scribecell check motion.csv --path line.csv --tolerance 0.01 --limits 0.2,5,200
      one motion, rest to rest, and how far it leaves the polyline that it was to follow
  scribecell check run1/samples.trace --ticks 5317:5592 --json
      a stretch of a trace as one motion; one JSON object

  scribecell check run1/samples.trace --pitch 5 --energy 10
      with other limits for pulses: their distance, their energy and that of a millimetre, of what the job asks for

Only the emitted samples are judged, by their differences; the planner is not asked. Pulses are judged one by one against
the items that the job was made of, if pulses.trace and job.items lie beside the trace: number, distance, energy, and
that the gate was open.
Exit codes: 0 all limits are kept; 1 one is broken; 2 bad input or usage.)";

int run(const CheckOptions& options) {
    const CheckOutcome outcome = run_check(options);
    const MotionReport& report = outcome.report;
    if (options.json) {
        std::printf("%s\n", motion_json(report).dump(2).c_str());
    } else {
        std::fputs(motion_text(report).c_str(), stdout);
    }
    return report.passed() ? kDone : kFailed;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand(
        "check", "Judge emitted set-points and pulses: limits, travel, keep-out, deviation; pitch, energy, gate.");
    sub->footer(kExamples);
    const auto options = std::make_shared<CheckOptions>();
    describe_check(*sub, *options);
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
