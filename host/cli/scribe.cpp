// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "host/bridge/stop.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/scribe_output.hpp"
#include "host/cli/scribe_run.hpp"
#include "host/cli/subcommands.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell scribe
      the example job (36 markers on four faces) on the simulated cell; prints how far each cross is off
  scribecell scribe my_job.toml --dry-run
      checks a job and prints what would be burnt, without moving anything
  scribecell scribe --table my_table.csv
      other points: the table gives measured and true places of ALL faces, in h
  scribecell scribe --face 90 --face 180 --json --out run1
      two faces; one JSON object on stdout; traces, journal and reports in run1.
      scribecell replay run1/inputs.rec runs the controller again with what it was given
  scribecell scribe --world bent.toml --script faults.txt
      the simulated cell with errors of its own, and faults to provoke
  scribecell scribe my_job.toml --preview --link tcp:127.0.0.1:7000
      traces the job with the visible guide laser, again and again until Ctrl-C: the source stays off and its shutter
      shut. With the key at setup the enclosure may be open
  scribecell scribe --link 'sim:?carrier=can' --capture job.pcap
      over a simulated CAN bus (canfd, serial), and all that passed as a file for Wireshark (docs/protocol.md)
  scribecell scribe --override 50
      at half speed; in a terminal the keys + and - change it by 10 % while the job runs, 0 sets 100 %
  scribecell scribe my_job.toml --link can:can0 --pendant
      with a USB pendant: its feed keys, Start/Pause and Stop (docs/pendant.md)
  scribecell scribe --board m7
      the example with the controller on a Cortex-M7 in QEMU; also prints what it cost in instructions
  scribecell scribe my_job.toml --link serial:/dev/ttyUSB0?baud=921600 --journal my_job.sqlite
      a cell on a serial line
  scribecell scribe my_job.toml --link serial:/dev/ttyUSB0?baud=921600 --journal my_job.sqlite --resume
      goes on with it after this program, the PC or the cell has died: each pulse once

Exit codes: 0 burnt and found again, or previewed; 1 the cell or the job failed; 2 bad input, nothing has moved; 130 Ctrl-C.)";

struct Words {
    ScribeOptions options;
    std::uint64_t jitter_us = 0;
};

template <class Value>
CLI::Option* optional_option(CLI::App& app, const char* name, std::optional<Value>& value, const char* text) {
    const auto take = [&value](const std::string& word) { value = Value(word); };
    return app.add_option_function<std::string>(name, take, text);
}

void describe_job(CLI::App& app, ScribeOptions& o) {
    app.add_option("job", o.job, "job file (default: the example, examples/ras3dm/job.toml)")->type_name("JOB.toml");
    optional_option(app, "--table", o.table,
                    "CSV that gives measured and true places of ALL faces, in h, in place of the job's own")
        ->type_name("FILE");
    optional_option(app, "--calibration", o.calibration, "calibration set, in place of the job's own")
        ->type_name("FILE");
    app.add_flag("--accept-expired", o.accept_expired, "burn with a calibration of which a record has expired");
    app.add_option("--face", o.faces, "burn only this face, degrees; may be given again")->type_name("DEG");
    app.add_flag("--dry-run", o.dry_run, "check everything, print what would be burnt, move nothing");
    app.add_flag("--preview", o.preview, "trace the job with the guide laser, slowly, and burn nothing");
    app.add_option_function<std::uint32_t>(
           "--rounds", [&o](const std::uint32_t& rounds) { o.rounds = rounds; },
           "of --preview (default: until Ctrl-C; the simulated cell: 1)")
        ->type_name("N")
        ->check(CLI::Range(1, 1'000'000));
    app.add_flag("--json", o.json, "one JSON object on stdout, everything else on stderr");
    optional_option(app, "--svg", o.svg, "picture of what was burnt and of its deviations")->type_name("FILE");
    app.add_flag(
        "--resume", o.resume,
        "go on with the job of the journal (--journal, or the one in the folder of --out) where it was broken off");
    optional_option(app, "--confirm-uncertain", o.confirmed,
                    "--resume after a loss of power: what the part shows of the stretch that is not certain, burnt, "
                    "unburnt, or PATH/PASS/PULSES as counted")
        ->type_name("WHAT");
    optional_option(app, "--journal", o.journal, "record of how far the job came; refused if it is another job's")
        ->type_name("FILE");
}

