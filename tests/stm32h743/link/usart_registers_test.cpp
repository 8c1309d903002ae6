// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/dma_stream.hpp"
#include "boards/stm32h743/registers/usart.hpp"
#include "tests/stm32h743/model/usart.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

using test::read_table;

TEST(UsartRegisters, DriverHasTheAddressesOfTheTable) {
    using namespace usart;
    const std::map<std::string, std::uint32_t> driver{
        {"RCC_AHB1ENR", kAhb1enr},        {"RCC_APB1LENR", kApb1lenr},    {"RCC_APB2ENR", kApb2enr},
        {"USART2_CR1", kUsart2 + kCr1},   {"USART6_CR1", kUsart6 + kCr1}, {"USART3_CR1", kUsart3 + kCr1},
        {"USART3_CR2", kUsart3 + kCr2},   {"USART3_CR3", kUsart3 + kCr3}, {"USART3_BRR", kUsart3 + kBrr},
        {"USART3_RTOR", kUsart3 + kRtor}, {"USART3_ISR", kUsart3 + kIsr}, {"USART3_ICR", kUsart3 + kIcr},
        {"USART3_RDR", kUsart3 + kRdr},   {"USART3_TDR", kUsart3 + kTdr}, {"DMA1_S2CR", dma::stream(2)},
        {"DMAMUX1_C2CR", dma::mux(2)},
    };
    EXPECT_EQ(driver, read_table("usart").address);
}

TEST(UsartRegisters, DriverHasTheBitsOfTheTable) {
    using namespace usart;
    const std::map<std::string, std::uint32_t> mask = read_table("usart").mask;
    const std::map<std::string, std::uint32_t> bits{
        {"RCC_AHB1ENR.DMA1EN", kDma1Clock},
        {"RCC_APB1LENR.USART2EN", kUsart2Clock},
        {"RCC_APB1LENR.USART3EN", kUsart3Clock},
        {"RCC_APB2ENR.USART6EN", kUsart6Clock},
        {"USART3_CR1.UE", kEnable},
        {"USART3_CR1.RE", kReceive},
        {"USART3_CR1.TE", kTransmit},
        {"USART3_CR1.IDLEIE", kIdleInterrupt},
        {"USART3_CR1.RXNEIE", kReceiveInterrupt},
        {"USART3_CR1.TCIE", kCompleteInterrupt},
        {"USART3_CR1.TXEIE", kEmptyInterrupt},
        {"USART3_CR1.PCE", kParity},
        {"USART3_CR1.M0", kNineBits},
        {"USART3_CR1.DEDT", 31U << kReleaseAt},
        {"USART3_CR1.DEAT", 31U << kAssertAt},
        {"USART3_CR1.RTOIE", kTimeoutInterrupt},
        {"USART3_CR2.RTOEN", kTimeoutEnable},
        {"USART3_CR3.DMAR", kDmaReceive},
        {"USART3_CR3.DMAT", kDmaTransmit},
        {"USART3_CR3.DEM", kDriverEnable},
        {"USART3_ISR.PE", kParityError},
        {"USART3_ISR.FE", kFramingError},
        {"USART3_ISR.NE", kNoise},
        {"USART3_ISR.ORE", kOverrun},
        {"USART3_ISR.IDLE", kIdle},
        {"USART3_ISR.RXNE", kReceived},
        {"USART3_ISR.TC", kComplete},
        {"USART3_ISR.TXE", kEmpty},
        {"USART3_ISR.RTOF", kTimeout},
        {"USART3_ISR.BUSY", kBusy},
        {"USART3_ISR.TEACK", kTransmitReady},
        {"USART3_ISR.REACK", kReceiveReady},
        {"DMA1_S2CR.TRBUFF", kBufferable},
    };
    for (const auto& [name, value] : bits) {
        EXPECT_EQ(value, mask.at(name)) << name;
    }
    // Values within fields.
    EXPECT_EQ((kRequestUsart3Rx | kRequestUsart3Tx) & ~mask.at("DMAMUX1_C2CR.DMAREQ_ID"), 0U);
    EXPECT_EQ(bits.size() + 2, mask.size());
}

TEST(UsartRegisters, ModelHasTheAddressesOfTheTable) {
    using namespace model::usart_at;
    using model::UsartModel;
    const std::map<std::string, std::uint32_t> at = read_table("usart").address;
    EXPECT_EQ(model::rcc::kBase + model::rcc::kAhb1, at.at("RCC_AHB1ENR"));
    EXPECT_EQ(model::rcc::kBase + model::rcc::kApb1l, at.at("RCC_APB1LENR"));
    EXPECT_EQ(model::rcc::kBase + model::rcc::kApb2, at.at("RCC_APB2ENR"));
    EXPECT_EQ(UsartModel::kUsart2.base, at.at("USART2_CR1"));
    EXPECT_EQ(UsartModel::kUsart6.base, at.at("USART6_CR1"));
    EXPECT_EQ(model::ByteDma::kBase + 0x40, at.at("DMA1_S2CR"));
    EXPECT_EQ(model::ByteDma::kMuxBase + 8, at.at("DMAMUX1_C2CR"));
    const std::map<std::string, std::uint32_t> offsets{{"CR1", cr1}, {"CR2", cr2},   {"CR3", cr3},
                                                       {"BRR", brr}, {"RTOR", rtor}, {"ISR", isr},
                                                       {"ICR", icr}, {"RDR", rdr},   {"TDR", tdr}};
    for (const auto& [name, offset] : offsets) {
        EXPECT_EQ(UsartModel::kUsart3.base + offset, at.at("USART3_" + name)) << name;
    }
}

}  // namespace
}  // namespace sc::stm32h743
