// SPDX-License-Identifier: Apache-2.0
// The main job through the built programs: what it reports, and that it cannot be faked.
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Json scribe(std::vector<std::string> arguments, int exit_code = 0) {
    arguments.insert(arguments.begin(), {"scribe", "--json"});
    Program program("scribecell", arguments);
    EXPECT_EQ(program.wait(), exit_code) << program.err();
    Json json = Json::parse(program.out(), nullptr, false);
    EXPECT_TRUE(json.is_object()) << program.out();
    return json;
}

/// Found places, mm, by face and marker.
using Places = std::map<std::pair<double, int>, std::array<double, 3>>;
Places places_of(const Json& report, const char* key) {
    Places places;
    for (const Json& face : report["faces"]) {
        for (const Json& row : face["table"]) {
            places[{face["face_deg"].get<double>(), row["no"].get<int>()}] = row[key].get<std::array<double, 3>>();
        }
    }
    return places;
}

TEST(Scribe, BurnsFourFacesWithinFiveMicrometres) {
    const fs::path folder = fresh_folder();
    const Json report = scribe({"--out", (folder / "out").string(), "--svg", (folder / "a.svg").string()});
    ASSERT_EQ(report["faces"].size(), 4U);
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(places_of(report, "found_mm").size(), 36U);
    for (const Json& face : report["faces"]) {
        EXPECT_LE(face["difference_um"].get<double>(), 5.0) << face["face_deg"];
    }
    ASSERT_EQ(report["datum_lines"].size(), 4U);
    for (const Json& line : report["datum_lines"]) {
        EXPECT_GE(line["length_mm"].get<double>(), 59.9);
    }
    EXPECT_LE(report["max_command_error_um"].get<double>(), 5.0);
    EXPECT_EQ(report["limit_violations"], 0);
    EXPECT_GT(report["pulses"].get<int>(), 10000);
    EXPECT_EQ(report["command_trace_sha256"].get<std::string>().size(), 64U);
    EXPECT_FALSE(report["known_errors"].empty());
    EXPECT_GT(report["wall_seconds"].get<double>(), 0.0);
    for (const char* name :
         {"pulses.trace", "samples.trace", "cell.json", "journal.sqlite", "report.json", "report.svg"}) {
        EXPECT_TRUE(fs::exists(folder / "out" / name)) << name;
    }
    EXPECT_NE(read_file(folder / "a.svg").find("<svg"), std::string::npos);
    fs::remove_all(folder);
}

TEST(Scribe, PacketSizeAndJitterChangeNothingOfTheCommands) {
    const std::vector<std::vector<std::string>> runs{
        {},
        {"--points-per-block", "1"},
        {"--points-per-block", "7"},
        {"--jitter-us", "20000", "--seed", "1"},
        {"--jitter-us", "20000", "--seed", "2", "--points-per-block", "3"},
    };
    std::string hash;
    for (std::vector<std::string> run : runs) {
        run.insert(run.end(), {"--face", "90"});
        const Json report = scribe(run);
        const auto found = report["command_trace_sha256"].get<std::string>();
        EXPECT_EQ(found.size(), 64U);
        EXPECT_EQ(hash.empty() ? found : hash, found) << ::testing::PrintToString(run);
        hash = found;
    }
    EXPECT_NE(scribe({"--face", "0"})["command_trace_sha256"], hash) << "the hash says nothing of the job";
}

TEST(Scribe, AWorldWithOtherErrorsShowsExactlyThose) {
    const fs::path folder = fresh_folder();
    const fs::path default_world = fs::path(SC_SOURCE_DIR) / "boards/sim/world/default";
    fs::copy(default_world, folder / "world");
    // The galvo 50 um further off, the stage 0.1 mrad further out of square.
    std::string world = read_file(folder / "world/world.toml");
    world = replaced(world, "offset_x_um = 35.0", "offset_x_um = 85.0");
    world = replaced(world, "squareness_xz_mrad = -0.080", "squareness_xz_mrad = -0.180");
    write_file(folder / "world/world.toml", world);
    const Json plain = scribe({"--face", "0"});
    const Json bent = scribe({"--face", "0", "--world", (folder / "world/world.toml").string()});
    const Places before = places_of(plain, "found_mm");
    const Places after = places_of(bent, "found_mm");
    ASSERT_EQ(after.size(), before.size());
    ASSERT_GT(after.size(), 5U);
    for (const auto& [marker, place] : after) {
        const auto& was = before.at(marker);
        EXPECT_NEAR(place[0] - was[0], 0.050 - 0.1e-3 * was[2], 0.002) << marker.second;
        EXPECT_NEAR(place[2] - was[2], 0.0, 0.002) << marker.second;
    }
    EXPECT_GT(bent["max_command_error_um"].get<double>(), 60.0);
    fs::remove_all(folder);
}

