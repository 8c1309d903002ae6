// SPDX-License-Identifier: Apache-2.0
#include "host/cli/scribe_run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include <unistd.h>

#include "host/bridge/stop.hpp"
#include "host/calibration/galvo_model.hpp"
#include "host/cli/black_box_file.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/job_pendant.hpp"
#include "host/cli/override_keys.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/job_items.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/path/face_places.hpp"

namespace sc::host::cli {
namespace {

std::string hex(std::uint64_t value) {
    std::string text(16, '0');
    for (std::size_t i = 0; i < 16; ++i) {
        text[15 - i] = "0123456789abcdef"[(value >> (4 * i)) & 0xFU];
    }
    return text;
}

/// A simulated run depends on its inputs and seed alone; on a wire two hosts must not draw the same number.
std::uint32_t draw_session(const ScribeOptions& options) {
    return is_simulated(options.link) ? static_cast<std::uint32_t>(options.link_options.seed) + 1U
                                      : std::random_device{}();
}

/// Refuses to burn a second time what the journal says has been burnt.
void check_fresh(const std::filesystem::path& file) {
    const JournalSummary summary = read_journal(file);
    if (summary.outcome != JobOutcome::done && (!summary.last || summary.last->fired == 0)) {
        return;
    }
    const std::uint32_t fired = summary.last ? summary.last->fired : 0;
    throw InputError({.file = file.string(),
                      .problem = "this job has been burnt already, up to item",
                      .value = std::to_string(fired) + " of " + std::to_string(summary.job.items),
                      .action = "--resume goes on with it; name a new journal to burn it again from its beginning"});
}

/// One run, with what its parts share.
class Run {
public:
    explicit Run(const ScribeOptions& options) : options_(options), printer_(stderr_is_terminal()) {}

    ScribeOutcome go() {
        input_ = read_input(options_);
        outcome_.job_name = input_.job.name;
        outcome_.dry_run = options_.dry_run;
        const bool simulated = is_simulated(options_.link);
        if (simulated) {
            // The simulated cell is the reference machine: what it cannot do is refused before it is started.
            static_cast<void>(plan_for(input_, reference_machine()));
        }
        if (simulated && !options_.dry_run) {
            folder_ = std::make_unique<RunFolder>(options_.link_options.out);
        }
        burn();
        if (simulated && !options_.dry_run) {
            read_cell_report();
        }
        if (simulated && !options_.dry_run && !options_.preview && !outcome_.failure) {
            verify();
        }
        outcome_.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
        if (outcome_.report) {
            outcome_.report->run.wall_seconds = outcome_.wall_seconds;
        }
        return std::move(outcome_);
    }

private:
    void burn() {
        LinkOptions link = options_.link_options;
        link.out = folder_ && is_simulated(options_.link) ? std::optional(folder_->path()) : std::nullopt;
        if (link.out && folder_->named() && !link.record) {
            link.record = *link.out / "inputs.rec";
        }
        const std::unique_ptr<Transport> transport = open_transport(options_.link, link);
        const std::uint32_t session_number = session_to_open();
        CellClient client(*transport, client_options(link, session_number));
        if (options_.pendant.asked()) {
            pendant_ = std::make_unique<JobPendant>(options_.pendant,
                                                    [this](const std::string& text) { printer_.step(text); });
        }
        client.set_stop_check([this] { return stop_requested() || (pendant_ && pendant_->stopped()); });
        client.connect();
        outcome_.machine = client.read_config();
        Planned planned = plan_for(input_, outcome_.machine);
        table_ = std::move(planned.table);
        outcome_.plan = std::move(planned.plan);
        if (options_.dry_run) {
            outcome_.state = "not run";
            return;
        }
        if (!folder_ && options_.link_options.out) {
            folder_ = std::make_unique<RunFolder>(options_.link_options.out);
        }
        if (folder_ && folder_->named()) {
            write_job_items(folder_->path() / "job.items", outcome_.plan.items);
        }
        const std::unique_ptr<Journal> journal = open_journal();
        if (options_.resume && read_journal(journal_file()).outcome == JobOutcome::done) {
            printer_.step("the journal says that this job is done");
            outcome_.state = "not run";
            return;
        }
        if (journal) {
            journal->note_session(session_number);
        }
        SessionOptions session_options;
        session_options.stream.items_per_block = options_.points_per_block;
        session_options.stream.wanted_override = [this, &client](std::uint8_t percent) {
            if (pendant_) {
                pendant_->look(client.now(), percent);
            }
            return pressed(percent);
        };
        if (pendant_) {
            session_options.stream.wanted_pause = [this] { return pendant_->take_pause(); };
        }
        session_options.reset_fault = options_.reset_fault;
        session_options.on_fault = [this, &client] { printer_.step(keep_black_box(client, folder_of_records())); };
        session_options.on_progress = [this](const Progress& progress) { note(progress); };
        session_options.on_step = [this](const std::string& what) { printer_.step(what); };
        Session session(client, session_options);
        mark(client, session, journal.get());
        printer_.end_line();
        outcome_.state = std::string(sc::name_of(client.state()));
    }

