// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/external_lines.hpp"
#include "tests/stm32h743/model/external_lines.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

TEST(SafetyLinesRegisters, DriverAndModelHaveWhatTheTableHas) {
    namespace regs = lines_registers;
    const test::Table table = test::read_table("lines");
    const std::map<std::string, std::uint32_t> driver{
        {"EXTI_RTSR1", regs::kRising},
        {"EXTI_FTSR1", regs::kFalling},
        {"EXTI_CPUIMR1", regs::kMask},
        {"EXTI_CPUPR1", regs::kPending},
        {"SYSCFG_EXTICR2", regs::kPortOf4To7},
        {"SYSCFG_EXTICR3", regs::kPortOf8To11},
        {"RCC_APB4ENR", regs::kApb4enr},
        {"GPIOE_IDR", regs::kInputs},
        {"TIM7_CR1", regs::kTim7Cr1},
        {"TIM7_DIER", regs::kTim7Dier},
        {"TIM7_SR", regs::kTim7Sr},
        {"TIM7_EGR", regs::kTim7Egr},
        {"TIM7_PSC", regs::kTim7Psc},
        {"TIM7_ARR", regs::kTim7Arr},
        {"RCC_APB1LENR", model::ClockGates::kBase + model::ClockGates::kApb1l},
    };
    EXPECT_EQ(driver, table.address);
    EXPECT_EQ(table.mask.at("RCC_APB4ENR.SYSCFGEN"), regs::kSyscfgClock);
    EXPECT_EQ(table.mask.at("RCC_APB1LENR.TIM7EN"), regs::kTim7Clock);
    EXPECT_EQ(table.mask.at("TIM7_CR1.CEN"), regs::kCounterEnable);
    EXPECT_EQ(table.mask.at("TIM7_DIER.UIE"), regs::kUpdateInterrupt);
    EXPECT_EQ(table.mask.at("TIM7_SR.UIF"), regs::kUpdateFlag);
    EXPECT_EQ(table.mask.at("TIM7_EGR.UG"), regs::kGenerateUpdate);
    EXPECT_EQ(model::EdgeLines::kBase, table.address.at("EXTI_RTSR1"));
    EXPECT_EQ(model::PortChoice::kBase + 0x0C, table.address.at("SYSCFG_EXTICR2"));
    EXPECT_EQ(model::PeriodTimer::kBase, table.address.at("TIM7_CR1"));
    EXPECT_EQ(model::ClockGates::kBase + model::ClockGates::kApb4, table.address.at("RCC_APB4ENR"));
    EXPECT_EQ(model::EdgePort::kBase + 0x10, table.address.at("GPIOE_IDR"));
}

}  // namespace
}  // namespace sc::stm32h743
