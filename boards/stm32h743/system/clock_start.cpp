// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/clock_start.hpp"

#include "boards/stm32h743/registers/clock_power.hpp"

namespace sc::stm32h743 {
namespace {

// Bounds in reads. Each takes some 10 bus cycles on HSI, 150 ns or more.
constexpr std::uint32_t kSwitchReads = 10'000;
constexpr std::uint32_t kVoltageReads = 100'000;  ///< 15 ms; the regulator takes less than 1 ms
constexpr std::uint32_t kLockReads = 100'000;     ///< a PLL locks within 0.15 ms
constexpr std::uint32_t kHseReads = 4'000'000;    ///< the ST-Link may start later than this chip

/// The field under `mask` becomes `value`, which is in place.
bool becomes(Address at, std::uint32_t mask, std::uint32_t value, std::uint32_t most) noexcept {
    for (std::uint32_t i = 0; i < most; ++i) {
        if ((read32(at) & mask) == value) {
            return true;
        }
    }
    return false;
}

bool take(std::uint32_t source) noexcept {
    change_bits(rcc::kCfgr, rcc::kSwitch, source);
    return becomes(rcc::kCfgr, rcc::kSwitchState, source << rcc::kSwitchStateShift, kSwitchReads);
}

/// The core on HSI, both PLLs off: only then may they be set.
bool fall_back() noexcept {
    set_bits(rcc::kCr, rcc::kHsiOn);
    if (!wait_for(rcc::kCr, rcc::kHsiReady, true, kSwitchReads)) {
        return false;
    }
    if (!take(rcc::kFromHsi)) {
        return false;
    }
    clear_bits(rcc::kCr, rcc::kPll1On | rcc::kPll2On);
    return wait_for(rcc::kCr, rcc::kPll1Ready | rcc::kPll2Ready, false, kSwitchReads);
}

/// For the fast clock already: on a slow one they cost time alone.
bool set_wait_states() noexcept {
    namespace neighbours = clock_neighbours;
    const std::uint32_t value = kFlashTiming.wait_states | kFlashTiming.write_delay << neighbours::kWriteDelayShift;
    change_bits(neighbours::kFlashAcr, neighbours::kLatency | neighbours::kWriteDelay, value);
    return becomes(neighbours::kFlashAcr, neighbours::kLatency | neighbours::kWriteDelay, value, kSwitchReads);
}

void set_dividers() noexcept {
    constexpr std::uint32_t kHalf = 4;      // of an APB
    constexpr std::uint32_t kHclkHalf = 8;  // HPRE
    static_assert(kHclkDivider == 2 && kApbDivider == 2);
    change_bits(rcc::kD1cfgr, rcc::kHpre | rcc::kD1ppre | rcc::kD1cpre, kHclkHalf | kHalf << 4U);
    change_bits(rcc::kD2cfgr, rcc::kD2ppre1 | rcc::kD2ppre2, kHalf << 4U | kHalf << 8U);
    change_bits(rcc::kD3cfgr, rcc::kD3ppre, kHalf << 4U);
    clear_bits(rcc::kCfgr, rcc::kTimerPrescaler);
}

/// Takes effect once after power comes; a later reset finds it so.
bool supply_from_ldo() noexcept {
    constexpr std::uint32_t kAll = pwr::kBypass | pwr::kLdoOn | pwr::kUpdateOpen;
    if ((read32(pwr::kCr3) & pwr::kUpdateOpen) != 0) {
        change_bits(pwr::kCr3, kAll, pwr::kLdoOn);
    }
    return (read32(pwr::kCr3) & (pwr::kBypass | pwr::kLdoOn)) == pwr::kLdoOn &&
           wait_for(pwr::kCsr1, pwr::kActualReady, true, kVoltageReads);
}

bool to_scale1() noexcept {
    change_bits(pwr::kD3cr, pwr::kScale, pwr::kScale1);
    return wait_for(pwr::kD3cr, pwr::kScaleReady, true, kVoltageReads);
}

bool to_scale0() noexcept {
    namespace neighbours = clock_neighbours;
    set_bits(rcc::kApb4enr, rcc::kSyscfgEn);
    (void)read32(rcc::kApb4enr);  // the clock is there two cycles later
    set_bits(neighbours::kSyscfgPwrcr, neighbours::kOverdrive);
    return wait_for(pwr::kD3cr, pwr::kScaleReady, true, kVoltageReads);
}

bool start_hse() noexcept {
    if ((read32(rcc::kCr) & (rcc::kHseBypass | rcc::kHseReady)) == (rcc::kHseBypass | rcc::kHseReady)) {
        return true;
    }
    clear_bits(rcc::kCr, rcc::kHseOn);
    if (!wait_for(rcc::kCr, rcc::kHseReady, false, kSwitchReads)) {
        return false;
    }
    set_bits(rcc::kCr, rcc::kHseBypass);
    set_bits(rcc::kCr, rcc::kHseOn);
    return wait_for(rcc::kCr, rcc::kHseReady, true, kHseReads);
}

constexpr std::uint32_t factors(const Pll& pll) noexcept {
    return (pll.n - 1) | (pll.p - 1) << 9U | (pll.q - 1) << 16U | (pll.r - 1) << 24U;
}

void set_plls() noexcept {
    change_bits(rcc::kPllckselr, rcc::kPllSource | rcc::kDivm1 | rcc::kDivm2,
                rcc::kPllFromHse | kPll1.m << 4U | kPll2.m << 12U);
    constexpr std::uint32_t kOurs = rcc::kPll1Fraction | rcc::kPll1Medium | rcc::kPll1Range | rcc::kPll2Fraction |
                                    rcc::kPll2Medium | rcc::kPll2Range | rcc::kDivp1En | rcc::kDivq1En | rcc::kDivr1En |
                                    rcc::kDivp2En | rcc::kDivq2En | rcc::kDivr2En;
    change_bits(rcc::kPllcfgr, kOurs, kPll1.range() << 2U | kPll2.range() << 6U | rcc::kDivp1En | rcc::kDivq2En);
    constexpr std::uint32_t kAll = rcc::kDivn | rcc::kDivp | rcc::kDivq | rcc::kDivr;
    change_bits(rcc::kPll1divr, kAll, factors(kPll1));
    change_bits(rcc::kPll2divr, kAll, factors(kPll2));
}

ClockFault speed_up() noexcept {
    if (read32(clock_neighbours::kIdCode) >> clock_neighbours::kRevisionShift < kFirstFastRevision) {
        return ClockFault::old_revision;
    }
    if (!supply_from_ldo()) {
        return ClockFault::supply;
    }
    if (!to_scale1()) {
        return ClockFault::scale1;
    }
    if (!to_scale0()) {
        return ClockFault::scale0;
    }
    if (!start_hse()) {
        return ClockFault::no_hse;
    }
    set_plls();
    set_bits(rcc::kCr, rcc::kPll1On | rcc::kPll2On);
    if (!wait_for(rcc::kCr, rcc::kPll1Ready, true, kLockReads)) {
        return ClockFault::pll1;
    }
    if (!wait_for(rcc::kCr, rcc::kPll2Ready, true, kLockReads)) {
        return ClockFault::pll2;
    }
    if (!take(rcc::kFromPll1)) {
        return ClockFault::switch_over;
    }
    change_bits(rcc::kD2ccip1r, rcc::kFdcanSource, rcc::kFdcanFromPll2q);
    clear_bits(rcc::kD2ccip2r, rcc::kUsart234578Source | rcc::kUsart16Source);
    set_bits(rcc::kCr, rcc::kHseGuard);
    return ClockFault::none;
}

}  // namespace

Clocks start_clocks() noexcept {
    if (!fall_back()) {
        return {ClockFault::hsi, kSlow};
    }
    set_dividers();
    clear_bits(rcc::kCr, rcc::kHsiDivider);
    if (!set_wait_states()) {
        return {ClockFault::wait_states, kSlow};
    }
    const ClockFault fault = speed_up();
    if (fault == ClockFault::none) {
        return {fault, kFast};
    }
    return {fall_back() ? fault : ClockFault::hsi, kSlow};
}

}  // namespace sc::stm32h743
