// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/fdcan.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/link/fdcan_cell.hpp"

namespace sc::stm32h743 {
namespace {

using test::CanCell;
using test::fd_frame_of;
using test::frame_of;
using test::same;

constexpr std::uint8_t kFdSizes[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

class FdcanTest : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(host.start(), Fdcan::Start::ok);
        ASSERT_EQ(drive.start(), Fdcan::Start::ok);
        cell.pass_us(20);  // each waits for 11 recessive bits
    }
    void TearDown() override { EXPECT_EQ(cell.machine.violations_text(), ""); }

    void service(Fdcan& port) { port.service(cell.machine.now_ns()); }
    /// `from` sends, and a while later `to` has it and no more.
    void expect_passes(Fdcan& from, Fdcan& to, const CanFrame& frame) {
        ASSERT_EQ(from.send(frame), CanSent::yes);
        cell.pass_us(1000);
        CanFrame heard;
        ASSERT_TRUE(to.receive(heard)) << "id " << frame.id << " size " << int{frame.size};
        EXPECT_TRUE(same(heard, frame)) << "id " << frame.id << " size " << int{frame.size};
        EXPECT_FALSE(to.receive(heard));
    }

    CanCell cell;
    Fdcan host{kHostCan};
    Fdcan drive{kDriveCan};
};

TEST_F(FdcanTest, ClassicFramesOfAllLengthsPassBothWays) {
    for (std::uint8_t size = 0; size <= 8; ++size) {
        expect_passes(host, drive, frame_of(0x100U + size, size));
        expect_passes(drive, host, frame_of(0x7FFU - size, size, 3));
    }
    EXPECT_EQ(host.counters().sent, 9U);
    EXPECT_EQ(host.counters().received, 9U);
}

TEST_F(FdcanTest, ExtendedAndRemoteFramesPass) {
    CanFrame wide = frame_of(0x1ABCDEF0, 5);
    wide.extended = true;
    expect_passes(host, drive, wide);
    CanFrame question;
    question.id = 0x321;
    question.remote = true;
    question.size = 4;
    expect_passes(drive, host, question);
}

TEST_F(FdcanTest, TheOrderOfFramesIsKept) {
    std::vector<CanFrame> frames;
    for (std::uint8_t i = 0; i < 32; ++i) {
        frames.push_back(frame_of(0x400U - i, i % 9, i));
        ASSERT_EQ(host.send(frames.back()), CanSent::yes);
    }
    cell.pass_us(5000);
    for (const CanFrame& frame : frames) {
        CanFrame heard;
        ASSERT_TRUE(drive.receive(heard));
        EXPECT_TRUE(same(heard, frame)) << frame.id;
    }
}

TEST_F(FdcanTest, FramesWithoutRoomAreRefusedAndCounted) {
    for (std::uint32_t i = 0; i < kDriveCan.tx_count; ++i) {
        ASSERT_EQ(drive.send(frame_of(0x200, 8)), CanSent::yes);
    }
    EXPECT_EQ(drive.send(frame_of(0x200, 8)), CanSent::full);
    EXPECT_EQ(drive.counters().full, 1U);
    EXPECT_EQ(drive.counters().sent, kDriveCan.tx_count);
    cell.pass_us(200);  // one has left
    EXPECT_EQ(drive.send(frame_of(0x201, 8)), CanSent::yes);
}

TEST_F(FdcanTest, WhatTheReceiveFifoHasNoRoomForIsLostAndCounted) {
    for (std::uint32_t i = 0; i < 70; ++i) {
        ASSERT_EQ(host.send(frame_of(0x100 + i, 8, static_cast<std::uint8_t>(i))), CanSent::yes);
        cell.pass_us(200);
    }
    service(drive);
    EXPECT_EQ(drive.counters().lost, 1U);
    service(drive);
    EXPECT_EQ(drive.counters().lost, 1U);  // told once
    CanFrame heard;
    for (std::uint32_t i = 0; i < kDriveCan.rx_count; ++i) {
        ASSERT_TRUE(drive.receive(heard));
        EXPECT_TRUE(same(heard, frame_of(0x100 + i, 8, static_cast<std::uint8_t>(i)))) << i;
    }
    EXPECT_FALSE(drive.receive(heard));
    expect_passes(host, drive, frame_of(0x300, 8));
}

TEST_F(FdcanTest, TheLowerIdentifierGoesFirstAndNoneIsLost) {
    model::CanPeer peer({1'000'000, 5'000'000});
    cell.wire.join(peer);
    ASSERT_EQ(host.send(frame_of(0x7FF, 8)), CanSent::yes);  // the others come while it is on the bus
    ASSERT_EQ(host.send(frame_of(0x300, 8)), CanSent::yes);
    ASSERT_EQ(host.send(frame_of(0x310, 8)), CanSent::yes);
    ASSERT_EQ(drive.send(frame_of(0x200, 8)), CanSent::yes);
    ASSERT_EQ(drive.send(frame_of(0x320, 8)), CanSent::yes);
    cell.pass_us(2000);
    std::vector<std::uint32_t> order;
    for (const model::WireFrame& frame : peer.frames) {
        order.push_back(frame.id);
    }
    EXPECT_EQ(order, (std::vector<std::uint32_t>{0x7FF, 0x200, 0x300, 0x310, 0x320}));
}

TEST_F(FdcanTest, AFrameTellsItsAgeInBits) {
    ASSERT_EQ(host.send(frame_of(0x123, 8)), CanSent::yes);
    const std::int64_t began_ns = cell.machine.now_ns();
    cell.pass_us(700);
    CanFrame heard;
    ASSERT_TRUE(drive.receive(heard));
    const auto age = static_cast<double>(cell.machine.now_ns() - began_ns) / 1000.0;
    EXPECT_NEAR(heard.age_bits, age, 1.0);
    // Across the end of the counter.
    cell.pass_us(64'700);
    ASSERT_EQ(host.send(frame_of(0x124, 1)), CanSent::yes);
    cell.pass_us(1000);
    ASSERT_TRUE(drive.receive(heard));
    EXPECT_NEAR(heard.age_bits, 1000.0, 1.0);
}

TEST_F(FdcanTest, RefusesWhatIsNoFrameOfThePort) {
    CanFrame quick = frame_of(1, 8);
    quick.fast = true;
    CanFrame question = fd_frame_of(1, 0, false);
    question.remote = true;
    EXPECT_EQ(host.send(frame_of(1, 12)), CanSent::failed);
    EXPECT_EQ(host.send(frame_of(0x800, 1)), CanSent::failed);
    EXPECT_EQ(host.send(fd_frame_of(1, 9, true)), CanSent::failed);
    EXPECT_EQ(host.send(quick), CanSent::failed);
    EXPECT_EQ(host.send(question), CanSent::failed);
    EXPECT_EQ(drive.send(fd_frame_of(1, 8, false)), CanSent::failed);
    EXPECT_EQ(host.counters().failed, 5U);
    EXPECT_EQ(host.counters().sent, 0U);
}

TEST_F(FdcanTest, StartsAgainWhileItRuns) {
    expect_passes(host, drive, frame_of(0x100, 8));
    EXPECT_EQ(host.start(), Fdcan::Start::ok);
    EXPECT_EQ(drive.start(), Fdcan::Start::ok);
    expect_passes(host, drive, frame_of(0x101, 8));
}

TEST_F(FdcanTest, AnInterruptForEachFrame) {
    unsigned calls = 0;
    std::vector<CanFrame> heard;
    cell.machine.on_interrupt(model::FdcanModel::kFdcan2Line0, [&] {
        ++calls;
        CanFrame frame;
        while (drive.acknowledge() && drive.receive(frame)) {
            heard.push_back(frame);
        }
    });
    drive.use_interrupt();
    for (std::uint32_t i = 0; i < 5; ++i) {
        ASSERT_EQ(host.send(frame_of(0x100 + i, 4)), CanSent::yes);
    }
    cell.pass_us(1000);
    EXPECT_EQ(calls, 5U);
    ASSERT_EQ(heard.size(), 5U);
    EXPECT_EQ(heard[4].id, 0x104U);
    EXPECT_EQ(cell.two.peek(fdcan::kIr), 0U);
}

TEST_F(FdcanTest, CountsErrorsAndTellsWarningAndPassive) {
    cell.wire.disturb(12);
    ASSERT_EQ(host.send(frame_of(0x100, 8)), CanSent::yes);
    cell.pass_us(1800);
    service(host);
    service(drive);
    EXPECT_EQ(host.counters().errors, 12U);
    EXPECT_EQ(drive.counters().errors, 12U);
    EXPECT_EQ(drive.counters().rx_error_count, 11U);
    EXPECT_EQ(host.counters().tx_error_count, 95U);
    EXPECT_EQ(host.state(), BusState::active);
    cell.wire.disturb(2);
    ASSERT_EQ(host.send(frame_of(0x100, 8)), CanSent::yes);
    cell.pass_us(300);
    service(host);
    EXPECT_EQ(host.state(), BusState::warning);
    cell.wire.disturb(5);
    ASSERT_EQ(host.send(frame_of(0x100, 8)), CanSent::yes);
    cell.pass_us(1000);
    service(host);
    EXPECT_EQ(host.state(), BusState::passive);
    EXPECT_EQ(host.counters().errors, 19U);
    EXPECT_EQ(host.counters().bus_offs, 0U);
}

TEST_F(FdcanTest, AloneOnTheBusItWaitsAndIsNotBusOff) {
    model::CanPeer peer({1'000'000, 5'000'000});
    peer.there = false;
    cell.wire.join(peer);
    write32(fdcan::kFdcan2 + fdcan::kCccr, fdcan::kInit);  // FDCAN2 leaves the bus
    cell.pass_us(10);
    ASSERT_EQ(host.send(frame_of(0x100, 8)), CanSent::yes);
    cell.pass_us(20'000);
    service(host);
    EXPECT_EQ(host.state(), BusState::passive);
    EXPECT_EQ(host.counters().no_acks, 1U);
    EXPECT_EQ(host.counters().bus_offs, 0U);
    peer.there = true;
    cell.pass_us(1000);
    service(host);
    ASSERT_EQ(peer.frames.size(), 1U);
    EXPECT_EQ(host.counters().no_acks, 1U);
}

TEST_F(FdcanTest, BusOffEndsAfterItsTimeAndStaleFramesAreDropped) {
    model::CanPeer peer({1'000'000, 5'000'000});
    cell.wire.join(peer);
    cell.wire.disturb(32);
    ASSERT_EQ(drive.send(frame_of(0x181, 8)), CanSent::yes);
    ASSERT_EQ(drive.send(frame_of(0x182, 8)), CanSent::yes);
    cell.pass_us(6000);
    service(drive);
    EXPECT_EQ(drive.state(), BusState::bus_off);
    EXPECT_EQ(drive.counters().bus_offs, 1U);
    EXPECT_EQ(drive.send(frame_of(0x183, 8)), CanSent::down);
    for (int i = 0; i < 98; ++i) {
        cell.pass_us(1000);
        service(drive);
        ASSERT_EQ(drive.state(), BusState::bus_off);
        ASSERT_EQ(drive.counters().restarts, 0U);
        ASSERT_NE(cell.two.read(fdcan::kCccr) & fdcan::kInit, 0U);
    }
    cell.pass_us(3000);
    service(drive);
    EXPECT_EQ(drive.counters().restarts, 1U);
    EXPECT_EQ(drive.counters().abandoned, 2U);
    cell.pass_us(1000);
    service(drive);
    EXPECT_EQ(drive.state(), BusState::bus_off);  // 1419 bits of silence first
    cell.pass_us(1000);
    service(drive);
    EXPECT_EQ(drive.state(), BusState::active);
    EXPECT_EQ(drive.counters().bus_offs, 1U);
    EXPECT_EQ(drive.counters().tx_error_count, 0U);
    expect_passes(drive, host, frame_of(0x184, 8));
    ASSERT_EQ(peer.frames.size(), 1U);
    EXPECT_EQ(peer.frames[0].id, 0x184U);
}

TEST_F(FdcanTest, TheRatesAreThoseOfTheSettings) {
    EXPECT_EQ(cell.one.rates(), (model::WireRates{1'000'000, 5'000'000}));
    EXPECT_EQ(cell.two.rates(), (model::WireRates{1'000'000, 0}));
}

TEST(FdcanFdTest, FramesOfAllLengthsPassWithAndWithoutTheFastRate) {
    CanCell cell;
    Fdcan one(test::kFdOne);
    Fdcan two(test::kFdTwo);
    ASSERT_EQ(one.start(), Fdcan::Start::ok);
    ASSERT_EQ(two.start(), Fdcan::Start::ok);
    cell.pass_us(20);
    for (const bool fast : {false, true}) {
        for (const std::uint8_t size : kFdSizes) {
            const CanFrame frame = fd_frame_of(0x200U + size, size, fast);
            ASSERT_EQ(one.send(frame), CanSent::yes);
            ASSERT_EQ(two.send(fd_frame_of(0x100U + size, size, fast)), CanSent::yes);
            cell.pass_us(2000);
            CanFrame heard;
            ASSERT_TRUE(two.receive(heard)) << int{size};
            EXPECT_TRUE(same(heard, frame)) << int{size};
            ASSERT_TRUE(one.receive(heard)) << int{size};
            EXPECT_TRUE(same(heard, fd_frame_of(0x100U + size, size, fast))) << int{size};
        }
    }
    one.service(cell.machine.now_ns());
    EXPECT_EQ(one.counters().errors, 0U);
    EXPECT_EQ(cell.machine.violations_text(), "");
}

TEST(FdcanFdTest, AnotherDeviceReadsTheSameFromTheWire) {
    CanCell cell;
    Fdcan host(kHostCan);
    ASSERT_EQ(host.start(), Fdcan::Start::ok);
    model::CanPeer peer({1'000'000, 5'000'000});
    cell.wire.join(peer);
    const CanFrame frame = fd_frame_of(0x101, 64, true);
    ASSERT_EQ(host.send(frame), CanSent::yes);
    model::WireFrame sent;
    sent.id = 0x2AA;
    sent.fd = sent.fast = true;
    sent.data = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    cell.pass_us(400);
    peer.to_send.push_back(sent);
    cell.pass_us(400);
    ASSERT_EQ(peer.frames.size(), 1U);
    EXPECT_EQ(peer.frames[0].id, 0x101U);
    EXPECT_TRUE(peer.frames[0].fd && peer.frames[0].fast && !peer.frames[0].extended);
    EXPECT_EQ(peer.frames[0].data, std::vector<std::uint8_t>(frame.data.begin(), frame.data.end()));
    CanFrame heard;
    ASSERT_TRUE(host.receive(heard));
    EXPECT_EQ(heard.id, 0x2AAU);
    EXPECT_EQ(heard.size, 12);
    EXPECT_EQ(heard.data[11], 12);
    EXPECT_EQ(heard.age_bits, 0);
    EXPECT_EQ(cell.machine.violations_text(), "");
}

TEST(FdcanStart, TellsWhatDidNotAnswer) {
    CanCell cell;
    cell.one.set_kernel_hz(0);
    Fdcan host(kHostCan);
    EXPECT_EQ(host.start(), Fdcan::Start::not_entered);
    EXPECT_EQ(host.state(), BusState::down);
    EXPECT_EQ(host.send(frame_of(1, 1)), CanSent::down);
    cell.one.set_kernel_hz(80'000'000);
    EXPECT_EQ(host.start(), Fdcan::Start::ok);
    cell.one.set_kernel_hz(0);
    EXPECT_EQ(host.start(), Fdcan::Start::no_init);
    EXPECT_EQ(cell.machine.violations_text(), "");
}

TEST(FdcanStart, TellsThatNothingIsThere) {
    model::Machine machine;
    model::RegisterWords clocks;
    model::RegisterWords nothing;
    machine.attach(model::rcc::kBase, model::rcc::kSize, clocks);
    machine.attach(model::FdcanModel::kFdcan1, model::FdcanModel::kSize, nothing);
    Fdcan host(kHostCan);
    EXPECT_EQ(host.start(), Fdcan::Start::absent);
}

}  // namespace
}  // namespace sc::stm32h743
