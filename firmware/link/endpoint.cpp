// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/endpoint.hpp"

#include <algorithm>
#include <type_traits>

#include "firmware/link/event_of.hpp"
#include "shared/hash/crc.hpp"

namespace sc::link {
Endpoint::Endpoint(const MachineConfig& machine, std::uint32_t boot_id, const EndpointOptions& options) noexcept
    : config_crc_(0),
      boot_id_(boot_id),
      control_period_ns_(std::max<std::int64_t>(machine.control_period_ns, 1)),
      items_per_tick_(options.items_per_tick),
      newest_minor_(options.newest_minor),
      stream_(options.rules) {
    serialise(machine, config_);
    config_crc_ = crc32(config_);
}

// --- receiving ----------------------------------------------------------------------------------------------------

void Endpoint::receive(std::int64_t tick, std::span<const std::uint8_t> bytes) noexcept {
    tick_ = tick;
    if (gate_.fitted()) {
        take_checked();
    }
    receiver_.receive(bytes, [this](const Envelope& envelope) noexcept {
        if (gate_.fitted()) {
            sift(envelope);
        } else {
            take(envelope);
        }
    });
    stream_.step(items_per_tick_);
}

void Endpoint::take(const Envelope& envelope) noexcept {
    if (session_open_ && envelope.id != Hello::kId) {
        if (!watch_.take(envelope.counter)) {
            return;
        }
        last_heard_ = tick_;
        heard_ = envelope.counter;
    }
    payload_ = envelope.payload;
    if (envelope.id == Block::kId) {
        take_block(envelope.payload);
        return;
    }
    const Dispatch result = dispatch(PlainHostMessages{}, envelope, [this, &envelope](const auto& message) noexcept {
        if constexpr (std::is_same_v<decltype(message), const Hello&>) {
            on_hello(message, envelope.counter);
        } else {
            on(message);
        }
    });
    if (result != Dispatch::handled) {
        ++counters_.frames_bad;
    }
}

Refusal Endpoint::judge(const Hello& hello) const noexcept {
    constexpr std::uint16_t kShortestTimeoutMs = 20;
    constexpr std::uint16_t kLongestTimeoutMs = 500;
    if (hello.major != kProtocolMajor) {
        return Refusal::version_mismatch;
    }
    if (minor_of(hello.schema).value_or(0xFF) > newest_minor_) {
        return Refusal::schema_mismatch;
    }
    if (hello.heartbeat_timeout_ms < kShortestTimeoutMs || hello.heartbeat_timeout_ms > kLongestTimeoutMs) {
        return Refusal::bad_config;
    }
    return hello.session != session_ && alive(tick_) ? Refusal::wrong_state : Refusal::none;
}

void Endpoint::on_hello(const Hello& hello, std::uint16_t counter) noexcept {
    const Refusal refusal = judge(hello);
    if (refusal == Refusal::none) {
        const bool resumed = session_open_ && hello.session == session_;
        if (!resumed) {
            event_count_ = 0;
            replies_ = {};
            unremembered_.reset();
            telemetry_.stop();
            blackbox_wanted_.reset();
            parameters_wanted_.reset();
        }
        if (!push_event(resumed ? LinkEvent::Kind::session_resumed : LinkEvent::Kind::session_open)) {
            return;
        }
        session_open_ = true;
        session_ = hello.session;
        minor_ = minor_of(hello.schema).value_or(kProtocolMinor);
        receiver_.set_minor(minor_);
        heard_ = counter;
        timeout_ticks_ = std::int64_t{hello.heartbeat_timeout_ms} * 1'000'000 / control_period_ns_;
        last_heard_ = tick_;
        watch_.restart(counter);
    } else {
        ++counters_.hellos_refused;
    }
    answer_hello(hello.session, refusal);
}

void Endpoint::answer_hello(std::uint32_t session, Refusal refusal) noexcept {
    HelloReply reply;
    // To a peer that is refused: the newest that is spoken here, so that it may choose an older one.
    const std::uint8_t minor = refusal == Refusal::none ? minor_ : newest_minor_;
    reply.schema = kSchemaHashes[minor];
    reply.minor = minor;
    reply.refusal = static_cast<std::uint16_t>(refusal);
    reply.session = session;
    reply.boot = boot_id_;
    reply.config_bytes = static_cast<std::uint16_t>(config_.size());
    reply.config_crc = config_crc_;
    reply.last_sequence = replies_.newest();
    hello_reply_ = reply;
}

void Endpoint::on(const Heartbeat& heartbeat) noexcept {
    if (session_open_ && tick_ - last_clock_tick_ >= kClockEveryTicks) {
        clock_ = ClockReply{heartbeat.host_time_us, cell_time_us(), 0};
        last_clock_tick_ = tick_;
    }
}

void Endpoint::on(const PositionRequest& /*request*/) noexcept {
    if (session_open_) {
        push_event(LinkEvent::Kind::position_request);
    }
}

void Endpoint::on(const SensorsRequest& /*request*/) noexcept {
    if (session_open_) {
        push_event(LinkEvent::Kind::sensors);
    }
}

void Endpoint::on(const TelemetryRequest& wanted) noexcept {
    if (fresh(wanted.sequence)) {
        std::int64_t detail = 0;
        const Refusal refusal =
            telemetry_.subscribe(wanted, static_cast<std::uint32_t>(control_period_ns_), tick_, detail);
        replies_.answer(wanted.sequence, refusal, detail);
    }
}

void Endpoint::on(const BlackboxRequest& wanted) noexcept {
    if (session_open_) {
        blackbox_wanted_ = wanted;
    }
}

void Endpoint::on(const ParametersRequest& wanted) noexcept {
    if (session_open_) {
        parameters_wanted_ = wanted;
    }
}

/// Everything that is answered by the controller under a sequence.
template <class Message>
void Endpoint::on(const Message& message) noexcept {
    if (session_open_ && event_count_ == kEvents) {
        ++counters_.events_lost;
    } else if (fresh(message.sequence)) {
        push_event(EventOf<Message>::kKind);
    }
}

void Endpoint::take_block(std::span<const std::uint8_t> payload) noexcept {
    const std::optional<BlockView> block = view_block(payload);
    if (!block) {
        ++counters_.frames_bad;
    } else if (session_open_ && stream_.take(*block) != JobStream::Taken::foreign) {
        ack_now_ = true;
        gap_told_ = false;
    }
}

void Endpoint::on(const ConfigRequest& request) noexcept {
    if (session_open_) {
        config_wanted_ = request.offset;
    }
}

/// False when a request is not to be done: its answer, if it has one, is on its way.
bool Endpoint::fresh(std::uint32_t sequence) noexcept {
    if (!session_open_) {
        answer_unremembered(sequence, Refusal::not_connected);
        return false;
    }
    switch (replies_.take(sequence)) {
        case ReplyMemory::Verdict::fresh: return true;
        case ReplyMemory::Verdict::stale: answer_unremembered(sequence, Refusal::wrong_state); break;
        case ReplyMemory::Verdict::full: ++counters_.events_lost; break;
        case ReplyMemory::Verdict::pending:
        case ReplyMemory::Verdict::repeat: break;
    }
    return false;
}

void Endpoint::answer_unremembered(std::uint32_t sequence, Refusal refusal) noexcept {
    unremembered_ = CommandReply{sequence, static_cast<std::uint16_t>(refusal), 0};
}

/// With the payload of the message that is being taken.
bool Endpoint::push_event(LinkEvent::Kind kind) noexcept {
    if (event_count_ == kEvents) {
        ++counters_.events_lost;
        return false;
    }
    Pending& event = events_[(event_head_ + event_count_) % kEvents];
    event.kind = kind;
    event.size = static_cast<std::uint8_t>(payload_.size());
    std::copy(payload_.begin(), payload_.end(), event.payload.begin());
    ++event_count_;
    return true;
}

bool Endpoint::alive(std::int64_t tick) const noexcept { return session_open_ && tick - last_heard_ <= timeout_ticks_; }

// --- the controller's side ----------------------------------------------------------------------------------------

void Endpoint::reply(std::uint32_t sequence, Refusal refusal, std::int64_t detail) noexcept {
    replies_.answer(sequence, refusal, detail);
}

void Endpoint::open_job(std::uint64_t job, std::uint32_t items) noexcept {
    stream_.open(job, items);
    if (stream_.received() == 0) {
        progress_ = {};
    }
    job_seen_ = true;
    ack_now_ = true;
    next_refused_tick_ = tick_;
}

void Endpoint::resume_job(const JobResume& resume) noexcept {
    stream_.open_at(resume.job, resume.items, {resume.first, resume.hash_before});
    progress_ = {};
    progress_.planned = progress_.fired = resume.first;
    job_seen_ = true;
    ack_now_ = true;
    next_refused_tick_ = tick_;
}

void Endpoint::close_job() noexcept { stream_.close(); }

void Endpoint::refuse_item(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept {
    stream_.refuse(item, refusal, axis, value);
}

void Endpoint::progress(std::uint32_t planned, std::uint32_t fired, const FiredPosition& position) noexcept {
    progress_ = {planned, fired, position};
}

LinkCounters Endpoint::counters() const noexcept {
    LinkCounters all = counters_;
    all.seals = gate_.counters();
    all.frames_bad += receiver_.frames_bad() + all.seals.wrong + all.seals.dropped;
    all.messages_lost = watch_.lost();
    all.messages_repeated = watch_.repeated() + all.seals.stale;
    all.items_repeated = stream_.items_repeated();
    all.blocks_ahead = stream_.blocks_ahead();
    return all;
}

}  // namespace sc::link
