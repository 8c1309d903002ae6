// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/link/cell_end.hpp"

#include <array>
#include <variant>

namespace sc::bench {

void CellEnd::reset() {
    endpoint_ = std::make_unique<link::Endpoint>(reference_machine(), ++boot_, options_);
    if (key_) {
        link::SealSecret secret{*key_, {}};
        secret.entropy.fill(static_cast<std::uint8_t>(boot_));  // a real board's differs likewise
        endpoint_->fit_key(secret);
    }
    state_ = State::disabled;
    homed_ = done_ = told_ = false;
}

Refusal CellEnd::decide(link::Verb verb) {
    const auto go = [this](State from, State to) {
        if (state_ != from) {
            return Refusal::wrong_state;
        }
        state_ = to;
        return Refusal::none;
    };
    switch (verb) {
        case link::Verb::enable: return go(State::disabled, State::idle);
        case link::Verb::disable: return go(State::idle, State::disabled);
        case link::Verb::home: homed_ = state_ == State::idle; return homed_ ? Refusal::none : Refusal::wrong_state;
        case link::Verb::arm: return go(State::idle, State::armed);
        case link::Verb::disarm: return go(State::armed, State::idle);
        case link::Verb::start: {
            const Refusal refusal = go(State::armed, State::running);
            if (refusal == Refusal::none) {
                record_ = start_;
                skip_ = start_.pulses;
                told_ = true;
                done_ = false;
            }
            return refusal;
        }
        case link::Verb::resume: return go(State::held_link, State::running);
        case link::Verb::abort:
            if (state_ != State::running && state_ != State::held_link) {
                return Refusal::wrong_state;
            }
            state_ = State::armed;
            endpoint_->close_job();
            return Refusal::none;
        case link::Verb::hold:
        case link::Verb::reset_fault:
        case link::Verb::jog:
        case link::Verb::stop:
        case link::Verb::set_override:
        case link::Verb::preview:
        case link::Verb::guide:
        case link::Verb::lasers_in_turn:
        case link::Verb::set_pulse_width: return Refusal::wrong_state;
    }
    return Refusal::unknown_command;
}

link::Position CellEnd::position(std::uint32_t token) const {
    link::Position p;
    p.token = token;
    if (record_.job != 0) {
        p.source = static_cast<std::uint8_t>(told_ ? link::PositionSource::memory : link::PositionSource::retained);
    }
    p.job = record_.job;
    p.items = record_.items;
    p.fired = record_.fired;
    p.path = p.reached_path = record_.path;
    p.pulses = p.reached_pulses = record_.pulses;
    return p;
}

void CellEnd::take(const link::LinkEvent& event) {
    using Kind = link::LinkEvent::Kind;
    const bool may_open = state_ == State::idle || state_ == State::armed;
    if (event.kind == Kind::command) {
        endpoint_->reply(event.command.sequence, decide(static_cast<link::Verb>(event.command.verb)), 0);
    } else if (event.kind == Kind::job_open) {
        if (may_open) {
            endpoint_->open_job(event.job_open.job, event.job_open.items);
            start_ = {event.job_open.job, event.job_open.items, 0, 0, 0};
            done_ = false;
        }
        endpoint_->reply(event.job_open.sequence, may_open ? Refusal::none : Refusal::wrong_state, 0);
    } else if (event.kind == Kind::job_resume) {
        const link::JobResume& r = event.job_resume;
        if (may_open) {
            endpoint_->resume_job(r);
            start_ = {r.job, r.items, r.first, r.path, r.pulse};
            done_ = false;
        }
        endpoint_->reply(r.sequence, may_open ? Refusal::none : Refusal::wrong_state, 0);
    } else if (event.kind == Kind::position_request) {
        endpoint_->position(position(event.position_request.token));
    }
}

void CellEnd::burn(std::int64_t tick) {
    for (std::uint32_t i = 0; i < burns_per_tick_ && endpoint_->items().front() != nullptr; ++i) {
        const Item item = *endpoint_->items().front();
        endpoint_->items().pop();
        if (const auto* begin = std::get_if<PathBegin>(&item)) {
            record_.pulses = skip_;
            record_.path = begin->path;
        } else if (const auto* point = std::get_if<PathPoint>(&item)) {
            if (skip_ > 0) {
                --skip_;
            } else {
                burnt_.push_back(*point);
                ++record_.pulses;
                first_burn_tick_ = first_burn_tick_ < 0 ? tick : first_burn_tick_;
                last_burn_tick_ = tick;
                burnt_at_first_ += tick == first_burn_tick_ ? 1U : 0U;
            }
        } else if (std::holds_alternative<JobEnd>(item)) {
            done_ = true;
            state_ = State::armed;
        }
        const bool burnt_point = std::holds_alternative<PathPoint>(item) && record_.pulses > 0 && skip_ == 0;
        if (burnt_point || (!std::holds_alternative<PathPoint>(item) && !std::holds_alternative<PathBegin>(item))) {
            record_.fired = endpoint_->received() - static_cast<std::uint32_t>(endpoint_->items().size());
        }
    }
    if (done_) {
        endpoint_->progress(record_.fired, record_.fired, {});
        endpoint_->close_job();
    }
}

void CellEnd::tick(std::int64_t tick, std::span<const std::uint8_t> in, std::vector<std::uint8_t>& out) {
    tick_ = tick;
    endpoint_->receive(tick, in);
    link::LinkEvent event;
    while (endpoint_->poll(event)) {
        take(event);
    }
    if (state_ == State::running) {
        burn(tick);
        if (!endpoint_->alive(tick) && state_ == State::running) {
            state_ = State::held_link;
        }
        if (state_ == State::running || state_ == State::held_link) {
            endpoint_->progress(record_.fired, record_.fired, {record_.path, 0, record_.fired, record_.pulses});
        }
    }
    refused_ = refused_ || endpoint_->job_refusal() != Refusal::none;
    if (tick % 20 == 0) {
        link::Status status;
        status.cell_time_us = static_cast<std::uint64_t>(tick) * 1000;
        status.state = static_cast<std::uint8_t>(state_);
        status.flags = static_cast<std::uint8_t>((homed_ ? unsigned{link::kFlagHomed} : 0U) |
                                                 (done_ ? unsigned{link::kFlagJobDone} : 0U));
        endpoint_->status(status);
    }
    std::array<std::uint8_t, 1024> bytes{};
    const std::size_t size = endpoint_->transmit(bytes);
    endpoint_->check_seals();
    out.insert(out.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
}

}  // namespace sc::bench