void describe_cell(CLI::App& app, Words& words) {
    ScribeOptions& o = words.options;
    LinkOptions& link = o.link_options;
    app.add_option("--link", o.link,
                   "the cell: sim:[?carrier=can], serial:/dev/...[?baud=N], tcp:HOST:PORT, lockstep:SOCKET")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(app, link.key);
    app.add_option("--board", link.board,
                   "where the simulated cell's controller runs: sim (on this PC) or m7 (Cortex-M7 in QEMU)")
        ->check(CLI::IsMember({"sim", "m7"}))
        ->capture_default_str();
    optional_option(app, "--m7-image", link.m7_image, "image for --board m7 (default: what the preset m7 builds)")
        ->type_name("FILE");
    app.add_flag("--reset-fault", o.reset_fault, "acknowledge a latched fault first");
    app.add_option_function<int>(
           "--override", [&o](const int& percent) { o.override_percent = percent; },
           "feed override, 10..200 % of the programmed speed of paths (default: as it stands in the cell)")
        ->type_name("PERCENT");
    add_pendant_options(app, o.pendant);
    app.add_option("--points-per-block", o.points_per_block, "most items in one message (default: as many as fit)")
        ->type_name("N")
        ->check(CLI::Range(1, 255));
    optional_option(app, "--world", link.world, "world of the simulated cell")->type_name("FILE");
    optional_option(app, "--out", link.out, "folder for traces, journal and reports (default: none are kept)")
        ->type_name("DIR");
    optional_option(app, "--script", link.script, "faults to provoke in the simulated cell")->type_name("FILE");
    optional_option(app, "--capture", link.capture,
                    "pcap file of all that passes over the link, for Wireshark and `scribecell protocol --decode`")
        ->type_name("FILE.pcap");
    optional_option(app, "--record", link.record,
                    "log of the controller's inputs, for replay (default: inputs.rec in the folder of --out)")
        ->type_name("FILE");
    app.add_option("--record-limit", link.record_limit_mb, "MB; the log ends there, the cell goes on")
        ->check(CLI::Range(0.1, 1e6))
        ->capture_default_str();
    app.add_option("--jitter-us", words.jitter_us, "arrival jitter of what the host sends, simulated cell")
        ->type_name("N")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{10'000'000}));
    app.add_option("--seed", link.seed, "of the jitter")->type_name("N")->capture_default_str();
}

int print(const ScribeOutcome& outcome, bool json) {
    if (outcome.failure) {
        print_failure(*outcome.failure);
        std::fputs(how_far_text(outcome).c_str(), stderr);
    }
    if (json) {
        std::printf("%s\n", outcome_json(outcome).dump(2).c_str());
    } else if (outcome.dry_run) {
        std::fputs(plan_text(outcome).c_str(), stdout);
    } else if (outcome.preview && !outcome.failure) {
        std::fputs(preview_text(outcome).c_str(), stdout);
    } else if (outcome.report) {
        std::fputs((report_text(*outcome.report) + board_text(outcome)).c_str(), stdout);
    } else if (!outcome.failure) {
        std::printf("%s is done in %.1f s; this link brings no traces back, so its accuracy is not known\n",
                    outcome.job_name.c_str(), outcome.cell_seconds);
    }
    if (outcome.report && outcome.report->samples.limit_violations > 0) {
        std::fprintf(stderr, "scribecell: the emitted samples break the machine's limits %llu times\n",
                     static_cast<unsigned long long>(outcome.report->samples.limit_violations));
    }
    if (outcome.report && !outcome.report->complete()) {
        std::fprintf(stderr, "scribecell: what was found is not all that was to be burnt, or more than that\n");
    }
    return outcome.exit_code();
}

}  // namespace

void add_scribe(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("scribe", "Burn a job and find it again from the pulses alone.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    describe_job(*sub, words->options);
    describe_cell(*sub, *words);
    sub->callback([words, &exit_code] {
        ScribeOptions& options = words->options;
        options.link_options.jitter = Nanoseconds(static_cast<std::int64_t>(words->jitter_us) * 1000);
        exit_code = guarded(options.json, [&options] {
            install_stop_signals();
            return print(run_scribe(options), options.json);
        });
    });
}

}  // namespace sc::host::cli
