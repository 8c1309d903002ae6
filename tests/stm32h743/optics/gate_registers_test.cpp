// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/advanced_timer.hpp"
#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"
#include "tests/stm32h743/model/advanced_timer.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

using test::read_table;

TEST(GateRegisters, DriverHasTheAddressesOfTheTable) {
    const std::map<std::string, std::uint32_t> driver{
        {"RCC_AHB1ENR", optics_port::kAhb1enr},
        {"RCC_AHB2ENR", optics_port::kAhb2enr},
        {"RCC_APB2ENR", optics_port::kApb2enr},
        {"GPIOE_PUPDR", optics_port::kPupdr},
        {"GPIOE_AFRH", optics_port::kAfrh},
        {"TIM1_CR1", tim1::kCr1},
        {"TIM1_CR2", tim1::kCr2},
        {"TIM1_DIER", tim1::kDier},
        {"TIM1_SR", tim1::kSr},
        {"TIM1_EGR", tim1::kEgr},
        {"TIM1_CCMR1", tim1::kCcmr1},
        {"TIM1_CCMR2", tim1::kCcmr2},
        {"TIM1_CCER", tim1::kCcer},
        {"TIM1_PSC", tim1::kPsc},
        {"TIM1_ARR", tim1::kArr},
        {"TIM1_RCR", tim1::kRcr},
        {"TIM1_CCR1", tim1::kCcr1},
        {"TIM1_CCR2", tim1::kCcr2},
        {"TIM1_CCR3", tim1::kCcr3},
        {"TIM1_BDTR", tim1::kBdtr},
        {"TIM1_DCR", tim1::kDcr},
        {"TIM1_DMAR", tim1::kDmar},
        {"TIM1_AF1", tim1::kAf1},
        {"DMA2_LISR", dma::kLisr2},
        {"DMA2_LIFCR", dma::kLifcr2},
        {"DMA2_S0CR", dma::stream2(0)},
        {"DMAMUX1_C8CR", dma::mux(8)},
    };
    EXPECT_EQ(driver, read_table("gate").address);
}

TEST(GateRegisters, DriverHasTheBitsOfTheTable) {
    const std::map<std::string, std::uint32_t> mask = read_table("gate").mask;
    const std::map<std::string, std::uint32_t> bits{
        {"RCC_AHB1ENR.DMA2EN", optics_port::kDma2Clock},
        {"RCC_AHB2ENR.SRAM2EN", optics_port::kSram2Clock},
        {"RCC_APB2ENR.TIM1EN", optics_port::kTim1Clock},
        {"TIM1_CR1.CEN", tim1::kCounterEnable},
        {"TIM1_CR1.ARPE", tim1::kReloadPreload},
        {"TIM1_DIER.UDE", tim1::kUpdateDma},
        {"TIM1_SR.BIF", tim1::kBreakFlag},
        {"TIM1_EGR.UG", tim1::kGenerateUpdate},
        {"TIM1_CCMR1.OC1PE", tim1::kFirstPreload},
        {"TIM1_CCMR1.OC2PE", tim1::kSecondPreload},
        {"TIM1_CCMR1.OC1M", tim1::first_mode(7)},
        {"TIM1_CCMR1.OC1M_3", tim1::first_mode(8)},
        {"TIM1_CCMR1.OC2M", tim1::second_mode(7)},
        {"TIM1_CCMR1.OC2M_3", tim1::second_mode(8)},
        {"TIM1_CCER.CC1E", tim1::kChannel1},
        {"TIM1_CCER.CC3E", tim1::kChannel3},
        {"TIM1_BDTR.LOCK", 3U * tim1::kLockFirst},
        {"TIM1_BDTR.OSSI", tim1::kOffIdle},
        {"TIM1_BDTR.OSSR", tim1::kOffRun},
        {"TIM1_BDTR.BKE", tim1::kBreakEnable},
        {"TIM1_BDTR.BKP", tim1::kBreakHigh},
        {"TIM1_BDTR.AOE", tim1::kAutomatic},
        {"TIM1_BDTR.MOE", tim1::kMainOutput},
        {"TIM1_DCR.DBA", tim1::burst(tim1::kBase + 4U * 31U, 1)},
        {"TIM1_DCR.DBL", tim1::burst(tim1::kBase, 32)},
        {"TIM1_AF1.BKINE", tim1::kBreakInput},
    };
    for (const auto& [name, value] : bits) {
        EXPECT_EQ(value, mask.at(name)) << name;
    }
    EXPECT_EQ(bits.size() + 1, mask.size());  // BG is the model's alone
    EXPECT_EQ(dma::kRequestTim1Update, model::AdvancedTimer::kRequest);
    EXPECT_EQ(dma::kRequestTim6Update, model::BasicTimer::kRequest);
}

