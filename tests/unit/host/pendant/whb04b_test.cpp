// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/whb04b.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sc::host::pendant {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Bytes as such pendants have sent them (docs/pendant.md).
TEST(PendantReport, ReadsKnobsKeysAndWheel) {
    const auto turned = parse_report(Bytes{0x04, 0xBA, 0x00, 0x00, 0x0E, 0x11, 0x00, 0xBA});
    ASSERT_TRUE(turned);
    EXPECT_EQ(turned->feed, FeedKnob::mm_0_01);
    EXPECT_EQ(turned->axis, AxisKnob::x);
    EXPECT_EQ(turned->detents, 0);
    EXPECT_TRUE(turned->proven);

    const auto pressed = parse_report(Bytes{0x04, 0x82, 0x01, 0x00, 0x0E, 0x12, 0x00, 0x81});
    ASSERT_TRUE(pressed);
    EXPECT_TRUE(pressed->holds(Key::reset));
    EXPECT_FALSE(pressed->holds(Key::stop));
    EXPECT_TRUE(pressed->proven) << "the rule of a press is not known: it must not be refused";

    const auto wheel = parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x0E, 0x12, 0x01, 0x9C});
    ASSERT_TRUE(wheel);
    EXPECT_EQ(wheel->detents, 1);
    EXPECT_TRUE(wheel->proven);
    const auto back = parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x0E, 0x12, 0xFD, 0x9C});
    ASSERT_TRUE(back);
    EXPECT_EQ(back->detents, -3);
}

TEST(PendantReport, TellsAWrongChecksumOfTheWheel) {
    const auto wheel = parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x0E, 0x12, 0x01, 0x9B});
    ASSERT_TRUE(wheel);
    EXPECT_FALSE(wheel->proven);
}

TEST(PendantReport, IsRefusedWhenItIsNone) {
    EXPECT_FALSE(parse_report({}));
    EXPECT_FALSE(parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x0E, 0x12, 0x01}));
    EXPECT_FALSE(parse_report(Bytes{0x05, 0x9D, 0x00, 0x00, 0x0E, 0x12, 0x01, 0x9C})) << "another report";
    EXPECT_FALSE(parse_report(Bytes{0x04, 0x9D, 0x11, 0x00, 0x0E, 0x12, 0x01, 0x9C})) << "no such key";
    EXPECT_FALSE(parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x11, 0x12, 0x01, 0x9C}))
        << "no such place of the feed knob";
    EXPECT_FALSE(parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x0E, 0x17, 0x01, 0x9C}))
        << "no such place of the axis knob";
    EXPECT_FALSE(parse_report(Bytes{0x04, 0x9D, 0x00, 0x00, 0x0E, 0x12, 0x01, 0x9C, 0x00})) << "too long";
}

TEST(PendantReport, ComesBackFromItsBytes) {
    for (int random = 0; random < 256; ++random) {
        Report report{.keys = {},
                      .feed = FeedKnob::percent_60,
                      .axis = AxisKnob::c,
                      .detents = random - 128,
                      .proven = random % 3 != 0};
        const auto back = parse_report(to_bytes(report, static_cast<std::uint8_t>(random)));
        ASSERT_TRUE(back);
        EXPECT_EQ(back->detents, report.detents);
        EXPECT_EQ(back->feed, report.feed);
        EXPECT_EQ(back->axis, report.axis);
        EXPECT_EQ(back->proven, report.proven) << random;
    }
}

/// The block as a pendant puts it together again.
Bytes block_of(const Display& display) {
    Bytes out;
    for (const auto& report : to_reports(display)) {
        EXPECT_EQ(report[0], 0x06);
        out.insert(out.end(), report.begin() + 1, report.end());
    }
    return out;
}
int word(const Bytes& block, std::size_t at) { return block[at] | block[at + 1] << 8; }

TEST(PendantDisplay, PutsPlacesAndNumbersWhereThePendantLooks) {
    Display display;
    display.lines = {-12.3456, 0.00004, 250.99996};
    display.feed = 120;
    display.speed = 1000;
    const Bytes block = block_of(display);
    ASSERT_EQ(block.size(), 21U);
    EXPECT_EQ(word(block, 0), 0xFDFE);
    EXPECT_EQ(block[3], 0x81);
    EXPECT_EQ(word(block, 4), 12);
    EXPECT_EQ(word(block, 6), 0x8000 | 3456);
    EXPECT_EQ(word(block, 8), 0);
    EXPECT_EQ(word(block, 10), 0) << "nothing is left of it, so it has no sign";
    EXPECT_EQ(word(block, 12), 251) << "carried over";
    EXPECT_EQ(word(block, 14), 0);
    EXPECT_EQ(word(block, 16), 120);
    EXPECT_EQ(word(block, 18), 1000);
}

TEST(PendantDisplay, KeepsWhatIsTooLargeOrNoNumberWithinItsLine) {
    Display display;
    display.lines = {1e9, -1e9, std::numeric_limits<double>::quiet_NaN()};
    const Bytes block = block_of(display);
    EXPECT_EQ(word(block, 4), 65535);
    EXPECT_EQ(word(block, 6), 9999);
    EXPECT_EQ(word(block, 8), 65535);
    EXPECT_EQ(word(block, 10), 0x8000 | 9999);
    EXPECT_EQ(word(block, 12), 0);
    EXPECT_EQ(word(block, 14), 0);
}

}  // namespace
}  // namespace sc::host::pendant
