// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/gpio_lines.hpp"

#include <stdexcept>
#include <system_error>

#include <gtest/gtest.h>

namespace sc::linux_rt {
namespace {

TEST(LineWiring, ReadsChipNamesOffsetsAndPolarity) {
    const LineWiring wiring = parse_wiring("gpiochip0:estop=3,!interlock=4,red=10");
    EXPECT_EQ(wiring.chip, "gpiochip0");
    ASSERT_EQ(wiring.wires.size(), 3U);
    EXPECT_EQ(wiring.wires[1].name, "interlock");
    EXPECT_EQ(wiring.wires[1].offset, 4U);
    EXPECT_TRUE(wiring.wires[1].active_low);
    EXPECT_FALSE(wiring.wires[2].active_low);
}

TEST(LineWiring, RefusesWhatIsNoneAndSaysWhat) {
    const auto why = [](const std::string& text) -> std::string {
        try {
            static_cast<void>(parse_wiring(text));
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "taken";
    };
    EXPECT_NE(why("gpiochip0").find("CHIP:"), std::string::npos);
    EXPECT_NE(why(":estop=1,interlock=2").find("CHIP:"), std::string::npos);
    EXPECT_NE(why("c:estop=1,interlock=2,door=3").find("'door'"), std::string::npos);
    EXPECT_NE(why("c:estop=1,interlock=x").find("'x'"), std::string::npos);
    EXPECT_NE(why("c:estop=1,interlock").find("'interlock'"), std::string::npos);
    EXPECT_NE(why("c:estop=1,interlock=2,estop=3").find("twice"), std::string::npos);
    EXPECT_NE(why("c:estop=1,interlock=1").find("'estop' already"), std::string::npos);
    EXPECT_NE(why("c:estop=1").find("'interlock'"), std::string::npos);
    EXPECT_NE(why("c:interlock=1,red=2").find("'estop'"), std::string::npos);
}

TEST(GpioLines, AChipThatIsNotThereIsNamed) {
    try {
        const GpioLines lines(parse_wiring("no_such_chip:estop=1,interlock=2"));
        FAIL();
    } catch (const std::system_error& error) {
        EXPECT_NE(std::string(error.what()).find("no_such_chip"), std::string::npos);
    }
}

}  // namespace
}  // namespace sc::linux_rt
