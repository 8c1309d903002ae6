// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/galvo_status.hpp"

#include <initializer_list>

#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/gpio.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"
#include "boards/stm32h743/registers/spi.hpp"

namespace sc::stm32h743 {
namespace {

constexpr Address kPort = gpio::base(gpio::Port::c);
constexpr std::uint32_t kFunction = 6;
constexpr unsigned kStreamNumber = 1;
constexpr Address kStream = dma::stream(kStreamNumber);
constexpr std::uint32_t kSettings = dma::kCircular | dma::kMemoryIncrement | dma::kPeripheralWord | dma::kMemoryWord;
constexpr std::uint32_t kStopReads = 100;
constexpr std::uint32_t kBits = 20;
constexpr std::uint32_t kConfig = spi3::word_bits(kBits) | spi3::kReceiveDma;
constexpr std::uint32_t kMode = spi3::kReceiveOnly | spi3::kSoftwareSelect;

std::size_t place() noexcept { return (kStatusWords - read32(kStream + dma::kNdtr)) % kStatusWords; }

}  // namespace

bool GalvoStatus::start() noexcept {
    set_bits(optics_port::kAhb1enr, optics_port::kDma1Clock);
    set_bits(optics_port::kAhb2enr, optics_port::kSram1Clock);
    set_bits(gpio::kAhb4enr, gpio::clock(gpio::Port::c));
    set_bits(spi3::kApb1lenr, spi3::kClock);
    (void)read32(spi3::kApb1lenr);  // a clock is there two cycles behind its bit
    write32(spi3::kCr1, 0);
    clear_bits(kStream + dma::kCr, dma::kEnable);
    if (!wait_for(kStream + dma::kCr, dma::kEnable, false, kStopReads)) {
        return false;
    }
    for (const std::uint32_t pin : {10U, 12U}) {
        change_bits(kPort + gpio::kPupdr, 3U << (2 * pin), gpio::kPullDown << (2 * pin));
        change_bits(kPort + gpio::kAfrh, 15U << (4 * (pin - 8)), kFunction << (4 * (pin - 8)));
        change_bits(kPort + gpio::kModer, 3U << (2 * pin), gpio::kAlternate << (2 * pin));
    }
    buffer_.words = {};
    seen_ = 0;
    barrier();
    write32(dma::kLifcr, dma::flags(kStreamNumber, dma::kAllFlags));
    write32(dma::mux(kStreamNumber), dma::kRequestSpi3Rx);
    write32(kStream + dma::kPar, spi3::kRxdr);
    write32(kStream + dma::kM0ar, address_of(buffer_.words.data()));
    write32(kStream + dma::kNdtr, kStatusWords);
    write32(kStream + dma::kFcr, 0);
    write32(kStream + dma::kCr, kSettings);
    set_bits(kStream + dma::kCr, dma::kEnable);
    write32(spi3::kCfg1, kConfig);
    write32(spi3::kCfg2, kMode);
    write32(spi3::kIfcr, spi3::kOverrun);
    write32(spi3::kCr1, spi3::kEnable);
    return (read32(kStream + dma::kCr) & dma::kEnable) != 0 && read32(spi3::kCfg1) == kConfig &&
           read32(spi3::kCfg2) == kMode && (read32(spi3::kCr1) & spi3::kEnable) != 0;
}

std::uint16_t GalvoStatus::word() noexcept {
    const std::size_t at = place();
    if ((read32(spi3::kSr) & spi3::kOverrun) != 0) {
        write32(spi3::kIfcr, spi3::kOverrun);
        ++overruns_;
        seen_ = at;
        return 0;
    }
    if (at == seen_) {
        return 0;
    }
    seen_ = at;
    const std::uint32_t newest = buffer_.words[(at + kStatusWords - 1) % kStatusWords];
    return static_cast<std::uint16_t>(newest >> 1U);
}

}  // namespace sc::stm32h743
