// SPDX-License-Identifier: Apache-2.0
// What the endpoint sends, and when.
#include <algorithm>

#include "firmware/link/endpoint.hpp"

namespace sc::link {

std::size_t Endpoint::transmit(std::span<std::uint8_t> out) noexcept {
    Outbox box{out};
    static_cast<void>(send_hello(box) && send_challenge(box) && send_replies(box) && send_refused(box) &&
                      send_ack(box) && send_missing(box) && send_position(box) && send_status(box) && send_clock(box) &&
                      send_report(box) && send_config(box));
    telemetry_.step(tick_, box.size);
    return box.size;
}

std::size_t Endpoint::transmit(std::span<std::uint8_t> out, const TelemetryValues& values) noexcept {
    Outbox box{out};
    if (telemetry_due() != 0 && send(box, telemetry_.message(values, cell_time_us())) && box.size > 0) {
        telemetry_.sent(box.size);
    }
    return box.size;
}

std::size_t Endpoint::transmit(std::span<std::uint8_t> out, const BlackboxChunk& chunk) noexcept {
    Outbox box{out};
    if (send(box, chunk)) {
        blackbox_wanted_.reset();
    }
    return box.size;
}

std::size_t Endpoint::transmit(std::span<std::uint8_t> out, const Parameters& told) noexcept {
    Outbox box{out};
    if (send(box, told)) {
        parameters_wanted_.reset();
    }
    return box.size;
}

/// Not in the tick of an acknowledgement or a state: a tick must not carry too much.
bool Endpoint::busy_tick() const noexcept { return last_ack_tick_ == tick_ || last_status_tick_ == tick_; }

std::uint32_t Endpoint::telemetry_due() const noexcept { return !alive(tick_) || busy_tick() ? 0 : telemetry_.due(); }

bool Endpoint::send_clock(Outbox& box) noexcept {
    if (!clock_ || busy_tick()) {
        return true;
    }
    clock_->sent_us = cell_time_us();
    if (!send(box, *clock_)) {
        return false;
    }
    clock_.reset();
    return true;
}

/// False when there is no room; everything less urgent then waits too.
template <class Message>
bool Endpoint::send(Outbox& box, const Message& message) noexcept {
    if (since<Message>() > minor_) {
        return true;  // the peer does not know it
    }
    const std::size_t size = encode_serial(message, send_counter_, box.out.subspan(box.size), minor_);
    if (size == 0) {
        return false;
    }
    ++send_counter_;
    box.size += size;
    return true;
}

bool Endpoint::send_hello(Outbox& box) noexcept {
    if (hello_reply_) {
        if (!send(box, *hello_reply_)) {
            return false;
        }
        hello_reply_.reset();
    }
    return true;
}

bool Endpoint::send_replies(Outbox& box) noexcept {
    while (const CommandReply* due = replies_.due()) {
        if (!send(box, *due)) {
            return false;
        }
        replies_.sent(due->sequence);
    }
    if (unremembered_) {
        if (!send(box, *unremembered_)) {
            return false;
        }
        unremembered_.reset();
    }
    return true;
}

bool Endpoint::send_refused(Outbox& box) noexcept {
    if (stream_.refused().refusal == 0 || tick_ < next_refused_tick_) {
        return true;
    }
    if (!send(box, stream_.refused())) {
        return false;
    }
    next_refused_tick_ = tick_ + kRefusedRepeatTicks;
    return true;
}

StreamAck Endpoint::current_ack() const noexcept {
    StreamAck ack;
    ack.job_low = stream_.job_low();
    ack.received = stream_.received();
    ack.planned = progress_.planned;
    ack.fired = progress_.fired;
    ack.free_items = stream_.is_open() ? static_cast<std::uint16_t>(stream_.window()) : std::uint16_t{0};
    ack.path = progress_.position.path;
    ack.pass = progress_.position.pass;
    ack.pulses = progress_.position.pulses;
    return ack;
}

bool Endpoint::ack_due(const StreamAck& ack) const noexcept {
    const bool changed = ack.planned != last_ack_.planned || ack.fired != last_ack_.fired ||
                         ack.free_items != last_ack_.free_items || ack.path != last_ack_.path ||
                         ack.pass != last_ack_.pass || ack.pulses != last_ack_.pulses;
    const std::int64_t age = tick_ - last_ack_tick_;
    return ack_now_ || (changed && age >= kAckEveryTicks) || age >= kAckRepeatTicks;
}

bool Endpoint::send_ack(Outbox& box) noexcept {
    if (!session_open_ || !job_seen_) {
        return true;
    }
    const StreamAck ack = current_ack();
    if (!ack_due(ack)) {
        return true;
    }
    if (!send(box, ack)) {
        return false;
    }
    last_ack_ = ack;
    ack_now_ = false;
    last_ack_tick_ = tick_;
    return true;
}

bool Endpoint::send_missing(Outbox& box) noexcept {
    if (gap_told_ || !session_open_) {
        return true;
    }
    std::array<JobStream::Gap, StreamMissing::kRuns> gaps;
    const std::size_t count = stream_.missing(gaps);
    if (count > 0) {
        StreamMissing missing;
        missing.job_low = stream_.job_low();
        missing.heard = heard_;
        missing.count = static_cast<std::uint8_t>(count);
        for (std::size_t i = 0; i < count; ++i) {
            missing.from[i] = gaps[i].from;
            missing.until[i] = gaps[i].until;
        }
        if (!send(box, missing)) {
            return false;
        }
    }
    gap_told_ = true;
    return true;
}

bool Endpoint::send_position(Outbox& box) noexcept {
    if (position_) {
        if (!send(box, *position_)) {
            return false;
        }
        position_.reset();
    }
    return true;
}

bool Endpoint::send_status(Outbox& box) noexcept {
    // Not in the tick of an acknowledgement: it can wait, and a tick must not carry both.
    if (!status_ || !session_open_ || last_ack_tick_ == tick_) {
        return true;
    }
    const LinkCounters now = counters();
    status_->frames_bad = now.frames_bad;
    status_->messages_lost = now.messages_lost;
    status_->items_repeated = now.items_repeated;
    if (!send(box, *status_)) {
        return false;
    }
    last_status_tick_ = tick_;
    status_.reset();
    return true;
}

bool Endpoint::send_report(Outbox& box) noexcept {
    if (report_) {
        if (!send(box, *report_)) {
            return false;
        }
        report_.reset();
    }
    return true;
}

bool Endpoint::send_config(Outbox& box) noexcept {
    constexpr std::size_t kChunkOverhead = cobs_capacity(kMessageOverhead + sizeof(ConfigChunk::offset) + 1);
    constexpr std::size_t kSmallestChunk = 16;
    if (!config_wanted_) {
        return true;
    }
    ConfigChunk chunk;
    chunk.offset = *config_wanted_;
    const auto rest = std::span<const std::uint8_t>(config_).subspan(std::min<std::size_t>(chunk.offset, kConfigSize));
    const std::size_t room = box.out.size() - box.size;
    if (room < kChunkOverhead + std::min(kSmallestChunk, rest.size())) {
        return false;
    }
    const std::size_t size = std::min({rest.size(), chunk.data.data.size(), room - kChunkOverhead});
    std::copy_n(rest.begin(), size, chunk.data.data.begin());
    chunk.data.size = static_cast<std::uint8_t>(size);
    if (!send(box, chunk)) {
        return false;
    }
    config_wanted_.reset();
    return true;
}

}  // namespace sc::link
