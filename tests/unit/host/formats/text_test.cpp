// SPDX-License-Identifier: Apache-2.0
#include "host/formats/text.hpp"

#include <gtest/gtest.h>

#include "host/formats/toml_writer.hpp"

namespace sc::host {
namespace {

TEST(Decimal, IsShortAndAlwaysAFloat) {
    EXPECT_EQ(decimal(0.1), "0.1");
    EXPECT_EQ(decimal(60.0), "60.0");
    EXPECT_EQ(decimal(-3e-12), "-3e-12");
    EXPECT_EQ(decimal(0.0), "0.0");
}

TEST(Fixed, RoundsAndHasNoNegativeZero) {
    EXPECT_EQ(fixed(-314.09, 4), "-314.0900");
    EXPECT_EQ(fixed(-0.00001, 4), "0.0000");
    EXPECT_EQ(fixed(1e300, 1).size(), 303U);
}

TEST(Trimmed, TakesBlanksOffBothEnds) {
    EXPECT_EQ(trimmed(" \ta b\r"), "a b");
    EXPECT_EQ(trimmed(" \t\r"), "");
    EXPECT_EQ(trimmed(""), "");
}

TEST(FileValue, ReadsBackToTheSameDouble) {
    // What a file can hold: decimals of up to nine places, read by a division.
    for (const double divisor : {1.0, 1e3, 1e6}) {
        for (int i = -50'000; i <= 50'000; i += 7) {
            const double written = i * 1.37e-3;
            const double si = written / divisor;
            ASSERT_EQ(file_value(si, divisor) / divisor, si) << written << " by " << divisor;
        }
    }
    EXPECT_EQ(file_value(0.25 / 1e3, 1e3), 0.25);
    EXPECT_EQ(file_value(0.0, 1e3), 0.0);
}

}  // namespace
}  // namespace sc::host
