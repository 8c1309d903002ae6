// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/bus_master.hpp"

#include "firmware/sensors/modbus_rtu.hpp"

namespace sc::sensors {
namespace {

constexpr std::uint32_t kFastBaud = 19'200;
constexpr std::int64_t kFastInnerNs = 750'000;
constexpr std::int64_t kFastGapNs = 1'750'000;
/// Times of received bytes are in whole µs.
constexpr std::int64_t kStampNs = 2'000;
constexpr std::uint8_t kLineEnd = '\r';

}  // namespace

BusTiming bus_timing(const SensorBusConfig& bus) noexcept {
    if (bus.baud == 0) {
        return {};
    }
    const std::int64_t bits = bus.parity == SensorParity::none ? 10 : 11;
    const std::int64_t character = bits * 1'000'000'000 / bus.baud;
    if (bus.baud > kFastBaud && bus.short_gaps == 0) {
        return {character, kFastInnerNs, kFastGapNs};
    }
    return {character, character * 3 / 2, character * 7 / 2};
}

bool BusMaster::step(std::int64_t now_ns, std::span<const SensorByte> received, Reply& reply) noexcept {
    bool handed = false;
    const auto hand_over = [&](std::int64_t until_ns) noexcept {
        if (!handed && (failed_ || (pending_ && until_ns >= pending_until_))) {
            failed_ = pending_ = false;
            reply = done_;
            handed = true;
        }
    };
    for (const SensorByte& byte : received) {
        const std::int64_t end_ns = now_ns - std::int64_t{byte.age_us} * 1000;
        hand_over(end_ns - timing_.character);
        take(byte, end_ns);
    }
    watch_time(now_ns);
    hand_over(now_ns);
    return handed;
}

void BusMaster::watch_time(std::int64_t now_ns) noexcept {
    if (state_ == State::waiting && now_ns > asked_ns_ + request_.patience_ns) {
        if (request_.reply == ReplyForm::none) {
            fail(SensorCode::none);
            state_ = State::quiet;
        } else {
            spoil(SensorCode::timeout);
            // Who answers late must not be taken for the answer to the next request.
            busy_until_ = now_ns + request_.patience_ns;
        }
    } else if (state_ == State::receiving && now_ns > last_byte_ns_ + timing_.gap + timing_.character) {
        spoil(SensorCode::bad_frame);
    }
    if (state_ == State::draining && now_ns >= busy_until_ + timing_.gap) {
        state_ = State::quiet;
    }
}

void BusMaster::take(const SensorByte& byte, std::int64_t end_ns) noexcept {
    if (end_ns > busy_until_) {
        busy_until_ = end_ns;
    }
    if (pending_ && end_ns - timing_.character < pending_until_) {
        // More than was announced: none of it can be trusted. The next request may be on its way already.
        pending_ = false;
        failed_ = true;
        done_.code = SensorCode::bad_frame;
        done_.size = 0;
        state_ = state_ == State::quiet ? State::draining : state_;
    } else if (state_ == State::waiting || state_ == State::receiving) {
        take_in_turn(byte, end_ns);
    } else {
        ++strays_;
    }
}

void BusMaster::take_in_turn(const SensorByte& byte, std::int64_t end_ns) noexcept {
    const std::int64_t begin = end_ns - timing_.character + kStampNs;
    if (state_ == State::waiting) {
        if (request_.reply == ReplyForm::none || begin < asked_ns_ + timing_.character * 3 / 2) {
            // Before anybody can have understood the request: the line turning round.
            ++strays_;
            return;
        }
        state_ = State::receiving;
        reply_.size = 0;
    } else if (request_.reply == ReplyForm::modbus && begin > last_byte_ns_ + timing_.inner + 2 * kStampNs) {
        spoil(SensorCode::bad_frame);
        return;
    }
    last_byte_ns_ = end_ns;
    append(byte);
}

void BusMaster::append(const SensorByte& byte) noexcept {
    if (byte.flags != 0 || reply_.size >= reply_.bytes.size()) {
        spoil(SensorCode::bad_frame);
        return;
    }
    reply_.bytes[reply_.size] = byte.data;
    ++reply_.size;
    if (request_.reply == ReplyForm::line) {
        if (byte.data == kLineEnd) {
            complete();
        }
        return;
    }
    const std::size_t whole = modbus::reply_size(reply_.view());
    if (whole > reply_.bytes.size()) {
        spoil(SensorCode::bad_frame);
    } else if (whole != 0 && reply_.size == whole) {
        complete();
    }
}

void BusMaster::complete() noexcept {
    done_ = reply_;
    done_.code = SensorCode::none;
    done_.detail = 0;
    done_.tag = request_.tag;
    done_.step = request_.step;
    done_.asked_ns = asked_ns_;
    if (request_.reply == ReplyForm::modbus) {
        done_.code = modbus::judge(request_.view(), reply_.view(), done_.detail);
    }
    pending_ = true;
    pending_until_ = last_byte_ns_ + timing_.gap;
    state_ = State::quiet;
}

void BusMaster::fail(SensorCode code) noexcept {
    done_.code = code;
    done_.detail = 0;
    done_.tag = request_.tag;
    done_.step = request_.step;
    done_.size = 0;
    done_.asked_ns = asked_ns_;
    failed_ = true;
}

void BusMaster::spoil(SensorCode code) noexcept {
    fail(code);
    state_ = State::draining;
}

void BusMaster::send(std::int64_t now_ns, const Telegram& telegram, SensorTransmission& out) noexcept {
    const std::int64_t begin = begin_at(now_ns);
    out.size = telegram.size;
    out.bytes = telegram.bytes;
    out.delay_ns = static_cast<std::uint32_t>(begin - now_ns - period_ns_);
    request_ = telegram;
    asked_ns_ = begin + telegram.size * timing_.character;
    busy_until_ = asked_ns_;
    state_ = State::waiting;
}

}  // namespace sc::sensors
