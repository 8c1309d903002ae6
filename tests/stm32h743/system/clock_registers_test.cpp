// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/clock_power.hpp"
#include "boards/stm32h743/registers/core_memory.hpp"
#include "boards/stm32h743/registers/fault_registers.hpp"
#include "boards/stm32h743/registers/nvic.hpp"
#include "boards/stm32h743/registers/watchdog.hpp"
#include "boards/stm32h743/system/memory_map.hpp"
#include "tests/stm32h743/model/core_faults.hpp"
#include "tests/stm32h743/model/core_memory.hpp"
#include "tests/stm32h743/model/interrupt_control.hpp"
#include "tests/stm32h743/model/watchdogs.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

TEST(ClockRegisters, DriverHasWhatTheTableHas) {
    namespace neighbours = clock_neighbours;
    const test::Table table = test::read_table("clock");
    const std::map<std::string, std::uint32_t> addresses{
        {"RCC_CR", rcc::kCr},
        {"RCC_CFGR", rcc::kCfgr},
        {"RCC_D1CFGR", rcc::kD1cfgr},
        {"RCC_D2CFGR", rcc::kD2cfgr},
        {"RCC_D3CFGR", rcc::kD3cfgr},
        {"RCC_PLLCKSELR", rcc::kPllckselr},
        {"RCC_PLLCFGR", rcc::kPllcfgr},
        {"RCC_PLL1DIVR", rcc::kPll1divr},
        {"RCC_PLL2DIVR", rcc::kPll2divr},
        {"RCC_D2CCIP1R", rcc::kD2ccip1r},
        {"RCC_D2CCIP2R", rcc::kD2ccip2r},
        {"RCC_APB4ENR", rcc::kApb4enr},
        {"RCC_APB3ENR", wwdg::kApb3enr},
        {"RCC_GCR", wwdg::kGcr},
        {"RCC_CIFR", fault_registers::kCifr},
        {"RCC_AHB2ENR", core_memory::kAhb2enr},
        {"RCC_AHB4ENR", fault_registers::kAhb4enr},
        {"RCC_APB2ENR", fault_registers::kApb2enr},
        {"PWR_CR1", fault_registers::kPwrCr1},
        {"FLASH_SR1", fault_registers::kFlashSr1},
        {"FLASH_SR2", fault_registers::kFlashSr2},
        {"RCC_RSR", rcc::kRsr},
        {"PWR_CSR1", pwr::kCsr1},
        {"PWR_CR3", pwr::kCr3},
        {"PWR_D3CR", pwr::kD3cr},
        {"FLASH_ACR", neighbours::kFlashAcr},
        {"SYSCFG_PWRCR", neighbours::kSyscfgPwrcr},
        {"DBGMCU_IDC", neighbours::kIdCode},
    };
    EXPECT_EQ(addresses, table.address);
    const std::map<std::string, std::uint32_t> masks{
        {"RCC_CR.HSION", rcc::kHsiOn},
        {"RCC_CR.HSIRDY", rcc::kHsiReady},
        {"RCC_CR.HSIDIV", rcc::kHsiDivider},
        {"RCC_CR.HSEON", rcc::kHseOn},
        {"RCC_CR.HSERDY", rcc::kHseReady},
        {"RCC_CR.HSEBYP", rcc::kHseBypass},
        {"RCC_CR.CSSHSEON", rcc::kHseGuard},
        {"RCC_CR.PLL1ON", rcc::kPll1On},
        {"RCC_CR.PLL1RDY", rcc::kPll1Ready},
        {"RCC_CR.PLL2ON", rcc::kPll2On},
        {"RCC_CR.PLL2RDY", rcc::kPll2Ready},
        {"RCC_CFGR.SW", rcc::kSwitch},
        {"RCC_CFGR.SWS", rcc::kSwitchState},
        {"RCC_CFGR.TIMPRE", rcc::kTimerPrescaler},
        {"RCC_D1CFGR.HPRE", rcc::kHpre},
        {"RCC_D1CFGR.D1PPRE", rcc::kD1ppre},
        {"RCC_D1CFGR.D1CPRE", rcc::kD1cpre},
        {"RCC_D2CFGR.D2PPRE1", rcc::kD2ppre1},
        {"RCC_D2CFGR.D2PPRE2", rcc::kD2ppre2},
        {"RCC_D3CFGR.D3PPRE", rcc::kD3ppre},
        {"RCC_PLLCKSELR.PLLSRC", rcc::kPllSource},
        {"RCC_PLLCKSELR.DIVM1", rcc::kDivm1},
        {"RCC_PLLCKSELR.DIVM2", rcc::kDivm2},
        {"RCC_PLLCFGR.PLL1FRACEN", rcc::kPll1Fraction},
        {"RCC_PLLCFGR.PLL1VCOSEL", rcc::kPll1Medium},
        {"RCC_PLLCFGR.PLL1RGE", rcc::kPll1Range},
        {"RCC_PLLCFGR.PLL2FRACEN", rcc::kPll2Fraction},
        {"RCC_PLLCFGR.PLL2VCOSEL", rcc::kPll2Medium},
        {"RCC_PLLCFGR.PLL2RGE", rcc::kPll2Range},
        {"RCC_PLLCFGR.DIVP1EN", rcc::kDivp1En},
        {"RCC_PLLCFGR.DIVQ1EN", rcc::kDivq1En},
        {"RCC_PLLCFGR.DIVR1EN", rcc::kDivr1En},
        {"RCC_PLLCFGR.DIVP2EN", rcc::kDivp2En},
        {"RCC_PLLCFGR.DIVQ2EN", rcc::kDivq2En},
        {"RCC_PLLCFGR.DIVR2EN", rcc::kDivr2En},
        {"RCC_PLL1DIVR.DIVN1", rcc::kDivn},
        {"RCC_PLL1DIVR.DIVP1", rcc::kDivp},
        {"RCC_PLL1DIVR.DIVQ1", rcc::kDivq},
        {"RCC_PLL1DIVR.DIVR1", rcc::kDivr},
        {"RCC_PLL2DIVR.DIVN2", rcc::kDivn},
        {"RCC_PLL2DIVR.DIVP2", rcc::kDivp},
        {"RCC_PLL2DIVR.DIVQ2", rcc::kDivq},
        {"RCC_PLL2DIVR.DIVR2", rcc::kDivr},
        {"RCC_D2CCIP1R.FDCANSEL", rcc::kFdcanSource},
        {"RCC_D2CCIP2R.USART28SEL", rcc::kUsart234578Source},
        {"RCC_D2CCIP2R.USART16SEL", rcc::kUsart16Source},
        {"RCC_APB3ENR.WWDG1EN", wwdg::kClock},
        {"RCC_GCR.WW1RSC", wwdg::kResetsSystem},
        {"RCC_RSR.RMVF", rcc::kForgetResets},
        {"RCC_RSR.BORRSTF", rcc::kBrownOut},
        {"RCC_RSR.PINRSTF", rcc::kPinReset},
        {"RCC_RSR.PORRSTF", rcc::kPowerOn},
        {"RCC_RSR.SFTRSTF", rcc::kSoftware},
        {"RCC_RSR.IWDG1RSTF", rcc::kIndependentWatchdog},
        {"RCC_RSR.WWDG1RSTF", rcc::kWindowWatchdog},
        {"RCC_CIFR.HSECSSF", 1U << 10U},
        {"RCC_AHB2ENR.SRAM1EN", core_memory::kSram1Clock},
        {"RCC_AHB2ENR.SRAM2EN", core_memory::kSram2Clock},
        {"RCC_AHB2ENR.SRAM3EN", core_memory::kSram3Clock},
        {"RCC_AHB4ENR.GPIOEEN", fault_registers::kGpioEClock},
        {"RCC_AHB4ENR.GPIOFEN", fault_registers::kGpioFClock},
        {"RCC_AHB4ENR.BKPRAMEN", fault_registers::kBackupRamClock},
        {"RCC_APB2ENR.TIM1EN", fault_registers::kTim1Clock},
        {"PWR_CR1.DBP", fault_registers::kUnlockBackup},
        {"FLASH_SR1.DBECCERR", 1U << 26U},
        {"FLASH_SR2.DBECCERR", 1U << 26U},
        {"RCC_APB4ENR.SYSCFGEN", rcc::kSyscfgEn},
        {"PWR_CSR1.ACTVOSRDY", pwr::kActualReady},
        {"PWR_CR3.BYPASS", pwr::kBypass},
        {"PWR_CR3.LDOEN", pwr::kLdoOn},
        {"PWR_CR3.SCUEN", pwr::kUpdateOpen},
        {"PWR_D3CR.VOSRDY", pwr::kScaleReady},
        {"PWR_D3CR.VOS", pwr::kScale},
        {"FLASH_ACR.LATENCY", neighbours::kLatency},
        {"FLASH_ACR.WRHIGHFREQ", neighbours::kWriteDelay},
        {"SYSCFG_PWRCR.ODEN", neighbours::kOverdrive},
        {"DBGMCU_IDC.REV_ID", 0xFFFFU << neighbours::kRevisionShift},
    };
    EXPECT_EQ(masks, table.mask);
}

