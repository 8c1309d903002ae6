// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/watchdogs.hpp"

#include "boards/stm32h743/registers/watchdog.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::uint32_t kLast = 0x40;  ///< the next count resets
constexpr std::uint32_t kFull = kLast + Watchdogs::kCounts - 1;
constexpr std::uint32_t kOpen = kFull - Watchdogs::kClosedCounts;  ///< from here on it may be fed
constexpr std::uint32_t kUpdateReads = 200'000;                    ///< six cycles of LSI for each register

}  // namespace

bool Watchdogs::start(const Frequencies& frequencies) noexcept {
    if (frequencies.apb_hz != kFast.apb_hz) {
        return false;
    }
    write32(iwdg::kKr, iwdg::kStart);  // starts LSI as well, which the registers below need
    write32(iwdg::kKr, iwdg::kUnlock);
    write32(iwdg::kPr, 0);
    write32(iwdg::kRlr, watchdog_plan::kIndependentCounts - 1);
    if (!wait_for(iwdg::kSr, iwdg::kPrescalerBusy | iwdg::kReloadBusy, false, kUpdateReads)) {
        return false;
    }
    write32(iwdg::kKr, iwdg::kReload);
    set_bits(wwdg::kGcr, wwdg::kResetsSystem);
    set_bits(wwdg::kApb3enr, wwdg::kClock);
    (void)read32(wwdg::kApb3enr);  // the clock is there two cycles later
    write32(wwdg::kCfr, kOpen | wwdg::kWarning);
    started_ = true;
    return true;
}

void Watchdogs::feed(bool healthy) noexcept {
    gave_up_ = gave_up_ || !healthy;
    if (gave_up_ || !started_) {
        return;
    }
    write32(wwdg::kCr, wwdg::kActive | kFull);
    write32(iwdg::kKr, iwdg::kReload);
}

void Watchdogs::acknowledge_warning_isr() noexcept { write32(wwdg::kSr, 0); }

ResetCause reset_cause(std::uint32_t word) noexcept {
    if ((word & (rcc::kPowerOn | rcc::kBrownOut)) != 0) {
        return ResetCause::power;
    }
    if ((word & rcc::kWindowWatchdog) != 0) {
        return ResetCause::window_watchdog;
    }
    if ((word & rcc::kIndependentWatchdog) != 0) {
        return ResetCause::independent_watchdog;
    }
    if ((word & rcc::kSoftware) != 0) {
        return ResetCause::software;
    }
    return (word & rcc::kPinReset) != 0 ? ResetCause::pin : ResetCause::other;
}

ResetCause take_reset_cause() noexcept {
    const ResetCause cause = reset_cause(read32(rcc::kRsr));
    set_bits(rcc::kRsr, rcc::kForgetResets);
    return cause;
}

}  // namespace sc::stm32h743
