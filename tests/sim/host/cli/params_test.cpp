// SPDX-License-Identifier: Apache-2.0
// Parameters that outlive the power, by the built programs.
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Params : public testing::Test {
protected:
    Params() : memory_(fresh_folder() / "retained.bin") {}

    int params(std::vector<std::string> more) {
        std::vector<std::string> words{"params", "--memory", memory_.string(), "--json"};
        words.insert(words.end(), more.begin(), more.end());
        Program program("scribecell", words);
        const int code = program.wait();
        said_ = program.err();
        json_ = code == 0 ? Json::parse(program.out()) : Json();
        return code;
    }
    [[nodiscard]] double now(const std::string& name) const { return json_.at("parameters").at(name); }
    [[nodiscard]] double stored(const std::string& name) const { return json_.at("stored").at(name); }

    fs::path memory_;
    std::string said_;
    Json json_;
};

TEST_F(Params, AreInForceFromTheNextStartAndForgottenOnRequest) {
    ASSERT_EQ(params({}), 0) << said_;
    EXPECT_EQ(json_.at("generation"), 0);
    const double built_in = now("x.speed_mm_s");
    ASSERT_NE(built_in, 123.5);
    ASSERT_EQ(params({"x.speed_mm_s=123.5", "settle_ms=31"}), 0) << said_;
    EXPECT_EQ(json_.at("generation"), 1);
    EXPECT_EQ(json_.at("in_force"), false);
    EXPECT_DOUBLE_EQ(now("x.speed_mm_s"), built_in);
    EXPECT_DOUBLE_EQ(stored("x.speed_mm_s"), 123.5);
    ASSERT_EQ(params({"z.speed_mm_s=77"}), 0) << said_;
    EXPECT_DOUBLE_EQ(now("x.speed_mm_s"), 123.5) << "in force by now";
    EXPECT_DOUBLE_EQ(stored("x.speed_mm_s"), 123.5) << "and kept beside what is changed";
    EXPECT_DOUBLE_EQ(stored("settle_ms"), 31);
    ASSERT_EQ(params({}), 0) << said_;
    EXPECT_EQ(json_.at("generation"), 2);
    EXPECT_EQ(json_.at("in_force"), true);
    EXPECT_DOUBLE_EQ(now("z.speed_mm_s"), 77);
    ASSERT_EQ(params({"--reset"}), 0) << said_;
    ASSERT_EQ(params({}), 0) << said_;
    EXPECT_EQ(json_.at("generation"), 0);
    EXPECT_DOUBLE_EQ(now("x.speed_mm_s"), built_in);
}

TEST_F(Params, ASlotThatIsSpoiltGivesWayToTheOneBefore) {
    ASSERT_EQ(params({"x.speed_mm_s=100"}), 0) << said_;
    ASSERT_EQ(params({"x.speed_mm_s=101"}), 0) << said_;
    std::fstream file(memory_.string() + ".parameters", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(1280 + 500);
    file.put('\x5A');
    file.close();
    ASSERT_EQ(params({}), 0) << said_;
    EXPECT_EQ(json_.at("generation"), 1);
    EXPECT_DOUBLE_EQ(now("x.speed_mm_s"), 100);
}

TEST_F(Params, WhatIsNoneIsRefused) {
    EXPECT_EQ(params({"x.sped_mm_s=1"}), 2);
    EXPECT_NE(said_.find("no parameter of this name"), std::string::npos) << said_;
    EXPECT_EQ(params({"x.speed_mm_s=0"}), 2);
    EXPECT_NE(said_.find("no controller can run with this"), std::string::npos) << said_;
    EXPECT_EQ(params({"--reset", "x.speed_mm_s=5"}), 2);
    EXPECT_EQ(params({"--link", "tcp:127.0.0.1:1"}), 2) << "--memory is the simulated cell's";
}

}  // namespace
}  // namespace sc::test
