// SPDX-License-Identifier: Apache-2.0
#include "host/drives/drive_report.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "firmware/drives/drive_configuration.hpp"

namespace sc::host {
namespace {

using Found = DriveFinding::Kind;

std::string text_of(const char* name) {
    std::ifstream in(std::filesystem::path(SC_TEST_DATA) / "canopen" / name);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}
constexpr const char* kFake = "cia402_slave.eds";

DriveReport report_of(const std::string& text) {
    return judge_drive(parse_eds("drive.eds", text), reference_machine(), 0);
}

std::vector<EdsKey> keys(const DriveReport& report, Found kind) {
    std::vector<EdsKey> found;
    for (const DriveFinding& finding : report.findings) {
        if (finding.kind == kind) {
            found.push_back(finding.key);
        }
    }
    return found;
}

TEST(DriveReport, NamesWhatEachDriveLacks) {
    const DriveReport fake = report_of(text_of(kFake));
    EXPECT_TRUE(fake.usable());
    EXPECT_EQ(fake.modes, (std::vector<std::string>{"PP", "PV", "HM", "CSP"}));
    EXPECT_FALSE(fake.paired_targets);
    EXPECT_TRUE(fake.nth_sync);
    const auto absent = keys(fake, Found::absent);
    for (const EdsKey key : {EdsKey{0x6007, 0}, EdsKey{0x6066, 0}, EdsKey{0x1006, 0}}) {
        EXPECT_NE(std::ranges::find(absent, key), absent.end()) << eds_text(key);
    }

    const DriveReport servo = report_of(text_of("TMCM-1636-CANopen_Hw1.1_Fw1.12.eds"));
    EXPECT_TRUE(servo.usable());
    EXPECT_EQ(keys(servo, Found::to_check), (std::vector<EdsKey>{{0x6502, 0}})) << "no default: read from the drive";

    const DriveReport stepper = report_of(text_of("TMCM_1276_V3.22.eds"));
    EXPECT_FALSE(stepper.usable());
    EXPECT_EQ(keys(stepper, Found::wrong), (std::vector<EdsKey>{{0x1400, 2}})) << "fixed at 0xFF";

    const DriveReport full = report_of(text_of("e35.eds"));
    EXPECT_FALSE(full.usable());
    EXPECT_EQ(keys(full, Found::missing), (std::vector<EdsKey>{{0x1016, 1}, {0x605A, 0}}));
    EXPECT_TRUE(full.paired_targets);
}

/// The good one with one thing changed.
DriveReport changed(const std::string& section, const std::string& from, const std::string& to) {
    std::string text = text_of(kFake);
    std::erase(text, '\r');
    const std::size_t begin = text.find("[" + section + "]");
    EXPECT_NE(begin, std::string::npos) << section;
    const std::size_t at = text.find(from, begin);
    EXPECT_LT(at, text.find("\n[", begin)) << from << " in " << section;
    text.replace(at, from.size(), to);
    return report_of(text);
}
void expect_wrong(const DriveReport& report, EdsKey key, const std::string& word) {
    EXPECT_FALSE(report.usable());
    const auto found = std::ranges::find_if(report.findings, [&key](const DriveFinding& f) {
        return (f.kind == Found::wrong || f.kind == Found::missing) && f.key == key;
    });
    ASSERT_NE(found, report.findings.end()) << eds_text(key);
    EXPECT_NE(found->text.find(word), std::string::npos) << found->text;
}

TEST(DriveReport, ADriveWithoutCspIsRefusedWithTheReason) {
    expect_wrong(changed("6502", "0x000000A5", "0x00000025"), {0x6502, 0}, "cannot do CSP");
    expect_wrong(changed("6502", "0x000000A5", "0x00000085"), {0x6502, 0}, "no homing mode");
}

TEST(DriveReport, EachWrongObjectIsNamed) {
    expect_wrong(changed("6040", "PDOMapping=1", "PDOMapping=0"), {0x6040, 0}, "mapped");
    expect_wrong(changed("607A", "AccessType=rww", "AccessType=ro"), {0x607A, 0}, "written");
    expect_wrong(changed("6064", "DataType=0x0004", "DataType=0x0003"), {0x6064, 0}, "2 bytes, not 4");
    expect_wrong(changed("60C2sub1", "DataType=0x0005", "DataType=0x0006"), {0x60C2, 1}, "2 bytes");
    expect_wrong(changed("1600sub1", "AccessType=rw", "AccessType=const"), {0x1600, 1}, "cannot be written");
    expect_wrong(changed("6502", "AccessType=ro", "AccessType=wo"), {0x6502, 0}, "cannot be read");
    expect_wrong(changed("6098", "AccessType=rw", "AccessType=rw\nHighLimit=17"), {0x6098, 0}, "no more than 17");
    expect_wrong(changed("6060", "AccessType=rww", "AccessType=rww\nLowLimit=9"), {0x6060, 0}, "no less than 9");
    expect_wrong(changed("DeviceInfo", "BaudRate_1000=1", "BaudRate_1000=0"), {}, "1 Mbit/s");
    for (const EdsKey key : {EdsKey{0x6041, 0}, EdsKey{0x6061, 0}, EdsKey{0x605A, 0}, EdsKey{0x607C, 0}}) {
        // Renamed to an object that nobody asks for.
        expect_wrong(changed(eds_text(key), eds_text(key), "2F0" + eds_text(key).substr(3)), key, "");
    }
}

drives::SetupStep::Kind kind_of(DriveStep::Kind kind) {
    using Kind = drives::SetupStep::Kind;
    switch (kind) {
        case DriveStep::Kind::expect_bits: return Kind::expect_bits;
        case DriveStep::Kind::expect_value: return Kind::expect_value;
        case DriveStep::Kind::write: return Kind::write;
        case DriveStep::Kind::write_if_there: return Kind::write_optional;
        case DriveStep::Kind::write_and_read_back: break;
    }
    return Kind::write_checked;
}

void expect_same(const DriveReport& report, const drives::DriveSetup& sent) {
    std::vector<DriveStep> shown;
    std::ranges::copy_if(report.steps, std::back_inserter(shown), &DriveStep::sent);
    ASSERT_EQ(shown.size(), sent.size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
        EXPECT_EQ(shown[i].key, (EdsKey{sent[i].key.index, sent[i].key.sub}));
        EXPECT_EQ(shown[i].size, int{sent[i].key.size}) << eds_text(shown[i].key);
        EXPECT_EQ(shown[i].value, sent[i].value) << eds_text(shown[i].key);
        EXPECT_EQ(kind_of(shown[i].kind), sent[i].kind) << eds_text(shown[i].key);
    }
}

/// What is shown is what the controller sends: written twice, compared here, for each axis, data sheet and plan.
TEST(DriveReport, TheSetUpIsTheControllers) {
    const MachineConfig machine = reference_machine();
    for (const char* const file : {kFake, "TMCM-1636-CANopen_Hw1.1_Fw1.12.eds"}) {
        const Eds eds = parse_eds("drive.eds", text_of(file));
        for (unsigned variant = 0; variant < 16; ++variant) {
            DrivePlan plan;
            for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
                DriveOptions wanted;
                wanted.paired = (variant & 1U) != 0;
                wanted.status_every = (variant & 2U) != 0 ? 3 : 1;
                wanted.homing_method = (variant & 4U) != 0 ? -3 : 33;
                wanted.bus = (variant & 8U) != 0 && axis > 1 ? 1 : 0;
                plan.drive[axis] = options_by(eds, wanted);
            }
            for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
                expect_same(judge_drive(eds, machine, axis, plan), drives::DriveSetup(machine, axis, plan));
            }
        }
    }
}

TEST(DriveReport, WhatThePlanAsksForAndTheDriveLacksIsWrong) {
    const Eds eds = parse_eds("drive.eds", text_of(kFake));
    DrivePlan plan;
    plan.drive[0].paired = true;
    const DriveReport report = judge_drive(eds, reference_machine(), 0, plan);
    EXPECT_FALSE(report.usable());
    EXPECT_TRUE(std::ranges::any_of(report.findings, [](const DriveFinding& finding) {
        return finding.kind == Found::wrong && finding.text.find("Dummy0007") != std::string::npos;
    }));
    plan = {};
    plan.drive[0].brake_apply_ms = 50;
    EXPECT_EQ(judge_drive(eds, reference_machine(), 0, plan).usable(), eds.find(0x60FE, 1) != nullptr);
}

}  // namespace
}  // namespace sc::host
