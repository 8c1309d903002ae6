// SPDX-License-Identifier: Apache-2.0
#include "host/drives/drive_plan_file.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "boards/drive_file/drive_file.hpp"
#include "host/drives/bus_text.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host {
namespace {

class DrivePlanFile : public testing::Test {
protected:
    void SetUp() override {
        folder_ =
            std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        file_ = folder_ / "machine.toml";
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    void write(const std::string& text) const { std::ofstream(file_) << text; }
    std::filesystem::path folder_;
    std::filesystem::path file_;
};

DriveOptions some() {
    DriveOptions options;
    options.bus = 1;
    options.status_every = 2;
    options.paired = true;
    options.homing_method = -3;
    options.absent = drive_object::k6007 | drive_object::kTpdos;
    options.brake_release_ms = 80;
    options.brake_apply_ms = 60;
    options.vendor = 0x2EF;
    options.product = 0xFFFF'FFFE;
    return options;
}

TEST_F(DrivePlanFile, WhatIsWrittenBothSidesRead) {
    write_drive_table(file_, 2, 17, some(), "it's.eds");
    write_drive_table(file_, 0, 5, DriveOptions{}, "x.eds");
    MachineConfig machine = reference_machine();
    const DrivePlan plan = read_drive_plan(file_, machine);
    EXPECT_EQ(plan.drive[2], some());
    EXPECT_EQ(plan.drive[0], DriveOptions{});
    EXPECT_EQ(machine.axis[2].drive_node, 17);
    EXPECT_EQ(machine.axis[0].drive_node, 5);
    MachineConfig boards = reference_machine();
    EXPECT_EQ(drive_file::read_drive_file(file_, boards).plan, plan);
    EXPECT_EQ(boards.axis[2].drive_node, 17);
}

TEST_F(DrivePlanFile, ATableIsReplacedAndTheRestStays) {
    write("# my machine\n[drives]\ncycle_ms = 1\n\n[drives.x]\nnode = 9\n\n[other]\nkey = 1 # stays\n");
    write_drive_table(file_, 0, 3, some(), "x.eds");
    const std::string text = read_text_file(file_);
    EXPECT_TRUE(text.starts_with("# my machine\n[drives]\ncycle_ms = 1\n"));
    EXPECT_NE(text.find("key = 1 # stays"), std::string::npos);
    EXPECT_EQ(text.find("node = 9"), std::string::npos);
    MachineConfig machine = reference_machine();
    EXPECT_EQ(read_drive_plan(file_, machine).drive[0], some());
    EXPECT_EQ(machine.drive_cycle_ticks, 1U);
}

TEST_F(DrivePlanFile, BadOnesAreRefusedWithTheirLine) {
    struct Bad {
        const char* text;
        int line;
    };
    for (const Bad& bad :
         {Bad{"[drives.x]\nnode = 0\n", 2}, Bad{"[drives.x]\nnode = \"one\"\n", 2}, Bad{"\n[drives.q]\n", 2},
          Bad{"[drives.x]\nbuss = 1\n", 2}, Bad{"[drives.x]\n\nabsent = [\"6040\"]\n", 3},
          Bad{"[drives.x]\nabsent = 3\n", 2}, Bad{"[drives.x]\npaired = 1\n", 2},
          Bad{"[drives.x]\nstatus_every = 17\n", 2}, Bad{"[drives.x\n", 1}, Bad{"[drives]\ncycle_ms = 0\n", 2}}) {
        write(bad.text);
        MachineConfig machine = reference_machine();
        try {
            static_cast<void>(read_drive_plan(file_, machine));
            ADD_FAILURE() << bad.text;
        } catch (const InputError& error) {
            EXPECT_EQ(error.line(), bad.line) << error.what();
        }
        EXPECT_THROW(static_cast<void>(drive_file::read_drive_file(file_, machine)), std::invalid_argument) << bad.text;
    }
    MachineConfig machine = reference_machine();
    EXPECT_THROW(static_cast<void>(read_drive_plan(folder_ / "none.toml", machine)), InputError);
}

TEST(BusText, ShowsTheArithmeticOfARefusal) {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 1;
    const BusSheet sheet = bus_sheet(machine, {});
    EXPECT_FALSE(sheet.fits());
    const std::string text = text_of(sheet);
    for (const char* const part :
         {"1 x  55 bits in  1.0 ms    5.50 %", "4 x 115 bits in  1.0 ms   46.00 %", "cyclic 97.50 %", "does not fit"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
    }
    EXPECT_TRUE(bus_sheet(reference_machine(), {}).fits());
    EXPECT_NE(drive_file::budget_text(machine, {}).find("97.50 %"), std::string::npos);
}

}  // namespace
}  // namespace sc::host
