// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/fdcan.hpp"

#include <array>
#include <bit>

namespace sc::stm32h743 {
namespace {

using namespace fdcan;

constexpr std::array<std::uint8_t, 16> kSizes{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
constexpr std::uint32_t kStandardIds = 0x7FF;
constexpr std::uint32_t kExtendedIds = 0x1FFFFFFF;
constexpr std::uint32_t kHeadBytes = 8;
/// Changes of CCCR cross between the clock of the bus and the kernel clock: some cycles of each.
constexpr std::uint32_t kReads = 2000;

/// Index into kSizes; 16 when no frame has this size.
std::uint32_t length_code(std::uint8_t size) noexcept {
    std::uint32_t code = 0;
    while (code < kSizes.size() && kSizes[code] != size) {
        ++code;
    }
    return code;
}

}  // namespace

Fdcan::Start Fdcan::start() noexcept {
    state_ = BusState::down;
    off_ = recovering_ = false;
    set_bits(kApb1henr, kClock);
    (void)read32(kApb1henr);  // the clock runs when this has been read
    if (read32(at(kEndn)) != kEndianTest) {
        return Start::absent;
    }
    clear_bits(at(kCccr), kStopRequest);
    if (!wait_for(at(kCccr), kStopAcknowledged, false, kReads)) {
        return Start::no_init;
    }
    set_bits(at(kCccr), kInit);
    if (!wait_for(at(kCccr), kInit, true, kReads)) {
        return Start::no_init;
    }
    set_bits(at(kCccr), kChangeEnable);
    if (!configure()) {
        return Start::refused;
    }
    clear_bits(at(kCccr), kInit);
    if (!wait_for(at(kCccr), kInit, false, kReads)) {
        return Start::not_entered;
    }
    state_ = BusState::active;
    return Start::ok;
}

bool Fdcan::configure() noexcept {
    const BitTiming& slow = settings_.nominal;
    const BitTiming& fast = settings_.data;
    const std::uint32_t modes = settings_.fd ? kFdEnable | kSwitchEnable : 0U;
    change_bits(at(kCccr), kFdEnable | kSwitchEnable, modes);
    const std::uint32_t nominal =
        (slow.jump - 1) << 25U | (slow.prescaler - 1) << 16U | (slow.before - 1) << 8U | (slow.after - 1);
    write32(at(kNbtp), nominal);
    if (settings_.fd) {
        write32(at(kDbtp), kDelayCompensation | (fast.prescaler - 1) << 16U | (fast.before - 1) << 8U |
                               (fast.after - 1) << 4U | (fast.jump - 1));
        // The second sample point lies where the sample point of a fast bit is, after the measured delay.
        write32(at(kTdcr), (fast.prescaler * (1 + fast.before)) << 8U);
    }
    write32(at(kTscc), settings_.fd ? 0U : kStampByBits);  // bits of two lengths are no clock
    write32(at(kGfc), 0);  // frames that no filter takes, of both kinds, go to FIFO 0; and there are no filters
    write32(at(kSidfc), 0);
    write32(at(kXidfc), 0);
    write32(at(kRxf0c), settings_.rx_count << kFifoSizeAt | settings_.ram);  // full: the new frame is lost
    write32(at(kRxesc), settings_.fd ? kData64 : 0U);
    write32(at(kTxbc), settings_.tx_count << kTxFifoSizeAt | settings_.tx_ram());
    write32(at(kTxesc), settings_.fd ? kData64 : 0U);
    for (std::uint32_t byte = settings_.ram; byte < settings_.end(); byte += 4) {
        write32(kMessageRam + byte, 0);
    }
    write32(at(kIr), kAllInterrupts);
    return read32(at(kNbtp)) == nominal;
}

void Fdcan::use_interrupt() noexcept {
    write32(at(kIr), kAllInterrupts);
    write32(at(kIls), 0);
    write32(at(kIe), kNewInFifo0 | kBusOffChanged);
    write32(at(kIle), kLine0);
}

bool Fdcan::acknowledge() noexcept {
    const std::uint32_t flags = read32(at(kIr)) & (kNewInFifo0 | kBusOffChanged | kLostInFifo0);
    write32(at(kIr), flags);
    note_lost(flags);
    return (flags & kNewInFifo0) != 0;
}

bool Fdcan::fits(const CanFrame& frame) const noexcept {
    const std::uint32_t code = length_code(frame.size);
    return frame.id <= (frame.extended ? kExtendedIds : kStandardIds) &&
           (frame.fd ? settings_.fd && code < kSizes.size() && !frame.remote : code <= 8 && !frame.fast);
}

CanSent Fdcan::send(const CanFrame& frame) noexcept {
    if (!fits(frame)) {
        ++counters_.failed;
        return CanSent::failed;
    }
    if (state_ == BusState::down || state_ == BusState::bus_off) {
        ++counters_.down;
        return CanSent::down;
    }
    const std::uint32_t status = read32(at(kTxfqs));
    if ((status & kTxFull) != 0) {
        ++counters_.full;
        return CanSent::full;
    }
    const std::uint32_t index = (status & kPutIndex) >> kPutIndexAt;
    const Address element = kMessageRam + settings_.tx_ram() + index * settings_.element_bytes();
    write32(element, frame.extended ? kExtended | frame.id | (frame.remote ? kRemote : 0U)
                                    : frame.id << kStandardAt | (frame.remote ? kRemote : 0U));
    write32(element + 4, length_code(frame.size) << kLengthAt | (frame.fd ? kFdFormat : 0U) |
                             (frame.fd && frame.fast ? kRateSwitch : 0U));
    for (std::uint32_t byte = 0; byte < frame.size && !frame.remote; byte += 4) {
        const std::uint32_t word = std::uint32_t{frame.data[byte]} | std::uint32_t{frame.data[byte + 1]} << 8U |
                                   std::uint32_t{frame.data[byte + 2]} << 16U |
                                   std::uint32_t{frame.data[byte + 3]} << 24U;
        write32(element + kHeadBytes + byte, word);
    }
    barrier();
    write32(at(kTxbar), 1U << index);
    ++counters_.sent;
    return CanSent::yes;
}

bool Fdcan::receive(CanFrame& out) noexcept {
    if (state_ == BusState::down) {
        return false;
    }
    const std::uint32_t status = read32(at(kRxf0s));
    if ((status & kFillLevel) == 0) {
        return false;
    }
    const std::uint32_t index = (status & kGetIndex) >> kGetIndexAt;
    const Address element = kMessageRam + settings_.ram + index * settings_.element_bytes();
    const std::uint32_t first = read32(element);
    const std::uint32_t second = read32(element + 4);
    out = {};
    out.extended = (first & kExtended) != 0;
    out.remote = (first & kRemote) != 0;
    out.id = out.extended ? first & kExtendedIds : (first >> kStandardAt) & kStandardIds;
    out.fd = (second & kFdFormat) != 0;
    out.fast = (second & kRateSwitch) != 0;
    const std::uint32_t code = (second >> kLengthAt) & 15U;
    out.size = out.fd || code <= 8 ? kSizes[code] : std::uint8_t{8};
    for (std::uint32_t byte = 0; byte < out.size && !out.remote; byte += 4) {
        const std::uint32_t word = read32(element + kHeadBytes + byte);
        for (std::uint32_t i = 0; i < 4 && byte + i < out.size; ++i) {
            out.data[byte + i] = static_cast<std::uint8_t>(word >> (8U * i));
        }
    }
    out.age_bits = static_cast<std::uint16_t>(settings_.fd ? 0U : read32(at(kTscv)) - (second & kStamp));
    barrier();
    write32(at(kRxf0a), index);
    ++counters_.received;
    return true;
}

void Fdcan::note_lost(std::uint32_t flags) noexcept {
    if ((flags & kLostInFifo0) != 0) {
        ++counters_.lost;
    }
}

void Fdcan::service(std::int64_t now_ns) noexcept {
    if (state_ == BusState::down) {
        return;
    }
    const std::uint32_t lost = read32(at(kIr)) & kLostInFifo0;
    write32(at(kIr), lost);
    note_lost(lost);
    const std::uint32_t errors = read32(at(kEcr));
    counters_.tx_error_count = static_cast<std::uint8_t>(errors & kTransmitErrors);
    counters_.rx_error_count = static_cast<std::uint8_t>((errors & kReceiveErrors) >> 8U);
    counters_.errors += (errors & kLoggedErrors) >> 16U;
    const std::uint32_t status = read32(at(kPsr));
    if ((status & kLastError) == kNoAck) {
        ++counters_.no_acks;
    }
    const bool stopped = (read32(at(kCccr)) & kInit) != 0;
    if (stopped && !off_) {
        off_ = true;
        recovering_ = false;
        off_since_ns_ = now_ns;
        ++counters_.bus_offs;
    }
    if (stopped && now_ns - off_since_ns_ >= kBusOffNs) {
        restart();
    }
    if (off_ || recovering_) {
        // Bus-off stands until the recessive bits are counted.
        recovering_ = recovering_ && (status & kBusOff) != 0;
        state_ = BusState::bus_off;
    }
    if (!off_ && !recovering_) {
        state_ = (status & kErrorPassive) != 0   ? BusState::passive
                 : (status & kErrorWarning) != 0 ? BusState::warning
                                                 : BusState::active;
    }
}

/// Opening the configuration empties both queues: what waits to be sent is stale, what was received is counted.
void Fdcan::restart() noexcept {
    counters_.abandoned += static_cast<std::uint32_t>(std::popcount(read32(at(kTxbrp))));
    if ((read32(at(kRxf0s)) & kFillLevel) != 0) {
        ++counters_.lost;
    }
    set_bits(at(kCccr), kChangeEnable);
    clear_bits(at(kCccr), kInit | kChangeEnable);
    off_ = false;
    recovering_ = true;
    ++counters_.restarts;
}

}  // namespace sc::stm32h743
