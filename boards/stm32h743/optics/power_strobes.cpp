// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/power_strobes.hpp"

#include "boards/stm32h743/registers/counter.hpp"
#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/gpio.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"

namespace sc::stm32h743 {
namespace {

constexpr Address kPort = gpio::base(gpio::Port::f);
constexpr std::uint32_t kByte = 0xFF;
constexpr std::uint32_t kLatch = 1U << 8U;
constexpr std::uint32_t kPins = kByte | kLatch;
constexpr unsigned kPortStream = 1;
constexpr unsigned kTimeStream = 2;
constexpr unsigned kFirstOfDma2 = 8;
constexpr Address kToPort = dma::stream2(kPortStream);
constexpr Address kToTimes = dma::stream2(kTimeStream);
constexpr std::uint32_t kSettings = dma::kToPeripheral | dma::kCircular | dma::kMemoryIncrement | dma::kPeripheralWord |
                                    dma::kMemoryWord | dma::kVeryHigh;
constexpr std::uint32_t kRequests = tim5::kCompare1Dma | tim5::kCompare2Dma;
constexpr std::uint32_t kStopReads = 100;
constexpr std::uint32_t kRing = kStrobeEvents;
/// The next compare values are loaded so long behind an event: 200 ns.
constexpr std::uint32_t kReloadCounts = 48;
constexpr std::int64_t kShortestNs = 500;
constexpr std::int64_t kIdleNs = 100'000;
constexpr std::int64_t kWindowNs = 1'000'000;
/// Strobes of the next window may begin so long before it.
constexpr std::int64_t kTailNs = 50'000;
/// From a restart to its first event.
constexpr std::int64_t kStartNs = 20'000;
/// Events that must wait beside the one that is added: the stream has read the compare values that follow the first.
constexpr std::uint32_t kWaiting = 2;
/// A count behind the last event that is 17.9 s away.
constexpr std::uint32_t kBehind = 240;

constexpr std::uint32_t lay(std::uint8_t byte) { return byte | (kByte & ~std::uint32_t{byte}) << 16U; }

constexpr std::uint32_t pairs(std::uint32_t value) {
    std::uint32_t all = 0;
    for (std::uint32_t pin = 0; pin < 16; ++pin) {
        all |= ((kPins >> pin) & 1U) != 0 ? value << (2 * pin) : 0;
    }
    return all;
}

bool stop(Address stream) noexcept {
    clear_bits(stream + dma::kCr, dma::kEnable);
    return wait_for(stream + dma::kCr, dma::kEnable, false, kStopReads);
}

bool run(Address stream, Address peripheral, Address memory, std::uint32_t words) noexcept {
    write32(stream + dma::kPar, peripheral);
    write32(stream + dma::kM0ar, memory);
    write32(stream + dma::kNdtr, words);
    write32(stream + dma::kFcr, 0);
    write32(stream + dma::kCr, kSettings);
    set_bits(stream + dma::kCr, dma::kEnable);
    return (read32(stream + dma::kCr) & dma::kEnable) != 0;
}

}  // namespace

bool PowerStrobes::start(std::int64_t until_ns) noexcept {
    set_bits(optics_port::kAhb1enr, optics_port::kDma2Clock);
    set_bits(optics_port::kAhb2enr, optics_port::kSram2Clock);
    set_bits(gpio::kAhb4enr, gpio::clock(gpio::Port::f));
    (void)read32(gpio::kAhb4enr);  // a clock is there two cycles behind its bit
    write32(kPort + gpio::kBsrr, kPins << 16U);
    clear_bits(kPort + gpio::kOtyper, kPins);
    change_bits(kPort + gpio::kModer, pairs(3), pairs(gpio::kOutput));
    byte_ = kUnknown;
    window_ns_ = until_ns;
    return restart();
}

/// From the ring's begin, idle to the end of the window before the next.
bool PowerStrobes::restart() noexcept {
    runs_ = false;
    write32(tim5::kDier, 0);
    write32(kPort + gpio::kBsrr, kLatch << 16U);
    if (!stop(kToPort) || !stop(kToTimes)) {
        return false;
    }
    end_ = 0;
    // The first event's values are the processor's; the stream's first pair is the second's.
    const std::int64_t first = window_ns_ - kWindowNs + clock_.since_ns(window_ns_ - kWindowNs) + kStartNs;
    const std::uint32_t count = clock_.count_at(first);
    write32(tim5::kCcr1, count);
    write32(tim5::kCcr2, count + kReloadCounts);
    buffers_.words[0] = 0;
    buffers_.compare[0] = {count - kBehind, count - kBehind};
    end_ = 1;
    last_ns_ = first;
    if (!idle_until(window_ns_ - kTailNs) || end_ <= kWaiting) {
        return false;
    }
    write32(dma::kLifcr2, dma::flags(kPortStream, dma::kAllFlags) | dma::flags(kTimeStream, dma::kAllFlags));
    write32(dma::mux(kFirstOfDma2 + kPortStream), dma::kRequestTim5Compare1);
    write32(dma::mux(kFirstOfDma2 + kTimeStream), dma::kRequestTim5Compare2);
    write32(tim5::kDcr, tim5::burst(tim5::kCcr1, 2));
    if (!run(kToPort, kPort + gpio::kBsrr, address_of(buffers_.words.data()), kRing) ||
        !run(kToTimes, tim5::kDmar, address_of(buffers_.compare.data()), 2 * kRing)) {
        return false;
    }
    write32(tim5::kDier, kRequests);
    runs_ = true;
    return true;
}

std::uint32_t PowerStrobes::loaded() noexcept { return (2 * kRing - read32(kToTimes + dma::kNdtr) + 1) / 2 % kRing; }

std::uint32_t PowerStrobes::waiting() const noexcept { return (end_ + kRing - loaded()) % kRing; }

/// Behind the last one. Its compare values are the pair of the event before it.
bool PowerStrobes::put(std::int64_t ns, std::uint32_t word) noexcept {
    const std::uint32_t next = (end_ + 1) % kRing;
    if (ns < last_ns_ + kShortestNs || (runs_ && next == loaded())) {
        return false;
    }
    const std::uint32_t count = clock_.count_at(ns);
    const std::uint32_t before = (end_ + kRing - 1) % kRing;
    buffers_.words[end_] = word;
    buffers_.compare[end_] = {count - kBehind, count - kBehind};  // nothing follows yet
    barrier();
    buffers_.compare[before] = {count, count + kReloadCounts};
    barrier();
    end_ = next;
    last_ns_ = ns;
    return !runs_ || waiting() > kWaiting;
}

bool PowerStrobes::idle_until(std::int64_t ns) noexcept {
    while (last_ns_ + kIdleNs + kShortestNs <= ns) {
        if (!put(last_ns_ + kIdleNs, 0)) {
            return false;
        }
    }
    return true;
}

bool PowerStrobes::strobe(std::int64_t rise_ns, std::uint8_t byte) noexcept {
    byte_ = byte;
    return idle_until(rise_ns - setup_ns_) && put(rise_ns - setup_ns_, lay(byte)) && put(rise_ns, kLatch) &&
           put(rise_ns + width_ns_, kLatch << 16U);
}

bool PowerStrobes::lay_window(std::span<const LaserRun> runs, bool clear) noexcept {
    if (clear && byte_ != 0 && !strobe(window_ns_ + setup_ns_, 0)) {
        return false;
    }
    for (const LaserRun& run : runs) {
        if (run.latch_ns > 0 && !strobe(run.t0_ns - run.latch_ns, run.power)) {
            return false;
        }
    }
    return idle_until(window_ns_ + kWindowNs - kTailNs);
}

bool PowerStrobes::fill(std::span<const LaserRun> runs, bool clear) noexcept {
    const bool good = runs_ && lay_window(runs, clear);
    window_ns_ += kWindowNs;
    if (!good) {
        ++refused_;
        runs_ = false;
        write32(tim5::kDier, 0);
        write32(kPort + gpio::kBsrr, kLatch << 16U);
    }
    return good;
}

void PowerStrobes::cancel() noexcept {
    byte_ = kUnknown;
    (void)restart();
}

}  // namespace sc::stm32h743
