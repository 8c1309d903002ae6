// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/gate_wave.hpp"

#include <initializer_list>

#include "boards/stm32h743/registers/advanced_timer.hpp"
#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::uint32_t kGatePin = 9;
constexpr std::uint32_t kTriggerPin = 13;
constexpr std::uint32_t kBreakPin = 15;
constexpr std::uint32_t kTimerFunction = 1;
constexpr Address kStream = dma::stream2(0);
constexpr std::uint32_t kRing = kRingSegments;
constexpr std::uint32_t kWords = kSegmentWords;
constexpr std::uint32_t kRingWords = kRing * kWords;
constexpr std::uint32_t kSettings = dma::kToPeripheral | dma::kCircular | dma::kMemoryIncrement | dma::kPeripheralWord |
                                    dma::kMemoryWord | dma::kVeryHigh;
constexpr std::uint32_t kStopReads = 100;
/// Darkness behind the end: what is loaded ahead of it, and room between the end and what plays.
constexpr std::uint32_t kStops = 4;
constexpr std::uint32_t kRoom = 8;
/// 18 s in one segment. Its count never reaches kNoCount.
constexpr Segment kStop{kNoCount - 1, 0xFFFF, 0, kNoCount, 0};
constexpr std::uint32_t kOff = tim1::kBreakEnable | tim1::kOffIdle | tim1::kOffRun | tim1::kLockFirst;
/// Loaded ahead of what the stream reads: one plays, one waits in the preload registers, one may be on its way.
constexpr std::uint32_t kLoaded = 3;

constexpr std::uint32_t ring(std::uint32_t at) { return at % kRing; }
constexpr std::uint32_t distance(std::uint32_t from, std::uint32_t to) { return ring(to + kRing - from); }

void load(const Segment& segment) noexcept {
    write32(tim1::kArr, segment.reload);
    write32(tim1::kRcr, segment.repeats);
    write32(tim1::kCcr1, segment.gate_until);
    write32(tim1::kCcr2, segment.gate_from);
    write32(tim1::kCcr3, segment.trigger);
}

}  // namespace

/// Segment that the stream reads next; one that it has begun counts as read.
std::uint32_t GateWave::position() noexcept {
    const std::uint32_t left = read32(kStream + dma::kNdtr);
    return ring((kRingWords - left + kWords - 1) / kWords);
}

/// The stream has read beyond the end.
bool GateWave::dry(std::uint32_t position) const noexcept { return distance(position, end_) >= kRing - kStops; }

void GateWave::put_stop(std::uint32_t at) noexcept {
    for (std::uint32_t i = 0; i < kStops; ++i) {
        buffers_.ring[ring(at + i)] = kStop;
    }
}

/// The timer holds both low before the pins are its own.
void GateWave::set_up_outputs() noexcept {
    write32(tim1::kCr2, 0);
    write32(tim1::kAf1, tim1::kBreakInput);
    write32(tim1::kBdtr, kOff);
    write32(tim1::kCcmr1, tim1::first_mode(tim1::kCombinedPwm1) | tim1::kFirstPreload | tim1::second_mode(tim1::kPwm2) |
                              tim1::kSecondPreload);
    write32(tim1::kCcmr2, tim1::first_mode(tim1::kPwm1) | tim1::kFirstPreload);
    write32(tim1::kCcer, tim1::kChannel1 | tim1::kChannel3);
    for (const std::uint32_t pin : {kGatePin, kTriggerPin, kBreakPin}) {
        const std::uint32_t both = 3U << (2U * pin);
        const std::uint32_t place = 4U * (pin - 8U);
        clear_bits(optics_port::kOtyper, 1U << pin);
        change_bits(optics_port::kOspeedr, both, both);
        change_bits(optics_port::kPupdr, both, 2U << (2U * pin));  // down
        change_bits(optics_port::kAfrh, 15U << place, kTimerFunction << place);
        change_bits(optics_port::kModer, both, 2U << (2U * pin));
    }
}

