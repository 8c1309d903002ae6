// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/basic_timer.hpp"
#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"
#include "tests/stm32h743/model/optics.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

using test::read_table;

TEST(OpticsRegisters, DriverHasTheAddressesOfTheTable) {
    const std::map<std::string, std::uint32_t> driver{
        {"RCC_AHB1ENR", optics_port::kAhb1enr},
        {"RCC_AHB2ENR", optics_port::kAhb2enr},
        {"RCC_AHB4ENR", optics_port::kAhb4enr},
        {"RCC_APB1LENR", optics_port::kApb1lenr},
        {"GPIOE_MODER", optics_port::kModer},
        {"GPIOE_OTYPER", optics_port::kOtyper},
        {"GPIOE_OSPEEDR", optics_port::kOspeedr},
        {"GPIOE_BSRR", optics_port::kBsrr},
        {"TIM6_CR1", tim6::kCr1},
        {"TIM6_DIER", tim6::kDier},
        {"TIM6_SR", tim6::kSr},
        {"TIM6_EGR", tim6::kEgr},
        {"TIM6_PSC", tim6::kPsc},
        {"TIM6_ARR", tim6::kArr},
        {"DMA1_LISR", dma::kLisr},
        {"DMA1_LIFCR", dma::kLifcr},
        {"DMA1_S0CR", dma::stream(0) + dma::kCr},
        {"DMA1_S0NDTR", dma::stream(0) + dma::kNdtr},
        {"DMA1_S0PAR", dma::stream(0) + dma::kPar},
        {"DMA1_S0M0AR", dma::stream(0) + dma::kM0ar},
        {"DMA1_S0M1AR", dma::stream(0) + dma::kM1ar},
        {"DMA1_S0FCR", dma::stream(0) + dma::kFcr},
        {"DMAMUX1_C0CR", dma::mux(0)},
    };
    EXPECT_EQ(driver, read_table("optics").address);
}

TEST(OpticsRegisters, DriverHasTheBitsOfTheTable) {
    const std::map<std::string, std::uint32_t> mask = read_table("optics").mask;
    const std::map<std::string, std::uint32_t> bits{
        {"RCC_AHB1ENR.DMA1EN", optics_port::kDma1Clock},
        {"RCC_AHB2ENR.SRAM1EN", optics_port::kSram1Clock},
        {"RCC_AHB4ENR.GPIOEEN", optics_port::kGpioEClock},
        {"RCC_APB1LENR.TIM6EN", optics_port::kTim6Clock},
        {"TIM6_CR1.CEN", tim6::kCounterEnable},
        {"TIM6_CR1.ARPE", tim6::kPreload},
        {"TIM6_DIER.UDE", tim6::kUpdateDma},
        {"TIM6_EGR.UG", tim6::kGenerateUpdate},
        {"DMA1_LISR.FEIF0", dma::kFifoError},
        {"DMA1_LISR.DMEIF0", dma::kDirectError},
        {"DMA1_LISR.TEIF0", dma::kTransferError},
        {"DMA1_LISR.HTIF0", dma::kHalf},
        {"DMA1_LISR.TCIF0", dma::kComplete},
        {"DMA1_S0CR.EN", dma::kEnable},
        {"DMA1_S0CR.DMEIE", dma::kDirectErrorInterrupt},
        {"DMA1_S0CR.TEIE", dma::kTransferErrorInterrupt},
        {"DMA1_S0CR.TCIE", dma::kCompleteInterrupt},
        {"DMA1_S0CR.CIRC", dma::kCircular},
        {"DMA1_S0CR.MINC", dma::kMemoryIncrement},
        {"DMA1_S0CR.PL", dma::kVeryHigh},
        {"DMA1_S0CR.DBM", dma::kDoubleBuffer},
        {"DMA1_S0CR.CT", dma::kCurrentTarget},
    };
    for (const auto& [name, value] : bits) {
        EXPECT_EQ(value, mask.at(name)) << name;
    }
    // Values within fields.
    EXPECT_EQ(dma::kToPeripheral & ~mask.at("DMA1_S0CR.DIR"), 0U);
    EXPECT_EQ(dma::kPeripheralWord & ~mask.at("DMA1_S0CR.PSIZE"), 0U);
    EXPECT_EQ(dma::kMemoryWord & ~mask.at("DMA1_S0CR.MSIZE"), 0U);
    EXPECT_EQ(dma::kRequestTim6Update & ~mask.at("DMAMUX1_C0CR.DMAREQ_ID"), 0U);
    EXPECT_EQ(bits.size() + 4, mask.size());
}

TEST(OpticsRegisters, ModelLiesAtTheAddressesOfTheTable) {
    const std::map<std::string, std::uint32_t> at = read_table("optics").address;
    EXPECT_EQ(model::ClockGates::kBase + model::ClockGates::kAhb1, at.at("RCC_AHB1ENR"));
    EXPECT_EQ(model::ClockGates::kBase + model::ClockGates::kAhb2, at.at("RCC_AHB2ENR"));
    EXPECT_EQ(model::ClockGates::kBase + model::ClockGates::kAhb4, at.at("RCC_AHB4ENR"));
    EXPECT_EQ(model::ClockGates::kBase + model::ClockGates::kApb1l, at.at("RCC_APB1LENR"));
    EXPECT_EQ(model::EdgePort::kBase, at.at("GPIOE_MODER"));
    EXPECT_EQ(model::DmaModel::kBase, at.at("DMA1_LISR"));
    EXPECT_EQ(model::DmaModel::kMuxBase, at.at("DMAMUX1_C0CR"));
    EXPECT_EQ(model::BasicTimer::kBase, at.at("TIM6_CR1"));
}

}  // namespace
}  // namespace sc::stm32h743
