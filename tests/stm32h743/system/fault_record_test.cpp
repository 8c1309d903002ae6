// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/fault_record.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/access.hpp"
#include "boards/stm32h743/system/pins.hpp"
#include "tests/stm32h743/model/core_faults.hpp"

namespace sc::stm32h743 {
namespace {

namespace fields = model::clock_fields;
namespace faults = model::fault_fields;

class Chip {
public:
    Chip() : dtcm(128 * std::size_t{1024}) { machine.map_memory(0x20000000, dtcm); }
    void put(std::uint32_t at, std::uint32_t word) {
        for (unsigned i = 0; i < 4; ++i) {
            dtcm.at(at - 0x20000000 + i) = static_cast<std::uint8_t>(word >> (8 * i));
        }
    }

    model::Machine machine;
    model::ClockTree tree{machine};
    model::BackupRam ram{machine, tree};
    model::CoreStatus core{machine};
    model::OutputPort port_e{machine, tree, faults::kPortE, fields::kGpioEEn};
    model::OutputPort port_f{machine, tree, faults::kPortF, fields::kGpioFEn};
    model::MainOutput tim1{machine, tree};
    std::vector<std::uint8_t> dtcm;
};

FaultRecord example() {
    return {.exception = 5,
            .tick = 123'456,
            .sp = 0x2000'1FE0,
            .pc = 0x0000'1234,
            .lr = 0x0000'1201,
            .xpsr = 0x6100'0005,
            .cfsr = 0x0000'8200,
            .hfsr = 0,
            .memory_address = 0,
            .bus_address = 0x4000'FFFC,
            .abfsr = 8,
            .clock_flags = 1,
            .flash_bank1 = 2,
            .flash_bank2 = 3};
}

TEST(SafeOutputs, EveryLineToTheLaserGoesLowAndNothingElseMoves) {
    Chip chip;
    chip.tree.preset(fields::kTim1En, 1);
    // Gate and trigger by TIM1, all lines high, the others in use.
    chip.port_e.preset(0x8808'0554 | 2U << 18U | 2U << 26U, 0xFFFF);
    chip.port_e.drive(0xFFFF);
    chip.port_f.preset(0x5555'5555, 0xFFFF);
    chip.tim1.preset(0x8000 | 0x1C00);
    const std::uint32_t before_e = chip.port_e.levels();
    chip.port_e.watch(0xFFFF);
    chip.port_f.watch(0xFFFF);
    make_outputs_safe();
    constexpr std::uint32_t kGateAndTrigger = 1U << 9U | 1U << 13U;
    constexpr std::uint32_t kOthers = 1U << 9U | 1U << 10U | 1U << 11U | 1U << 15U;
    EXPECT_EQ(before_e & kGateAndTrigger, kGateAndTrigger);
    EXPECT_EQ(chip.port_e.levels(), before_e & ~kGateAndTrigger);
    EXPECT_EQ(chip.port_f.levels(), kOthers);
    EXPECT_EQ(chip.port_f.modes(), 0x5555'5555U);
    chip.tree.preset(fields::kTim1En, 1);
    EXPECT_EQ(read32(faults::kTim1 + 0x44), 0x1C00U);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(SafeOutputs, NoLineRisesOnTheWay) {
    Chip chip;
    chip.port_e.preset(2U << 18U | 2U << 26U, 0xFFFF);  // TIM1 holds both low
    chip.port_f.preset(0, 0xFFFF);
    chip.port_e.watch(0xFFFF);
    chip.port_f.watch(0xFFFF);
    make_outputs_safe();
    EXPECT_EQ(chip.port_e.levels(), 0U);
    EXPECT_EQ(chip.port_f.levels(), 0U);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(SafeOutputs, BeforeAnyPinWasSetUp) {
    Chip chip;
    chip.port_e.watch(0xFFFF);
    chip.port_f.watch(0xFFFF);
    make_outputs_safe();
    EXPECT_EQ(chip.port_e.levels(), 0U);
    EXPECT_EQ(chip.port_f.levels(), 0U);
    EXPECT_EQ(chip.port_e.modes() >> 18U & 3U, 1U);
    EXPECT_EQ(chip.port_f.modes() >> 28U & 3U, 1U);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(FaultRecord, IsThereAfterTheResetOnceAndWhole) {
    Chip chip;
    leave_fault_record(example());
    chip.ram.reset();
    ASSERT_TRUE(start_fault_records());
    const auto found = take_fault_record();
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(*found, example());
    EXPECT_FALSE(take_fault_record().has_value());
    chip.ram.reset();
    EXPECT_FALSE(take_fault_record().has_value());
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(FaultRecord, LeavesTheRestOfTheRamAlone) {
    Chip chip;
    chip.ram.fill(0x1234'5678);
    leave_fault_record(example());
    (void)take_fault_record();
    for (std::uint32_t at = 0x3880'0000; at < 0x3880'1000; at += 4) {
        if (at < 0x3880'0F00 || at >= 0x3880'0F40) {
            ASSERT_EQ(read32(at), 0x1234'5678U) << std::hex << at;
        }
    }
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(FaultRecord, WhateverPowerLeavesInTheRamIsNone) {
    Chip chip;
    for (const std::uint32_t word : {0U, ~0U, 0xAAAA'AAAAU, 0x5555'5555U, 1U}) {
        chip.ram.fill(word);
        EXPECT_FALSE(take_fault_record().has_value());
    }
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(FaultRecord, NoFlippedBitPasses) {
    Chip chip;
    for (std::uint32_t offset = 0xF00; offset < 0xF3C; offset += 4) {
        for (unsigned bit = 0; bit < 32; ++bit) {
            leave_fault_record(example());
            chip.ram.flip(offset, bit);
            EXPECT_FALSE(take_fault_record().has_value()) << offset << ' ' << bit;
        }
    }
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(FaultRecord, AResetAtAnyWriteLeavesAWholeRecordOrNone) {
    FaultRecord second = example();
    second.pc = 0x0000'5678;
    second.tick = 99;
    std::uint32_t whole = 0;
    for (std::uint32_t writes = 0; writes <= 20; ++writes) {
        Chip chip;
        leave_fault_record(example());
        chip.ram.cut_after(writes);
        leave_fault_record(second);
        chip.ram.reset();
        const auto found = take_fault_record();
        whole += found == second ? 1U : 0U;
        EXPECT_TRUE(!found || *found == second || *found == example()) << writes;
        EXPECT_EQ(chip.machine.violations_text(), "");
    }
    EXPECT_GT(whole, 0U);
    EXPECT_LT(whole, 20U);
}

TEST(GatherFault, HasWhatTheCoreTells) {
    Chip chip;
    note_tick(4711);
    chip.put(0x2000'0414, 0x0000'2345);
    chip.put(0x2000'0418, 0x0000'1230);
    chip.put(0x2000'041C, 0x0100'0003);
    chip.core.preset(0xE000'ED28, 0x0000'8282);
    chip.core.preset(0xE000'ED2C, 0x4000'0000);
    chip.core.preset(0xE000'ED34, 0x2002'0000);
    chip.core.preset(0xE000'ED38, 0x6000'0000);
    chip.core.preset(0xE000'EFA8, 8);
    chip.tree.preset(fields::kHseStopped, 1);
    chip.tree.preset(fields::kBank1Double, 1);
    chip.tree.preset(fields::kBank2Double, 1);
    const FaultRecord expected{.exception = 3,
                               .tick = 4711,
                               .sp = 0x2000'0400,
                               .pc = 0x0000'1230,
                               .lr = 0x0000'2345,
                               .xpsr = 0x0100'0003,
                               .cfsr = 0x0000'8282,
                               .hfsr = 0x4000'0000,
                               .memory_address = 0x2002'0000,
                               .bus_address = 0x6000'0000,
                               .abfsr = 8,
                               .clock_flags = 1U << 10U,
                               .flash_bank1 = 1U << 26U,
                               .flash_bank2 = 1U << 26U};
    EXPECT_EQ(gather_fault(3, 0x2000'0400), expected);
    chip.core.preset(0xE000'ED28, 0x0000'0400);
    EXPECT_EQ(gather_fault(3, 0x2000'0400).memory_address, 0U);
    EXPECT_EQ(gather_fault(3, 0x2000'0400).bus_address, 0U);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(GatherFault, DoesNotReadAStackThatIsNotThere) {
    Chip chip;
    for (const std::uint32_t sp : {0U, 0x1FFF'FFFCU, 0x2001'FFE4U, 0x2002'0000U, 0x2000'0402U, 0xFFFF'FFFCU}) {
        const FaultRecord record = gather_fault(4, sp);
        EXPECT_EQ(record.sp, sp);
        EXPECT_EQ(record.pc, 0U);
    }
    chip.put(0x2001'FFF8, 7);
    EXPECT_EQ(gather_fault(4, 0x2001'FFE0).pc, 7U);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(FaultRecord, StartGivesFaultsTheirOwnHandlers) {
    Chip chip;
    ASSERT_TRUE(start_fault_records());
    EXPECT_EQ(chip.core.word(0xE000'ED24), 7U << 16U);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(Pins, TheTableSaysWhatTheDriversUse) {
    EXPECT_EQ(kSafeLowE, 1U << 9U | 1U << 13U);
    EXPECT_EQ(kSafeLowF, 0x71FFU);
    EXPECT_EQ(pins_of(Port::e, PinUse::output), 1U << 1U | 15U << 2U);
    EXPECT_EQ(pins_of(Port::e, PinUse::input), 1U << 7U | 1U << 8U | 1U << 15U);
}

}  // namespace
}  // namespace sc::stm32h743
