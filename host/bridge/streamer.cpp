// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/streamer.hpp"

#include <algorithm>
#include <chrono>

#include "shared/link/blocks.hpp"

namespace sc::host {
namespace {

/// Longest wait for a message before the clockwork is looked at again.
constexpr Nanoseconds kLook{20'000'000};
constexpr Nanoseconds kHearOut{60'000'000};
constexpr Nanoseconds kReportPeriod{200'000'000};
constexpr Nanoseconds kResumePeriod{200'000'000};
/// So many times the usual time between two acknowledgements is silence.
constexpr int kSilentPaces = 4;
constexpr Nanoseconds kLeastSilence{4'000'000};
/// The usual time is a mean over some so many.
constexpr int kPaceOver = 8;
/// Acknowledgements are repeated each 100 ms: when they have said less for longer than this, what said more was stale.
constexpr Nanoseconds kLessBelieved{200'000'000};
/// A block is sent when a quarter of the window is free: each stretch costs one synced record in the journal.
constexpr std::uint32_t kWindowParts = 4;
/// Sent before the window is known.
constexpr std::uint32_t kFirstItems = 16;

std::int64_t real_now_ns() {
    return std::chrono::duration_cast<Nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Streamer::Streamer(CellClient& client, const StreamJob& job, const StreamOptions& options, Journal* journal)
    : client_(&client),
      job_(job),
      options_(options),
      journal_(journal),
      estimate_(job.items, job.expected_seconds),
      free_(kFirstItems),
      begun_(client.now()),
      moved_(client.now()),
      pace_(options.resend_after / kSilentPaces),
      reported_(client.now()) {}

void Streamer::run() {
    while (!done()) {
        take_ack();
        check_refused();
        client_->check_fault();
        check_running();
        resend_missing();
        resend_when_silent();
        send_window();
        pause_or_go_on();
        resume_when_held();
        change_override();
        record_sometimes();
        report(false);
        client_->pump(std::min(client_->now() + kLook, next_question()));
    }
    // The job is done, whether or not the last word on its items arrives.
    progress_.planned = progress_.fired = static_cast<std::uint32_t>(job_.items.size());
    record();
    report(true);
}

void Streamer::begin_at(std::uint32_t item, const JobProgress& progress) {
    progress_ = progress;
    received_ = sent_ = item;
    progress_.sent = std::max(progress_.sent, item);
}

void Streamer::hear_out() {
    client_->pump_until([] { return false; }, kHearOut);
    take_ack();
}

bool Streamer::done() const {
    return client_->status_is_fresh() && (client_->status()->flags & link::kFlagJobDone) != 0;
}

/// An acknowledgement names the job, not the start of the cell that it is from: one that a carrier has held back since
/// an earlier start may claim more than this one has.
bool Streamer::believable(const link::StreamAck& ack) {
    if (ack.job_low != static_cast<std::uint32_t>(job_.hash & 0xFFFFFFFFU) ||
        ack.received > std::max(progress_.sent, received_)) {
        return false;
    }
    if (ack.received >= received_) {
        less_since_.reset();
        return true;
    }
    if (!less_since_) {
        less_since_ = client_->now();
    }
    if (client_->now() - *less_since_ <= kLessBelieved) {
        return false;
    }
    less_since_.reset();
    received_ = sent_ = ack.received;
    unacknowledged_.clear();
    return true;
}

void Streamer::take_ack() {
    const auto& ack = client_->ack();
    if (!ack || !believable(*ack)) {
        return;
    }
    if (ack->received > received_) {
        const HostTime now = client_->now();
        pace_ += (std::min(now - moved_, options_.resend_after) - pace_) / kPaceOver;
        moved_ = now;
    }
    received_ = ack->received;
    while (!unacknowledged_.empty() && unacknowledged_.begin()->second.end <= received_) {
        unacknowledged_.erase(unacknowledged_.begin());
    }
    free_ = ack->free_items;
    widest_ = std::max(widest_, free_);
    sent_ = std::max(sent_, received_);
    progress_.planned = ack->planned;
    progress_.fired = ack->fired;
    progress_.path = ack->path;
    progress_.pass = ack->pass;
    progress_.pulses = ack->pulses;
    progress_.cell_state = client_->state();
}

std::uint32_t Streamer::window_end() const {
    const auto all = static_cast<std::uint32_t>(job_.items.size());
    return std::min(all, received_ + std::min(free_, all));
}

void Streamer::send_window() {
    const std::uint32_t end = window_end();
    const bool again = sent_ < progress_.sent;
    const bool idle = sent_ == received_;
    const bool worth_it = idle || end == job_.items.size() || end - std::min(sent_, end) >= widest_ / kWindowParts;
    if (sent_ >= end || !(again || worth_it)) {
        return;
    }
    if (sent_ == received_) {
        moved_ = client_->now();
    }
    if (end > progress_.sent) {
        progress_.sent = end;
        record();
    }
    while (sent_ < end && send_block(end)) {
    }
}

/// A block that is cut short by the window waits for a wider one, unless nothing is on its way: the cell has places for
/// blocks, whatever is in them.
bool Streamer::send_block(std::uint32_t end) {
    auto last = static_cast<std::uint32_t>(job_.items.size());
    if (options_.items_per_block > 0) {
        last = std::min(last, sent_ + options_.items_per_block);
    }
    link::Block block = link::make_block(job_.hash, job_.items.first(last), sent_, client_->items_capacity());
    if (sent_ + block.count > end) {
        if (sent_ > received_) {
            return false;
        }
        block = link::make_block(job_.hash, job_.items.first(end), sent_, client_->items_capacity());
    }
    const std::uint16_t counter = client_->send_block(block);
    unacknowledged_[sent_] = {sent_ + block.count, counter};
    sent_ += block.count;
    return true;
}

/// The lost end of a window is told by nothing but silence: a cell that has acknowledged each millisecond so far need
/// not be waited for as long as one that hardly says anything.
HostTime Streamer::next_question() const {
    if (sent_ <= received_) {
        return HostTime::max();
    }
    const bool answers = client_->minor() >= link::StreamMissing::kSince;
    const Nanoseconds silence = std::clamp(kSilentPaces * pace_, kLeastSilence, options_.resend_after);
    return std::max(moved_, asked_) + (answers ? silence : options_.resend_after);
}

void Streamer::resend_when_silent() {
    if (client_->now() < next_question()) {
        return;
    }
    asked_ = client_->now();
    if (client_->minor() < link::StreamMissing::kSince) {
        sent_ = received_;
        return;
    }
    // A block without items is answered with what is missing before it.
    link::Block question;
    question.job_low = static_cast<std::uint32_t>(job_.hash & 0xFFFFFFFFU);
    question.first = sent_;
    client_->send_block(question);
}

void Streamer::resend_missing() {
    const auto missing = client_->take_missing();
    if (!missing || missing->job_low != static_cast<std::uint32_t>(job_.hash & 0xFFFFFFFFU)) {
        return;
    }
    const std::size_t runs = std::min<std::size_t>(missing->count, missing->from.size());
    for (std::size_t i = 0; i < runs; ++i) {
        resend(std::max(missing->from[i], received_), std::min(missing->until[i], sent_), missing->heard);
    }
}

/// Blocks of which the cell would have heard, had they arrived: a carrier keeps order.
void Streamer::resend(std::uint32_t from, std::uint32_t until, std::uint16_t heard) {
    auto next = unacknowledged_.upper_bound(from);
    if (next != unacknowledged_.begin()) {
        --next;
    }
    for (; next != unacknowledged_.end() && next->first < until; ++next) {
        Sent& sent = next->second;
        const bool heard_later = static_cast<std::int16_t>(static_cast<std::uint16_t>(heard - sent.counter)) >= 0;
        if (sent.end <= from || !heard_later) {
            continue;
        }
        const link::Block block =
            link::make_block(job_.hash, job_.items.first(sent.end), next->first, client_->items_capacity());
        sent.counter = client_->send_block(block);
        ++blocks_repeated_;
    }
}

void Streamer::resume_when_held() {
    const State state = client_->state();
    const bool held = state == State::held || state == State::held_link;
    const bool fed = state == State::held_link || received_ > progress_.planned || received_ == job_.items.size();
    if (paused_ || !held || !fed || client_->now() - asked_resume_ < kResumePeriod) {
        return;
    }
    asked_resume_ = client_->now();
    if (state == State::held_link) {
        client_->connect();
    }
    try {
        client_->command(link::Verb::resume);
    } catch (const CellRefused& refused) {
        // Between its last status and the command the cell may have gone on, or into a fault that the loop will see.
        if (refused.refusal != Refusal::wrong_state) {
            throw;
        }
    }
}

void Streamer::pause_or_go_on() {
    if (options_.wanted_pause && options_.wanted_pause()) {
        paused_ = !paused_;
    }
    const State state = client_->state();
    if (!paused_ || !client_->status_is_fresh() || (state != State::running && state != State::marking)) {
        return;
    }
    try {
        client_->command(link::Verb::hold);
    } catch (const CellRefused& refused) {
        // It may have come to a rest of its own meanwhile; asked again if it goes on.
        if (refused.refusal != Refusal::wrong_state) {
            throw;
        }
    }
}

void Streamer::change_override() {
    if (!options_.wanted_override || !client_->status_is_fresh()) {
        return;
    }
    const std::uint8_t present = client_->status()->override_percent;
    const std::optional<std::uint8_t> wanted = options_.wanted_override(present);
    if (wanted && *wanted != present) {
        client_->command(link::Verb::set_override, *wanted);
    }
}

void Streamer::check_refused() const {
    const auto& refused = client_->job_refused();
    if (refused && refused->job_low == static_cast<std::uint32_t>(job_.hash & 0xFFFFFFFFU)) {
        throw CellRefused("the cell refused item " + std::to_string(refused->item) +
                              " of the job: " + describe_code(refused->refusal) + ", axis " +
                              std::to_string(refused->axis) + ", value " + std::to_string(refused->value),
                          static_cast<Refusal>(refused->refusal), refused->item);
    }
}

void Streamer::check_running() {
    if (!client_->status_is_fresh()) {
        return;
    }
    const State state = client_->state();
    const bool at_rest =
        state == State::armed || state == State::idle || state == State::disabled || state == State::boot;
    running_seen_ = running_seen_ || !at_rest;
    if (running_seen_ && at_rest && !done()) {
        throw CellError("the cell has dropped the job; it is in state " + std::string(sc::name_of(state)));
    }
}

void Streamer::report(bool last) {
    const HostTime now = client_->now();
    if (!on_progress_ || (!last && now - reported_ < kReportPeriod)) {
        return;
    }
    reported_ = now;
    Progress progress;
    progress.items = static_cast<std::uint32_t>(job_.items.size());
    progress.sent = progress_.sent;
    progress.planned = progress_.planned;
    progress.fired = progress_.fired;
    progress.fraction = last ? 1.0 : estimate_.fraction(progress_.fired);
    progress.elapsed = now - begun_;
    progress.left = estimate_.left(progress.fraction, progress.elapsed);
    on_progress_(progress);
}

void Streamer::record() {
    progress_.cell_state = client_->state();
    if (journal_ == nullptr || progress_ == recorded_) {
        return;
    }
    journal_->record(progress_);
    recorded_ = progress_;
    recorded_at_ns_ = real_now_ns();
}

void Streamer::record_sometimes() {
    if (real_now_ns() - recorded_at_ns_ >= options_.journal_period.count()) {
        record();
    }
}

}  // namespace sc::host