bool GateWave::start(std::int64_t origin_ns) noexcept {
    set_bits(optics_port::kAhb1enr, optics_port::kDma2Clock);
    set_bits(optics_port::kAhb2enr, optics_port::kSram2Clock);
    set_bits(optics_port::kAhb4enr, optics_port::kGpioEClock);
    set_bits(optics_port::kApb2enr, optics_port::kTim1Clock);
    (void)read32(optics_port::kApb2enr);  // a clock is there two cycles behind its bit

    runs_ = false;
    clear_bits(tim1::kBdtr, tim1::kMainOutput);  // not yet the lock
    write32(tim1::kCr1, 0);
    write32(tim1::kDier, 0);
    clear_bits(kStream + dma::kCr, dma::kEnable);
    if (!wait_for(kStream + dma::kCr, dma::kEnable, false, kStopReads)) {
        return false;
    }
    segments_.begin(origin_ns);
    window_end_ns_ = origin_ns + kWindowNs;
    const Segment first = segments_.next(window_end_ns_ - kTailNs).value_or(kStop);
    const Segment second = segments_.next(window_end_ns_ - kTailNs).value_or(kStop);
    std::uint32_t end = 0;
    while (const std::optional<Segment> segment = segments_.next(window_end_ns_ - kTailNs)) {
        buffers_.ring[end] = *segment;
        ++end;
    }
    put_stop(end);
    end_ = end;
    cancelled_ = false;
    barrier();

    write32(tim1::kCr1, tim1::kReloadPreload);
    set_up_outputs();
    write32(tim1::kPsc, 0);
    load(first);
    write32(tim1::kEgr, tim1::kGenerateUpdate);  // the first one plays, and the preload registers are free again
    load(second);
    write32(tim1::kSr, 0);

    write32(dma::kLifcr2, dma::kAllFlags);
    write32(dma::mux(8), dma::kRequestTim1Update);
    write32(kStream + dma::kPar, tim1::kDmar);
    write32(kStream + dma::kM0ar, address_of(buffers_.ring.data()));
    write32(kStream + dma::kNdtr, kRingWords);
    write32(kStream + dma::kFcr, 0);
    write32(kStream + dma::kCr, kSettings);
    set_bits(kStream + dma::kCr, dma::kEnable);
    if ((read32(kStream + dma::kCr) & dma::kEnable) == 0) {
        return false;
    }
    write32(tim1::kDcr, tim1::burst(tim1::kArr, kWords));
    write32(tim1::kDier, tim1::kUpdateDma);
    write32(tim1::kCr1, tim1::kCounterEnable | tim1::kReloadPreload);
    runs_ = true;
    return true;
}

bool GateWave::fill(std::span<const LaserRun> runs) noexcept {
    const std::uint32_t before = position();
    if (!runs_ || dry(before)) {
        fail();
        return false;
    }
    for (const LaserRun& run : runs) {
        overflows_ += segments_.add(run) ? 0U : run.count;
    }
    window_end_ns_ += kWindowNs;
    const std::uint32_t begin = end_;
    const std::uint32_t ahead = distance(before, begin);
    std::uint32_t room = kRing - kRoom - ahead;
    const std::optional<Segment> first = segments_.next(window_end_ns_ - kTailNs);
    std::uint32_t end = begin;
    for (std::optional<Segment> segment = first; segment; segment = segments_.next(window_end_ns_ - kTailNs)) {
        if (room == 0) {
            fail();
            return false;
        }
        --room;
        if (end != begin) {
            buffers_.ring[end] = *segment;
        }
        end = ring(end + 1);
    }
    // The darkness at the old end goes last: a stream that is there before all is written finds it.
    if (end != begin) {
        put_stop(end);
        barrier();
        buffers_.ring[begin] = *first;
    }
    barrier();
    // The stream reads a word ahead: of the segment that comes next, it has the first one.
    if (distance(before, position()) >= ahead) {
        fail();
        return false;
    }
    end_ = end;
    return true;
}

void GateWave::shut() noexcept { write32(tim1::kBdtr, kOff); }

void GateWave::fail() noexcept {
    shut();
    failures_ += runs_.exchange(false) ? 1U : 0U;
}

void GateWave::cancel() noexcept {
    shut();
    segments_.drop();
    const std::uint32_t from = position();
    for (std::uint32_t at = from; at != end_; at = ring(at + 1)) {
        Segment& segment = buffers_.ring[at];
        segment.gate_until = 0;
        segment.gate_from = kNoCount;
        segment.trigger = 0;
    }
    barrier();
    cancelled_at_ = position();
    cancelled_ = true;
}

bool GateWave::arm() noexcept {
    (void)check();
    if (!runs_) {
        return false;
    }
    if (cancelled_ && distance(cancelled_at_, position()) < kLoaded) {
        return false;
    }
    cancelled_ = false;
    write32(tim1::kSr, ~tim1::kBreakFlag);
    if (broken()) {
        return false;  // the input is still active
    }
    write32(tim1::kBdtr, kOff | tim1::kMainOutput);
    return (read32(tim1::kBdtr) & tim1::kMainOutput) != 0;
}

bool GateWave::check() noexcept {
    if (!runs_ || (read32(dma::kLisr2) & dma::kTransferError) != 0 || dry(position())) {
        fail();
        return false;
    }
    return (read32(tim1::kBdtr) & tim1::kMainOutput) != 0;
}

bool GateWave::broken() noexcept { return (read32(tim1::kSr) & tim1::kBreakFlag) != 0; }

}  // namespace sc::stm32h743
