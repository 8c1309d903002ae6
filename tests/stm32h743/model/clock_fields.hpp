// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

/// Fields of RCC, PWR, FLASH, SYSCFG and DBGMCU that the model of the clock tree knows. Numbers:
/// tests/data/stm32h743/clock.csv.

namespace sc::model {

struct Field {
    const char* reg;
    const char* name;
    std::uint32_t address;
    unsigned first;
    unsigned width;
    [[nodiscard]] constexpr std::uint32_t mask() const {
        return static_cast<std::uint32_t>(((std::uint64_t{1} << width) - 1U) << first);
    }
};

namespace clock_fields {

inline constexpr std::uint32_t kRcc = 0x58024400;
inline constexpr std::uint32_t kPwr = 0x58024800;
inline constexpr std::uint32_t kFlash = 0x52002000;
inline constexpr std::uint32_t kSyscfg = 0x58000400;
inline constexpr std::uint32_t kDebug = 0x5C001000;

inline constexpr std::uint32_t kCr = kRcc + 0x00;
inline constexpr std::uint32_t kCfgr = kRcc + 0x10;
inline constexpr std::uint32_t kD1cfgr = kRcc + 0x18;
inline constexpr std::uint32_t kD2cfgr = kRcc + 0x1C;
inline constexpr std::uint32_t kD3cfgr = kRcc + 0x20;
inline constexpr std::uint32_t kPllckselr = kRcc + 0x28;
inline constexpr std::uint32_t kPllcfgr = kRcc + 0x2C;
inline constexpr std::uint32_t kPll1divr = kRcc + 0x30;
inline constexpr std::uint32_t kPll2divr = kRcc + 0x38;
inline constexpr std::uint32_t kD2ccip1r = kRcc + 0x50;
inline constexpr std::uint32_t kD2ccip2r = kRcc + 0x54;
inline constexpr std::uint32_t kGcr = kRcc + 0xA0;
inline constexpr std::uint32_t kRsr = kRcc + 0xD0;
inline constexpr std::uint32_t kCifr = kRcc + 0x64;
inline constexpr std::uint32_t kAhb2enr = kRcc + 0xDC;
inline constexpr std::uint32_t kAhb4enr = kRcc + 0xE0;
inline constexpr std::uint32_t kApb2enr = kRcc + 0xF0;
inline constexpr std::uint32_t kPwrCr1 = kPwr + 0x00;
inline constexpr std::uint32_t kFlashSr1 = kFlash + 0x10;
inline constexpr std::uint32_t kFlashSr2 = kFlash + 0x110;
inline constexpr std::uint32_t kApb3enr = kRcc + 0xE4;
inline constexpr std::uint32_t kApb4enr = kRcc + 0xF4;
inline constexpr std::uint32_t kCsr1 = kPwr + 0x04;
inline constexpr std::uint32_t kCr3 = kPwr + 0x0C;
inline constexpr std::uint32_t kD3cr = kPwr + 0x18;
inline constexpr std::uint32_t kPwrcr = kSyscfg + 0x2C;

inline constexpr Field kHsiOn{"RCC_CR", "HSION", kCr, 0, 1};
inline constexpr Field kHsiReady{"RCC_CR", "HSIRDY", kCr, 2, 1};
inline constexpr Field kHsiDiv{"RCC_CR", "HSIDIV", kCr, 3, 2};
inline constexpr Field kHseOn{"RCC_CR", "HSEON", kCr, 16, 1};
inline constexpr Field kHseReady{"RCC_CR", "HSERDY", kCr, 17, 1};
inline constexpr Field kHseBypass{"RCC_CR", "HSEBYP", kCr, 18, 1};
inline constexpr Field kHseGuard{"RCC_CR", "CSSHSEON", kCr, 19, 1};
inline constexpr Field kPll1On{"RCC_CR", "PLL1ON", kCr, 24, 1};
inline constexpr Field kPll1Ready{"RCC_CR", "PLL1RDY", kCr, 25, 1};
inline constexpr Field kPll2On{"RCC_CR", "PLL2ON", kCr, 26, 1};
inline constexpr Field kPll2Ready{"RCC_CR", "PLL2RDY", kCr, 27, 1};
inline constexpr Field kSw{"RCC_CFGR", "SW", kCfgr, 0, 3};
inline constexpr Field kSws{"RCC_CFGR", "SWS", kCfgr, 3, 3};
inline constexpr Field kTimpre{"RCC_CFGR", "TIMPRE", kCfgr, 15, 1};
inline constexpr Field kHpre{"RCC_D1CFGR", "HPRE", kD1cfgr, 0, 4};
inline constexpr Field kD1ppre{"RCC_D1CFGR", "D1PPRE", kD1cfgr, 4, 3};
inline constexpr Field kD1cpre{"RCC_D1CFGR", "D1CPRE", kD1cfgr, 8, 4};
inline constexpr Field kD2ppre1{"RCC_D2CFGR", "D2PPRE1", kD2cfgr, 4, 3};
inline constexpr Field kD2ppre2{"RCC_D2CFGR", "D2PPRE2", kD2cfgr, 8, 3};
inline constexpr Field kD3ppre{"RCC_D3CFGR", "D3PPRE", kD3cfgr, 4, 3};
inline constexpr Field kPllSource{"RCC_PLLCKSELR", "PLLSRC", kPllckselr, 0, 2};
inline constexpr Field kDivm1{"RCC_PLLCKSELR", "DIVM1", kPllckselr, 4, 6};
inline constexpr Field kDivm2{"RCC_PLLCKSELR", "DIVM2", kPllckselr, 12, 6};
inline constexpr Field kFraction1{"RCC_PLLCFGR", "PLL1FRACEN", kPllcfgr, 0, 1};
inline constexpr Field kMedium1{"RCC_PLLCFGR", "PLL1VCOSEL", kPllcfgr, 1, 1};
inline constexpr Field kRange1{"RCC_PLLCFGR", "PLL1RGE", kPllcfgr, 2, 2};
inline constexpr Field kFraction2{"RCC_PLLCFGR", "PLL2FRACEN", kPllcfgr, 4, 1};
inline constexpr Field kMedium2{"RCC_PLLCFGR", "PLL2VCOSEL", kPllcfgr, 5, 1};
inline constexpr Field kRange2{"RCC_PLLCFGR", "PLL2RGE", kPllcfgr, 6, 2};
inline constexpr Field kDivp1en{"RCC_PLLCFGR", "DIVP1EN", kPllcfgr, 16, 1};
inline constexpr Field kDivq1en{"RCC_PLLCFGR", "DIVQ1EN", kPllcfgr, 17, 1};
inline constexpr Field kDivr1en{"RCC_PLLCFGR", "DIVR1EN", kPllcfgr, 18, 1};
inline constexpr Field kDivp2en{"RCC_PLLCFGR", "DIVP2EN", kPllcfgr, 19, 1};
inline constexpr Field kDivq2en{"RCC_PLLCFGR", "DIVQ2EN", kPllcfgr, 20, 1};
inline constexpr Field kDivr2en{"RCC_PLLCFGR", "DIVR2EN", kPllcfgr, 21, 1};
inline constexpr Field kDivn1{"RCC_PLL1DIVR", "DIVN1", kPll1divr, 0, 9};
inline constexpr Field kDivp1{"RCC_PLL1DIVR", "DIVP1", kPll1divr, 9, 7};
inline constexpr Field kDivq1{"RCC_PLL1DIVR", "DIVQ1", kPll1divr, 16, 7};
inline constexpr Field kDivr1{"RCC_PLL1DIVR", "DIVR1", kPll1divr, 24, 7};
inline constexpr Field kDivn2{"RCC_PLL2DIVR", "DIVN2", kPll2divr, 0, 9};
inline constexpr Field kDivp2{"RCC_PLL2DIVR", "DIVP2", kPll2divr, 9, 7};
inline constexpr Field kDivq2{"RCC_PLL2DIVR", "DIVQ2", kPll2divr, 16, 7};
inline constexpr Field kDivr2{"RCC_PLL2DIVR", "DIVR2", kPll2divr, 24, 7};
inline constexpr Field kFdcanSel{"RCC_D2CCIP1R", "FDCANSEL", kD2ccip1r, 28, 2};
inline constexpr Field kUsart28Sel{"RCC_D2CCIP2R", "USART28SEL", kD2ccip2r, 0, 3};
inline constexpr Field kUsart16Sel{"RCC_D2CCIP2R", "USART16SEL", kD2ccip2r, 3, 3};
inline constexpr Field kWw1rsc{"RCC_GCR", "WW1RSC", kGcr, 0, 1};
inline constexpr Field kForgetResets{"RCC_RSR", "RMVF", kRsr, 16, 1};
inline constexpr Field kBorReset{"RCC_RSR", "BORRSTF", kRsr, 21, 1};
inline constexpr Field kPinReset{"RCC_RSR", "PINRSTF", kRsr, 22, 1};
inline constexpr Field kPorReset{"RCC_RSR", "PORRSTF", kRsr, 23, 1};
inline constexpr Field kSoftReset{"RCC_RSR", "SFTRSTF", kRsr, 24, 1};
inline constexpr Field kIwdgReset{"RCC_RSR", "IWDG1RSTF", kRsr, 26, 1};
inline constexpr Field kWwdgReset{"RCC_RSR", "WWDG1RSTF", kRsr, 28, 1};
inline constexpr Field kHseStopped{"RCC_CIFR", "HSECSSF", kCifr, 10, 1};
inline constexpr Field kSram1En{"RCC_AHB2ENR", "SRAM1EN", kAhb2enr, 29, 1};
inline constexpr Field kSram2En{"RCC_AHB2ENR", "SRAM2EN", kAhb2enr, 30, 1};
inline constexpr Field kSram3En{"RCC_AHB2ENR", "SRAM3EN", kAhb2enr, 31, 1};
inline constexpr Field kGpioEEn{"RCC_AHB4ENR", "GPIOEEN", kAhb4enr, 4, 1};
inline constexpr Field kGpioFEn{"RCC_AHB4ENR", "GPIOFEN", kAhb4enr, 5, 1};
inline constexpr Field kBackupRamEn{"RCC_AHB4ENR", "BKPRAMEN", kAhb4enr, 28, 1};
inline constexpr Field kTim1En{"RCC_APB2ENR", "TIM1EN", kApb2enr, 0, 1};
inline constexpr Field kBackupUnlock{"PWR_CR1", "DBP", kPwrCr1, 8, 1};
inline constexpr Field kBank1Double{"FLASH_SR1", "DBECCERR", kFlashSr1, 26, 1};
inline constexpr Field kBank2Double{"FLASH_SR2", "DBECCERR", kFlashSr2, 26, 1};
inline constexpr Field kWwdgEn{"RCC_APB3ENR", "WWDG1EN", kApb3enr, 6, 1};
inline constexpr Field kSyscfgEn{"RCC_APB4ENR", "SYSCFGEN", kApb4enr, 1, 1};
inline constexpr Field kActualReady{"PWR_CSR1", "ACTVOSRDY", kCsr1, 13, 1};
inline constexpr Field kBypass{"PWR_CR3", "BYPASS", kCr3, 0, 1};
inline constexpr Field kLdoEn{"PWR_CR3", "LDOEN", kCr3, 1, 1};
inline constexpr Field kScuEn{"PWR_CR3", "SCUEN", kCr3, 2, 1};
inline constexpr Field kVosReady{"PWR_D3CR", "VOSRDY", kD3cr, 13, 1};
inline constexpr Field kVos{"PWR_D3CR", "VOS", kD3cr, 14, 2};
inline constexpr Field kLatency{"FLASH_ACR", "LATENCY", kFlash, 0, 4};
inline constexpr Field kWriteDelay{"FLASH_ACR", "WRHIGHFREQ", kFlash, 4, 2};
inline constexpr Field kOden{"SYSCFG_PWRCR", "ODEN", kPwrcr, 0, 1};
inline constexpr Field kRevision{"DBGMCU_IDC", "REV_ID", kDebug, 16, 16};

inline constexpr std::array kAll{
    kHsiOn,       kHsiReady,    kHsiDiv,       kHseOn,    kHseReady,   kHseBypass,   kHseGuard,   kPll1On,
    kPll1Ready,   kPll2On,      kPll2Ready,    kSw,       kSws,        kTimpre,      kHpre,       kD1ppre,
    kD1cpre,      kD2ppre1,     kD2ppre2,      kD3ppre,   kPllSource,  kDivm1,       kDivm2,      kFraction1,
    kMedium1,     kRange1,      kFraction2,    kMedium2,  kRange2,     kDivp1en,     kDivq1en,    kDivr1en,
    kDivp2en,     kDivq2en,     kDivr2en,      kDivn1,    kDivp1,      kDivq1,       kDivr1,      kDivn2,
    kDivp2,       kDivq2,       kDivr2,        kFdcanSel, kUsart28Sel, kUsart16Sel,  kSyscfgEn,   kActualReady,
    kBypass,      kLdoEn,       kScuEn,        kVosReady, kVos,        kLatency,     kWriteDelay, kOden,
    kRevision,    kWw1rsc,      kForgetResets, kBorReset, kPinReset,   kPorReset,    kSoftReset,  kIwdgReset,
    kWwdgReset,   kWwdgEn,      kHseStopped,   kGpioEEn,  kGpioFEn,    kBackupRamEn, kTim1En,     kBackupUnlock,
    kBank1Double, kBank2Double, kSram1En,      kSram2En,  kSram3En};

}  // namespace clock_fields
}  // namespace sc::model