template <std::size_t N>
void expect_model(const std::array<model::Field, N>& fields, const test::Table& table) {
    std::map<std::string, std::uint32_t> addresses;
    std::map<std::string, std::uint32_t> masks;
    for (const model::Field& one : fields) {
        addresses[one.reg] = one.address;
        masks[std::string(one.reg) + "." + one.name] = one.mask();
    }
    EXPECT_EQ(addresses, table.address);
    EXPECT_EQ(masks, table.mask);
}

TEST(ClockRegisters, ModelHasWhatTheTableHas) { expect_model(model::clock_fields::kAll, test::read_table("clock")); }

TEST(WatchdogRegisters, DriverAndModelHaveWhatTheTableHas) {
    const test::Table table = test::read_table("watchdog");
    const std::map<std::string, std::uint32_t> addresses{
        {"IWDG_KR", iwdg::kKr}, {"IWDG_PR", iwdg::kPr},   {"IWDG_RLR", iwdg::kRlr}, {"IWDG_SR", iwdg::kSr},
        {"WWDG_CR", wwdg::kCr}, {"WWDG_CFR", wwdg::kCfr}, {"WWDG_SR", wwdg::kSr},
    };
    EXPECT_EQ(addresses, table.address);
    const std::map<std::string, std::uint32_t> masks{
        {"IWDG_KR.KEY", 0xFFFF},
        {"IWDG_PR.PR", 7},
        {"IWDG_RLR.RL", iwdg::kReloadMask},
        {"IWDG_SR.PVU", iwdg::kPrescalerBusy},
        {"IWDG_SR.RVU", iwdg::kReloadBusy},
        {"WWDG_CR.T", wwdg::kCounter},
        {"WWDG_CR.WDGA", wwdg::kActive},
        {"WWDG_CFR.W", wwdg::kWindow},
        {"WWDG_CFR.EWI", wwdg::kWarning},
        {"WWDG_CFR.WDGTB", wwdg::kTimeBase},
        {"WWDG_SR.EWIF", wwdg::kWarned},
    };
    EXPECT_EQ(masks, table.mask);
    EXPECT_EQ(wwdg::kInterrupt, model::WatchdogPair::kWarningInterrupt);
    expect_model(model::watchdog_fields::kAll, table);
}

