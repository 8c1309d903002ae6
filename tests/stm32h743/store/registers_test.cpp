// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/backup.hpp"
#include "boards/stm32h743/registers/flash.hpp"
#include "boards/stm32h743/store/backup_ram.hpp"
#include "tests/stm32h743/model/backup_ram.hpp"
#include "tests/stm32h743/model/flash.hpp"

namespace sc::stm32h743 {
namespace {

struct Table {
    std::map<std::string, std::uint32_t> address;
    std::map<std::string, std::uint32_t> mask;  ///< REGISTER.FIELD
};

Table read_table(const std::string& name) {
    Table table;
    std::ifstream file(SC_TEST_DATA "/stm32h743/" + name);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::istringstream in(line);
        std::array<std::string, 5> cell;
        for (std::string& one : cell) {
            std::getline(in, one, ',');
        }
        table.address[cell[0]] = static_cast<std::uint32_t>(std::stoul(cell[1], nullptr, 16));
        if (!cell[2].empty()) {
            const unsigned long bits = (1UL << std::stoul(cell[4])) - 1UL;
            table.mask[cell[0] + "." + cell[2]] = static_cast<std::uint32_t>(bits << std::stoul(cell[3]));
        }
    }
    return table;
}

TEST(FlashRegisters, TheDriverHasWhatTheTableHas) {
    namespace regs = flash_registers;
    const Table table = read_table("flash.csv");
    const std::map<std::string, std::uint32_t> addresses{
        {"FLASH_KEYR1", regs::kKeyr},
        {"FLASH_CR1", regs::kCr},
        {"FLASH_SR1", regs::kSr},
        {"FLASH_CCR1", regs::kCcr},
        {"FLASH_KEYR2", regs::kKeyr + regs::kBank2},
        {"FLASH_CR2", regs::kCr + regs::kBank2},
        {"FLASH_SR2", regs::kSr + regs::kBank2},
        {"FLASH_CCR2", regs::kCcr + regs::kBank2},
        {"SCB_CCR", regs::kScbCcr},
        {"SCB_CFSR", regs::kCfsr},
        {"SCB_DCIMVAC", regs::kDcimvac},
    };
    const std::map<std::string, std::uint32_t> masks{
        {"FLASH_CR1.LOCK", regs::kLock},
        {"FLASH_CR1.PG", regs::kProgram},
        {"FLASH_CR1.SER", regs::kSectorErase},
        {"FLASH_CR1.PSIZE", regs::kSize64},
        {"FLASH_CR1.START", regs::kStart},
        {"FLASH_CR1.SNB", regs::kSectorMask},
        {"FLASH_SR1.BSY", regs::kBusy},
        {"FLASH_SR1.WBNE", regs::kBufferNotEmpty},
        {"FLASH_SR1.QW", regs::kQueued},
        {"FLASH_SR1.WRPERR", regs::kWriteProtection},
        {"FLASH_SR1.PGSERR", regs::kSequence},
        {"FLASH_SR1.STRBERR", regs::kStrobe},
        {"FLASH_SR1.INCERR", regs::kInconsistency},
        {"FLASH_SR1.OPERR", regs::kOperation},
        {"FLASH_SR1.RDPERR", regs::kReadProtection},
        {"FLASH_SR1.RDSERR", regs::kSecure},
        {"FLASH_SR1.SNECCERR", regs::kSingleError},
        {"FLASH_SR1.DBECCERR", regs::kDoubleError},
        {"SCB_CCR.BFHFNMIGN", regs::kIgnoreBusFaults},
        {"SCB_CFSR.PRECISERR", regs::kPreciseBusFault},
        {"SCB_CFSR.BFARVALID", regs::kBusFaultAddress},
    };
    EXPECT_EQ(addresses, table.address);
    EXPECT_EQ(masks, table.mask);
}

TEST(FlashRegisters, TheModelHasWhatTheTableHas) {
    using model::Core;
    using model::Flash;
    const Table table = read_table("flash.csv");
    const std::map<std::string, std::uint32_t> addresses{
        {"FLASH_KEYR1", Flash::kRegisters + Flash::kKey},
        {"FLASH_CR1", Flash::kRegisters + Flash::kControl},
        {"FLASH_SR1", Flash::kRegisters + Flash::kStatus},
        {"FLASH_CCR1", Flash::kRegisters + Flash::kClear},
        {"FLASH_KEYR2", Flash::kRegisters + Flash::kSecondBank + Flash::kKey},
        {"FLASH_CR2", Flash::kRegisters + Flash::kSecondBank + Flash::kControl},
        {"FLASH_SR2", Flash::kRegisters + Flash::kSecondBank + Flash::kStatus},
        {"FLASH_CCR2", Flash::kRegisters + Flash::kSecondBank + Flash::kClear},
        {"SCB_CCR", Core::kBase + Core::kConfiguration},
        {"SCB_CFSR", Core::kBase + Core::kFaults},
        {"SCB_DCIMVAC", Core::kBase + Core::kForgetLine},
    };
    EXPECT_EQ(addresses, table.address);
    std::map<std::string, std::uint32_t> masks = Flash::kMasks;
    masks.insert(Core::kMasks.begin(), Core::kMasks.end());
    EXPECT_EQ(masks, table.mask);
}

TEST(BackupRegisters, TheDriverHasWhatTheTableHas) {
    namespace regs = backup_registers;
    const Table table = read_table("backup_ram.csv");
    const std::map<std::string, std::uint32_t> addresses{
        {"RCC_AHB4ENR", regs::kAhb4enr},
        {"PWR_CR1", regs::kPwrCr1},
        {"PWR_CR2", regs::kPwrCr2},
        {"BKPSRAM", kBackupRam},
    };
    const std::map<std::string, std::uint32_t> masks{
        {"RCC_AHB4ENR.BKPRAMEN", regs::kRamClock},
        {"PWR_CR1.DBP", regs::kAccess},
        {"PWR_CR2.BREN", regs::kRegulator},
        {"PWR_CR2.BRRDY", regs::kRegulatorReady},
    };
    EXPECT_EQ(addresses, table.address);
    EXPECT_EQ(masks, table.mask);
}

TEST(BackupRegisters, TheModelHasWhatTheTableHas) {
    using model::BackupRam;
    const Table table = read_table("backup_ram.csv");
    const std::map<std::string, std::uint32_t> addresses{
        {"RCC_AHB4ENR", BackupRam::kClocks},
        {"PWR_CR1", BackupRam::kPower + BackupRam::kPowerControl1},
        {"PWR_CR2", BackupRam::kPower + BackupRam::kPowerControl2},
        {"BKPSRAM", BackupRam::kRam},
    };
    EXPECT_EQ(addresses, table.address);
    EXPECT_EQ(BackupRam::kMasks, table.mask);
}

}  // namespace
}  // namespace sc::stm32h743
