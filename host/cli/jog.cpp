// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "host/bridge/open_transport.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/black_box_file.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/number_text.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell jog --axis X --distance-mm -2.5
      on the simulated cell (which is homed first)
  scribecell jog --axis Z --distance-mm 0.05 --speed-mm-s 1 --link serial:/dev/ttyUSB0
  scribecell jog --axis C --distance-deg 5 --speed-deg-s 2 --home --link tcp:127.0.0.1:7000
      homes all axes first, if they are not

One step is 10 mm or 10 degrees at most. C turns only with y retracted.)";

constexpr double kLargestMm = 10.0;
constexpr double kLargestDeg = 10.0;
constexpr double kFastestMm = 50.0;
constexpr double kFastestDeg = 20.0;
constexpr Nanoseconds kBeginLimit = std::chrono::milliseconds(300);

struct JogOptions {
    std::string axis;
    std::optional<double> distance_mm;
    std::optional<double> distance_deg;
    double speed_mm_s = 5.0;
    double speed_deg_s = 5.0;
    std::string link = "sim:";
    LinkOptions link_options;
    bool home = false;
    bool reset_fault = false;
};

[[noreturn]] void refuse(const std::string& problem, const std::string& value, const std::string& action) {
    throw InputError({.file = {}, .problem = problem, .value = value, .action = action});
}

/// A number that is one and within its limit.
double bounded(double value, double limit, const char* what, const char* unit) {
    if (!std::isfinite(value) || value == 0.0 || std::abs(value) > limit) {
        refuse(std::string(what) + " is not within one step", number_text(value),
               "use up to " + number_text(limit) + " " + unit + ", not 0");
    }
    return value;
}

/// A jog in the units of the wire (link::Verb::jog).
struct Step {
    std::int32_t axis = 0;
    std::int32_t distance = 0;
    std::int32_t speed = 0;
};

Step step_of(const JogOptions& o) {
    const std::string names = "XYZC";
    const std::size_t axis =
        o.axis.size() == 1 ? names.find(static_cast<char>(std::toupper(o.axis[0]))) : std::string::npos;
    if (axis == std::string::npos) {
        refuse("no such axis", o.axis, "use X, Y, Z or C");
    }
    const bool turn = axis == index(Axis::c);
    const std::optional<double> distance = turn ? o.distance_deg : o.distance_mm;
    if (!distance || (turn ? o.distance_mm : o.distance_deg)) {
        refuse("a jog needs a distance in its axis' own unit", o.axis,
               turn ? "give --distance-deg" : "give --distance-mm");
    }
    Step step;
    step.axis = static_cast<std::int32_t>(axis);
    const double way = turn ? bounded(*distance, kLargestDeg, "the distance", "degrees") * kWireUnitsPerDegree
                            : bounded(*distance, kLargestMm, "the distance", "mm") * 1e-3 * kWireUnitsPerMetre;
    const double speed = turn ? bounded(o.speed_deg_s, kFastestDeg, "the speed", "degrees/s")
                              : bounded(o.speed_mm_s, kFastestMm, "the speed", "mm/s");
    if (speed < 0.0) {
        refuse("the speed is negative", number_text(speed), "give the direction with the distance");
    }
    step.distance = static_cast<std::int32_t>(std::llround(way));
    step.speed = static_cast<std::int32_t>(std::llround(speed * 1e3));
    return step;
}

double position_of(const CellClient& client, const Step& step) {
    const double units = static_cast<double>(client.status()->actual.at(static_cast<std::size_t>(step.axis)));
    return step.axis == 3 ? units / kWireUnitsPerDegree : units / kWireUnitsPerMetre * 1e3;
}

void move(CellClient& client, const Step& step) {
    bool begun = false;
    client.on_state([&begun](State, State to) { begun = begun || to == State::jogging; });
    client.command(link::Verb::jog, step.axis, step.distance, step.speed);
    // A very short step may be over before its state is told.
    client.pump_until([&] { return begun; }, kBeginLimit);
    const double seconds = std::abs(static_cast<double>(step.distance)) / (step.axis == 3 ? 1e5 : 1e8) /
                           (static_cast<double>(step.speed) * (step.axis == 3 ? 1e-3 : 1e-6));
    client.wait_for({State::idle}, std::chrono::seconds(5 + std::lround(2.0 * seconds)), "the jog");
    client.on_state({});
}

int run(const JogOptions& options) {
    const Step step = step_of(options);
    const bool simulated = is_simulated(options.link);
    if (options.link_options.record && !simulated) {
        refuse("--record belongs to the simulated cell", options.link, "give it to `scribecell cell`");
    }
    install_stop_signals();
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, 2));
    client.set_stop_check(stop_requested);
    client.connect();
    SessionOptions session_options;
    session_options.reset_fault = options.reset_fault;
    session_options.on_fault = [&client] { std::fprintf(stderr, "%s\n", keep_black_box(client, {}).c_str()); };
    session_options.on_step = [](const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); };
    Session session(client, session_options);
    try {
        session.clear();
        const bool homed = (client.status()->flags & link::kFlagHomed) != 0;
        if (!homed && !options.home && !simulated) {
            refuse("the axes are not homed", "", "add --home to home all of them first");
        }
        session.enable_and_home();
        const double before = position_of(client, step);
        move(client, step);
        const double after = position_of(client, step);
        std::printf("%c: %.4f -> %.4f %s\n", "XYZC"[step.axis], before, after, step.axis == 3 ? "deg" : "mm");
    } catch (const std::exception&) {
        session.make_safe();
        throw;
    }
    session.make_safe();
    return 0;
}

}  // namespace

void add_jog(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("jog", "Move one axis by one bounded step.");
    sub->footer(kExamples);
    const auto options = std::make_shared<JogOptions>();
    sub->add_option("--axis", options->axis, "X, Y, Z or C")->required();
    sub->add_option_function<double>(
        "--distance-mm", [&way = options->distance_mm](const double& v) { way = v; },
        "of X, Y, Z; up to 10 either way");
    sub->add_option_function<double>(
        "--distance-deg", [&way = options->distance_deg](const double& v) { way = v; }, "of C; up to 10 either way");
    sub->add_option("--speed-mm-s", options->speed_mm_s, "up to 50")->capture_default_str();
    sub->add_option("--speed-deg-s", options->speed_deg_s, "of C; up to 20")->capture_default_str();
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_option_function<std::string>(
           "--record", [&file = options->link_options.record](const std::string& word) { file = word; },
           "log of the controller's inputs, for replay; simulated cell")
        ->type_name("FILE");
    sub->add_option("--capture", options->link_options.capture, "pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    sub->add_flag("--home", options->home, "home all axes first, if they are not");
    sub->add_flag("--reset-fault", options->reset_fault, "acknowledge a latched fault first");
    sub->callback([options, &exit_code] { exit_code = guarded(false, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
