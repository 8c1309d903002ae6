// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace sc::test {
namespace {

using nlohmann::json;

TEST(BenchLaser, FieldAndPulsesMeetWhatIsAskedAndEachPartEarnsIt) {
    Program bench("scribecell", {"bench", "laser", "--json"});
    EXPECT_EQ(bench.wait(), 0) << bench.out() << bench.err();
    const json object = json::parse(bench.out());
    ASSERT_EQ(object.at("figures").size(), 37U);
    std::map<std::string, double> value;
    for (const json& figure : object.at("figures")) {
        EXPECT_TRUE(figure.at("met").get<bool>()) << figure.dump();
        value[figure.at("name").get<std::string>()] = figure.at("value").get<double>();
    }
    // With a part switched off, the figure that is asked of it fails by far.
    EXPECT_GT(value.at("field_without_depth_max_um"), 10.0 * 10.0);
    EXPECT_GT(value.at("placement_without_lag_peak_um"), 100.0 * value.at("placement_peak_um"));
    EXPECT_GT(value.at("placement_time_only_peak_um"), 10.0 * value.at("placement_peak_um"));
    EXPECT_GT(value.at("placement_untuned_peak_um"), 10.0 * value.at("placement_mismatched_peak_um"));
    EXPECT_GT(value.at("pitch_without_lag_peak_pct"), 10.0 * value.at("pitch_error_peak_pct"));
    EXPECT_GT(value.at("energy_without_law_pct"), 10.0 * value.at("energy_error_pct"));
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

TEST(CalibrateGalvoLag, FindsTheMirrorsOfTheWorldAndWritesASetThatAJobRunsOn) {
    const auto folder = fresh_folder();
    Program calibrate("scribecell", {"calibrate", "galvo-lag", "--out", (folder / "a").string(), "--json"});
    ASSERT_EQ(calibrate.wait(), 0) << calibrate.err();
    const json object = json::parse(calibrate.out());
    EXPECT_NEAR(object.at("latency_us").at("value").get<double>(), 160.0, 2.0);
    EXPECT_NEAR(object.at("natural_frequency_hz").at("value").get<double>(), 2000.0, 100.0);
    EXPECT_NEAR(object.at("damping").at("value").get<double>(), 0.75, 0.03);
    // The same marks as a person would hand them in.
    Program again("scribecell", {"calibrate", "galvo-lag", "--plan", (folder / "a/plan.csv").string(), "--measured",
                                 (folder / "a/measured.csv").string(), "--json"});
    ASSERT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(json::parse(again.out()).at("damping"), object.at("damping"));
    Program scribe("scribecell",
                   {"scribe", "--face", "90", "--calibration", (folder / "a/calibration.toml").string(), "--json"});
    ASSERT_EQ(scribe.wait(), 0) << scribe.err();
    EXPECT_LT(json::parse(scribe.out()).at("max_command_error_um").get<double>(), 5.0);
}

TEST(CalibrateGalvoLag, RefusesWhatCannotSupportIt) {
    const auto folder = fresh_folder();
    write_file(folder / "plan.csv",
               "line,along,way,start_x,start_z,run,amplitude,wavelength,speed,pitch,anchor_x,anchor_y,anchor_z,"
               "told_latency_us,told_frequency_hz,told_damping\n"
               "1,x,1,-8,2,16,0,0,2000,0.1,-225,-210,-250,160,2000,0.75\n");
    write_file(folder / "few.csv", "line,mark,x,y,z,sigma\n1,40,-229,-210,-248,0.0075\n");
    Program few("scribecell", {"calibrate", "galvo-lag", "--plan", (folder / "plan.csv").string(), "--measured",
                               (folder / "few.csv").string()});
    EXPECT_EQ(few.wait(), 2);
    EXPECT_NE(few.err().find("fewer than 200"), std::string::npos) << few.err();
    Program alone("scribecell", {"calibrate", "galvo-lag", "--plan", (folder / "plan.csv").string()});
    EXPECT_EQ(alone.wait(), 2);
    EXPECT_NE(alone.err().find("--measured"), std::string::npos) << alone.err();
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
