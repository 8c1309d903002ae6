// SPDX-License-Identifier: Apache-2.0
#include "host/drives/emergency_text.hpp"

#include <gtest/gtest.h>

namespace sc::host {
namespace {

TEST(EmergencyText, CodesTheirGroupsAndWhatIsNone) {
    EXPECT_NE(emergency_text(0x8611).find("following error"), std::string::npos);
    EXPECT_NE(emergency_text(0x8130).find("heartbeat"), std::string::npos);
    EXPECT_NE(emergency_text(0x2345).find("current"), std::string::npos) << "the group of a code that is not listed";
    EXPECT_NE(emergency_text(0xFF42).find("maker"), std::string::npos);
    EXPECT_NE(emergency_text(0xA000).find("not in"), std::string::npos);
    EXPECT_TRUE(emergency_text(0x0000).starts_with("0000: no error"));
    for (unsigned code = 0; code <= 0xFFFF; ++code) {
        ASSERT_GT(emergency_text(static_cast<std::uint16_t>(code)).size(), 8U) << code;
    }
}

TEST(EmergencyText, TheErrorRegister) {
    EXPECT_EQ(error_register_text(0), "");
    EXPECT_EQ(error_register_text(0x09), "generic, temperature");
}

}  // namespace
}  // namespace sc::host
