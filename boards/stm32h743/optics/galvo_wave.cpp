// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/galvo_wave.hpp"

#include <utility>

#include "boards/stm32h743/registers/basic_timer.hpp"
#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::uint32_t kClockPin = 2;
constexpr std::uint32_t kSyncPin = 3;
constexpr std::uint32_t kXPin = 4;
constexpr std::uint32_t kZPin = 5;
constexpr std::uint32_t kTimerTicks = 60;  // 240 MHz / 4 MHz
constexpr Address kStream = dma::stream(0);
constexpr std::uint32_t kSettings = dma::kToPeripheral | dma::kCircular | dma::kMemoryIncrement | dma::kPeripheralWord |
                                    dma::kMemoryWord | dma::kVeryHigh | dma::kDoubleBuffer | dma::kCompleteInterrupt |
                                    dma::kTransferErrorInterrupt | dma::kDirectErrorInterrupt;
constexpr std::uint32_t kDeadlineWords = GalvoWave::kDeadlineNs / GalvoWave::kWordNs;
/// A stream that is told to stop ends its transfer first, some 100 ns.
constexpr std::uint32_t kStopReads = 100;

constexpr std::uint32_t set(std::uint32_t pin) { return 1U << pin; }
constexpr std::uint32_t reset(std::uint32_t pin) { return 1U << (pin + 16U); }
constexpr std::uint32_t level(std::uint32_t pin, std::uint32_t bit) { return bit != 0 ? set(pin) : reset(pin); }
constexpr std::uint32_t kFalls = reset(kClockPin);
/// The rising clock with bits x (bit 0) and z (bit 1), sync high.
constexpr std::array<std::uint32_t, 4> rising() {
    std::array<std::uint32_t, 4> words{};
    for (std::uint32_t i = 0; i < 4; ++i) {
        words[i] = set(kClockPin) | set(kSyncPin) | level(kXPin, i & 1U) | level(kZPin, i & 2U);
    }
    return words;
}
constexpr std::array<std::uint32_t, 4> kRises = rising();
constexpr std::uint32_t kSyncLow = set(kSyncPin) | reset(kSyncPin);

/// Writes both bits of a pin as they must be before the DMA takes over: all lines low, fast push-pull outputs.
void set_up_pins() noexcept {
    write32(optics_port::kBsrr, reset(kClockPin) | reset(kSyncPin) | reset(kXPin) | reset(kZPin));
    std::uint32_t both = 0;
    std::uint32_t single = 0;
    for (const std::uint32_t pin : {kClockPin, kSyncPin, kXPin, kZPin}) {
        both |= 3U << (2U * pin);
        single |= 1U << (2U * pin);
        clear_bits(optics_port::kOtyper, 1U << pin);
    }
    change_bits(optics_port::kOspeedr, both, both);
    change_bits(optics_port::kModer, both, single);
}

}  // namespace

unsigned GalvoWave::playing() noexcept { return (read32(kStream + dma::kCr) & dma::kCurrentTarget) != 0 ? 1 : 0; }

void GalvoWave::put(std::size_t buffer, std::size_t frame, Words words) noexcept {
    std::uint32_t* out = &buffers_.words[buffer][frame * kGalvoBits * 2];
    for (std::size_t left = kGalvoBits; left > 0; --left, out += 2) {
        const std::uint32_t x = (words.x >> (left - 1)) & 1U;
        const std::uint32_t z = (words.z >> (left - 1)) & 1U;
        const std::uint32_t rise = kRises[x | (z << 1U)];
        out[0] = left == 1 ? rise ^ kSyncLow : rise;
    }
}

void GalvoWave::repeat(std::size_t buffer, Words words) noexcept {
    put(buffer, 0, words);
    std::array<std::uint32_t, kGalvoBufferWords>& out = buffers_.words[buffer];
    for (std::size_t i = kGalvoBits * 2; i < out.size(); i += 2) {
        out[i] = out[i - kGalvoBits * 2];
    }
    last_[buffer] = words;
}

