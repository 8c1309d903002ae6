// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/mopa_serial.hpp"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

constexpr std::int64_t kMs = 1'000'000;

std::vector<std::uint8_t> bytes(std::string_view text) { return {text.begin(), text.end()}; }

std::vector<std::uint8_t> sent(MopaSerial& serial) {
    std::array<std::uint8_t, kSourceBytesPerTick> out{};
    const std::size_t size = serial.transmit(out);
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

/// The answer to a width of 300 ns.
WidthAnswer answer(LaserSource source, const std::vector<std::uint8_t>& heard, std::uint16_t& width) {
    MopaSerial serial(source, kMs);
    serial.begin(300);
    static_cast<void>(sent(serial));
    const WidthAnswer verdict = serial.step(heard);
    width = serial.answered();
    EXPECT_EQ(serial.busy(), verdict == WidthAnswer::none);
    return verdict;
}

TEST(MopaSerial, SendsTheRequestOfItsMakerOnce) {
    MopaSerial raycus(LaserSource::raycus, kMs);
    EXPECT_TRUE(sent(raycus).empty());
    raycus.begin(300);
    EXPECT_EQ(sent(raycus), (std::vector<std::uint8_t>{0xA5, 0x01, 0x01, 0x2C}));
    EXPECT_TRUE(sent(raycus).empty());
    MopaSerial jpt(LaserSource::jpt, kMs);
    jpt.begin(20);
    EXPECT_EQ(sent(jpt), bytes("$34;020*"));
    EXPECT_TRUE(sent(jpt).empty());
}

TEST(MopaSerial, JudgesWhatItHears) {
    struct Case {
        LaserSource source;
        std::vector<std::uint8_t> heard;
        WidthAnswer verdict;
        std::uint16_t width;
    };
    const std::vector<Case> cases{
        {LaserSource::raycus, {0xA5, 0x01, 0x2C}, WidthAnswer::set, 300},
        {LaserSource::raycus, {0xA5, 0x00, 0x64}, WidthAnswer::refused, 100},
        {LaserSource::raycus, {0xA5, 0x01}, WidthAnswer::none, 0},
        {LaserSource::raycus, bytes("E"), WidthAnswer::foreign, 0},
        {LaserSource::raycus, {0x00}, WidthAnswer::foreign, 0},
        {LaserSource::jpt, bytes("$34;300*"), WidthAnswer::set, 300},
        {LaserSource::jpt, bytes("$34;100*"), WidthAnswer::refused, 100},
        {LaserSource::jpt, bytes("E"), WidthAnswer::refused, 0},
        {LaserSource::jpt, bytes("$34;30"), WidthAnswer::none, 0},
        {LaserSource::jpt, bytes("$35;300*"), WidthAnswer::foreign, 0},
        {LaserSource::jpt, bytes("$34;3x0*"), WidthAnswer::foreign, 0},
        {LaserSource::jpt, bytes("$34;300;"), WidthAnswer::foreign, 0},
        {LaserSource::jpt, {0xA5}, WidthAnswer::foreign, 0},
    };
    for (std::size_t i = 0; i < cases.size(); ++i) {
        std::uint16_t width = 0;
        EXPECT_EQ(answer(cases[i].source, cases[i].heard, width), cases[i].verdict) << i;
        EXPECT_EQ(width, cases[i].width) << i;
    }
}

TEST(MopaSerial, TakesAnAnswerThatComesByteByByte) {
    MopaSerial serial(LaserSource::jpt, kMs);
    serial.begin(20);
    static_cast<void>(sent(serial));
    const auto answer = bytes("$34;020*");
    for (std::size_t i = 0; i < answer.size(); ++i) {
        const WidthAnswer verdict = serial.step(std::span(answer).subspan(i, 1));
        EXPECT_EQ(verdict, i + 1 == answer.size() ? WidthAnswer::set : WidthAnswer::none);
    }
}

TEST(MopaSerial, GivesUpAfterItsTimeAndCanBeAskedAgain) {
    MopaSerial serial(LaserSource::raycus, kMs);
    for (int round = 0; round < 2; ++round) {
        serial.begin(20);
        static_cast<void>(sent(serial));
        int ticks = 1;
        WidthAnswer verdict = serial.step({});
        for (; verdict == WidthAnswer::none && ticks < 1000; ++ticks) {
            verdict = serial.step({});
        }
        EXPECT_EQ(verdict, WidthAnswer::silent);
        EXPECT_EQ(ticks, 150);
        const auto late = std::vector<std::uint8_t>{0xA5, 0x00, 0x14};
        EXPECT_EQ(serial.step(late), WidthAnswer::none) << "nobody asks any more";
    }
}

}  // namespace
}  // namespace sc::laser
