// SPDX-License-Identifier: Apache-2.0
#include "host/formats/error.hpp"

#include <gtest/gtest.h>

namespace sc::host {
namespace {

TEST(InputError, SaysFileLineProblemValueAndAction) {
    const InputError error(
        {.file = "a.csv", .line = 7, .problem = "is not a number", .value = "abc", .action = "give a number"});
    EXPECT_STREQ(error.what(), "a.csv:7: is not a number: abc; give a number");
    EXPECT_EQ(error.file(), "a.csv");
    EXPECT_EQ(error.line(), 7);
    EXPECT_EQ(error.problem(), "is not a number");
    EXPECT_EQ(error.value(), "abc");
    EXPECT_EQ(error.action(), "give a number");
}

TEST(InputError, LeavesOutWhatIsEmpty) {
    EXPECT_STREQ(InputError({.file = "a.csv", .problem = "is empty", .action = "give rows"}).what(),
                 "a.csv: is empty; give rows");
    EXPECT_STREQ(InputError({.problem = "unknown face", .value = "45"}).what(), "unknown face: 45");
}

}  // namespace
}  // namespace sc::host
