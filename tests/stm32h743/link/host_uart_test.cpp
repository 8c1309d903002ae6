// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/host_uart.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/byte_dma.hpp"
#include "tests/stm32h743/model/usart.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::uint32_t kSram1 = 0x30000000;
constexpr std::uint32_t kBaud = 1'000'000;  // 10 us a byte

class HostUartTest : public testing::Test {
protected:
    HostUartTest() {
        machine.attach(model::rcc::kBase, model::rcc::kSize, clocks);
        auto* first = static_cast<std::uint8_t*>(static_cast<void*>(memory.get()));
        machine.map_memory(kSram1, {first, sizeof(HostUart::Memory)});
    }
    void SetUp() override { ASSERT_EQ(link.start(kBaud), HostUart::Start::ok); }
    void TearDown() override { EXPECT_EQ(machine.violations_text(), ""); }

    void pass_us(std::int64_t us) { machine.advance_to(machine.now_ns() + 1000 * us); }
    static std::vector<std::uint8_t> pattern(std::size_t size, std::uint32_t seed) {
        std::vector<std::uint8_t> bytes(size);
        for (std::uint8_t& byte : bytes) {
            seed = seed * 1664525U + 1013904223U;
            byte = static_cast<std::uint8_t>(seed >> 24U);
        }
        return bytes;
    }
    void comes(const std::vector<std::uint8_t>& bytes) { uart.arrive_from(machine.now_ns(), bytes); }
    std::vector<std::uint8_t> fetch(std::size_t most = 1024) {
        std::vector<std::uint8_t> out(most);
        out.resize(link.receive(out));
        return out;
    }
    std::vector<std::uint8_t> on_line() const {
        std::vector<std::uint8_t> bytes;
        for (const model::UsartModel::Sent& one : uart.sent()) {
            bytes.push_back(one.byte);
        }
        return bytes;
    }

    model::Machine machine;
    model::RegisterWords clocks;
    model::ByteDma dma{machine, clocks};
    model::UsartModel uart{machine, clocks, &dma, model::UsartModel::kUsart3};
    std::unique_ptr<HostUart::Memory> memory = std::make_unique<HostUart::Memory>();
    HostUart link{*memory};
};

TEST_F(HostUartTest, BytesStreamBothWaysOverManyLapsOfTheRing) {
    std::vector<std::uint8_t> to_us;
    std::vector<std::uint8_t> heard;
    std::vector<std::uint8_t> from_us;
    for (std::uint32_t tick = 0; tick < 400; ++tick) {
        const std::vector<std::uint8_t> in = pattern(90 + tick % 10, tick);
        const std::vector<std::uint8_t> out = pattern(70 + tick % 27, 1000 + tick);
        comes(in);
        link.send(out);
        to_us.insert(to_us.end(), in.begin(), in.end());
        from_us.insert(from_us.end(), out.begin(), out.end());
        pass_us(1000);
        const std::vector<std::uint8_t> got = fetch();
        heard.insert(heard.end(), got.begin(), got.end());
    }
    link.send({});
    pass_us(2000);
    ASSERT_GT(to_us.size(), 8 * HostUart::kIn);
    EXPECT_EQ(heard, to_us);
    EXPECT_EQ(on_line(), from_us);
    EXPECT_EQ(link.counters().bytes_in, to_us.size());
    EXPECT_EQ(link.counters().bytes_out, from_us.size());
    EXPECT_EQ(link.counters().laps, 0U);
    EXPECT_EQ(link.counters().unsent, 0U);
}