/// The example's calibration with one thing changed, and without the hash that would tell.
fs::path changed_calibration(const fs::path& folder, const std::string& from, const std::string& to) {
    std::string text = read_file(fs::path(SC_SOURCE_DIR) / "examples/ras3dm/calibration.toml");
    const std::size_t hash = text.find("sha256 = ");
    text.erase(hash, text.find('\n', hash) + 1 - hash);
    write_file(folder / "calibration.toml", replaced(text, from, to));
    return folder / "calibration.toml";
}

TEST(Scribe, MissesItsFigureWithoutTheCompensationThatEarnsIt) {
    const std::string galvo_offset = "offset_um = [35.398261515333864, -22.343300346235115]";
    const fs::path folder = fresh_folder();
    const std::vector<std::pair<std::string, std::string>> ablations{
        {galvo_offset + "\ngain", "offset_um = [0.0, 0.0]\ngain"},  // that of galvo_field, which the galvo goes by
        {"squareness_xz_mrad = -0.0813", "squareness_xz_mrad = 0.0"},
        {"squareness_xy_mrad = 0.1219", "squareness_xy_mrad = 0.0"},
    };
    for (const auto& [from, to] : ablations) {
        const fs::path file = changed_calibration(folder, from, to);
        const Json report = scribe({"--calibration", file.string()});
        EXPECT_GT(report["max_command_error_um"].get<double>(), 5.0) << to;
    }
    fs::remove_all(folder);
}

TEST(Scribe, AWrongTurntableAxisShowsOnTheFaceThatIsGivenInC) {
    const fs::path folder = fresh_folder();
    const fs::path file =
        changed_calibration(folder, "point_mm = [-250.0173, -470.0281, 0.0]", "point_mm = [-250.0173, -469.9281, 0.0]");
    const Places right = places_of(scribe({"--face", "0", "--face", "90"}), "found_mm");
    const Places wrong = places_of(scribe({"--face", "0", "--face", "90", "--calibration", file.string()}), "found_mm");
    ASSERT_EQ(wrong.size(), 18U);
    for (const auto& [marker, place] : wrong) {
        // About an axis 0.1 mm further in y, a quarter turn clockwise moves a place by −0.1 in x and +0.1 in y.
        EXPECT_NEAR(place[0] - right.at(marker)[0], marker.first == 90.0 ? -0.1 : 0.0, 0.002) << marker.second;
    }
    fs::remove_all(folder);
}

TEST(Scribe, AnotherTableIsBurntAndJudgedAsItStands) {
    const fs::path folder = fresh_folder();
    // Every measured x is 0.3 mm further to the left than it was; what is true stays.
    std::istringstream in(read_file(fs::path(SC_SOURCE_DIR) / "examples/ras3dm/table1.csv"));
    std::string line;
    std::getline(in, line);
    std::string out = "face_deg,no,mx,my,mz,tx,ty,tz\n";
    while (std::getline(in, line)) {
        std::istringstream cells(line);
        std::string cell;
        for (int column = 0; column < 8 && std::getline(cells, cell, ','); ++column) {
            out += column == 2 ? std::to_string(std::stod(cell) - 0.3) : cell;
            out += column < 7 ? "," : "\n";
        }
    }
    write_file(folder / "moved.csv", out);
    const Places before = places_of(scribe({"--face", "180"}), "deviation_mm");
    const Places after =
        places_of(scribe({"--face", "180", "--table", (folder / "moved.csv").string()}), "deviation_mm");
    ASSERT_EQ(after.size(), before.size());
    ASSERT_GT(after.size(), 5U);
    for (const auto& [marker, deviation] : after) {
        EXPECT_NEAR(deviation[0] - before.at(marker)[0], -0.3, 0.003) << marker.second;
    }
    fs::remove_all(folder);
}