TEST(FaultRegisters, DriverAndModelHaveWhatTheTableHas) {
    namespace regs = fault_registers;
    const test::Table table = test::read_table("fault");
    const std::map<std::string, std::uint32_t> addresses{
        {"SCB_AIRCR", regs::kAircr},
        {"SCB_SHCSR", regs::kShcsr},
        {"SCB_CFSR", regs::kCfsr},
        {"SCB_HFSR", regs::kHfsr},
        {"SCB_MMFAR", regs::kMmfar},
        {"SCB_BFAR", regs::kBfar},
        {"SCB_ABFSR", regs::kAbfsr},
        {"GPIOE_MODER", regs::kGpioE + regs::kModer},
        {"GPIOE_BSRR", regs::kGpioE + regs::kBsrr},
        {"GPIOF_MODER", regs::kGpioF + regs::kModer},
        {"GPIOF_BSRR", regs::kGpioF + regs::kBsrr},
        {"TIM1_BDTR", regs::kTim1Bdtr},
    };
    EXPECT_EQ(addresses, table.address);
    EXPECT_EQ(table.mask.at("SCB_AIRCR.SYSRESETREQ"), regs::kResetRequest & 0xFFFFU);
    EXPECT_EQ(table.mask.at("SCB_SHCSR.MEMFAULTENA"), regs::kMemManage);
    EXPECT_EQ(table.mask.at("SCB_SHCSR.BUSFAULTENA"), regs::kBusFault);
    EXPECT_EQ(table.mask.at("SCB_SHCSR.USGFAULTENA"), regs::kUsageFault);
    EXPECT_EQ(table.mask.at("SCB_CFSR.MMARVALID"), regs::kMmarValid);
    EXPECT_EQ(table.mask.at("SCB_CFSR.BFARVALID"), regs::kBfarValid);
    EXPECT_EQ(table.mask.at("TIM1_BDTR.MOE"), regs::kMainOutput);
    EXPECT_EQ(model::fault_fields::kBackupRam, memory::kBackup.base);
    EXPECT_EQ(model::fault_fields::kBackupBytes, memory::kBackup.bytes);
    expect_model(model::fault_fields::kAll, table);
}

