// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/counter.hpp"
#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/gpio.hpp"
#include "boards/stm32h743/registers/spi.hpp"
#include "tests/stm32h743/model/slow_lines.hpp"
#include "tests/stm32h743/model/status_spi.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

TEST(PowerRegisters, DriverAndModelHaveWhatTheTableHas) {
    const test::Table table = test::read_table("power");
    const std::map<std::string, std::uint32_t> driver{
        {"TIM5_DIER", tim5::kDier},
        {"TIM5_CCR1", tim5::kCcr1},
        {"TIM5_CCR2", tim5::kCcr2},
        {"TIM5_DCR", tim5::kDcr},
        {"TIM5_DMAR", tim5::kDmar},
        {"GPIOF_BSRR", gpio::base(gpio::Port::f) + gpio::kBsrr},
        {"DMA2_S1CR", dma::stream2(1) + dma::kCr},
        {"DMA2_S2CR", dma::stream2(2) + dma::kCr},
        {"DMA2_LIFCR", dma::kLifcr2},
        {"DMAMUX1_C9CR", dma::mux(9)},
        {"DMAMUX1_C10CR", dma::mux(10)},
    };
    EXPECT_EQ(driver, table.address);
    EXPECT_EQ(table.mask.at("TIM5_DIER.CC1DE"), tim5::kCompare1Dma);
    EXPECT_EQ(table.mask.at("TIM5_DIER.CC2DE"), tim5::kCompare2Dma);
    // A burst of two words from CCR1 on: its number among the timer's words, and one less than two.
    const std::uint32_t burst = tim5::burst(tim5::kCcr1, 2);
    EXPECT_EQ(burst & table.mask.at("TIM5_DCR.DBA"), (tim5::kCcr1 - table.address.at("TIM5_DIER") + 0x0C) / 4);
    EXPECT_EQ(burst & table.mask.at("TIM5_DCR.DBL"), 1U << 8U);
    EXPECT_EQ(burst & ~(table.mask.at("TIM5_DCR.DBA") | table.mask.at("TIM5_DCR.DBL")), 0U);
    for (const unsigned stream : {1U, 2U}) {
        const std::uint32_t flags = dma::flags(stream, dma::kAllFlags);
        EXPECT_EQ(flags & ~table.mask.at("DMA2_LIFCR.STREAM" + std::to_string(stream)), 0U);
    }
    EXPECT_EQ(dma::kRequestTim5Compare1, model::Counter::kRequest1);
    EXPECT_EQ(dma::kRequestTim5Compare2, model::Counter::kRequest2);
    EXPECT_EQ(model::SlowPort::kBase + 5 * model::SlowPort::kStep + 0x18, table.address.at("GPIOF_BSRR"));
}

TEST(GalvoStatusRegisters, DriverAndModelHaveWhatTheTableHas) {
    const test::Table table = test::read_table("status");
    const std::map<std::string, std::uint32_t> driver{
        {"SPI3_CR1", spi3::kCr1},          {"SPI3_CFG1", spi3::kCfg1},
        {"SPI3_CFG2", spi3::kCfg2},        {"SPI3_SR", spi3::kSr},
        {"SPI3_IFCR", spi3::kIfcr},        {"SPI3_RXDR", spi3::kRxdr},
        {"RCC_APB1LENR", spi3::kApb1lenr}, {"DMA1_S1CR", dma::stream(1) + dma::kCr},
        {"DMAMUX1_C1CR", dma::mux(1)},
    };
    EXPECT_EQ(driver, table.address);
    EXPECT_EQ(table.mask.at("SPI3_CR1.SPE"), spi3::kEnable);
    EXPECT_EQ(table.mask.at("SPI3_CFG1.RXDMAEN"), spi3::kReceiveDma);
    EXPECT_EQ(spi3::word_bits(20) & table.mask.at("SPI3_CFG1.DSIZE"), 19U);
    EXPECT_EQ(spi3::word_bits(20) & table.mask.at("SPI3_CFG1.CRCSIZE"), 7U << 16U);
    EXPECT_EQ(spi3::kReceiveOnly & ~table.mask.at("SPI3_CFG2.COMM"), 0U);
    EXPECT_EQ(table.mask.at("SPI3_CFG2.SSM"), spi3::kSoftwareSelect);
    EXPECT_EQ(table.mask.at("SPI3_SR.OVR"), spi3::kOverrun);
    EXPECT_EQ(table.mask.at("RCC_APB1LENR.SPI3EN"), spi3::kClock);
    EXPECT_EQ(dma::kRequestSpi3Rx, model::StatusSpi::kRequest);
    EXPECT_EQ(model::StatusSpi::kBase, table.address.at("SPI3_CR1"));
}

}  // namespace
}  // namespace sc::stm32h743
