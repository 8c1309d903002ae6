// SPDX-License-Identifier: Apache-2.0
// Runs in the guest: SC_CAN_A and SC_CAN_B name two interfaces on one bus, which may be the same; SC_CAN_FD=1 if it
// carries FD; SC_CAN_SLOW names one whose queue holds two frames for seconds. Without them there is nothing to test
// here.
#include <array>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "boards/socketcan/can_socket.hpp"

namespace sc::socketcan {
namespace {

std::string named(const char* variable) {
    const char* text = std::getenv(variable);
    return text == nullptr ? "" : text;
}

CanFrame numbered(std::uint32_t n, std::uint8_t size, bool fd) {
    CanFrame frame;
    frame.id = 0x100 + n % 0x400;
    frame.fd = fd;
    frame.fast = fd;
    frame.size = size;
    for (std::size_t i = 0; i < size; ++i) {
        frame.data[i] = static_cast<std::uint8_t>(n + i);
    }
    return frame;
}

bool await(CanSocket& socket, CanFrame& out) {
    while (!socket.receive(out)) {
        pollfd waiting{.fd = socket.file(), .events = POLLIN, .revents = 0};
        if (::poll(&waiting, 1, 20'000) <= 0) {
            return false;
        }
    }
    return true;
}

void exchange(CanSocket& from, CanSocket& to, std::uint8_t size, bool fd) {
    for (std::uint32_t n = 0; n < 200; ++n) {
        const CanFrame sent = numbered(n, size, fd);
        while (from.send(sent) == CanSent::full) {  // a card's queue is short; counted
            ::usleep(1000);
        }
        CanFrame got;
        ASSERT_TRUE(await(to, got)) << "frame " << n << " of " << int{size} << " bytes did not come";
        EXPECT_EQ(got.id, sent.id);
        EXPECT_EQ(got.fd, fd);
        ASSERT_EQ(got.size, size);
        EXPECT_EQ(got.data, sent.data);
        EXPECT_GT(got.time_ns, 0);
    }
}

TEST(KernelCan, FramesCrossTheBusBothWaysInOrder) {
    if (named("SC_CAN_A").empty()) {
        GTEST_SKIP();
    }
    const CanOptions options{.fd = !named("SC_CAN_FD").empty()};
    CanSocket a(named("SC_CAN_A"), options);
    CanSocket b(named("SC_CAN_B"), options);
    for (const std::uint8_t size : std::array<std::uint8_t, 4>{0, 1, 7, 8}) {
        exchange(a, b, size, false);
        exchange(b, a, size, false);
    }
    if (options.fd) {
        exchange(a, b, 64, true);
        exchange(b, a, 12, true);
    }
    EXPECT_EQ(a.counters().sent, b.counters().received);
    EXPECT_EQ(b.counters().sent, a.counters().received);
    EXPECT_EQ(b.counters().malformed, 0U);
    EXPECT_EQ(b.counters().dropped, 0U);
}

TEST(KernelCan, AFullQueueIsToldAndCounted) {
    if (named("SC_CAN_SLOW").empty()) {
        GTEST_SKIP();
    }
    CanSocket slow(named("SC_CAN_SLOW"));
    int full = 0;
    for (std::uint32_t n = 0; n < 10; ++n) {
        full += slow.send(numbered(n, 8, false)) == CanSent::full ? 1 : 0;
    }
    EXPECT_GE(full, 7);
    EXPECT_EQ(slow.counters().full, static_cast<std::uint64_t>(full));
    EXPECT_EQ(slow.state(), BusState::active);
}

TEST(KernelCan, AnUnknownInterfaceIsRefusedByName) {
    try {
        const CanSocket none("nosuchcan");
        FAIL() << "it was opened";
    } catch (const std::exception& error) {
        EXPECT_NE(std::string(error.what()).find("nosuchcan"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace sc::socketcan
