// SPDX-License-Identifier: Apache-2.0
// Segmented SDO of the master's side against the simulated drive's server.
#include "firmware/drives/sdo_transfer.hpp"

#include <algorithm>
#include <array>
#include <string>

#include <gtest/gtest.h>

#include "tests/sim/firmware/drives/drive_loop.hpp"

namespace sc::test {
namespace {

using Result = drives::SdoTransfer::Result;

std::string read_text(DriveLoop& loop, drives::SdoTransfer& transfer, std::uint16_t index) {
    std::array<std::uint8_t, 64> bytes{};
    transfer.read(index, 0, bytes);
    loop.run(500, [&] { return transfer.result() != Result::busy; });
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(transfer.size())};
}

TEST(SdoTransfer, ReadsNamesAndNumbersWhileTheDriveIsInOperation) {
    DriveLoop loop;
    drives::SdoTransfer transfer;
    loop.master.attach(1, &transfer);
    ASSERT_TRUE(loop.enable());
    EXPECT_EQ(read_text(loop, transfer, 0x1008), "scribecell simulated servo drive");
    EXPECT_EQ(transfer.result(), Result::done);
    EXPECT_EQ(read_text(loop, transfer, 0x1009), "1.0");
    EXPECT_EQ(read_text(loop, transfer, 0x100A), "CiA 402 CSP and homing");
    std::array<std::uint8_t, 4> type{};
    transfer.read(0x1000, 0, type);
    loop.run(100, [&] { return transfer.result() != Result::busy; });
    EXPECT_EQ(type[0] | (type[1] << 8), 402);
    EXPECT_TRUE(loop.outcome.all_follow);
}

TEST(SdoTransfer, WritesInSegmentsOfEachLength) {
    DriveLoop loop;
    drives::SdoTransfer transfer;
    loop.master.attach(0, &transfer);
    ASSERT_TRUE(loop.enable());
    for (std::size_t length = 1; length <= 30; ++length) {
        std::string text;
        for (std::size_t i = 0; i < length; ++i) {
            text += static_cast<char>('a' + i % 26);
        }
        transfer.write(0x2000, 0, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
        ASSERT_TRUE(loop.run(500, [&] { return transfer.result() != Result::busy; }));
        ASSERT_EQ(transfer.result(), Result::done) << length;
        ASSERT_EQ(read_text(loop, transfer, 0x2000), text);
    }
}

TEST(SdoTransfer, EndsWithTheReason) {
    DriveLoop loop;
    drives::SdoTransfer transfer;
    loop.master.attach(0, &transfer);
    ASSERT_TRUE(loop.enable());
    std::array<std::uint8_t, 64> bytes{};
    transfer.read(0x5FFF, 0, bytes);
    loop.run(100, [&] { return transfer.result() != Result::busy; });
    EXPECT_EQ(transfer.result(), Result::aborted);
    EXPECT_EQ(transfer.abort_code(), 0x0602'0000U);
    transfer.read(0x1008, 0, std::span(bytes).first(10));
    loop.run(100, [&] { return transfer.result() != Result::busy; });
    EXPECT_EQ(transfer.result(), Result::too_long);
    transfer.write(0x1008, 0, std::span(bytes).first(9));
    loop.run(100, [&] { return transfer.result() != Result::busy; });
    EXPECT_EQ(transfer.abort_code(), 0x0601'0002U);
    EXPECT_EQ(read_text(loop, transfer, 0x1009), "1.0") << "the channel is free again";
    loop.drives[0].go_silent(true);
    transfer.read(0x1008, 0, bytes);
    loop.run(400, [&] { return transfer.result() != Result::busy; });
    EXPECT_EQ(transfer.result(), Result::busy) << "no drive, no channel";
    loop.drives[0].go_silent(false);
    loop.run(3000, [&] { return transfer.result() != Result::busy; });
    EXPECT_EQ(transfer.result(), Result::timed_out) << "the drive has booted again";
}

/// Homing uses the same channel.
TEST(SdoTransfer, GivesWayToTheMaster) {
    DriveLoop loop;
    drives::SdoTransfer transfer;
    loop.master.attach(0, &transfer);
    ASSERT_TRUE(loop.enable());
    std::array<std::uint8_t, 64> bytes{};
    loop.request.home = true;
    loop.request.home_axes = 1;
    int finished = 0;
    const bool homed = loop.run(20'000, [&] {
        if (transfer.result() != Result::busy) {
            ++finished;
            transfer.read(0x1008, 0, bytes);
        }
        return loop.outcome.homing_done;
    });
    EXPECT_TRUE(homed);
    EXPECT_GT(finished, 3);
}

}  // namespace
}  // namespace sc::test