TEST(CoreMemoryRegisters, DriverAndModelHaveWhatTheTableHas) {
    namespace regs = core_memory;
    const test::Table table = test::read_table("core_memory");
    const std::map<std::string, std::uint32_t> addresses{
        {"SCB_CCR", regs::kCcr},     {"SCB_CSSELR", regs::kCsselr}, {"SCB_ICIALLU", regs::kIciallu},
        {"SCB_DCISW", regs::kDcisw}, {"MPU_TYPE", regs::kMpuType},  {"MPU_CTRL", regs::kMpuCtrl},
        {"MPU_RNR", regs::kMpuRnr},  {"MPU_RBAR", regs::kMpuRbar},  {"MPU_RASR", regs::kMpuRasr},
    };
    EXPECT_EQ(addresses, table.address);
    const std::map<std::string, std::uint32_t> masks{
        {"SCB_CCR.DIV_0_TRP", regs::kDivisionTrap},
        {"SCB_CCR.DC", regs::kDataCache},
        {"SCB_CCR.IC", regs::kCodeCache},
        {"SCB_CSSELR.CSSELR", 15},
        {"SCB_ICIALLU.ALL", ~0U},
        {"SCB_DCISW.SET", (regs::kDataCacheSets - 1U) << regs::kSetShift},
        {"SCB_DCISW.WAY", (regs::kDataCacheWays - 1U) << regs::kWayShift},
        {"MPU_TYPE.DREGION", regs::kRegionCount},
        {"MPU_CTRL.ENABLE", regs::kMpuEnable},
        {"MPU_CTRL.PRIVDEFENA", regs::kDefaultMap},
        {"MPU_RNR.REGION", 255},
        {"MPU_RBAR.ADDR", ~31U},
        {"MPU_RASR.ENABLE", regs::kRegionEnable},
        {"MPU_RASR.SIZE", regs::kRegionSize},
        {"MPU_RASR.SRD", 0xFF00},
        {"MPU_RASR.B", regs::kBufferable},
        {"MPU_RASR.C", regs::kCacheable},
        {"MPU_RASR.S", 1U << 18U},
        {"MPU_RASR.TEX", regs::kTypeExtension},
        {"MPU_RASR.AP", regs::kAccess},
        {"MPU_RASR.XN", regs::kNeverExecute},
    };
    EXPECT_EQ(masks, table.mask);
    expect_model(model::core_memory_fields::kAll, table);
}

TEST(InterruptRegisters, DriverAndModelHaveWhatTheTableHas) {
    const test::Table table = test::read_table("nvic");
    const std::map<std::string, std::uint32_t> addresses{
        {"NVIC_ISER0", nvic::kIser},
        {"NVIC_ICER0", nvic::kIcer},
        {"NVIC_ICPR0", nvic::kIcpr},
        {"NVIC_IPR0", nvic::kIpr},
        {"SCB_ICSR", nvic::kIcsr},
        {"SCB_AIRCR", nvic::kAircr},
        {"SCB_SHPR1", nvic::kFaultPriorities},
        {"SCB_SHPR3", nvic::kPendSvPriority - 2},
    };
    EXPECT_EQ(addresses, table.address);
    EXPECT_EQ(table.mask.at("SCB_ICSR.PENDSVSET"), nvic::kPendPendSv);
    EXPECT_EQ(table.mask.at("SCB_AIRCR.PRIGROUP"), nvic::kGroups);
    EXPECT_EQ(table.mask.at("NVIC_IPR0.PRI_N0"), 15U << nvic::kPriorityShift);
    EXPECT_EQ(table.mask.at("SCB_SHPR3.PRI_14"), 15U << nvic::kPriorityShift << 16U);
    expect_model(model::nvic_fields::kAll, table);
}

}  // namespace
}  // namespace sc::stm32h743
