// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "boards/sim/carrier/can_bus.hpp"
#include "boards/sim/carrier/frame_bits.hpp"
#include "boards/sim/carrier/serial_line.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/serial.hpp"

namespace {

using namespace sc::sim;  // NOLINT(google-build-using-namespace): the subject of this file
using sc::link::LinkCanFrame;

LinkCanFrame frame_of(std::uint32_t id, std::size_t size, std::uint8_t fill = 0x55, bool fd = false) {
    LinkCanFrame frame;
    frame.id = id;
    frame.fd = fd;
    frame.size = static_cast<std::uint8_t>(size);
    for (std::size_t i = 0; i < size; ++i) {
        frame.data[i] = fill;
    }
    return frame;
}

TEST(FrameBits, StayBetweenTheUnstuffedAndTheWorstOfTheStandard) {
    for (const int byte : {0x00, 0x0F, 0x55, 0xAA, 0xFF}) {
        for (std::size_t n = 0; n <= 8; ++n) {
            const int bits = frame_bits(frame_of(0x200, n, static_cast<std::uint8_t>(byte))).nominal;
            const int plain = 47 + 8 * static_cast<int>(n);
            EXPECT_GE(bits, plain);
            EXPECT_LE(bits, plain + (34 + 8 * static_cast<int>(n) - 1) / 4);
        }
    }
    EXPECT_GT(frame_bits(frame_of(0, 8, 0x00)).nominal, frame_bits(frame_of(0x555, 8, 0x55)).nominal);
}

TEST(FrameBits, AnFdFrameSwitchesItsRate) {
    const FrameBits bits = frame_bits(frame_of(0x555, 64, 0x55, true));
    // 17 bits to the rate switch, 12 behind the data phase; 5 + 512 + 4 + 21 + 7 + 1 in it, and stuff bits in both.
    EXPECT_GE(bits.nominal, 29);
    EXPECT_LE(bits.nominal, 33);
    EXPECT_GE(bits.data, 550);
    EXPECT_LE(bits.data, 550 + 129);
    EXPECT_LT(frame_ns(frame_of(0x555, 64, 0x55, true), {1'000'000, 5'000'000}), 170'000);
}

TEST(CanBus, TheLowestIdentifierWinsAndEachTakesItsTime) {
    CanBus bus({}, {});
    bus.send(0, frame_of(0x200, 8), 0);
    bus.send(1, frame_of(0x100, 8), 0);
    std::vector<LinkCanFrame> at_0;
    std::vector<LinkCanFrame> at_1;
    const std::int64_t one = frame_ns(frame_of(0x100, 8), {});
    bus.receive(0, one + 1, at_0);
    EXPECT_EQ(at_0.size(), 1U);
    bus.receive(1, one + 1, at_1);
    EXPECT_TRUE(at_1.empty());
    bus.receive(1, 1'000'000, at_1);
    ASSERT_EQ(at_1.size(), 1U);
    EXPECT_EQ(at_1[0].id, 0x200U);
}

TEST(CanBus, SendsADestroyedFrameAgain) {
    CanBus bus({}, Troubles({.destroy = 0.08}, {}, 5));
    std::vector<LinkCanFrame> arrived;
    for (std::uint8_t i = 0; i < 200; ++i) {
        bus.send(0, frame_of(0x200, 8, i), 0);
    }
    bus.receive(1, 1'000'000'000, arrived);
    ASSERT_EQ(arrived.size(), 200U);
    for (std::uint8_t i = 0; i < 200; ++i) {
        EXPECT_EQ(arrived[i].data[0], i);
    }
    EXPECT_GT(bus.error_frames(), 5U);
}

TEST(CanBus, GoesOffAfterTooManyErrorsAndComesBack) {
    CanBus bus({}, Troubles({.destroy = 1.0}, {}, 5));
    bus.send(0, frame_of(0x200, 8), 0);
    std::vector<LinkCanFrame> arrived;
    bus.receive(1, 5'000'000, arrived);
    EXPECT_EQ(bus.bus_offs(), 1U);
    EXPECT_EQ(bus.waiting(0), 0U) << "what it had to send is lost";
    EXPECT_EQ(bus.error_frames(), 32U);
    bus.receive(1, 20'000'000, arrived);
    EXPECT_EQ(bus.state(0), CanBus::NodeState::active);
    EXPECT_TRUE(arrived.empty());
}

TEST(CanBus, ALoneNodeGoesOnAndNeverOffTheBus) {
    CanBus bus({}, Troubles({}, {{0, 50'000'000}}, 5));
    bus.send(0, frame_of(0x200, 8), 0);
    std::vector<LinkCanFrame> arrived;
    bus.receive(1, 49'000'000, arrived);
    EXPECT_TRUE(arrived.empty());
    EXPECT_EQ(bus.state(0), CanBus::NodeState::passive);
    bus.receive(1, 60'000'000, arrived);
    EXPECT_EQ(arrived.size(), 1U);
    EXPECT_EQ(bus.bus_offs(), 0U);
}

TEST(SerialLine, TakesTenBitsAByte) {
    SerialLine line(1'000'000, {});
    const std::vector<std::uint8_t> bytes{3, 1, 2, 0};
    line.send(0, bytes, 0);
    std::vector<std::uint8_t> out;
    line.receive(1, 39'999, out);
    EXPECT_TRUE(out.empty());
    line.receive(1, 40'000, out);
    EXPECT_EQ(out, bytes);
}

TEST(SerialLine, TheSameSeedGivesTheSameTroubles) {
    const auto run = [](std::uint64_t seed) {
        SerialLine line(3'000'000,
                        Troubles({.lose = 0.2, .repeat = 0.2, .late = 0.2, .swap = 0.2, .spoil = 0.2}, {}, seed));
        std::vector<std::uint8_t> out;
        for (std::uint8_t i = 1; i < 250; ++i) {
            line.send(0, std::vector<std::uint8_t>{2, i, 0}, i * 100'000);
        }
        line.receive(1, 1'000'000'000, out);
        return out;
    };
    EXPECT_EQ(run(1), run(1));
    EXPECT_NE(run(1), run(2));
}

TEST(CanPort, MessagesPassUnchangedOverEitherKindOfFrame) {
    for (const bool fd : {false, true}) {
        sc::link::CanPort<2048> sender(sc::link::kCanIdToController, fd);
        sc::link::CanPort<2048> receiver(sc::link::kCanIdToHost, fd);
        sc::link::SerialReceiver messages;
        std::vector<std::uint16_t> counters;
        for (std::uint16_t counter = 0; counter < 50; ++counter) {
            std::vector<std::uint8_t> bytes(sc::link::kSerialCapacity);
            sc::link::Block block;
            block.items.size = static_cast<std::uint8_t>(counter * 4);
            bytes.resize(sc::link::encode_serial(block, counter, bytes));
            EXPECT_EQ(sender.push(bytes), bytes.size());
            LinkCanFrame frame;
            while (sender.next(frame)) {
                EXPECT_EQ(frame.fd, fd);
                std::vector<std::uint8_t> out(sc::link::kSerialCapacity);
                out.resize(receiver.take(frame, out));
                messages.receive(out, [&](const sc::link::Envelope& e) { counters.push_back(e.counter); });
            }
        }
        ASSERT_EQ(counters.size(), 50U);
        EXPECT_EQ(counters.back(), 49U);
        EXPECT_EQ(messages.frames_bad(), 0U);
    }
}

}  // namespace
