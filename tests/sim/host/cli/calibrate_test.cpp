// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace sc::test {
namespace {

using nlohmann::json;

TEST(BenchLaser, FieldCorrectionMeetsWhatIsAskedAndItsThirdDimensionEarnsIt) {
    Program bench("scribecell", {"bench", "laser", "--json"});
    EXPECT_EQ(bench.wait(), 0) << bench.out() << bench.err();
    const json object = json::parse(bench.out());
    ASSERT_EQ(object.at("figures").size(), 5U);
    for (const json& figure : object.at("figures")) {
        EXPECT_TRUE(figure.at("met").get<bool>()) << figure.dump();
        if (figure.at("name") == "field_without_depth_max_um") {
            // Without depth the figure that is asked of the correction fails by far.
            EXPECT_GT(figure.at("value").get<double>(), 10.0 * 10.0);
        }
    }
}

TEST(CalibrateGalvoField, WritesASetThatAJobRunsOn) {
    const auto folder = fresh_folder();
    Program calibrate("scribecell", {"calibrate", "galvo-field", "--out", (folder / "a").string(), "--json"});
    ASSERT_EQ(calibrate.wait(), 0) << calibrate.err();
    const json object = json::parse(calibrate.out());
    EXPECT_EQ(object.at("crosses"), 675);
    EXPECT_NEAR(object.at("rms_um").get<double>(), 7.5, 1.0);
    // The same crosses as a person would hand them in.
    Program again("scribecell", {"calibrate", "galvo-field", "--plan", (folder / "a/plan.csv").string(), "--measured",
                                 (folder / "a/measured.csv").string(), "--json"});
    ASSERT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(json::parse(again.out()).at("parameters"), object.at("parameters"));
    Program scribe("scribecell",
                   {"scribe", "--face", "90", "--calibration", (folder / "a/calibration.toml").string(), "--json"});
    ASSERT_EQ(scribe.wait(), 0) << scribe.err();
    EXPECT_LT(json::parse(scribe.out()).at("max_command_error_um").get<double>(), 5.0);
}

TEST(CalibrateGalvoField, RefusesWhatCannotSupportIt) {
    const auto folder = fresh_folder();
    write_file(folder / "plan.csv", "no,command_x,command_z,anchor_x,anchor_y,anchor_z\n1,0,0,-225,-210,-250\n");
    write_file(folder / "few.csv", "no,x,y,z,sigma\n1,-225,-210,-250,0.0075\n");
    write_file(folder / "other.csv", "no,x,y,z,sigma\n2,-225,-210,-250,0.0075\n");
    const auto refused = [&](std::vector<std::string> words, const char* word) {
        words.insert(words.begin(), {"calibrate", "galvo-field"});
        Program program("scribecell", words);
        EXPECT_EQ(program.wait(), 2) << word;
        EXPECT_NE(program.err().find(word), std::string::npos) << program.err();
        EXPECT_EQ(program.out(), "");
    };
    const std::string plan = (folder / "plan.csv").string();
    refused({"--plan", plan, "--measured", (folder / "few.csv").string()}, "too few");
    refused({"--plan", plan, "--measured", (folder / "other.csv").string()}, "not in the plan");
    refused({"--plan", plan}, "--plan and --measured together");
    refused({"--plan", plan, "--measured", (folder / "none.csv").string()}, "none.csv");
    refused({"--link", "tcp:127.0.0.1:9"}, "measured by a person");
    refused({"--burn-only"}, "--out");
}

}  // namespace
}  // namespace sc::test
