// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// The clock tree, on one page. Whoever needs a frequency takes it from here.
///
///     HSE 8 MHz (MCO of the ST-Link) ─┬─ PLL1: 4 MHz x 240 = 960 MHz, P/2 ─ core 480 ─ /2 ─ AXI, AHB 240 ─ /2 ─ APB
///     120
///                                     │                                                      timers 240, USART 120
///                                     └─ PLL2: 4 MHz x 160 = 640 MHz, Q/8 ─ FDCAN 80
///
/// 480 MHz needs the core voltage scale VOS0 (scale 1 and overdrive) and a chip of revision V. Without one of these,
/// or without HSE, the chip stays on HSI with the same dividers (kSlow). Limits: data sheet, sections General operating
/// conditions and PLL characteristics; wait states: reference manual, section Read access latency.

namespace sc::stm32h743 {

inline constexpr std::uint32_t kMhz = 1'000'000;
inline constexpr std::uint32_t kHseHz = 8 * kMhz;
inline constexpr std::uint32_t kHsiHz = 64 * kMhz;

/// Frequency = source / m · n / p (q, r). The fraction is not used.
struct Pll {
    std::uint32_t m, n, p, q, r;
    [[nodiscard]] constexpr std::uint32_t reference_hz() const noexcept { return kHseHz / m; }
    [[nodiscard]] constexpr std::uint32_t vco_hz() const noexcept { return reference_hz() * n; }
    /// As PLLCFGR names the range of the reference: 0 from 1, 1 from 2, 2 from 4, 3 from 8 MHz.
    [[nodiscard]] constexpr std::uint32_t range() const noexcept {
        const std::uint32_t mhz = reference_hz() / kMhz;
        return mhz >= 8 ? 3 : mhz >= 4 ? 2 : mhz >= 2 ? 1 : 0;
    }
};

inline constexpr Pll kPll1{.m = 2, .n = 240, .p = 2, .q = 8, .r = 8};  ///< P alone is let out
inline constexpr Pll kPll2{.m = 2, .n = 160, .p = 8, .q = 8, .r = 8};  ///< Q alone is let out
inline constexpr std::uint32_t kHclkDivider = 2;
inline constexpr std::uint32_t kApbDivider = 2;  ///< of each of the four

struct Frequencies {
    std::uint32_t core_hz;
    std::uint32_t hclk_hz;   ///< AXI, AHB, flash
    std::uint32_t apb_hz;    ///< each APB, and the kernel clock of every USART
    std::uint32_t timer_hz;  ///< twice the APB, as its divider is not 1
    std::uint32_t fdcan_hz;  ///< 0: none
};

[[nodiscard]] constexpr Frequencies divided(std::uint32_t core_hz, std::uint32_t fdcan_hz) noexcept {
    const std::uint32_t hclk = core_hz / kHclkDivider;
    return {core_hz, hclk, hclk / kApbDivider, hclk / kApbDivider * 2, fdcan_hz};
}
inline constexpr Frequencies kFast = divided(kPll1.vco_hz() / kPll1.p, kPll2.vco_hz() / kPll2.q);
inline constexpr Frequencies kSlow = divided(kHsiHz, 0);

/// Wait states of the flash, and the delay of its programming signals, at VOS0.
struct FlashTiming {
    std::uint32_t wait_states;
    std::uint32_t write_delay;
};
[[nodiscard]] constexpr FlashTiming flash_timing(std::uint32_t hclk_hz) noexcept {
    const std::uint32_t mhz = (hclk_hz + kMhz - 1) / kMhz;
    if (mhz <= 70) {
        return {0, 0};
    }
    if (mhz <= 140) {
        return {1, 1};
    }
    if (mhz <= 210) {
        return {2, mhz <= 185 ? 1U : 2U};
    }
    return {mhz <= 225 ? 3U : 4U, 2};
}
inline constexpr FlashTiming kFlashTiming = flash_timing(kFast.hclk_hz);

/// First revision that runs at VOS0 (V), as DBGMCU names it.
inline constexpr std::uint32_t kFirstFastRevision = 0x2003;

// Limits at VOS0.
[[nodiscard]] constexpr bool possible(const Pll& pll) noexcept {
    return pll.m >= 1 && pll.m <= 63 && pll.n >= 4 && pll.n <= 512 && pll.p % 2 == 0 && pll.p <= 128 && pll.q <= 128 &&
           pll.r <= 128 && kHseHz % pll.m == 0 && pll.reference_hz() >= 2 * kMhz && pll.reference_hz() <= 16 * kMhz &&
           pll.vco_hz() >= 192 * kMhz && pll.vco_hz() <= 960 * kMhz;
}
static_assert(possible(kPll1) && possible(kPll2));
static_assert(kFast.core_hz == 480 * kMhz, "the most that VOS0 allows");
static_assert(kFast.hclk_hz <= 240 * kMhz && kFast.apb_hz <= 120 * kMhz && kFast.timer_hz <= 240 * kMhz);
static_assert(kFast.timer_hz == 240 * kMhz, "waveforms count in it");
static_assert(kFast.fdcan_hz == 80 * kMhz, "bit times are whole multiples of 12.5 ns");
static_assert(kFast.fdcan_hz <= kFast.apb_hz, "a kernel clock of an FDCAN is no faster than its APB");
static_assert(kFlashTiming.wait_states == 4 && kFlashTiming.write_delay == 2 && kFast.hclk_hz <= 240 * kMhz);
// Before the voltage has risen, at VOS3: core 200, AHB 100, APB 50 MHz.
static_assert(kSlow.core_hz <= 200 * kMhz && kSlow.hclk_hz <= 100 * kMhz && kSlow.apb_hz <= 50 * kMhz);

}  // namespace sc::stm32h743