TEST_F(HostUartTest, TheRateIsThatAskedFor) {
    EXPECT_EQ(uart.character_ns(), 10'000);
    ASSERT_EQ(link.start(921'600), HostUart::Start::ok);
    EXPECT_NEAR(static_cast<double>(uart.character_ns()), 1e10 / 921'600, 0.004 * 1e10 / 921'600);
}

TEST_F(HostUartTest, WhatDoesNotFitIntoATickWaits) {
    const std::vector<std::uint8_t> bytes = pattern(300, 5);
    comes(bytes);
    pass_us(4000);
    std::vector<std::uint8_t> heard;
    for (int i = 0; i < 3; ++i) {
        const std::vector<std::uint8_t> got = fetch(100);
        EXPECT_EQ(got.size(), 100U);
        heard.insert(heard.end(), got.begin(), got.end());
    }
    EXPECT_EQ(heard, bytes);
}

TEST_F(HostUartTest, ARingThatWasLappedIsToldAndReadingGoesOn) {
    comes(pattern(HostUart::kIn + 50, 1));
    pass_us(10 * (HostUart::kIn + 60));
    EXPECT_TRUE(fetch().empty());
    EXPECT_EQ(link.counters().laps, 1U);
    const std::vector<std::uint8_t> bytes = pattern(40, 9);
    comes(bytes);
    pass_us(1000);
    EXPECT_EQ(fetch(), bytes);
    EXPECT_EQ(link.counters().laps, 1U);
}

/// Reading takes time, in which bytes come: at each place of the ring.
TEST_F(HostUartTest, AWrapWhileThePlaceIsReadIsNoLap) {
    machine.set_access_ns(3'000);  // three readings a byte
    std::uint32_t seed = 1;
    std::vector<std::uint8_t> to_us;
    std::vector<std::uint8_t> heard;
    for (int lap = 0; lap < 6; ++lap) {
        const std::vector<std::uint8_t> in = pattern(HostUart::kIn + 1, ++seed);
        to_us.insert(to_us.end(), in.begin(), in.end());
        comes(in);
        while (heard.size() < to_us.size()) {
            const std::vector<std::uint8_t> got = fetch();
            heard.insert(heard.end(), got.begin(), got.end());
            ASSERT_LT(machine.now_ns(), 1'000'000'000);
        }
    }
    EXPECT_EQ(heard, to_us);
    EXPECT_EQ(link.counters().laps, 0U);
}

TEST_F(HostUartTest, WhatFindsNoRoomIsDroppedAndCounted) {
    const std::vector<std::uint8_t> first = pattern(10, 1);
    const std::vector<std::uint8_t> rest = pattern(HostUart::kOut + 77, 2);
    link.send(first);
    link.send(rest);
    EXPECT_EQ(link.counters().unsent, 77U);
    pass_us(200);
    link.send({});
    pass_us(30'000);
    std::vector<std::uint8_t> expected = first;
    expected.insert(expected.end(), rest.begin(), rest.end() - 77);
    EXPECT_EQ(on_line(), expected);
}

TEST_F(HostUartTest, ErrorsOfTheLineAreCounted) {
    uart.arrives(0x11, machine.now_ns(), model::UsartModel::framing);
    uart.arrives(0x22, machine.now_ns() + 20'000, model::UsartModel::noise);
    pass_us(100);
    EXPECT_EQ(fetch(), (std::vector<std::uint8_t>{0x11, 0x22}));
    EXPECT_EQ(link.counters().framing, 1U);
    EXPECT_EQ(link.counters().noise, 1U);
    EXPECT_TRUE(fetch().empty());
    EXPECT_EQ(link.counters().framing, 1U);
    EXPECT_EQ(link.counters().overruns, 0U);
}

TEST_F(HostUartTest, BytesThatDmaComesTooLateForAreCounted) {
    dma.hold(true);
    comes({1, 2, 3});
    pass_us(100);
    dma.hold(false);
    EXPECT_EQ(fetch(), std::vector<std::uint8_t>{1});
    EXPECT_EQ(link.counters().overruns, 1U);
    comes({4});
    pass_us(100);
    EXPECT_EQ(fetch(), std::vector<std::uint8_t>{4});
    EXPECT_EQ(link.counters().overruns, 1U);
}

TEST_F(HostUartTest, AStreamThatFailedIsStartedAgain) {
    dma.fail_next(2);
    comes({1, 2});
    pass_us(100);
    (void)fetch();
    EXPECT_EQ(link.counters().dma_errors, 1U);
    (void)fetch();  // what stood in the register
    comes({3, 4, 5});
    pass_us(100);
    EXPECT_EQ(fetch(), (std::vector<std::uint8_t>{3, 4, 5}));
    dma.fail_next(3);
    link.send(pattern(5, 1));
    pass_us(100);
    (void)fetch();
    EXPECT_EQ(link.counters().dma_errors, 2U);
    const std::size_t before = uart.sent().size();
    link.send(pattern(5, 2));
    pass_us(100);
    EXPECT_EQ(uart.sent().size(), before + 5);
}

TEST_F(HostUartTest, AnInterruptTellsThatTheLineFellSilent) {
    std::vector<std::uint8_t> got;
    unsigned calls = 0;
    machine.on_interrupt(model::UsartModel::kUsart3.interrupt, [&] {
        ++calls;
        if (link.acknowledge()) {
            got = fetch();
        }
    });
    link.use_interrupt();
    const std::vector<std::uint8_t> bytes = pattern(20, 3);
    comes(bytes);
    pass_us(205);
    EXPECT_EQ(calls, 0U);
    pass_us(10);
    EXPECT_EQ(calls, 1U);
    EXPECT_EQ(got, bytes);
    EXPECT_FALSE(link.acknowledge());  // taken back
}

TEST_F(HostUartTest, StartsAgainWhileBytesRun) {
    comes(pattern(100, 1));
    link.send(pattern(100, 2));
    pass_us(300);
    ASSERT_EQ(link.start(kBaud), HostUart::Start::ok);
    pass_us(2000);
    (void)fetch();
    const std::vector<std::uint8_t> bytes = pattern(30, 4);
    comes(bytes);
    pass_us(1000);
    EXPECT_EQ(fetch(), bytes);
}

TEST_F(HostUartTest, TellsWhyItDidNotStart) {
    EXPECT_EQ(link.start(1'200), HostUart::Start::bad_rate);
    EXPECT_EQ(link.start(4'000'000), HostUart::Start::bad_rate);
    uart.set_kernel_hz(0);
    EXPECT_EQ(link.start(kBaud), HostUart::Start::silent);
    link.send(std::vector<std::uint8_t>(7));
    EXPECT_EQ(link.counters().unsent, 7U);
    EXPECT_TRUE(fetch().empty());
}

}  // namespace
}  // namespace sc::stm32h743