    void mark(CellClient& client, Session& session, Journal* journal) {
        const HostTime begun = client.now();
        try {
            const StreamJob job{outcome_.plan.hash, outcome_.plan.items, outcome_.plan.expected_seconds_estimate};
            ResumePoint from;
            if (options_.resume) {
                const Session::Standing standing = session.look(job, journal->last());
                if (standing.kind == Session::Standing::Kind::under_way) {
                    outcome_.progress = session.rejoin(job, journal).progress;
                } else if (standing.kind == Session::Standing::Kind::done) {
                    session.finish(journal);
                }
                if (standing.kind != Session::Standing::Kind::broken_off) {
                    outcome_.cell_seconds = static_cast<double>((client.now() - begun).count()) * 1e-9;
                    return;
                }
                from = resume_point(job.items, found(standing.place));
            }
            session.clear();
            client.set_compensation(compensation_of(input_.calibration));
            client.set_map(axis_map_of(input_.calibration));
            client.set_galvo_field(galvo_field_of(input_.calibration));
            client.set_power_curve(power_curve_of(input_.calibration));
            client.set_galvo_lag(galvo_lag_of(input_.calibration));
            if (outcome_.plan.pulse_width_ns != 0 && !options_.preview) {
                client.command(link::Verb::set_pulse_width, outcome_.plan.pulse_width_ns);
            }
            watch_surface(client);
            if (input_.job.seating && !options_.preview) {
                printer_.step("checking the workpiece's seat");
                client.check_seating(seating_of(*input_.job.seating));
            }
            if (options_.override_percent) {
                note_override(*options_.override_percent);
                client.command(link::Verb::set_override, *options_.override_percent);
            } else if (client.status() && client.status()->override_percent != 100) {
                note_override(client.status()->override_percent);
            }
            if (options_.preview) {
                outcome_.preview = session.preview(job, options_.rounds.value_or(is_simulated(options_.link) ? 1 : 0));
            } else {
                outcome_.progress = session.run(job, journal, from).progress;
            }
        } catch (const InputError&) {
            throw;
        } catch (const CellRefused& refused) {
            outcome_.failure = current_failure();
            if (client.job_refused()) {
                outcome_.failure->message +=
                    "; it belongs to: " + describe_item(outcome_.plan, static_cast<std::size_t>(refused.detail));
            }
        } catch (const std::exception&) {
            outcome_.failure = current_failure();
        }
        if (outcome_.failure && journal != nullptr) {
            outcome_.progress = journal->last().value_or(JobProgress{});
        }
        outcome_.cell_seconds = static_cast<double>((client.now() - begun).count()) * 1e-9;
    }

    /// Where the job came to, by a person's word where nobody else can tell.
    FiredPlace found(const KnownPlace& known) {
        const std::vector<Item>& items = outcome_.plan.items;
        if (known.exact()) {
            return known.certain;
        }
        const std::string stretch = describe_uncertain(items, known);
        printer_.step("not certain whether this is burnt: " + stretch);
        std::optional<std::string> word = options_.confirmed;
        if (!word && (::isatty(STDIN_FILENO) == 1)) {
            std::fputs("look at the part; burnt, unburnt, or PATH/PASS/PULSES as counted? ", stderr);
            std::string line;
            if (std::getline(std::cin, line)) {
                word = line;
            }
        }
        if (!word) {
            throw InputError({.file = journal_file().string(),
                              .problem = "it is not certain whether this stretch is burnt",
                              .value = stretch,
                              .action = "look at the part, and say --confirm-uncertain burnt, unburnt or "
                                        "PATH/PASS/PULSES as counted"});
        }
        return confirmed_place(items, known, *word);
    }

    /// Beside the traces, or the journal; the present folder without either.
    [[nodiscard]] std::filesystem::path folder_of_records() const {
        if (options_.link_options.out) {
            return *options_.link_options.out;
        }
        return options_.journal ? options_.journal->parent_path() : std::filesystem::path();
    }

    [[nodiscard]] std::filesystem::path journal_file() const {
        if (options_.journal) {
            return *options_.journal;
        }
        if (options_.link_options.out) {
            return *options_.link_options.out / "journal.sqlite";
        }
        throw InputError({.file = {},
                          .problem = "--resume needs the journal of the job",
                          .value = {},
                          .action = "name it with --journal, or its folder with --out"});
    }

    [[nodiscard]] std::uint32_t session_to_open() const {
        if (options_.resume) {
            if (const auto earlier = read_journal(journal_file()).session) {
                return *earlier;
            }
        }
        return draw_session(options_);
    }

