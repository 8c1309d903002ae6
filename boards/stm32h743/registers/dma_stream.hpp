// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// DMA1 and the request multiplexer before it (reference manual, sections DMA and DMAMUX). DMA1 and DMA2 reach AXI SRAM
/// and SRAM1 to SRAM3, not the tightly coupled memories.

namespace sc::stm32h743::dma {

inline constexpr Address kDma1 = 0x40020000;
inline constexpr Address kMux1 = 0x40020800;

inline constexpr Address kDma2 = 0x40020400;

/// Flags of streams 0 to 3 and where they are cleared.
inline constexpr Address kLisr = kDma1 + 0x00;
inline constexpr Address kLifcr = kDma1 + 0x08;
inline constexpr Address kLisr2 = kDma2 + 0x00;
inline constexpr Address kLifcr2 = kDma2 + 0x08;
/// Of stream 0, in all.
inline constexpr std::uint32_t kFifoError = 1U << 0U;
inline constexpr std::uint32_t kDirectError = 1U << 2U;
inline constexpr std::uint32_t kTransferError = 1U << 3U;
inline constexpr std::uint32_t kHalf = 1U << 4U;
inline constexpr std::uint32_t kComplete = 1U << 5U;
inline constexpr std::uint32_t kAllFlags = kFifoError | kDirectError | kTransferError | kHalf | kComplete;

/// Where the flags of streams 0 to 3 are in LISR and LIFCR.
[[nodiscard]] constexpr std::uint32_t flags(unsigned n, std::uint32_t of_stream_0) noexcept {
    return of_stream_0 << (n * 6U + (n >= 2 ? 4U : 0U));
}

[[nodiscard]] constexpr Address stream(unsigned n) noexcept { return kDma1 + 0x10 + 0x18 * n; }
[[nodiscard]] constexpr Address stream2(unsigned n) noexcept { return kDma2 + 0x10 + 0x18 * n; }
inline constexpr Address kCr = 0x00;
inline constexpr Address kNdtr = 0x04;
inline constexpr Address kPar = 0x08;
inline constexpr Address kM0ar = 0x0C;
inline constexpr Address kM1ar = 0x10;
inline constexpr Address kFcr = 0x14;

inline constexpr std::uint32_t kEnable = 1U << 0U;
inline constexpr std::uint32_t kDirectErrorInterrupt = 1U << 1U;
inline constexpr std::uint32_t kTransferErrorInterrupt = 1U << 2U;
inline constexpr std::uint32_t kCompleteInterrupt = 1U << 4U;
inline constexpr std::uint32_t kToPeripheral = 1U << 6U;
inline constexpr std::uint32_t kCircular = 1U << 8U;
inline constexpr std::uint32_t kMemoryIncrement = 1U << 10U;
inline constexpr std::uint32_t kPeripheralWord = 2U << 11U;
inline constexpr std::uint32_t kMemoryWord = 2U << 13U;
inline constexpr std::uint32_t kVeryHigh = 3U << 16U;
inline constexpr std::uint32_t kDoubleBuffer = 1U << 18U;
inline constexpr std::uint32_t kCurrentTarget = 1U << 19U;

/// Streams of DMA1 have channels 0 to 7, those of DMA2 8 to 15.
[[nodiscard]] constexpr Address mux(unsigned channel) noexcept { return kMux1 + 4 * channel; }
inline constexpr std::uint32_t kRequestTim1Update = 15;
inline constexpr std::uint32_t kRequestTim5Compare1 = 55;
inline constexpr std::uint32_t kRequestTim5Compare2 = 56;
inline constexpr std::uint32_t kRequestSpi3Rx = 61;
inline constexpr std::uint32_t kRequestTim6Update = 69;

}  // namespace sc::stm32h743::dma
