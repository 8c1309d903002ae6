// SPDX-License-Identifier: Apache-2.0
#include "host/cli/asked.hpp"

#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

std::filesystem::path written(const std::string& text) {
    const std::filesystem::path file =
        std::filesystem::path(::testing::TempDir()) /
        (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + "_asked.toml");
    std::ofstream(file) << text;
    return file;
}

TEST(Asked, ReadsBothSides) {
    const auto asked = read_asked(written("[b]\nx = {asked = 5.5, better = \"lower\"}\n"
                                          "y = {asked = 3, better = \"higher\"}\n"),
                                  "b");
    ASSERT_EQ(asked.size(), 2U);
    EXPECT_EQ(asked.at("x").value, 5.5);
    EXPECT_TRUE(asked.at("x").lower_is_better);
    EXPECT_EQ(asked.at("y").value, 3.0);
    EXPECT_FALSE(asked.at("y").lower_is_better);
}

TEST(Asked, MeetingIncludesTheValueItselfAndNeverWhatIsNoNumber) {
    const Asked lower{5.0, true};
    const Asked higher{5.0, false};
    const double none = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(meets(5.0, lower));
    EXPECT_FALSE(meets(5.001, lower));
    EXPECT_TRUE(meets(5.0, higher));
    EXPECT_FALSE(meets(4.999, higher));
    EXPECT_FALSE(meets(none, lower));
    EXPECT_FALSE(meets(none, higher));
}

TEST(Asked, RefusesWhatIsIncompleteAndNamesTheLine) {
    for (const char* figure : {"x = 5", "x = {asked = 5}", "x = {asked = 5, better = \"left\"}",
                               "x = {asked = nan, better = \"lower\"}", "x = {better = \"lower\"}"}) {
        try {
            static_cast<void>(read_asked(written("[b]\n" + std::string(figure) + "\n"), "b"));
            FAIL() << figure;
        } catch (const InputError& error) {
            EXPECT_EQ(error.line(), 2) << figure;
        }
    }
    EXPECT_THROW(static_cast<void>(read_asked(written("[b]\n"), "c")), InputError);
    EXPECT_THROW(static_cast<void>(read_asked(written("[b\n"), "b")), InputError);
    EXPECT_THROW(static_cast<void>(read_asked("no-such-file.toml", "b")), InputError);
}

TEST(Asked, TheProjectsOwnListIsSound) {
    const auto asked = read_asked(std::filesystem::path(SC_SOURCE_DIR) / "tests/bench/asked.toml", "scribe");
    EXPECT_EQ(asked.at("max_command_error_um").value, 5.0);
    EXPECT_EQ(asked.at("limit_violations").value, 0.0);
    EXPECT_LE(asked.at("wall_seconds").value, 20.0);
}

}  // namespace
}  // namespace sc::host::cli
