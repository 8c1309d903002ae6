// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/session.hpp"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace sc::host {
namespace {

using std::chrono::seconds;

constexpr Nanoseconds kEnableLimit = seconds(5);
constexpr Nanoseconds kHomeLimit = seconds(120);
constexpr Nanoseconds kArmLimit = seconds(10);
constexpr Nanoseconds kRestLimit = seconds(10);
constexpr int kClearTries = 50;
/// A silent host breaks homing off: on a busy PC that may happen.
constexpr int kHomeTries = 3;
constexpr Nanoseconds kLook = std::chrono::milliseconds(200);
constexpr Nanoseconds kFirstStatusLimit = seconds(1);

bool homed(const CellClient& client) {
    return client.status_is_fresh() && (client.status()->flags & link::kFlagHomed) != 0;
}

double seconds_of(Nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }

/// What brings the cell nearer to rest from a state; empty where there is nothing to do but wait.
std::vector<link::Verb> towards_rest(State state) {
    switch (state) {
        case State::running:
        case State::marking:
        case State::stopping: return {link::Verb::hold, link::Verb::abort};
        case State::held:
        case State::held_link:
        case State::previewing: return {link::Verb::abort};
        case State::homing:
        case State::jogging: return {link::Verb::stop};
        case State::arming:
        case State::armed: return {link::Verb::disarm};
        case State::idle: return {link::Verb::disable};
        case State::boot:
        case State::disabled:
        case State::enabling:
        case State::disabling:
        case State::preview_stopping:
        case State::fault: return {};
    }
    return {};
}

/// Neither at rest without power nor ready to be set up.
bool left_behind(State state) { return state != State::idle && !towards_rest(state).empty(); }

bool safe(State state) { return state == State::boot || state == State::disabled || state == State::fault; }

}  // namespace

Session::Session(CellClient& client, SessionOptions options) : client_(&client), options_(std::move(options)) {}

void Session::step(const std::string& what) const {
    if (options_.on_step) {
        options_.on_step(what);
    }
}

void Session::clear() {
    client_->pump_until([this] { return client_->status().has_value(); }, kFirstStatusLimit);
    if (client_->state() == State::fault && options_.reset_fault) {
        if (options_.on_fault) {
            options_.on_fault();
        }
        step("resetting the fault");
        client_->command(link::Verb::reset_fault);
        client_->wait_for({State::disabled}, kRestLimit, "resetting the fault");
    }
    client_->check_fault();
    if (left_behind(client_->state())) {
        step("dropping the job that an earlier host has left");
    }
    for (int i = 0; i < kClearTries && left_behind(client_->state()); ++i) {
        ease_towards_rest();
    }
}

void Session::enable_and_home() {
    clear();
    step("powering the axes");
    if (client_->state() == State::boot) {
        client_->wait_for({State::disabled, State::idle}, kEnableLimit, "finding the drives");
    }
    if (client_->state() != State::idle) {
        client_->command(link::Verb::enable);
        client_->wait_for({State::idle}, kEnableLimit, "powering the axes");
    }
    if (homed(*client_)) {
        return;
    }
    home();
}

void Session::home() {
    for (int i = 0; i < kHomeTries && !homed(*client_); ++i) {
        step(i == 0 ? "homing" : "homing again: it was broken off");
        client_->command(link::Verb::home);
        bool moving = false;
        const auto over = [&] {
            const State state = client_->state();
            moving = moving || state == State::homing;
            const bool at_end = state == State::idle && (moving || homed(*client_));
            return client_->status_is_fresh() && (state == State::fault || at_end);
        };
        client_->pump_until(over, kHomeLimit);
        client_->check_fault();
    }
    if (!homed(*client_)) {
        throw CellError("the axes could not be homed; the cell is in state " +
                        std::string(sc::name_of(client_->state())));
    }
}

void Session::arm() {
    step("arming the laser");
    client_->command(link::Verb::arm);
    client_->wait_for({State::armed}, kArmLimit, "arming");
}

