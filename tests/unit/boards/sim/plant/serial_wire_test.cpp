// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/serial_wire.hpp"

#include <numeric>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

constexpr std::int64_t kMs = 1'000'000;

std::vector<std::uint8_t> counting(std::size_t n) {
    std::vector<std::uint8_t> bytes(n);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    return bytes;
}

TEST(SerialWire, PassesTheBaudRateInOrder) {
    SerialWire wire(921'600, kMs, 1024);
    const auto sent = counting(9216);
    wire.push(sent);
    std::vector<std::uint8_t> got;
    for (int tick = 1; tick <= 100; ++tick) {
        wire.tick(got);
        // 92.16 bytes a tick, whole ones only.
        EXPECT_EQ(got.size(), static_cast<std::size_t>(92.16 * tick + 1e-6));
    }
    EXPECT_EQ(got, sent);
}

TEST(SerialWire, IdleTimeIsLost) {
    SerialWire wire(115'200, kMs, 1024);
    std::vector<std::uint8_t> got;
    for (int tick = 0; tick < 1000; ++tick) {
        wire.tick(got);
    }
    wire.push(counting(100));
    wire.tick(got);
    EXPECT_EQ(got.size(), 11U);
}

TEST(SerialWire, SlowLineGivesAByteEveryOtherTick) {
    SerialWire wire(9600, kMs, 1024);
    wire.push(counting(4));
    std::vector<std::size_t> sizes;
    std::vector<std::uint8_t> got;
    for (int tick = 0; tick < 3; ++tick) {
        wire.tick(got);
        sizes.push_back(got.size());
    }
    EXPECT_EQ(sizes, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(SerialWire, NeverMoreThanTheLimitAtOneBoundary) {
    SerialWire wire(100'000'000, kMs, 1024);
    wire.push(counting(3000));
    std::vector<std::uint8_t> got;
    wire.tick(got);
    EXPECT_EQ(got.size(), 1024U);
    EXPECT_EQ(wire.waiting(), 1976U);
}

TEST(SerialWire, CutLosesWhatIsOnItsWay) {
    SerialWire wire(921'600, kMs, 1024);
    wire.push(counting(200));
    wire.set_connected(false);
    wire.push(counting(10));
    std::vector<std::uint8_t> got;
    wire.tick(got);
    EXPECT_TRUE(got.empty());
    wire.set_connected(true);
    wire.push(counting(10));
    wire.tick(got);
    EXPECT_EQ(got, counting(10));
}

}  // namespace
}  // namespace sc::sim
