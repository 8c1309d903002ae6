// SPDX-License-Identifier: Apache-2.0
// A job's pulse width and a calibration set's power curve on their way to the source, through the built programs.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/formats/pulse_trace.hpp"
#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string kExample = SC_SOURCE_DIR "/examples/ras3dm/";

std::string replaced_all(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
        text.replace(at, from.size(), to);
    }
    return text;
}

/// The example's job in a folder of its own, with a pulse width.
fs::path job_with_width(const fs::path& folder, int width_ns) {
    fs::copy(kExample, folder / "job", fs::copy_options::recursive);
    const fs::path file = folder / "job/job.toml";
    write_file(file, replaced_all(read_file(file),
                                  "actuator = ", "pulse_width_ns = " + std::to_string(width_ns) + "\nactuator = "));
    return file;
}

Json scribe(std::vector<std::string> words, int exit_code) {
    words.insert(words.begin(), {"scribe", "--json"});
    words.insert(words.end(), {"--face", "0"});
    Program program("scribecell", words);
    EXPECT_EQ(program.wait(), exit_code) << program.err();
    Json json = Json::parse(program.out(), nullptr, false);
    EXPECT_TRUE(json.is_object()) << program.out();
    return json;
}

TEST(ScribeSource, SetsTheJobsPulseWidthBeforeItBurns) {
    const fs::path folder = fresh_folder();
    const fs::path job = job_with_width(folder, 20);
    const fs::path out = folder / "out";
    const Json report = scribe({job.string(), "--out", out.string()}, 0);
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(Json::parse(read_file(out / "cell.json"))["pulse_width_ns"], 20);
}

TEST(ScribeSource, AWidthThatTheSourceDoesNotTakeBurnsNothing) {
    const fs::path folder = fresh_folder();
    const Json json = scribe({job_with_width(folder, 21).string()}, 1);
    EXPECT_EQ(json["error"]["name"], "pulse_width_refused");
    EXPECT_EQ(json["cell"]["pulses"], 0);
    write_file(folder / "mute.txt", "at 0 laser mute\n");
    const Json mute = scribe({(folder / "job/job.toml").string(), "--script", (folder / "mute.txt").string()}, 1);
    EXPECT_EQ(mute["error"]["name"], "pulse_width_no_answer");
}

/// Mean energy of the pulses as the cell has seen them, nJ.
double mean_energy(const fs::path& out) {
    const host::PulseTrace trace = host::read_pulse_trace(out / "pulses.trace");
    double sum = 0.0;
    for (const auto& pulse : trace.pulses) {
        sum += pulse.energy_nj;
    }
    return sum / static_cast<double>(trace.pulses.size());
}

TEST(ScribeSource, AppliesTheMeasuredPowerCurve) {
    const fs::path folder = fresh_folder();
    write_file(folder / "bent.toml", "version = 1\nbase = \"" SC_SOURCE_DIR
                                     "/boards/sim/world/default/world.toml\"\n[laser]\nfirst_pulse_excess = 0.0\n"
                                     "power_bend = -0.4\n");
    const std::string plain = read_file(kExample + "calibration.toml");
    std::string text = plain;
    text.erase(text.find("sha256"), text.find('\n', text.find("sha256")) + 1 - text.find("sha256"));
    std::string bytes;
    std::string watts;
    for (int i = 0; i <= 16; ++i) {
        const int byte = std::min(16 * i, 255);
        const double share = byte / 255.0;
        bytes += std::to_string(byte) + (i < 16 ? ", " : "");
        watts += std::to_string(80.0 * share * (1.0 - 0.4 * (1.0 - share))) + (i < 16 ? ", " : "");
    }
    write_file(folder / "measured.toml",
               text + "\n[power]\nbytes = [" + bytes + "]\nwatts = [" + watts + "]\ntime = \"2026-02-01T00:00:00Z\"\n");
    const std::string world = (folder / "bent.toml").string();
    (void)scribe(
        {"--world", world, "--out", (folder / "with").string(), "--calibration", (folder / "measured.toml").string()},
        0);
    (void)scribe({"--world", world, "--out", (folder / "without").string()}, 0);
    EXPECT_NEAR(mean_energy(folder / "with"), 300'000.0, 0.01 * 300'000.0);
    EXPECT_LT(mean_energy(folder / "without"), 0.85 * 300'000.0);
}

}  // namespace
}  // namespace sc::test
