// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/open_transport.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/black_box_file.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/pendant_options.hpp"
#include "host/cli/pendant_run.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell pendant --link can:can0
      jogs the cell with the wheel of a pendant XHC WHB04B-6, until Ctrl-C or its key Reset
  scribecell pendant --link serial:/dev/ttyUSB0 --home --device /dev/hidraw3
  scribecell pendant --steps-um 1,5,10,100,1000
      other steps for the places 0.001, 0.01, 0.1, 1 and 60 % of the feed knob
  scribecell pendant --reports pendant.txt --json
      plays the events of a file (docs/pendant.md) on the simulated cell

The axis knob chooses the axis, the feed knob the step; both are said, and shown on the pendant. A detent moves one step,
those of a report 2 mm (2 degrees) at most. What is turned while the axis still moves is not kept. Stop, turning a knob,
a wheel that rests for 0.5 s, and an unplugged pendant stop the axis; after Stop, the rest and the unplugging the wheel is
dead until the axis knob is turned. Feed+ and Feed- change the override by 10 %, with Fn they set 100 %.

Exit codes: 0 ended by the person; 1 the cell failed; 2 bad input.)";

struct Words {
    std::string link = "sim:";
    LinkOptions link_options;
    std::string device;
    std::string reports;
    std::vector<double> steps_um;
    double dead_man_s = 0.5;
    bool hold_fn = false;
    bool home = false;
    bool reset_fault = false;
    bool json = false;
};

nlohmann::ordered_json to_json(const PendantRun& run, const CellClient& client) {
    const pendant::ControlCounters& c = run.control().counters();
    nlohmann::ordered_json place = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double units = static_cast<double>(client.status()->actual.at(i));
        place[std::string(1, "XYZC"[i])] = i == 3 ? units / kWireUnitsPerDegree : 1e3 * units / kWireUnitsPerMetre;
    }
    return {{"format", "scribecell-pendant"},
            {"version", 1},
            {"place", place},
            {"override_percent", client.status()->override_percent},
            {"jogs", run.jogs().size()},
            {"refused", run.refused()},
            {"reports", c.reports},
            {"malformed", c.malformed},
            {"detents",
             {{"moved", c.moved},
              {"busy", c.busy},
              {"late", c.late},
              {"beyond", c.beyond},
              {"unarmed", c.unarmed},
              {"unproven", c.unproven}}},
            {"stops", c.stops},
            {"unplugs", c.unplugs}};
}

void prepare(Session& session, const CellClient& client, const Words& words) {
    session.clear();
    if ((client.status()->flags & link::kFlagHomed) == 0 && !words.home && !is_simulated(words.link)) {
        throw InputError({.problem = "the axes are not homed", .action = "add --home to home all of them first"});
    }
    session.enable_and_home();
}

void say(const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); }

void report(const Words& words, const PendantRun& run, const CellClient& client) {
    if (words.json) {
        std::printf("%s\n", to_json(run, client).dump(2).c_str());
        return;
    }
    const pendant::ControlCounters& c = run.control().counters();
    const std::uint64_t left = c.busy + c.late + c.beyond + c.unarmed + c.unproven;
    std::printf(
        "%s\n",
        fmt::format("{} jogs of {} detents; {} detents moved nothing", run.jogs().size(), c.moved, left).c_str());
}

int run(const Words& words) {
    PendantRunOptions options;
    options.control.hold_fn = words.hold_fn;
    options.control.dead_man = Nanoseconds(std::llround(words.dead_man_s * 1e9));
    if (!words.steps_um.empty()) {
        options.control.steps = pendant::step_table(words.steps_um);
    }
    options.on_note = say;
    const auto port = open_pendant({.used = true, .device = words.device, .reports = words.reports});
    install_stop_signals();
    const auto transport = open_transport(words.link, words.link_options);
    CellClient client(*transport,
                      client_options(words.link_options, is_simulated(words.link) ? 2U : std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    SessionOptions session_options;
    session_options.reset_fault = words.reset_fault;
    session_options.on_fault = [&client] { say(keep_black_box(client, {})); };
    session_options.on_step = say;
    Session session(client, session_options);
    PendantRun pendant(client, *port, options);
    try {
        prepare(session, client, words);
        say("steps: " + options.control.steps.text());
        pendant.run();
    } catch (const Interrupted&) {
        say("ended by Ctrl-C");
    } catch (const std::exception&) {
        session.make_safe();
        throw;
    }
    if (!session.make_safe()) {
        throw CellError("the cell could not be brought to rest");
    }
    report(words, pendant, client);
    return 0;
}

}  // namespace

void add_pendant(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("pendant", "Jog a cell with the wheel of a USB pendant.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--link", words->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, words->link_options.key);
    sub->add_option("--device", words->device, "file of the pendant; without it the first one that is found")
        ->type_name("/dev/hidrawN");
    sub->add_option("--reports", words->reports, "events from a file in place of a pendant")->type_name("FILE");
    sub->add_option("--steps-um", words->steps_um, "a detent at each place of the feed knob")
        ->delimiter(',')
        ->type_name("A,B,C,D,E");
    sub->add_option("--dead-man-s", words->dead_man_s, "an axis stops when the wheel has rested for so long")
        ->check(CLI::Range(0.05, 10.0))
        ->capture_default_str();
    sub->add_flag("--hold-fn", words->hold_fn, "the wheel counts only while Fn is held");
    sub->add_flag("--home", words->home, "home all axes first, if they are not");
    sub->add_flag("--reset-fault", words->reset_fault, "acknowledge a latched fault first");
    sub->add_option("--out", words->link_options.out, "folder for the traces of the simulated cell")->type_name("DIR");
    sub->add_option("--capture", words->link_options.capture, "pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    sub->add_flag("--json", words->json, "one JSON object at the end");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