void Session::disarm_and_disable() {
    step("switching off");
    client_->command(link::Verb::disarm);
    client_->wait_for({State::idle}, kRestLimit, "disarming");
    disable();
}

void Session::disable() {
    client_->command(link::Verb::disable);
    client_->wait_for({State::disabled}, kRestLimit, "unpowering the axes");
}

void Session::check_dark(std::uint32_t pulses_before) const {
    constexpr unsigned kLight = link::kFlagMasterOscillator | link::kFlagGateOpen | link::kFlagShutterOpen;
    const auto& status = client_->status();
    if (status && ((status->flags & kLight) != 0 || status->pulses_total != pulses_before)) {
        throw CellError(
            "the cell tells of the marking laser during a preview: report this, with the log of the inputs");
    }
}

void Session::trace(const StreamJob& job, std::uint32_t rounds, PreviewResult& result) {
    enable_and_home();
    const std::uint32_t pulses = client_->status()->pulses_total;
    while (rounds == 0 || result.rounds < rounds) {
        client_->open_job(job.hash, static_cast<std::uint32_t>(job.items.size()));
        client_->command(link::Verb::preview);
        step("tracing with the guide laser, round " + std::to_string(result.rounds + 1));
        Streamer streamer(*client_, job, options_.stream, nullptr);
        streamer.on_progress([&](const Progress& progress) {
            check_dark(pulses);
            if (options_.on_progress) {
                options_.on_progress(progress);
            }
        });
        streamer.run();
        check_dark(pulses);
        ++result.rounds;
    }
    step("switching off");
    disable();
}

PreviewResult Session::preview(const StreamJob& job, std::uint32_t rounds) {
    const HostTime begun = client_->now();
    PreviewResult result;
    try {
        trace(job, rounds, result);
    } catch (const Interrupted&) {
        make_safe();
        result.stopped = true;
        if (rounds != 0) {
            throw;
        }
    } catch (const std::exception&) {
        make_safe();
        throw;
    }
    result.cell_seconds = seconds_of(client_->now() - begun);
    return result;
}

void Session::mark(const StreamJob& job, Streamer& streamer, const ResumePoint& from) {
    const auto items = static_cast<std::uint32_t>(job.items.size());
    enable_and_home();
    arm();
    if (from.first == 0 && from.pulses == 0) {
        client_->open_job(job.hash, items);
    } else {
        client_->resume_job({.job = job.hash,
                             .items = items,
                             .first = from.first,
                             .hash_before = from.hash_before,
                             .c = from.c,
                             .path = from.path,
                             .pass = from.pass,
                             .pulse = from.pulses});
        streamer.begin_at(from.first, {.sent = from.first,
                                       .planned = from.first,
                                       .fired = from.first,
                                       .path = from.path,
                                       .pass = from.pass,
                                       .pulses = from.pulses});
    }
    client_->command(link::Verb::start);
    step("scribing");
    streamer.run();
    disarm_and_disable();
}

Session::Standing Session::look(const StreamJob& job, const std::optional<JobProgress>& last) {
    client_->pump_until([this] { return client_->status().has_value(); }, kFirstStatusLimit);
    const auto items = static_cast<std::uint32_t>(job.items.size());
    const std::optional<link::Position> told = client_->position();
    Standing standing;
    standing.place = known_place(told, last, job.hash, items);
    const bool in_memory = standing.place.source == PlaceSource::controller;
    const State state = client_->state();
    const bool live = state == State::running || state == State::marking || state == State::stopping ||
                      state == State::held || state == State::held_link;
    const bool done = client_->status() && (client_->status()->flags & link::kFlagJobDone) != 0;
    if (in_memory && live) {
        standing.kind = Standing::Kind::under_way;
    } else if ((in_memory && done) || standing.place.certain.fired == items) {
        standing.kind = Standing::Kind::done;
    }
    return standing;
}