    /// Also takes back what a job before has left in force.
    void watch_surface(CellClient& client) const {
        const bool fitted = outcome_.machine.sensors.sensor[kYSensor].kind != SensorKind::none;
        if (input_.job.surface || fitted) {
            client.set_surface(surface_of(input_.job, input_.calibration));
        }
    }

    void note_override(int percent) { printer_.step("feed override " + std::to_string(percent) + " %"); }

    std::optional<std::uint8_t> pressed(std::uint8_t percent) {
        std::optional<std::uint8_t> wanted = pendant_ ? pendant_->take_override() : std::nullopt;
        for (std::optional<char> key = keys_.next(); key; key = keys_.next()) {
            if (const auto next = override_after(*key, wanted.value_or(percent))) {
                wanted = next;
            }
        }
        if (wanted) {
            note_override(*wanted);
        }
        return wanted;
    }

    void note(const Progress& progress) {
        outcome_.progress.sent = progress.sent;
        outcome_.progress.planned = progress.planned;
        outcome_.progress.fired = progress.fired;
        printer_.show(progress);
    }

    std::unique_ptr<Journal> open_journal() {
        if (options_.preview) {
            return nullptr;
        }
        const JournalJob job{outcome_.plan.hash, static_cast<std::uint32_t>(outcome_.plan.items.size()),
                             outcome_.job_name};
        if (options_.resume) {
            outcome_.journal = journal_file().string();
            return std::make_unique<Journal>(journal_file(), job, JournalStart::resume);
        }
        if (options_.journal) {
            auto journal = std::make_unique<Journal>(*options_.journal, job, JournalStart::resume);
            check_fresh(*options_.journal);
            outcome_.journal = options_.journal->string();
            return journal;
        }
        if (folder_ && folder_->named()) {
            const std::filesystem::path file = folder_->path() / "journal.sqlite";
            outcome_.journal = file.string();
            return std::make_unique<Journal>(file, job, JournalStart::new_job);
        }
        return nullptr;
    }

    void read_cell_report() {
        const std::filesystem::path file = folder_->path() / "cell.json";
        if (std::filesystem::exists(file)) {
            outcome_.cell = nlohmann::ordered_json::parse(read_text_file(file));
        }
    }

    void verify() {
        const PulseTrace trace = read_pulse_trace(folder_->path() / "pulses.trace");
        FollowedPaths followed = follow_paths(trace.pulses, trace.header.axis, outcome_.plan);
        std::vector<double> angles = face_angles(table_);
        for (const double face : outcome_.plan.faces) {
            if (std::ranges::none_of(angles, [face](double angle) { return same_face(angle, face); })) {
                angles.push_back(face);
            }
        }
        const BurnFindings burns = find_burns(followed.others, trace.header.axis, angles);
        Report report{.accuracy = assess(burns, table_, outcome_.plan, trace.header, input_.calibration),
                      .burns = burns,
                      .samples = check_samples(folder_->path() / "samples.trace", outcome_.machine),
                      .run = {},
                      .paths = std::move(followed.paths)};
        report.run.job = outcome_.job_name;
        report.run.job_hash = hex(outcome_.plan.hash);
        report.run.state = outcome_.state;
        report.run.pulses = outcome_.cell->value("pulses", std::uint64_t{0});
        report.run.cell_seconds = outcome_.cell_seconds;
        report.run.command_trace_sha256 = outcome_.cell->value("command_trace_sha256", std::string());
        outcome_.report = std::move(report);
        write_reports();
    }

    void write_reports() const {
        if (options_.svg) {
            write_text_file(*options_.svg, report_svg(*outcome_.report));
        }
        if (folder_->named()) {
            write_text_file(folder_->path() / "report.svg", report_svg(*outcome_.report));
            write_text_file(folder_->path() / "report.json", report_json(*outcome_.report).dump(2) + "\n");
        }
    }

    const ScribeOptions& options_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    ProgressPrinter printer_;
    TerminalKeys keys_;
    std::unique_ptr<JobPendant> pendant_;
    std::unique_ptr<RunFolder> folder_;
    ScribeInput input_;
    VerificationTable table_;
    ScribeOutcome outcome_;
};

}  // namespace

int ScribeOutcome::exit_code() const {
    if (failure) {
        return failure->exit_code;
    }
    // The simulated cell has seen for itself what was switched on.
    const bool light = preview && cell &&
                       (cell->value("pulses", std::uint64_t{1}) != 0 || cell->value("gate_seconds", 1.0) != 0.0 ||
                        cell->value("master_oscillator_seconds", 1.0) != 0.0);
    if (light) {
        return kFailed;
    }
    const bool wrong = report && (report->samples.limit_violations > 0 || !report->complete());
    return wrong ? kFailed : kDone;
}

ScribeOutcome run_scribe(const ScribeOptions& options) { return Run(options).go(); }

}  // namespace sc::host::cli
