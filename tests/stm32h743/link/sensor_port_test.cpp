// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/sensor_port.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/sensors/bus_master.hpp"
#include "firmware/sensors/modbus_rtu.hpp"
#include "tests/stm32h743/model/usart.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
constexpr SensorBusConfig kBus{.baud = 115'200, .parity = SensorParity::even};

class SensorPortTest : public testing::Test {
protected:
    SensorPortTest() {
        machine.attach(model::rcc::kBase, model::rcc::kSize, clocks);
        machine.on_interrupt(model::UsartModel::kUsart2.interrupt, [this] {
            if (served) {
                port.on_interrupt(machine.now_ns());
            }
        });
        uart.set_echo(true);
    }
    void SetUp() override { ASSERT_EQ(port.start(kBus), SensorPort::Start::ok); }
    void TearDown() override { EXPECT_EQ(machine.violations_text(), ""); }

    /// As on the chip: 10 000 times a second the port may begin.
    void pass_until(std::int64_t ns) {
        while (machine.now_ns() < ns) {
            machine.advance_to(std::min(ns, machine.now_ns() + 100'000));
            port.poll(machine.now_ns());
        }
    }
    static SensorTransmission request(std::uint8_t size, std::uint32_t delay_ns = 0) {
        SensorTransmission sent;
        sent.size = size;
        sent.delay_ns = delay_ns;
        for (std::uint8_t i = 0; i < size; ++i) {
            sent.bytes[i] = static_cast<std::uint8_t>(0x31 + 7 * i);
        }
        return sent;
    }
    std::vector<std::uint8_t> bytes_until(std::int64_t tick_ns) {
        std::vector<std::uint8_t> bytes;
        for (const SensorByte& byte : port.take(tick_ns)) {
            bytes.push_back(byte.data);
        }
        return bytes;
    }

    model::Machine machine;
    model::RegisterWords clocks;
    model::UsartModel uart{machine, clocks, nullptr, model::UsartModel::kUsart2};
    SensorPort port{kSensorPorts[0]};
    bool served = true;
};

TEST_F(SensorPortTest, TheDriverIsOnForTheFrameAndNoLonger) {
    port.give(request(8), 2 * kTickNs);
    pass_until(4 * kTickNs);
    ASSERT_EQ(uart.sent().size(), 8U);
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_EQ(uart.sent()[i].byte, request(8).bytes[i]);
        if (i > 0) {
            EXPECT_EQ(uart.sent()[i].begin_ns, uart.sent()[i - 1].end_ns) << i;  // no pause within the frame
        }
    }
    ASSERT_EQ(uart.driven().size(), 1U);
    const model::UsartModel::Window window = uart.driven()[0];
    EXPECT_NEAR(static_cast<double>(uart.sent().front().begin_ns - window.begin_ns),
                static_cast<double>(uart.bit_ns()) / 2, 10.0);
    EXPECT_NEAR(static_cast<double>(window.end_ns - uart.sent().back().end_ns), static_cast<double>(uart.bit_ns()) / 4,
                10.0);
    EXPECT_EQ(port.counters().sent, 1U);
    EXPECT_EQ(uart.character_ns(), 11'000'000'000 / 115'163);  // 120 MHz / 1042
}

TEST_F(SensorPortTest, ATransmissionBeginsWhenItIsDueAndNotBefore) {
    port.give(request(3, 450'000), 2 * kTickNs);
    pass_until(2 * kTickNs + 400'000);
    EXPECT_TRUE(uart.driven().empty());
    pass_until(4 * kTickNs);
    ASSERT_FALSE(uart.sent().empty());
    EXPECT_GE(uart.sent()[0].begin_ns, 2 * kTickNs + 450'000);
    EXPECT_LE(uart.sent()[0].begin_ns, 2 * kTickNs + 450'000 + 110'000);
}

TEST_F(SensorPortTest, NothingIsHeardWhileItSends) {
    port.give(request(16), kTickNs);
    pass_until(4 * kTickNs);
    EXPECT_EQ(uart.sent().size(), 16U);
    EXPECT_TRUE(bytes_until(4 * kTickNs).empty());
    EXPECT_EQ(port.counters().heard, 0U);
    EXPECT_EQ(uart.collisions(), 0U);
}

TEST_F(SensorPortTest, AnAnswerRightAfterTheDriverIsHeard) {
    port.give(request(4), kTickNs);
    const std::int64_t end = kTickNs + 4 * uart.character_ns() + uart.bit_ns();
    uart.arrive_from(end + uart.bit_ns(), {1, 2, 3, 4, 5});
    pass_until(4 * kTickNs);
    EXPECT_EQ(bytes_until(4 * kTickNs), (std::vector<std::uint8_t>{1, 2, 3, 4, 5}));
    EXPECT_EQ(uart.collisions(), 0U);
    EXPECT_EQ(port.counters().silences, 1U);
    EXPECT_EQ(port.counters().cut, 0U);
}

TEST_F(SensorPortTest, TheSilenceAfterAFrameIsThreeAndAHalfCharacters) {
    uart.arrive_from(kTickNs, {1, 2});
    const std::int64_t end = kTickNs + 2 * uart.character_ns();
    pass_until(end + 34 * uart.character_ns() / 10);
    EXPECT_EQ(port.counters().silences, 0U);
    pass_until(end + 36 * uart.character_ns() / 10);
    EXPECT_EQ(port.counters().silences, 1U);
}

TEST_F(SensorPortTest, BytesTellTheirAge) {
    uart.arrive_from(kTickNs + 100'000, {7, 8});
    pass_until(2 * kTickNs);
    const std::span<const SensorByte> heard = port.take(2 * kTickNs);
    ASSERT_EQ(heard.size(), 2U);
    const std::int64_t age = 900'000 - uart.character_ns();
    EXPECT_EQ(heard[0].age_us, age / 1000);
    EXPECT_EQ(heard[1].age_us, (age - uart.character_ns()) / 1000);
    EXPECT_EQ(heard[0].flags, 0);
}

TEST_F(SensorPortTest, ATickTakesBytesOfItsTimeAloneAndThirtyTwoAtMost) {
    std::vector<std::uint8_t> bytes(40);
    for (std::uint8_t i = 0; i < 40; ++i) {
        bytes[i] = i;
    }
    uart.arrive_from(0, bytes);
    pass_until(5 * kTickNs);
    EXPECT_EQ(bytes_until(kTickNs).size(), 10U);  // 95.5 us each
    EXPECT_EQ(bytes_until(5 * kTickNs).size(), 30U);
    uart.arrive_from(5 * kTickNs, bytes);
    pass_until(10 * kTickNs);
    EXPECT_EQ(bytes_until(10 * kTickNs), std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + 32));
    EXPECT_EQ(bytes_until(10 * kTickNs), std::vector<std::uint8_t>(bytes.begin() + 32, bytes.end()));
}

TEST_F(SensorPortTest, DamagedBytesAreMarked) {
    uart.arrives(0x11, kTickNs, model::UsartModel::parity);
    uart.arrives(0x22, kTickNs + 200'000, model::UsartModel::framing);
    uart.arrives(0x33, kTickNs + 400'000);
    pass_until(3 * kTickNs);
    const std::span<const SensorByte> heard = port.take(3 * kTickNs);
    ASSERT_EQ(heard.size(), 3U);
    EXPECT_EQ(heard[0].flags, 1);
    EXPECT_EQ(heard[1].flags, 2);
    EXPECT_EQ(heard[2].flags, 0);
    EXPECT_EQ(port.counters().damaged, 2U);
}

TEST_F(SensorPortTest, ALateInterruptCostsBytesAndTheNextTellsIt) {
    served = false;
    uart.arrive_from(kTickNs, {1, 2, 3});
    pass_until(kTickNs + 250'000);  // the second has come over the first
    served = true;
    pass_until(2 * kTickNs);
    uart.arrives(9, 2 * kTickNs);
    pass_until(3 * kTickNs);
    const std::span<const SensorByte> heard = port.take(3 * kTickNs);
    ASSERT_EQ(heard.size(), 2U);
    EXPECT_EQ(heard[0].data, 1);
    EXPECT_EQ(heard[0].flags, 0);
    EXPECT_EQ(heard[1].data, 9);
    EXPECT_EQ(heard[1].flags, 4);
    EXPECT_EQ(port.counters().lost_bytes, 1U);
}

TEST_F(SensorPortTest, ABusThatNobodyReadsLosesBytesAndTellsIt) {
    uart.arrive_from(0, std::vector<std::uint8_t>(70, 5));
    pass_until(10 * kTickNs);
    EXPECT_EQ(port.counters().lost_bytes, 6U);
    EXPECT_EQ(bytes_until(10 * kTickNs).size(), 32U);
    EXPECT_EQ(bytes_until(10 * kTickNs).size(), 32U);
    uart.arrives(6, 10 * kTickNs);
    pass_until(11 * kTickNs);
    const std::span<const SensorByte> heard = port.take(11 * kTickNs);
    ASSERT_EQ(heard.size(), 1U);
    EXPECT_EQ(heard[0].flags, 4);
}

TEST_F(SensorPortTest, ASecondRequestIsLostAndCounted) {
    port.give(request(16), kTickNs);
    port.give(request(3), kTickNs);
    pass_until(kTickNs + 500'000);
    port.give(request(4), 2 * kTickNs);
    pass_until(6 * kTickNs);
    EXPECT_EQ(uart.sent().size(), 16U);
    EXPECT_EQ(port.counters().lost_requests, 2U);
    port.give(request(5), 7 * kTickNs);
    pass_until(9 * kTickNs);
    EXPECT_EQ(uart.sent().size(), 21U);
    EXPECT_EQ(uart.driven().size(), 2U);
    EXPECT_EQ(port.counters().sent, 2U);
}

TEST_F(SensorPortTest, TwoWhoSendAtOnceAreNoted) {
    port.give(request(8), kTickNs);
    uart.arrive_from(kTickNs - 40'000, {0x55, 0x66});
    pass_until(3 * kTickNs);
    EXPECT_GE(uart.collisions(), 1U);
    EXPECT_EQ(port.counters().cut, 1U);
    EXPECT_EQ(uart.sent().size(), 8U);
}

/// The controller's own master asks a device that answers as Modbus has it.
TEST_F(SensorPortTest, TheBusMasterHasItsAnswers) {
    sensors::BusMaster master(kBus, kTickNs);
    unsigned answers = 0;
    std::uint8_t made = 0;  // the next request may be on its way before an answer is good
    std::size_t asked = 0;
    for (std::int64_t tick = 1; tick < 200; ++tick) {
        const std::int64_t now = tick * kTickNs;
        pass_until(now);
        if (uart.sent().size() == asked + 8) {  // a whole request: one register is read
            asked += 8;
            std::vector<std::uint8_t> answer{5, 4, 2, 0x12, made++};
            const std::uint16_t sum = sensors::modbus::crc(answer);
            answer.push_back(static_cast<std::uint8_t>(sum & 0xFFU));
            answer.push_back(static_cast<std::uint8_t>(sum >> 8U));
            uart.arrive_from(std::max(now, uart.sent().back().end_ns + 2'000'000), answer);
        }
        sensors::Reply reply;
        if (master.step(now, port.take(now), reply)) {
            ASSERT_EQ(reply.size, 7U);
            EXPECT_EQ(sensors::modbus::register_of(reply.bytes, 0), 0x1200U + answers);
            ++answers;
        }
        SensorTransmission out;
        if (master.can_send(now)) {
            master.send(now, sensors::modbus::read(5, sensors::modbus::kReadInput, 6, 1, 10'000'000), out);
        }
        port.give(out, now + kTickNs);
    }
    EXPECT_GE(answers, 20U);
    EXPECT_EQ(master.strays(), 0U);
    EXPECT_EQ(port.counters().lost_requests, 0U);
    EXPECT_EQ(port.counters().cut, 0U);
}

TEST_F(SensorPortTest, TheRatesAndFormatsOfTheBusAreSet) {
    for (const std::uint32_t baud : {2'400U, 9'600U, 19'200U, 230'400U}) {
        ASSERT_EQ(port.start({.baud = baud, .parity = SensorParity::none}), SensorPort::Start::ok);
        EXPECT_NEAR(static_cast<double>(uart.character_ns()), 1e10 / baud, 0.002 * 1e10 / baud);
    }
    EXPECT_EQ(port.start({.baud = 1'200}), SensorPort::Start::bad_rate);
    EXPECT_EQ(port.start({.baud = 460'800}), SensorPort::Start::bad_rate);
}

TEST_F(SensorPortTest, TellsThatItDidNotStart) {
    uart.set_kernel_hz(0);
    EXPECT_EQ(port.start(kBus), SensorPort::Start::silent);
    port.give(request(3), kTickNs);
    EXPECT_EQ(port.counters().lost_requests, 1U);
}

TEST(SensorPortSecond, WorksOnTheOtherUsart) {
    model::Machine machine;
    model::RegisterWords clocks;
    machine.attach(model::rcc::kBase, model::rcc::kSize, clocks);
    model::UsartModel uart(machine, clocks, nullptr, model::UsartModel::kUsart6);
    SensorPort port(kSensorPorts[1]);
    machine.on_interrupt(model::UsartModel::kUsart6.interrupt, [&] { port.on_interrupt(machine.now_ns()); });
    ASSERT_EQ(port.start(kBus), SensorPort::Start::ok);
    SensorTransmission sent;
    sent.size = 2;
    sent.bytes = {0xA5, 0x5A};
    port.give(sent, 0);
    port.poll(1000);
    machine.advance_to(kTickNs);
    ASSERT_EQ(uart.sent().size(), 2U);
    EXPECT_EQ(uart.sent()[1].byte, 0x5A);
    EXPECT_EQ(machine.violations_text(), "");
}

}  // namespace
}  // namespace sc::stm32h743
