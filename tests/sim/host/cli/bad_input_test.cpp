// SPDX-License-Identifier: Apache-2.0
// Bad input ends with exit code 2 and a message with file, line, value and what to do; no cell is started for it.
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;

class BadInput : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        fs::copy(fs::path(SC_SOURCE_DIR) / "examples/ras3dm", folder_, fs::copy_options::recursive);
    }
    void TearDown() override { fs::remove_all(folder_); }

    [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }
    void edit(const std::string& name, const std::string& from, const std::string& to) const {
        write_file(file(name), replaced(read_file(file(name)), from, to));
    }
    /// Runs the job of the folder and expects it to be refused with all of `parts` in its message.
    void expect_refused(std::vector<std::string> arguments, const std::vector<std::string>& parts) const {
        arguments.insert(arguments.begin(),
                         {"scribe", file("job.toml").string(), "--json", "--out", file("out").string()});
        Program program("scribecell", arguments);
        EXPECT_EQ(program.wait(), 2) << program.err();
        for (const std::string& part : parts) {
            EXPECT_NE(program.err().find(part), std::string::npos) << "'" << part << "' is not in: " << program.err();
        }
        const auto json = nlohmann::json::parse(program.out(), nullptr, false);
        ASSERT_TRUE(json.is_object()) << program.out();
        EXPECT_EQ(json["error"]["name"], "bad_input");
        EXPECT_NE(json["error"]["action"], "");
        EXPECT_FALSE(fs::exists(file("out"))) << "a refused job has left something behind";
    }

    fs::path folder_;
    /// Line 2 of the table: the first marker.
    const std::string first_row_ = "0,1,-314.090,-319.770,-425.944";
};

TEST_F(BadInput, MissingJob) {
    fs::remove(file("job.toml"));
    expect_refused({}, {"job.toml"});
}
TEST_F(BadInput, MissingTable) { expect_refused({"--table", "no_table.csv"}, {"no_table.csv"}); }
TEST_F(BadInput, MissingCalibration) { expect_refused({"--calibration", "no_set.toml"}, {"no_set.toml"}); }
TEST_F(BadInput, ExpiredCalibration) {
    edit("calibration.toml", "sha256 = ", "# ");
    edit("calibration.toml", "[turntable]\n", "[turntable]\nvalid_days = 20.5\n");
    expect_refused({}, {"calibration.toml", "has expired", "turntable (2026-02-04T21:18:00Z", "--accept-expired"});
    Program accepted("scribecell", {"scribe", file("job.toml").string(), "--dry-run", "--accept-expired"});
    EXPECT_EQ(accepted.wait(), 0) << accepted.err();
    EXPECT_NE(accepted.err().find("warning: "), std::string::npos) << accepted.err();
}
TEST_F(BadInput, MissingColumn) {
    write_file(file("table1.csv"), "face_deg,no,my,mz,tx,ty,tz\n0,1,-319.770,-425.944,-314.128,-319.812,-425.964\n");
    expect_refused({}, {"table1.csv", "mx"});
}
TEST_F(BadInput, TextForANumber) {
    edit("table1.csv", first_row_, "0,1,left,-319.770,-425.944");
    expect_refused({}, {"table1.csv:2", "left"});
}
TEST_F(BadInput, DecimalComma) {
    edit("table1.csv", first_row_, "0,1,\"-314,090\",-319.770,-425.944");
    expect_refused({}, {"table1.csv:2", "-314,090"});
}
TEST_F(BadInput, NotANumber) {
    edit("table1.csv", first_row_, "0,1,nan,-319.770,-425.944");
    expect_refused({}, {"table1.csv:2", "nan"});
}
TEST_F(BadInput, PointOutOfTravel) {
    edit("table1.csv", first_row_, "0,1,-514.090,-319.770,-425.944");
    expect_refused({}, {"table1.csv:2", "-514.09"});
}
TEST_F(BadInput, PointInAKeepOutVolume) {
    edit("table1.csv", first_row_, "0,1,-314.090,-319.770,-485.000");
    expect_refused({}, {"table1.csv:2"});
}
TEST_F(BadInput, FaceThatTheTurntableCannotReach) {
    std::string job = read_file(file("job.toml"));
    std::string table = read_file(file("table1.csv"));
    job = replaced(job, "angle_deg = 270.0", "angle_deg = 10000.0");
    for (std::size_t at = table.find("\n270,"); at != std::string::npos; at = table.find("\n270,", at)) {
        table.replace(at, 5, "\n10000,");
    }
    write_file(file("job.toml"), job);
    write_file(file("table1.csv"), table);
    expect_refused({}, {"10000", "cannot reach"});
}
TEST_F(BadInput, RotationThatIsNone) {
    edit("job.toml", "0.784392369711", "0.884392369711");
    expect_refused({}, {"job.toml", "rotation"});
}
TEST_F(BadInput, FaceThatTheJobHasNot) { expect_refused({"--face", "45"}, {"job.toml", "45", "0, 90, 180, 270"}); }
TEST_F(BadInput, MissingWorld) { expect_refused({"--world", "no_world.toml"}, {"no_world.toml"}); }
TEST_F(BadInput, MissingScript) { expect_refused({"--script", "no_script.txt"}, {"no_script.txt"}); }
TEST_F(BadInput, PictureIntoNowhere) { expect_refused({"--svg", "no/folder/a.svg"}, {"no/folder"}); }
TEST_F(BadInput, UnknownLink) { expect_refused({"--link", "usb:1"}, {"usb:1"}); }
TEST_F(BadInput, MissingCanInterface) { expect_refused({"--link", "can:no-such-bus"}, {"no-such-bus"}); }
TEST_F(BadInput, MissingSerialDevice) { expect_refused({"--link", "serial:/dev/no-such-line"}, {"/dev/no-such-line"}); }

