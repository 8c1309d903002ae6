// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/host_link.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "shared/link/cobs.hpp"

namespace sc::linux_rt {
namespace {

std::vector<std::uint8_t> message(std::size_t size) {
    std::vector<std::uint8_t> plain(size);
    std::iota(plain.begin(), plain.end(), std::uint8_t{1});
    std::vector<std::uint8_t> bytes(2 * size + 8);
    bytes.resize(link::cobs_encode(plain, bytes));
    return bytes;
}

class CanLinkTest : public testing::Test {
protected:
    CanLinkTest() : link_(socketcan::CanSocket(make()), true, "can:test?fd=1") {}
    int make() {
        std::array<int, 2> files{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, files.data()), 0);
        host_.emplace_back(files[1]);
        return files[0];
    }
    void host_says(const std::vector<std::uint8_t>& bytes, std::uint32_t id = link::kCanIdToController) {
        link::CanPort<4096> port(id, true);
        (void)port.push(bytes);
        link::LinkCanFrame frame;
        while (port.next(frame)) {
            socketcan::CanFrame raw;
            raw.id = frame.id;
            raw.fd = true;
            raw.size = frame.size;
            raw.data = frame.data;
            ASSERT_EQ(host_[0].send(raw), socketcan::CanSent::yes);
        }
    }
    std::vector<socketcan::CanSocket> host_;
    CanLink link_;
};

TEST_F(CanLinkTest, GivesMessagesOfTheHostAndNothingElse) {
    const std::vector<std::uint8_t> sent = message(100);
    host_says(message(20), 0x123);
    host_says(sent);
    std::array<std::uint8_t, kLinkBytesPerTick> got{};
    const std::size_t n = link_.receive(got);
    EXPECT_TRUE(std::equal(sent.begin(), sent.end(), got.begin(), got.begin() + static_cast<std::ptrdiff_t>(n)));
    EXPECT_EQ(link_.receive(got), 0U);
}

TEST_F(CanLinkTest, NoTickGetsMoreThanItTakesAndNothingIsLost) {
    const std::vector<std::uint8_t> one = message(200);
    for (int i = 0; i < 12; ++i) {
        host_says(one);
    }
    std::array<std::uint8_t, kLinkBytesPerTick> got{};
    std::size_t all = 0;
    for (int tick = 0; tick < 4; ++tick) {
        all += link_.receive(got);
    }
    EXPECT_EQ(all, 12 * one.size());
}

TEST_F(CanLinkTest, WhatTheBusHasNoRoomForWaitsUntilItsOwnRoomIsFull) {
    const std::vector<std::uint8_t> one = message(200);
    for (int i = 0; i < 2000 && link_.counters().lost == 0; ++i) {
        link_.send(one);
    }
    EXPECT_GT(link_.counters().lost, 0U);
    EXPECT_GT(link_.can()->counters().full, 0U);
    const std::uint64_t before = link_.can()->counters().sent;
    socketcan::CanFrame frame;
    while (host_[0].receive(frame)) {
    }
    link_.send({});
    EXPECT_GT(link_.can()->counters().sent, before);
}

TEST(OpenHostLink, RefusesWhatIsNone) {
    for (const char* text : {"", "can", "can:", "can:can0?fd=2", "serial:", "serial:/dev/x?speed=1", "tcp:", "tcp:x",
                             "tcp:70000", "tcp:nowhere:1", "usb:1", "fd:1", "fd:x"}) {
        EXPECT_THROW(static_cast<void>(open_host_link(text)), std::invalid_argument) << text;
    }
}

TEST(OpenHostLink, ListensOnTcp) {
    const std::unique_ptr<HostLink> link = open_host_link("tcp:0");
    EXPECT_GT(std::stoi(link->name()), 0);
    EXPECT_EQ(link->can(), nullptr);
}

}  // namespace
}  // namespace sc::linux_rt