TEST(Scribe, DryRunTellsWhatWouldBeBurntAndMovesNothing) {
    const fs::path folder = fresh_folder();
    const Json plan = scribe({"--dry-run", "--out", (folder / "out").string()});
    EXPECT_EQ(plan["dry_run"], true);
    EXPECT_EQ(plan["faces"].size(), 4U);
    EXPECT_EQ(plan["paths"].size(), 36U * 2U + 4U);
    EXPECT_FALSE(fs::exists(folder / "out"));
    Program text("scribecell", {"scribe", "--dry-run", "--face", "90"});
    EXPECT_EQ(text.wait(), 0);
    EXPECT_NE(text.out().find("datum"), std::string::npos);
    fs::remove_all(folder);
}

TEST(Scribe, AJournalOfAnotherJobOrOfOneThatIsDoneIsRefused) {
    const fs::path folder = fresh_folder();
    const std::string journal = (folder / "j.sqlite").string();
    scribe({"--face", "0", "--journal", journal});
    const Json other = scribe({"--face", "90", "--journal", journal}, 2);
    EXPECT_EQ(other["error"]["name"], "bad_input");
    EXPECT_NE(other["error"]["text"].get<std::string>().find("j.sqlite"), std::string::npos);
    const Json again = scribe({"--face", "0", "--journal", journal}, 2);
    EXPECT_NE(again["error"]["text"].get<std::string>().find("burnt already"), std::string::npos);
    fs::remove_all(folder);
}

TEST(Scribe, TextReportHasATableForEachFace) {
    Program program("scribecell", {"scribe", "--face", "0", "--face", "270"});
    EXPECT_EQ(program.wait(), 0) << program.err();
    EXPECT_NE(program.out().find("270"), std::string::npos);
    EXPECT_NE(program.err().find("100 %"), std::string::npos) << program.err();
}

TEST(OtherSubcommands, WorkOnTheSimulatedCell) {
    Program monitor("scribecell", {"monitor", "--once", "--json", "--config"});
    EXPECT_EQ(monitor.wait(), 0) << monitor.err();
    const Json status = Json::parse(monitor.out());
    EXPECT_EQ(status["machine"]["axes"].size(), 4U);
    Program jog("scribecell", {"jog", "--axis", "x", "--distance-mm", "-2.5"});
    EXPECT_EQ(jog.wait(), 0) << jog.err();
    EXPECT_NE(jog.out().find("X: "), std::string::npos);
    Program doctor("scribecell", {"doctor", "--json"});
    EXPECT_EQ(doctor.wait(), 0) << doctor.out();
    EXPECT_EQ(Json::parse(doctor.out())["good"], true);
}

TEST(Bench, PrintsEveryFigureWithWhatIsAskedAndItsRawData) {
    const fs::path folder = fresh_folder();
    Program program("scribecell", {"bench", "scribe", "--json", "--raw", folder.string()});
    const int code = program.wait();
    EXPECT_LE(code, 1) << "a slow machine may miss a figure of speed; " << program.err() << program.out();
    const Json json = Json::parse(program.out());
    EXPECT_EQ(json["bench"], "scribe");
    double told = -1.0;
    for (const Json& figure : json["figures"]) {
        EXPECT_TRUE(figure.contains("asked") && figure.contains("better") && figure.contains("met"));
        told = figure["name"] == "max_command_error_um" ? figure["value"].get<double>() : told;
    }
    std::istringstream rows(read_file(folder / "scribe_crosses.csv"));
    std::string line;
    std::getline(rows, line);
    double largest = 0.0;
    while (std::getline(rows, line)) {
        std::istringstream cells(line);
        std::vector<double> v;
        for (std::string cell; std::getline(cells, cell, ',');) {
            v.push_back(std::stod(cell));
        }
        ASSERT_EQ(v.size(), 11U);
        largest = std::max(largest, std::hypot(v[5] - v[2], v[6] - v[3], v[7] - v[4]) * 1e3);
    }
    EXPECT_NEAR(largest, told, 0.01);
    fs::remove_all(folder);
}

}  // namespace
}  // namespace sc::test