/// Numbers in another unit: every coordinate of the table divided by `divisor`.
std::string scaled_table(const std::string& table, double divisor) {
    std::istringstream in(table);
    std::string line;
    std::string out;
    std::getline(in, line);
    out = "face_deg,no,mx,my,mz,tx,ty,tz\n";
    while (std::getline(in, line)) {
        std::istringstream cells(line);
        std::string cell;
        for (int column = 0; column < 8 && std::getline(cells, cell, ','); ++column) {
            out += column < 2 ? cell : std::to_string(std::stod(cell) / divisor);
            out += column < 7 ? "," : "\n";
        }
    }
    return out;
}

TEST_F(BadInput, InchesAndMetres) {
    const std::string table = read_file(file("table1.csv"));
    write_file(file("inch.csv"), scaled_table(table, 25.4));
    expect_refused({"--table", file("inch.csv").string()}, {"inch.csv", "inch"});
    write_file(file("metre.csv"), scaled_table(table, 1000.0));
    expect_refused({"--table", file("metre.csv").string()}, {"metre.csv", "metre"});
}

TEST(BadUsage, EndsWithTwoAndSaysSo) {
    const std::vector<std::vector<std::string>> usages{
        {},
        {"dance"},
        {"scribe", "--no-such-option"},
        {"scribe", "--points-per-block", "0"},
        {"scribe", "--points-per-block", "256"},
        {"scribe", "--face", "left"},
        {"jog"},
        {"jog", "--axis", "Q", "--distance-mm", "1"},
        {"jog", "--axis", "X", "--distance-mm", "11"},
        {"jog", "--axis", "X", "--distance-mm", "nan"},
        {"jog", "--axis", "X", "--distance-mm", "0"},
        {"jog", "--axis", "X", "--distance-deg", "1"},
        {"jog", "--axis", "C", "--distance-mm", "1"},
        {"jog", "--axis", "X", "--distance-mm", "1", "--speed-mm-s", "-1"},
        {"override", "50"},
        {"override", "9", "--link", "tcp:127.0.0.1:1"},
        {"override", "201", "--link", "tcp:127.0.0.1:1"},
        {"override", "50", "--link", "sim:"},
        {"scribe", "--override", "0"},
        {"monitor", "--link", "can0"},
        {"cell", "--pty", "--tcp", "0"},
        {"cell", "--world", "no_world.toml"},
        {"bench"},
        {"bench", "no_such_bench"},
    };
    for (const auto& usage : usages) {
        Program program("scribecell", usage);
        EXPECT_EQ(program.wait(), 2) << ::testing::PrintToString(usage) << program.err();
        EXPECT_FALSE(program.err().empty() && program.out().empty());
    }
    Program bench("scribecell", {"bench", "no_such_bench"});
    bench.wait();
    EXPECT_NE(bench.err().find("choose of: scribe"), std::string::npos) << bench.err();
}

TEST(Help, EverySubcommandHasExamples) {
    for (const char* name :
         {"scribe", "cell", "jog", "override", "monitor", "telemetry", "blackbox", "doctor", "version", "bench"}) {
        Program program("scribecell", {name, "--help"});
        EXPECT_EQ(program.wait(), 0);
        EXPECT_NE(program.out().find("Examples:"), std::string::npos) << name;
    }
}

TEST(Version, SaysItsSchemaInBothForms) {
    Program text("scribecell", {"version"});
    EXPECT_EQ(text.wait(), 0);
    Program program("scribecell", {"version", "--json"});
    EXPECT_EQ(program.wait(), 0);
    const auto json = nlohmann::json::parse(program.out());
    EXPECT_EQ(json["schema_hash"].get<std::string>().size(), 16U);
    EXPECT_NE(text.out().find(json["schema_hash"].get<std::string>()), std::string::npos);
}

}  // namespace
}  // namespace sc::test
