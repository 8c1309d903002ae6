// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/sensor_port.hpp"

#include <algorithm>

namespace sc::stm32h743 {
namespace {

constexpr std::uint32_t kSlowest = 2'400;
constexpr std::uint32_t kFastest = 230'400;
constexpr std::uint32_t kReads = 5000;
// Sixteenths of a bit.
constexpr std::uint32_t kAssert = 8;
constexpr std::uint32_t kRelease = 4;
constexpr std::uint32_t kErrors = usart::kParityError | usart::kFramingError | usart::kNoise | usart::kOverrun;
constexpr std::uint8_t kParityFlag = 1;  // of SensorByte
constexpr std::uint8_t kStopFlag = 2;
constexpr std::uint8_t kGapFlag = 4;

}  // namespace

SensorPort::Start SensorPort::start(const SensorBusConfig& bus) noexcept {
    state_ = State::off;
    first_ = size_ = 0;
    gap_ = false;
    if (bus.baud < kSlowest || bus.baud > kFastest) {
        return Start::bad_rate;
    }
    const bool even = bus.parity == SensorParity::even;
    const std::uint32_t divider = (kKernelHz + bus.baud / 2) / bus.baud;
    lead_ns_ = std::int64_t{kAssert} * divider * 1'000'000'000 / (16 * std::int64_t{kKernelHz});
    set_bits(settings_.clock_at, settings_.clock);
    (void)read32(settings_.clock_at);             // the clock runs when this has been read
    clear_bits(at(usart::kCr1), usart::kEnable);  // by itself, before what may change only while it is off
    const std::uint32_t format =
        (even ? usart::kParity | usart::kNineBits : 0U) | kAssert << usart::kAssertAt | kRelease << usart::kReleaseAt;
    write32(at(usart::kCr1), format);
    write32(at(usart::kBrr), divider);
    write32(at(usart::kRtor), (even ? 77U : 70U) / 2);  // 3.5 characters, in bits
    write32(at(usart::kCr2), usart::kTimeoutEnable);
    write32(at(usart::kCr3), usart::kDriverEnable);
    write32(at(usart::kIcr), kErrors | usart::kTimeout | usart::kComplete);
    write32(at(usart::kCr1), format | usart::kEnable | usart::kReceive | usart::kTransmit | usart::kReceiveInterrupt |
                                 usart::kTimeoutInterrupt);
    if (!wait_for(at(usart::kIsr), usart::kTransmitReady | usart::kReceiveReady, true, kReads)) {
        return Start::silent;
    }
    state_ = State::hearing;
    return Start::ok;
}

void SensorPort::give(const SensorTransmission& sent, std::int64_t window_ns) noexcept {
    if (sent.size == 0) {
        return;
    }
    if (state_ != State::hearing || sent.size > kSensorTransmissionBytes) {
        ++counters_.lost_requests;
        return;
    }
    sending_ = sent;
    next_ = 0;
    due_ns_ = window_ns + sent.delay_ns;
    state_ = State::due;
}

void SensorPort::poll(std::int64_t now_ns) noexcept {
    if (state_ != State::due || now_ns < due_ns_ - lead_ns_) {
        return;
    }
    const std::uint32_t flags = read32(at(usart::kIsr));
    if ((flags & usart::kReceived) != 0) {
        hear(flags, now_ns);
    }
    begin(flags);
}

/// The receiver is off before the driver is on, so that it hears no echo.
void SensorPort::begin(std::uint32_t flags) noexcept {
    if ((flags & (usart::kBusy | usart::kReceived)) != 0) {
        ++counters_.cut;
    }
    state_ = State::sending;
    clear_bits(at(usart::kCr1), usart::kReceive);
    write32(at(usart::kTdr), sending_.bytes[next_++]);
    set_bits(at(usart::kCr1), usart::kEmptyInterrupt);
}

void SensorPort::on_interrupt(std::int64_t now_ns) noexcept {
    const std::uint32_t flags = read32(at(usart::kIsr));
    if ((flags & (usart::kReceived | usart::kOverrun)) != 0) {
        hear(flags, now_ns);
    }
    if ((flags & usart::kTimeout) != 0) {
        write32(at(usart::kIcr), usart::kTimeout);
        ++counters_.silences;
    }
    if (state_ == State::sending) {
        feed(flags);
    }
}

void SensorPort::hear(std::uint32_t flags, std::int64_t now_ns) noexcept {
    if ((flags & usart::kReceived) != 0) {
        const auto data = static_cast<std::uint8_t>(read32(at(usart::kRdr)) & 0xFFU);
        const bool parity = (flags & usart::kParityError) != 0;
        const bool stop = (flags & usart::kFramingError) != 0;
        counters_.damaged += parity || stop ? 1U : 0U;
        ++counters_.heard;
        if (size_ == kQueue) {
            ++counters_.lost_bytes;
            gap_ = true;
        } else {
            const auto wrong = static_cast<std::uint8_t>((parity ? kParityFlag : 0U) | (stop ? kStopFlag : 0U) |
                                                         (gap_ ? kGapFlag : 0U));
            queue_[(first_ + size_) % kQueue] = {now_ns, data, wrong};
            ++size_;
            gap_ = false;
        }
    }
    if ((flags & usart::kOverrun) != 0) {  // the byte after the one that was read
        ++counters_.lost_bytes;
        gap_ = true;
    }
    write32(at(usart::kIcr), flags & kErrors);
}

void SensorPort::feed(std::uint32_t flags) noexcept {
    if (next_ < sending_.size) {
        if ((flags & usart::kEmpty) != 0) {
            write32(at(usart::kTdr), sending_.bytes[next_++]);
        }
        return;
    }
    const std::uint32_t control = read32(at(usart::kCr1));
    if ((control & usart::kEmptyInterrupt) != 0) {
        write32(at(usart::kCr1), (control & ~usart::kEmptyInterrupt) | usart::kCompleteInterrupt);
        return;
    }
    if ((flags & usart::kComplete) != 0) {
        state_ = State::hearing;
        ++counters_.sent;
        write32(at(usart::kIcr), usart::kComplete);
        write32(at(usart::kCr1), (control & ~usart::kCompleteInterrupt) | usart::kReceive);
    }
}

std::span<const SensorByte> SensorPort::take(std::int64_t tick_ns) noexcept {
    std::size_t count = 0;
    while (size_ > 0 && count < out_.size() && queue_[first_].end_ns <= tick_ns) {
        const Heard& heard = queue_[first_];
        const std::int64_t age_us = std::min<std::int64_t>((tick_ns - heard.end_ns) / 1000, 0xFFFF);
        out_[count++] = {heard.data, heard.flags, static_cast<std::uint16_t>(age_us)};
        first_ = (first_ + 1) % kQueue;
        --size_;
    }
    return std::span<const SensorByte>(out_).first(count);
}

}  // namespace sc::stm32h743