TEST(GateRegisters, ModelLiesAtTheAddressesOfTheTable) {
    const std::map<std::string, std::uint32_t> at = read_table("gate").address;
    EXPECT_EQ(model::ClockGates::kBase + model::ClockGates::kApb2, at.at("RCC_APB2ENR"));
    EXPECT_EQ(model::AdvancedTimer::kBase, at.at("TIM1_CR1"));
    EXPECT_EQ(model::DmaModel::kBase2, at.at("DMA2_LISR"));
    EXPECT_EQ(model::DmaModel::kMuxBase2, at.at("DMAMUX1_C8CR"));
}

/// The model's places and bits, by what it does with the table's.
TEST(GateRegisters, ModelHasTheBitsOfTheTable) {
    const test::Table table = read_table("gate");
    const auto bit = [&](const char* name) { return table.mask.at(name); };
    model::Machine machine;
    model::ClockGates clocks(machine);
    model::EdgePort port(machine, clocks);
    model::DmaModel dma(machine, clocks, model::DmaModel::Which::second);
    model::AdvancedTimer timer(machine, clocks, dma, port);
    machine.attach(model::ClockGates::kBase, 0x400, clocks);
    machine.attach(model::EdgePort::kBase, 0x400, port);
    machine.attach(model::AdvancedTimer::kBase, 0x400, timer);
    const auto write = [&](const char* name, std::uint32_t value) { machine.write(table.address.at(name), value, 4); };
    const auto read = [&](const char* name) { return machine.read(table.address.at(name)); };

    write("TIM1_PSC", 1);  // without its clock nothing is taken
    EXPECT_EQ(read("TIM1_PSC"), 0U);
    EXPECT_EQ(machine.violations().size(), 1U);
    write("RCC_APB2ENR", bit("RCC_APB2ENR.TIM1EN"));
    machine.write(model::ClockGates::kBase + model::ClockGates::kAhb4, 1U << 4U, 4);
    machine.write(model::EdgePort::kBase, 2U << 30U, 4);
    write("GPIOE_AFRH", 1U << 28U);
    write("GPIOE_PUPDR", 2U << 30U);
    EXPECT_EQ(port.function(15), 1);
    EXPECT_TRUE(port.pulled_down(15));

    timer.set_break_pin(true);
    write("TIM1_BDTR", bit("TIM1_BDTR.BKE") | bit("TIM1_BDTR.MOE") | bit("TIM1_BDTR.OSSI") | bit("TIM1_BDTR.OSSR"));
    EXPECT_EQ(read("TIM1_BDTR") & bit("TIM1_BDTR.MOE"), bit("TIM1_BDTR.MOE"));
    timer.set_break_pin(false);
    EXPECT_EQ(read("TIM1_BDTR") & bit("TIM1_BDTR.MOE"), 0U);
    EXPECT_EQ(read("TIM1_SR") & bit("TIM1_SR.BIF"), bit("TIM1_SR.BIF"));
    write("TIM1_SR", ~bit("TIM1_SR.BIF"));
    EXPECT_NE(read("TIM1_SR") & bit("TIM1_SR.BIF"), 0U);  // as long as the input is active
    timer.set_break_pin(true);
    write("TIM1_SR", ~bit("TIM1_SR.BIF"));
    EXPECT_EQ(read("TIM1_SR") & bit("TIM1_SR.BIF"), 0U);
    // With the other polarity the high input is the break.
    write("TIM1_BDTR", bit("TIM1_BDTR.BKE") | bit("TIM1_BDTR.BKP") | bit("TIM1_BDTR.MOE") | bit("TIM1_BDTR.OSSI"));
    EXPECT_EQ(read("TIM1_BDTR") & bit("TIM1_BDTR.MOE"), 0U);
    // Without the source nothing breaks.
    write("TIM1_AF1", 0);
    write("TIM1_BDTR", bit("TIM1_BDTR.BKE") | bit("TIM1_BDTR.BKP") | bit("TIM1_BDTR.MOE") | bit("TIM1_BDTR.OSSI"));
    EXPECT_NE(read("TIM1_BDTR") & bit("TIM1_BDTR.MOE"), 0U);
    write("TIM1_AF1", bit("TIM1_AF1.BKINE"));
    EXPECT_EQ(read("TIM1_BDTR") & bit("TIM1_BDTR.MOE"), 0U);
    write("TIM1_SR", 0);
    EXPECT_EQ(machine.violations().size(), 1U);
    write("TIM1_BDTR", bit("TIM1_BDTR.BKE") | bit("TIM1_BDTR.OSSI") | bit("TIM1_BDTR.LOCK") / 3U);
    write("TIM1_BDTR", bit("TIM1_BDTR.OSSI"));
    EXPECT_EQ(machine.violations().size(), 2U);
    EXPECT_NE(read("TIM1_BDTR") & bit("TIM1_BDTR.BKE"), 0U);
    // By software.
    write("TIM1_BDTR", read("TIM1_BDTR") | bit("TIM1_BDTR.MOE"));
    write("TIM1_EGR", bit("TIM1_EGR.BG"));
    EXPECT_EQ(read("TIM1_BDTR") & bit("TIM1_BDTR.MOE"), 0U);
}

}  // namespace
}  // namespace sc::stm32h743