void Session::take_over(const StreamJob& job, Streamer& streamer, Journal* journal) {
    step("going on with the job that an earlier host has begun");
    const auto job_low = static_cast<std::uint32_t>(job.hash & 0xFFFFFFFFU);
    const auto told = [&] { return client_->ack() && client_->ack()->job_low == job_low; };
    if (!client_->pump_until(told, kFirstStatusLimit)) {
        throw LinkError("the cell does not tell which items of the job it has");
    }
    const link::StreamAck& ack = *client_->ack();
    JobProgress progress{.sent = ack.received,
                         .planned = ack.planned,
                         .fired = ack.fired,
                         .path = ack.path,
                         .pass = ack.pass,
                         .pulses = ack.pulses};
    if (const auto last = journal == nullptr ? std::nullopt : journal->last()) {
        progress.sent = std::max(progress.sent, last->sent);
    }
    streamer.begin_at(ack.received, progress);
    streamer.run();
    disarm_and_disable();
}

void Session::finish(Journal* journal) {
    if (journal != nullptr) {
        journal->close(JobOutcome::done);
    }
    clear();
    if (client_->state() == State::idle) {
        disable();
    }
}

RunResult Session::run(const StreamJob& job, Journal* journal) { return run(job, journal, {}); }

RunResult Session::run(const StreamJob& job, Journal* journal, const ResumePoint& from) {
    return run_guarded(job, journal, [&](Streamer& streamer) { mark(job, streamer, from); });
}

RunResult Session::rejoin(const StreamJob& job, Journal* journal) {
    return run_guarded(job, journal, [&](Streamer& streamer) { take_over(job, streamer, journal); });
}

RunResult Session::run_guarded(const StreamJob& job, Journal* journal, const std::function<void(Streamer&)>& work) {
    const HostTime begun = client_->now();
    Streamer streamer(*client_, job, options_.stream, journal);
    streamer.on_progress(options_.on_progress);
    const auto close = [&](JobOutcome outcome) {
        streamer.record();
        if (journal != nullptr) {
            journal->close(outcome);
        }
    };
    const auto close_early = [&](JobOutcome outcome) {
        make_safe();
        try {
            streamer.hear_out();
        } catch (const std::exception& error) {
            step(std::string("the cell says no more: ") + error.what());
        }
        close(outcome);
    };
    try {
        work(streamer);
    } catch (const Interrupted&) {
        close_early(JobOutcome::aborted);
        throw;
    } catch (const std::exception&) {
        close_early(JobOutcome::failed);
        throw;
    }
    close(JobOutcome::done);
    RunResult result;
    result.cell_seconds = seconds_of(client_->now() - begun);
    result.progress = streamer.progress();
    result.pulses = client_->status()->pulses_total;
    result.starvations = client_->status()->starvations;
    result.items_repeated = client_->status()->items_repeated;
    result.requests_repeated = client_->repeats();
    result.wire = client_->counters();
    return result;
}

void Session::ease_towards_rest() {
    const State before = client_->state();
    for (const link::Verb verb : towards_rest(before)) {
        try {
            client_->command(verb);
        } catch (const CellRefused& refused) {
            // wrong_state: the cell was on its way already.
            if (refused.refusal != Refusal::wrong_state) {
                step(refused.what());
            }
        }
    }
    client_->pump_until([&] { return client_->status_is_fresh() && client_->state() != before; }, kLook);
}

bool Session::make_safe() noexcept {
    try {
        client_->set_stop_check({});
        step("bringing the cell to rest");
        const HostTime end = client_->now() + kRestLimit;
        while (!(client_->status_is_fresh() && safe(client_->state())) && client_->now() < end) {
            ease_towards_rest();
        }
        return safe(client_->state());
    } catch (const std::exception&) {
        // The link no longer reaches the cell, which stops by itself when the host falls silent.
        return false;
    }
}

}  // namespace sc::host
