// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/script_port.hpp"

#include <string>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host::pendant {
namespace {

HostTime at_ms(double ms) { return HostTime(Nanoseconds(static_cast<std::int64_t>(ms * 1e6))); }

TEST(ScriptPort, PlaysReportsInTheirTime) {
    ScriptPort port(
        parse_script("0 plug\n"
                     "0 axis z  # comment\n"
                     "\n"
                     "10.5 feed 60%\n"
                     "20 wheel -3\n"
                     "20 press fn feed+\n"
                     "30 raw 04 9d 00 00 0e 12 01 9c\n"
                     "40 unplug\n",
                     "a.txt"));
    EXPECT_FALSE(port.ended());
    const auto plugged = port.next(at_ms(100));  // the first look is its zero
    ASSERT_TRUE(plugged);
    EXPECT_EQ(plugged->kind, PortEvent::Kind::plugged);
    const auto axis = port.next(at_ms(100));
    ASSERT_TRUE(axis);
    EXPECT_EQ(parse_report(std::span(axis->bytes).first(axis->size))->axis, AxisKnob::z);
    EXPECT_FALSE(port.next(at_ms(110.4)));
    const auto feed = port.next(at_ms(110.5));
    ASSERT_TRUE(feed);
    EXPECT_EQ(parse_report(std::span(feed->bytes).first(feed->size))->feed, FeedKnob::percent_60);
    const auto wheel = port.next(at_ms(200));
    ASSERT_TRUE(wheel);
    const auto turned = parse_report(std::span(wheel->bytes).first(wheel->size));
    EXPECT_EQ(turned->detents, -3);
    EXPECT_EQ(turned->axis, AxisKnob::z) << "a knob stays where it was turned to";
    EXPECT_TRUE(turned->proven);
    const auto keys = port.next(at_ms(200));
    const auto pressed = parse_report(std::span(keys->bytes).first(keys->size));
    EXPECT_TRUE(pressed->holds(Key::fn));
    EXPECT_TRUE(pressed->holds(Key::feed_plus));
    EXPECT_EQ(pressed->detents, 0);
    const auto raw = port.next(at_ms(200));
    EXPECT_EQ(parse_report(std::span(raw->bytes).first(raw->size))->axis, AxisKnob::y);
    EXPECT_EQ(port.next(at_ms(200))->kind, PortEvent::Kind::unplugged);
    EXPECT_TRUE(port.ended());
    EXPECT_FALSE(port.next(at_ms(900)));
}

TEST(ScriptPort, RefusesWhatIsNoEventWithItsLine) {
    for (const std::string bad :
         {"wheel 1", "5 wheel 1.5", "5 wheel 300", "5 axis q", "5 feed 2", "5 press nothing", "5 press fn stop fn", "5",
          "5 raw", "5 raw 4 zz", "-1 plug", "nan plug", "5 plug now"}) {
        try {
            (void)parse_script("0 plug\n" + bad + "\n", "a.txt");
            ADD_FAILURE() << "taken: " << bad;
        } catch (const InputError& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("a.txt"), std::string::npos) << text;
            EXPECT_NE(text.find('2'), std::string::npos) << text;
        }
    }
    EXPECT_THROW((void)parse_script("5 plug\n4 unplug\n", "a.txt"), InputError) << "back in time";
}

}  // namespace
}  // namespace sc::host::pendant
