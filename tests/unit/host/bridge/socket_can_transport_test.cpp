// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/socket_can_transport.hpp"

#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>

#include "host/bridge/can_transport.hpp"
#include "host/formats/error.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/can_record.hpp"
#include "shared/link/cobs.hpp"

namespace sc::host {
namespace {

constexpr Nanoseconds kShort{2'000'000};
constexpr Nanoseconds kLong{5'000'000'000};

std::array<UniqueFd, 2> pair() {
    std::array<int, 2> files{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, files.data()), 0);
    return {UniqueFd(files[0]), UniqueFd(files[1])};
}

/// One COBS message of so many bytes.
std::vector<std::uint8_t> message(std::size_t size) {
    std::vector<std::uint8_t> plain(size);
    std::iota(plain.begin(), plain.end(), std::uint8_t{1});
    std::vector<std::uint8_t> bytes(2 * size + 8);
    bytes.resize(link::cobs_encode(plain, bytes));
    return bytes;
}

class SocketCan : public testing::TestWithParam<bool> {};

TEST_P(SocketCan, MessagesPassBothWaysInFramesOfTheKernel) {
    const bool fd = GetParam();
    auto [here, there] = pair();
    const int bus = there.get();
    CanTransport link(std::make_unique<SocketCanTransport>(std::move(here), fd), fd, nullptr);
    const std::vector<std::uint8_t> sent = message(60);
    link.send(sent);
    // The other end takes the frames as a controller would.
    link::CanPort<4096> controller(link::kCanIdToHost, fd);
    std::array<std::uint8_t, link::kSerialCapacity> got{};
    std::size_t size = 0;
    int frames = 0;
    canfd_frame raw{};
    while (true) {
        const ssize_t n = ::recv(bus, &raw, sizeof raw, MSG_DONTWAIT);
        if (n < 0) {
            break;
        }
        ++frames;
        ASSERT_EQ(n, static_cast<ssize_t>(fd ? CANFD_MTU : CAN_MTU));
        EXPECT_EQ(raw.can_id, link::kCanIdToController);
        EXPECT_EQ(raw.flags & CANFD_BRS, fd ? CANFD_BRS : 0);
        link::LinkCanFrame frame{.id = raw.can_id, .size = raw.len, .fd = fd};
        std::copy_n(std::begin(raw.data), raw.len, frame.data.begin());
        size += controller.take(frame, got);
    }
    EXPECT_EQ(frames, fd ? 1 : 9);
    EXPECT_EQ(std::vector<std::uint8_t>(got.begin(), got.begin() + static_cast<std::ptrdiff_t>(size)), sent);

    const std::vector<std::uint8_t> answer = message(33);
    (void)controller.push(answer);
    link::LinkCanFrame frame;
    while (controller.next(frame)) {
        raw = {};
        raw.can_id = frame.id;
        raw.len = frame.size;
        std::copy_n(frame.data.begin(), frame.size, std::begin(raw.data));
        ASSERT_GT(::send(bus, &raw, fd ? CANFD_MTU : CAN_MTU, 0), 0);
    }
    std::vector<std::uint8_t> heard(answer.size());
    ASSERT_EQ(link.receive(heard, link.now() + kLong), answer.size());
    EXPECT_EQ(heard, answer);
    EXPECT_FALSE(link.closed());
}

INSTANTIATE_TEST_SUITE_P(Kinds, SocketCan, testing::Bool());

TEST(SocketCanTransport, CountsErrorFramesAndIgnoresWhatIsNoneOfTheLinks) {
    auto [here, there] = pair();
    SocketCanTransport bus(std::move(here), false);
    can_frame raw{};
    raw.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
    raw.can_dlc = 8;
    ASSERT_GT(::send(there.get(), &raw, sizeof raw, 0), 0);
    raw.can_id = CAN_ERR_FLAG | CAN_ERR_RESTARTED;
    ASSERT_GT(::send(there.get(), &raw, sizeof raw, 0), 0);
    raw.can_id = 0x123U | CAN_EFF_FLAG;
    ASSERT_GT(::send(there.get(), &raw, sizeof raw, 0), 0);
    ASSERT_GT(::send(there.get(), &raw, 3, 0), 0);
    std::array<std::uint8_t, 64> out{};
    EXPECT_EQ(bus.receive(out, bus.now() + kShort), 0U);
    EXPECT_EQ(bus.counters().errors, 2U);
    EXPECT_EQ(bus.counters().bus_offs, 1U);
    EXPECT_EQ(bus.counters().restarts, 1U);
    EXPECT_EQ(bus.counters().malformed, 1U);
    EXPECT_FALSE(bus.closed());
}

TEST(SocketCanTransport, WhatFindsNoRoomWaitsAndGoesInOrder) {
    auto [here, there] = pair();
    SocketCanTransport bus(std::move(here), false);
    std::vector<std::uint8_t> record(link::can_record_size(false));
    constexpr std::uint32_t kFrames = 5000;
    for (std::uint32_t i = 0; i < kFrames; ++i) {
        link::LinkCanFrame frame{.id = 0x200, .size = 4};
        for (std::size_t k = 0; k < 4; ++k) {
            frame.data.at(k) = static_cast<std::uint8_t>(i >> (8 * k));
        }
        link::put_can_record(frame, record);
        bus.send(record);
    }
    EXPECT_GT(bus.counters().full, 0U);
    std::uint32_t next = 0;
    std::array<std::uint8_t, 64> out{};
    for (int round = 0; round < 5000 && next < kFrames; ++round) {
        can_frame raw{};
        while (::recv(there.get(), &raw, sizeof raw, MSG_DONTWAIT) > 0) {
            const std::uint32_t number = raw.data[0] + (std::uint32_t{raw.data[1]} << 8U);
            ASSERT_EQ(number, next);
            ++next;
        }
        EXPECT_EQ(bus.receive(out, bus.now() + Nanoseconds{100'000}), 0U);
    }
    EXPECT_EQ(next, kFrames);
}

TEST(SocketCanTransport, AnInterfaceThatIsGoneClosesIt) {
    auto [here, there] = pair();
    SocketCanTransport bus(std::move(here), false);
    there.reset();
    std::array<std::uint8_t, 64> out{};
    EXPECT_EQ(bus.receive(out, bus.now() + kLong), 0U);
    EXPECT_TRUE(bus.closed());
}

TEST(SocketCanTransport, AnInterfaceThatIsNotThereIsBadInput) {
    EXPECT_THROW(static_cast<void>(open_socket_can("can_not_here", false)), InputError);
}

}  // namespace
}  // namespace sc::host
