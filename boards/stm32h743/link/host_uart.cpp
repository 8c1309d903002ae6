// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/host_uart.hpp"

#include <algorithm>

#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/usart.hpp"

namespace sc::stm32h743 {
namespace {

constexpr Address kUart = usart::kUsart3;
constexpr unsigned kInStream = 2;
constexpr unsigned kOutStream = 3;
constexpr Address kInDma = dma::stream(kInStream);
constexpr Address kOutDma = dma::stream(kOutStream);
/// Flags of streams 0 to 3 lie in one register.
constexpr std::uint32_t kInFlagsAt = 16;
constexpr std::uint32_t kOutFlagsAt = 22;
constexpr std::uint32_t kFaults = dma::kTransferError | dma::kDirectError | dma::kFifoError;
constexpr std::uint32_t kInSettings = dma::kMemoryIncrement | dma::kCircular | usart::kBufferable;
constexpr std::uint32_t kOutSettings = dma::kMemoryIncrement | dma::kToPeripheral | usart::kBufferable;
constexpr std::uint32_t kLineErrors = usart::kFramingError | usart::kNoise | usart::kOverrun;
constexpr std::uint32_t kReads = 5000;

}  // namespace

HostUart::Start HostUart::start(std::uint32_t baud) noexcept {
    runs_ = false;
    if (baud < kSlowest || baud > kFastest) {
        return Start::bad_rate;
    }
    set_bits(usart::kAhb1enr, usart::kDma1Clock);
    set_bits(usart::kApb1lenr, usart::kUsart3Clock);
    (void)read32(usart::kApb1lenr);  // the clocks run when this has been read
    write32(kUart + usart::kCr1, 0);
    if (!stop_streams()) {
        return Start::stream_runs;
    }
    read_ = filling_ = filled_ = 0;
    write32(kUart + usart::kBrr, (kKernelHz + baud / 2) / baud);
    write32(kUart + usart::kCr2, 0);
    write32(kUart + usart::kCr3, usart::kDmaReceive | usart::kDmaTransmit);
    write32(kUart + usart::kIcr, kLineErrors | usart::kIdle | usart::kComplete);
    write32(dma::mux(kOutStream), usart::kRequestUsart3Tx);
    write32(kOutDma + dma::kPar, kUart + usart::kTdr);
    begin_receiving();
    write32(kUart + usart::kCr1, usart::kEnable | usart::kReceive | usart::kTransmit);
    if (!wait_for(kUart + usart::kIsr, usart::kTransmitReady | usart::kReceiveReady, true, kReads)) {
        return Start::silent;
    }
    runs_ = true;
    return Start::ok;
}

/// Registers of a stream may be written when it reads as stopped.
bool HostUart::stop_streams() noexcept {
    write32(kInDma + dma::kCr, 0);
    write32(kOutDma + dma::kCr, 0);
    if (!wait_for(kInDma + dma::kCr, dma::kEnable, false, kReads) ||
        !wait_for(kOutDma + dma::kCr, dma::kEnable, false, kReads)) {
        return false;
    }
    write32(dma::kLifcr, dma::kAllFlags << kInFlagsAt | dma::kAllFlags << kOutFlagsAt);
    return true;
}

void HostUart::begin_receiving() noexcept {
    write32(dma::mux(kInStream), usart::kRequestUsart3Rx);
    write32(kInDma + dma::kPar, kUart + usart::kRdr);
    write32(kInDma + dma::kM0ar, address_of(memory_.in.data()));
    write32(kInDma + dma::kNdtr, kIn);
    write32(kInDma + dma::kCr, kInSettings | dma::kVeryHigh);
    write32(kInDma + dma::kCr, kInSettings | dma::kVeryHigh | dma::kEnable);
}

void HostUart::use_interrupt() noexcept {
    write32(kUart + usart::kIcr, usart::kIdle);
    set_bits(kUart + usart::kCr1, usart::kIdleInterrupt);
}

bool HostUart::acknowledge() noexcept {
    const bool idle = (read32(kUart + usart::kIsr) & usart::kIdle) != 0;
    write32(kUart + usart::kIcr, usart::kIdle);
    return idle;
}

void HostUart::note_errors() noexcept {
    const std::uint32_t flags = read32(kUart + usart::kIsr) & kLineErrors;
    if (flags != 0) {
        write32(kUart + usart::kIcr, flags);
        counters_.overruns += (flags & usart::kOverrun) != 0 ? 1U : 0U;
        counters_.framing += (flags & usart::kFramingError) != 0 ? 1U : 0U;
        counters_.noise += (flags & usart::kNoise) != 0 ? 1U : 0U;
    }
    const std::uint32_t faults = read32(dma::kLisr) & (kFaults << kInFlagsAt | kFaults << kOutFlagsAt);
    if (faults != 0) {
        ++counters_.dma_errors;
        write32(dma::kLifcr, faults);
        if ((read32(kInDma + dma::kCr) & dma::kEnable) == 0) {  // an error stops the stream
            write32(dma::kLifcr, dma::kAllFlags << kInFlagsAt);
            read_ = 0;
            begin_receiving();
        }
    }
}

/// Where DMA writes next. The flag of a finished lap belongs to the place if the place has not gone back between two
/// readings of it.
std::size_t HostUart::arrived() noexcept {
    std::size_t place = (kIn - read32(kInDma + dma::kNdtr)) % kIn;
    bool lap = false;
    while (true) {
        lap = (read32(dma::kLisr) & (dma::kComplete << kInFlagsAt)) != 0;
        const std::size_t again = (kIn - read32(kInDma + dma::kNdtr)) % kIn;
        if (again >= place) {
            break;
        }
        place = again;
    }
    if (lap) {
        write32(dma::kLifcr, dma::kComplete << kInFlagsAt);
        if (place >= read_) {  // it has passed what is not read yet
            ++counters_.laps;
            read_ = place;
        }
    }
    barrier();
    return place;
}

std::size_t HostUart::receive(std::span<std::uint8_t> out) noexcept {
    if (!runs_) {
        return 0;
    }
    note_errors();
    const std::size_t place = arrived();
    std::size_t size = 0;
    while (read_ != place && size < out.size()) {
        out[size++] = memory_.in[read_];
        read_ = (read_ + 1) % kIn;
    }
    counters_.bytes_in += static_cast<std::uint32_t>(size);
    return size;
}

void HostUart::send(std::span<const std::uint8_t> bytes) noexcept {
    if (!runs_) {
        counters_.unsent += static_cast<std::uint32_t>(bytes.size());
        return;
    }
    flush();
    const std::size_t taken = std::min(bytes.size(), kOut - filled_);
    std::copy_n(bytes.begin(), taken, memory_.out[filling_].begin() + static_cast<std::ptrdiff_t>(filled_));
    filled_ += taken;
    counters_.unsent += static_cast<std::uint32_t>(bytes.size() - taken);
    flush();
}

/// The buffer that is filled goes out when the other has gone.
void HostUart::flush() noexcept {
    if (filled_ == 0 || (read32(kOutDma + dma::kCr) & dma::kEnable) != 0) {
        return;
    }
    write32(dma::kLifcr, dma::kAllFlags << kOutFlagsAt);
    write32(kOutDma + dma::kM0ar, address_of(memory_.out[filling_].data()));
    write32(kOutDma + dma::kNdtr, static_cast<std::uint32_t>(filled_));
    barrier();
    write32(kOutDma + dma::kCr, kOutSettings);
    write32(kOutDma + dma::kCr, kOutSettings | dma::kEnable);
    counters_.bytes_out += static_cast<std::uint32_t>(filled_);
    filling_ = 1 - filling_;
    filled_ = 0;
}

}  // namespace sc::stm32h743
