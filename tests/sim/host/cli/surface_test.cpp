// SPDX-License-Identifier: Apache-2.0
// Jobs with [surface]: the Y sensor looks at each line before it is burnt, by the built programs.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/formats/pulse_trace.hpp"
#include "program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string kExamples = std::string(SC_SOURCE_DIR) + "/examples/ras3dm/";

class ScribeSurface : public testing::Test {
protected:
    ScribeSurface() : folder_(fresh_folder()) {}

    /// The example's job with more text; its files are found where they are.
    std::string job(const std::string& more) {
        std::string text = read_file(kExamples + "job.toml");
        for (const char* file : {"table1.csv", "calibration.toml", "face90_c.csv"}) {
            const std::string quoted = '"' + std::string(file) + '"';
            text = replaced(text, quoted, '"' + kExamples + file + '"');
        }
        return write("job.toml", text + more);
    }
    /// One line between markers 1 and 2 of face 0, so many mm too far from the head; or too near.
    std::string line(double deeper_mm, const std::string& surface) {
        return write("line.toml", "format = \"scribecell-job\"\nversion = 1\nname = \"line\"\ncalibration = \"" +
                                      kExamples + "calibration.toml\"\n" + surface +
                                      "[[path]]\nname = \"between the markers\"\nface_deg = 0.0\nframe = \"h\"\n"
                                      "points_mm = [[-314.09, " +
                                      std::to_string(-319.77 - deeper_mm) + ", -425.944], [-266.127, " +
                                      std::to_string(-319.066 - deeper_mm) +
                                      ", -413.494]]\nactuator = \"axes\"\nspeed_mm_s = 20.0\npitch_um = 20.0\n"
                                      "energy_uj = 300.0\n");
    }
    int scribe(const std::string& file, std::vector<std::string> more = {}) {
        std::vector<std::string> words{"scribe", file, "--out", out().string(), "--json"};
        words.insert(words.end(), more.begin(), more.end());
        Program program("scribecell", words);
        const int code = program.wait();
        said_ = program.err();
        json_ = program.out().empty() ? Json() : Json::parse(program.out());
        return code;
    }
    [[nodiscard]] fs::path out() const { return folder_ / "out"; }
    /// Largest defocus of the pulses, mm.
    [[nodiscard]] double defocus() const {
        double worst = 0.0;
        for (const trace::PulseRecord& pulse : host::read_pulse_trace(out() / "pulses.trace").pulses) {
            worst = std::max(worst, std::abs(static_cast<double>(pulse.defocus_pm)) * 1e-9);
        }
        return worst;
    }
    std::string said_;
    Json json_;

private:
    std::string write(const std::string& name, const std::string& text) {
        write_file(folder_ / name, text);
        return (folder_ / name).string();
    }
    fs::path folder_;
};

const std::string kCheck = "[surface]\nmode = \"check\"\nwindow_mm = 1.0\n";
const std::string kFollow = "[surface]\nmode = \"follow\"\nwindow_mm = 1.0\nbound_mm = 0.8\n";

TEST_F(ScribeSurface, TheExampleIsLookedAtAndBurntAsWithoutTheSensor) {
    ASSERT_EQ(scribe(job(""), {"--face", "0"}), 0) << said_;
    const std::string bare = json_.at("command_trace_sha256");
    const double seconds = json_.at("cell_seconds");
    for (const std::string& surface : {kCheck, kFollow}) {
        ASSERT_EQ(scribe(job(surface), {"--face", "0"}), 0) << said_;
        EXPECT_EQ(json_.at("command_trace_sha256"), bare);
        EXPECT_GT(json_.at("cell_seconds"), seconds + 5.0) << "looking takes its time";
    }
}

TEST_F(ScribeSurface, ALineThatIsOffIsRefusedByNameAndNothingIsBurnt) {
    EXPECT_EQ(scribe(line(1.6, kCheck)), 1);
    EXPECT_NE(said_.find("surface_not_there"), std::string::npos) << said_;
    EXPECT_NE(said_.find("the Y sensor's look at the path \"between the markers\""), std::string::npos) << said_;
    EXPECT_TRUE(host::read_pulse_trace(out() / "pulses.trace").pulses.empty());
}

TEST_F(ScribeSurface, FollowingTakesALineThatIsTooDeepIntoFocus) {
    ASSERT_EQ(scribe(line(0.4, kCheck)), 0) << said_;
    EXPECT_GT(defocus(), 0.3);
    ASSERT_EQ(scribe(line(0.4, kFollow)), 0) << said_;
    EXPECT_LT(defocus(), 0.15);
}

TEST_F(ScribeSurface, APreviewLooksAtNothing) { ASSERT_EQ(scribe(line(5.0, kCheck), {"--preview"}), 0) << said_; }

TEST_F(ScribeSurface, WithoutASensorInTheCalibrationItSaysSo) {
    const std::string set = read_file(kExamples + "calibration.toml");
    const fs::path file = out().parent_path() / "bare.toml";
    std::string bare = set.substr(0, set.find("[y_sensor]"));
    const std::string rest = set.substr(set.find("[y_sensor]") + 1);
    bare += rest.find("\n[") == std::string::npos ? "" : rest.substr(rest.find("\n[") + 1);
    const std::size_t sum = bare.find("sha256 = ");
    bare.erase(sum, bare.find('\n', sum) + 1 - sum);
    write_file(file, bare);
    EXPECT_EQ(scribe(line(0.0, kCheck), {"--calibration", file.string()}), 2);
    EXPECT_NE(said_.find("does not say where the Y sensor is"), std::string::npos) << said_;
}

}  // namespace
}  // namespace sc::test
