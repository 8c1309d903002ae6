// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/fdcan.hpp"
#include "tests/stm32h743/model/fdcan.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

using test::read_table;

TEST(FdcanRegisters, DriverHasTheAddressesOfTheTable) {
    using namespace fdcan;
    std::map<std::string, std::uint32_t> driver{{"RCC_APB1HENR", kApb1henr}, {"SRAMCAN", kMessageRam}};
    driver["FDCAN2_ENDN"] = kFdcan2 + kEndn;
    const std::map<std::string, std::uint32_t> offsets{
        {"ENDN", kEndn},   {"DBTP", kDbtp},   {"CCCR", kCccr},   {"NBTP", kNbtp},   {"TSCC", kTscc},
        {"TSCV", kTscv},   {"ECR", kEcr},     {"PSR", kPsr},     {"TDCR", kTdcr},   {"IR", kIr},
        {"IE", kIe},       {"ILS", kIls},     {"ILE", kIle},     {"GFC", kGfc},     {"SIDFC", kSidfc},
        {"XIDFC", kXidfc}, {"RXF0C", kRxf0c}, {"RXF0S", kRxf0s}, {"RXF0A", kRxf0a}, {"RXESC", kRxesc},
        {"TXBC", kTxbc},   {"TXFQS", kTxfqs}, {"TXESC", kTxesc}, {"TXBRP", kTxbrp}, {"TXBAR", kTxbar},
    };
    for (const auto& [name, offset] : offsets) {
        driver["FDCAN1_" + name] = kFdcan1 + offset;
    }
    EXPECT_EQ(driver, read_table("fdcan").address);
}

TEST(FdcanRegisters, DriverHasTheBitsOfTheTable) {
    using namespace fdcan;
    const std::map<std::string, std::uint32_t> mask = read_table("fdcan").mask;
    const std::map<std::string, std::uint32_t> bits{
        {"RCC_APB1HENR.FDCANEN", kClock},    {"FDCAN1_CCCR.INIT", kInit},
        {"FDCAN1_CCCR.CCE", kChangeEnable},  {"FDCAN1_CCCR.CSA", kStopAcknowledged},
        {"FDCAN1_CCCR.CSR", kStopRequest},   {"FDCAN1_CCCR.FDOE", kFdEnable},
        {"FDCAN1_CCCR.BRSE", kSwitchEnable}, {"FDCAN1_DBTP.TDC", kDelayCompensation},
        {"FDCAN1_ECR.TEC", kTransmitErrors}, {"FDCAN1_ECR.REC", kReceiveErrors},
        {"FDCAN1_ECR.CEL", kLoggedErrors},   {"FDCAN1_PSR.LEC", kLastError},
        {"FDCAN1_PSR.EP", kErrorPassive},    {"FDCAN1_PSR.EW", kErrorWarning},
        {"FDCAN1_PSR.BO", kBusOff},          {"FDCAN1_IR.RF0N", kNewInFifo0},
        {"FDCAN1_IR.RF0L", kLostInFifo0},    {"FDCAN1_IR.BO", kBusOffChanged},
        {"FDCAN1_IE.RF0NE", kNewInFifo0},    {"FDCAN1_IE.BOE", kBusOffChanged},
        {"FDCAN1_ILE.EINT0", kLine0},        {"FDCAN1_RXF0S.F0FL", kFillLevel},
        {"FDCAN1_RXF0S.F0GI", kGetIndex},    {"FDCAN1_TXFQS.TFQPI", kPutIndex},
        {"FDCAN1_TXFQS.TFQF", kTxFull},      {"FDCAN1_RXESC.F0DS", kData64},
        {"FDCAN1_TXESC.TBDS", kData64},
    };
    for (const auto& [name, value] : bits) {
        EXPECT_EQ(value, mask.at(name)) << name;
    }
    // Values at the start of fields.
    EXPECT_EQ(kStampByBits & ~mask.at("FDCAN1_TSCC.TSS"), 0U);
    EXPECT_EQ(64U << kFifoSizeAt & ~mask.at("FDCAN1_RXF0C.F0S"), 0U);
    EXPECT_EQ(32U << kTxFifoSizeAt & ~mask.at("FDCAN1_TXBC.TFQS"), 0U);
    EXPECT_EQ(kGetIndex >> kGetIndexAt << kGetIndexAt, kGetIndex);
    EXPECT_EQ(kPutIndex >> kPutIndexAt << kPutIndexAt, kPutIndex);
    EXPECT_EQ((kMessageRamBytes - 4) & ~mask.at("FDCAN1_RXF0C.F0SA"), 0U);
    EXPECT_EQ((kMessageRamBytes - 4) & ~mask.at("FDCAN1_TXBC.TBSA"), 0U);
}

TEST(FdcanRegisters, ModelHasTheAddressesOfTheTable) {
    using namespace model::fdcan_at;
    std::map<std::string, std::uint32_t> at{
        {"RCC_APB1HENR", model::rcc::kBase + model::rcc::kApb1h},
        {"SRAMCAN", model::FdcanRam::kBase},
        {"FDCAN2_ENDN", model::FdcanModel::kFdcan2 + endn},
    };
    const std::map<std::string, std::uint32_t> offsets{
        {"ENDN", endn},   {"DBTP", dbtp},   {"CCCR", cccr},   {"NBTP", nbtp},   {"TSCC", tscc},
        {"TSCV", tscv},   {"ECR", ecr},     {"PSR", psr},     {"TDCR", tdcr},   {"IR", ir},
        {"IE", ie},       {"ILS", ils},     {"ILE", ile},     {"GFC", gfc},     {"SIDFC", sidfc},
        {"XIDFC", xidfc}, {"RXF0C", rxf0c}, {"RXF0S", rxf0s}, {"RXF0A", rxf0a}, {"RXESC", rxesc},
        {"TXBC", txbc},   {"TXFQS", txfqs}, {"TXESC", txesc}, {"TXBRP", txbrp}, {"TXBAR", txbar},
    };
    for (const auto& [name, offset] : offsets) {
        at["FDCAN1_" + name] = model::FdcanModel::kFdcan1 + offset;
    }
    EXPECT_EQ(at, read_table("fdcan").address);
}

}  // namespace
}  // namespace sc::stm32h743