bool GalvoWave::start(std::uint32_t word_x, std::uint32_t word_z) noexcept {
    set_bits(optics_port::kAhb1enr, optics_port::kDma1Clock);
    set_bits(optics_port::kAhb2enr, optics_port::kSram1Clock);
    set_bits(optics_port::kAhb4enr, optics_port::kGpioEClock);
    set_bits(optics_port::kApb1lenr, optics_port::kTim6Clock);
    (void)read32(optics_port::kApb1lenr);  // a clock is there two cycles behind its bit

    write32(tim6::kCr1, 0);
    write32(tim6::kDier, 0);
    clear_bits(kStream + dma::kCr, dma::kEnable);
    if (!wait_for(kStream + dma::kCr, dma::kEnable, false, kStopReads)) {
        return false;
    }
    for (std::size_t buffer = 0; buffer < buffers_.words.size(); ++buffer) {
        for (std::size_t i = 1; i < kGalvoBufferWords; i += 2) {
            buffers_.words[buffer][i] = kFalls;
        }
        repeat(buffer, {word_x, word_z});
    }
    barrier();
    set_up_pins();

    with_dma_ = {0, 1};
    free_ = 2;
    played_ = 0;
    next_ = Next::open;
    shut_ = true;
    write32(dma::kLifcr, dma::kAllFlags);
    write32(dma::mux(0), dma::kRequestTim6Update);
    write32(kStream + dma::kPar, optics_port::kBsrr);
    write32(kStream + dma::kM0ar, address_of(buffers_.words[0].data()));
    write32(kStream + dma::kM1ar, address_of(buffers_.words[1].data()));
    write32(kStream + dma::kNdtr, kGalvoBufferWords);
    write32(kStream + dma::kFcr, 0);
    write32(kStream + dma::kCr, kSettings);
    set_bits(kStream + dma::kCr, dma::kEnable);
    if ((read32(kStream + dma::kCr) & dma::kEnable) == 0) {
        return false;
    }

    write32(tim6::kPsc, 0);
    write32(tim6::kArr, kTimerTicks - 1);
    write32(tim6::kEgr, tim6::kGenerateUpdate);  // before it may ask: each request is a word
    write32(tim6::kSr, 0);
    write32(tim6::kDier, tim6::kUpdateDma);
    write32(tim6::kCr1, tim6::kCounterEnable | tim6::kPreload);
    return true;
}

bool GalvoWave::fill(std::span<const GalvoFrame, kGalvoFramesPerTick> frames) noexcept {
    const std::uint32_t turn = turn_;
    if (next_ != Next::open) {
        return false;
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
        put(free_, i, {frames[i].word_x, frames[i].word_z});
    }
    last_[free_] = {frames.back().word_x, frames.back().word_z};
    barrier();
    if (next_ != Next::open || turn_ != turn) {
        return false;
    }
    const unsigned coming = 1 - playing();
    write32(kStream + (coming == 0 ? dma::kM0ar : dma::kM1ar), address_of(buffers_.words[free_].data()));
    std::swap(free_, with_dma_[coming]);
    next_ = Next::filled;
    return true;
}

bool GalvoWave::check() noexcept {
    // In this order: a swap between the two leaves many words to go, and nothing is done.
    const unsigned now = playing();
    const std::uint32_t words = read32(kStream + dma::kNdtr);
    if (next_ == Next::open && words <= kDeadlineWords) {
        repeat(with_dma_[1 - now], last_[with_dma_[now]]);
        barrier();
        next_ = Next::repeats;
        shut_ = true;
        ++underruns_;
    }
    return !shut_;
}

bool GalvoWave::swapped() noexcept {
    const std::uint32_t flags = read32(dma::kLisr) & dma::kAllFlags;
    write32(dma::kLifcr, flags);
    const unsigned now = playing();
    const bool failed = (flags & (dma::kTransferError | dma::kDirectError)) != 0 || now == played_;
    errors_ += failed ? 1U : 0U;
    played_ = now;
    const Next held = next_.exchange(Next::open);
    underruns_ += held == Next::open ? 1U : 0U;
    shut_ = failed || held != Next::filled;
    ++turn_;
    return !failed && held != Next::open;
}

}  // namespace sc::stm32h743
