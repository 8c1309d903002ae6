// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/drive_bus.hpp"

#include <array>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

namespace sc::linux_rt {
namespace {

using socketcan::CanFrame;
using socketcan::CanSocket;

class TwoBuses : public testing::Test {
protected:
    TwoBuses() : bus_(make()) {}
    std::vector<CanSocket> make() {
        std::vector<CanSocket> ours;
        for (int i = 0; i < 2; ++i) {
            std::array<int, 2> files{};
            EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, files.data()), 0);
            ours.emplace_back(files[0]);
            drives_.emplace_back(files[1]);
        }
        return ours;
    }
    void drive_says(std::size_t bus, std::uint16_t id, std::uint8_t size = 6, std::uint8_t first = 1) {
        CanFrame frame;
        frame.id = id;
        frame.size = size;
        frame.data[0] = first;
        EXPECT_EQ(drives_.at(bus).send(frame), socketcan::CanSent::yes);
    }
    std::vector<std::uint32_t> heard(std::size_t bus) {
        std::vector<std::uint32_t> ids;
        CanFrame frame;
        while (drives_.at(bus).receive(frame)) {
            ids.push_back(frame.id);
        }
        return ids;
    }
    void send(std::uint16_t id) {
        const DriveFrame frame{.id = id, .size = 1};
        bus_.send(std::span(&frame, 1));
    }
    using Ids = std::vector<std::uint32_t>;
    std::vector<CanSocket> drives_;
    DriveBus bus_;
};

TEST_F(TwoBuses, AFrameGoesToTheBusThatItsIdentifierSays) {
    send(0x080);
    send(0x080 | kSecondDriveBus);
    send(0x202 | kSecondDriveBus);
    EXPECT_EQ(heard(0), Ids{0x080});
    EXPECT_EQ(heard(1), (Ids{0x080, 0x202}));
    drive_says(0, 0x181);
    drive_says(1, 0x181);
    const auto frames = bus_.receive();
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[0].id, 0x181);
    EXPECT_EQ(frames[1].id, 0x181 | kSecondDriveBus);
}

TEST_F(TwoBuses, FramesBeyondATickWaitForTheNext) {
    for (std::size_t i = 0; i < kDriveFramesPerTick + 3; ++i) {
        drive_says(i % 2, static_cast<std::uint16_t>(0x180 + 1 + i % 4));
    }
    EXPECT_EQ(bus_.receive().size(), kDriveFramesPerTick);
    EXPECT_EQ(bus_.counters().held, 3U);
    EXPECT_EQ(bus_.receive().size(), 3U);
    EXPECT_EQ(bus_.receive().size(), 0U);
}

TEST_F(TwoBuses, WhatNoDriveSendsIsCountedAndDropped) {
    CanFrame frame;
    frame.id = 0x181;
    frame.extended = true;
    (void)drives_[0].send(frame);
    frame.extended = false;
    frame.fd = true;
    (void)drives_[0].send(frame);
    EXPECT_EQ(bus_.receive().size(), 0U);
    EXPECT_EQ(bus_.counters().foreign, 2U);
}

TEST_F(TwoBuses, WaitsForThoseThatAnsweredBefore) {
    const auto sync = [this] {
        send(0x080);
        send(0x080 | kSecondDriveBus);
    };
    for (int i = 0; i < 2; ++i) {
        sync();
        EXPECT_TRUE(bus_.answered());
        drive_says(0, 0x181);
        drive_says(1, 0x181);
        EXPECT_TRUE(bus_.answered());
    }
    sync();
    EXPECT_FALSE(bus_.answered());
    drive_says(0, 0x181);
    EXPECT_FALSE(bus_.answered());
    drive_says(1, 0x181);
    EXPECT_TRUE(bus_.answered());
    sync();
    drive_says(0, 0x181);
    EXPECT_FALSE(bus_.answered());
    bus_.give_up();
    EXPECT_TRUE(bus_.answered());
    EXPECT_EQ(bus_.counters().unanswered, 1U);
    sync();
    drive_says(0, 0x181);
    EXPECT_TRUE(bus_.answered());  // the other is not waited for until it speaks again
}

TEST_F(TwoBuses, ADriveThatIsResetIsNotWaitedForUntilItSpeaksAgain) {
    const auto both_answer = [this] {
        send(0x080);
        drive_says(0, 0x181);
        drive_says(0, 0x182);
        EXPECT_TRUE(bus_.answered());
    };
    both_answer();
    both_answer();
    const auto nmt = [this](std::uint8_t command, std::uint8_t node) {
        const DriveFrame frame{.id = 0, .size = 2, .data = {command, node}};
        bus_.send(std::span(&frame, 1));
    };
    nmt(0x01, 1);  // start: nothing changes
    send(0x080);
    drive_says(0, 0x182);
    EXPECT_FALSE(bus_.answered());
    nmt(0x81, 1);  // reset
    EXPECT_TRUE(bus_.answered());
    send(0x080);
    EXPECT_FALSE(bus_.answered());  // the other one is
    drive_says(0, 0x182);
    EXPECT_TRUE(bus_.answered());
    nmt(0x81, 0);  // of all
    send(0x080);
    EXPECT_TRUE(bus_.answered());
    EXPECT_EQ(bus_.counters().unanswered, 0U);
}

TEST_F(TwoBuses, ADriveThatAnswersEverySecondSyncIsWaitedForThenAlone) {
    for (int i = 0; i < 2; ++i) {
        send(0x080);
        send(0x080);
        drive_says(0, 0x181);
        EXPECT_TRUE(bus_.answered());
    }
    send(0x080);
    EXPECT_TRUE(bus_.answered());
    send(0x080);
    EXPECT_FALSE(bus_.answered());
    drive_says(0, 0x181);
    EXPECT_TRUE(bus_.answered());
}

TEST_F(TwoBuses, WaitsForTheReplyToAnSdoAndForgetsADriveThatBoots) {
    drive_says(0, 0x701, 1, 0);
    (void)bus_.receive();
    send(0x601);
    EXPECT_FALSE(bus_.answered());
    drive_says(0, 0x581, 8);
    EXPECT_TRUE(bus_.answered());
    drive_says(0, 0x181);
    (void)bus_.receive();
    drive_says(0, 0x701, 1, 0);
    (void)bus_.receive();
    send(0x080);
    EXPECT_TRUE(bus_.answered());
}

TEST_F(TwoBuses, FramesThatABusDoesNotTakeAreDroppedAndCounted) {
    drives_.clear();
    send(0x080);
    send(0x080 | kSecondDriveBus);
    EXPECT_EQ(bus_.counters().unsent, 2U);
}

}  // namespace
}  // namespace sc::linux_rt
