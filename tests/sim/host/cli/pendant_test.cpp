// SPDX-License-Identifier: Apache-2.0
// A pendant that a file plays, on the simulated cell.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

std::filesystem::path played(const std::string& events) {
    const std::filesystem::path file = fresh_folder() / "pendant.txt";
    write_file(file, events);
    return file;
}

nlohmann::json jogged(const std::string& events) {
    Program program("scribecell", {"pendant", "--reports", played(events).string(), "--json"});
    EXPECT_EQ(program.wait(), 0) << program.err();
    return nlohmann::json::parse(program.out());
}

TEST(PendantCommand, MovesByDetentsTimesTheStep) {
    const auto done = jogged(
        "0 plug\n0 axis z\n"
        "10 feed 0.1\n100 wheel -2\n"
        "500 feed 60%\n510 wheel 3\n"
        "900 axis x\n910 feed 0.001\n920 wheel 1\n"
        "1200 press feed-\n1210 release\n");
    EXPECT_NEAR(done["place"]["Z"].get<double>(), -0.185, 1e-3);
    EXPECT_NEAR(done["place"]["X"].get<double>(), 0.001, 1e-3);
    EXPECT_EQ(done["jogs"], 3);
    EXPECT_EQ(done["override_percent"], 90);
}

TEST(PendantCommand, KeepsNothingOfWhatIsTurnedMeanwhile) {
    const auto done = jogged("0 plug\n0 axis z\n5 feed 1\n100 wheel 1\n110 wheel 5\n120 wheel 5\n130 wheel 5\n");
    EXPECT_NEAR(done["place"]["Z"].get<double>(), 1.0, 1e-3);
    EXPECT_EQ(done["detents"]["busy"], 15);
}

TEST(PendantCommand, UnpluggedInMidJogItStopsAndStaysDeadUntilTheAxisKnobIsTurned) {
    const std::string cut = "0 plug\n0 axis z\n5 feed 1\n100 wheel 2\n150 unplug\n500 plug\n500 axis z\n600 wheel 2\n";
    const auto stopped = jogged(cut);
    const double place = stopped["place"]["Z"].get<double>();
    EXPECT_GT(place, 0.1) << "it had begun";
    EXPECT_LT(place, 1.8) << "a move of 2 mm was to be stopped";
    EXPECT_EQ(stopped["detents"]["unarmed"], 2);
    const auto again = jogged(cut + "700 axis off\n710 axis z\n720 wheel -1\n");
    EXPECT_NEAR(again["place"]["Z"].get<double>(), place - 1.0, 1e-3);
}

TEST(PendantCommand, ASlowMoveEndsWhenTheWheelRests) {
    // 10 mm of wheel are bounded to 2 mm a report; C at 1 degree a detent takes longest.
    const auto done = jogged("0 plug\n0 axis c\n5 feed 1\n100 wheel 10\n");
    EXPECT_LE(done["place"]["C"].get<double>(), 2.0 + 1e-6);
    EXPECT_EQ(done["detents"]["beyond"], 8);
}

TEST(PendantCommand, RefusesAFileWithTheLine) {
    Program program("scribecell", {"pendant", "--reports", played("0 plug\n10 wheel many\n").string(), "--json"});
    EXPECT_EQ(program.wait(), 2);
    const auto error = nlohmann::json::parse(program.out()).at("error");
    EXPECT_EQ(error.at("line"), 2);
}

TEST(PendantCommand, RefusesTwoPendants) {
    Program program("scribecell",
                    {"pendant", "--reports", played("0 plug\n").string(), "--device", "/dev/hidraw9", "--json"});
    EXPECT_EQ(program.wait(), 2);
}

TEST(PendantAtMarkers, RecordsWhereTheWheelHasBroughtTheBeam) {
    const auto events = played(
        "0 plug\n0 axis x\n10 feed 0.1\n"
        "2000 wheel 2\n3000 press probe-z\n3010 release\n60000 press reset\n");
    const auto out = events.parent_path() / "checked.csv";
    Program program("scribecell",
                    {"verify", "record", "--job", std::string(SC_SOURCE_DIR) + "/examples/ras3dm/job.toml", "--out",
                     out.string(), "--pendant-reports", events.string()});
    EXPECT_EQ(program.wait(), 0) << program.err();
    EXPECT_NE(program.err().find("measured - true -0.2"), std::string::npos) << program.err();
    EXPECT_NE(program.out().find("1 markers recorded"), std::string::npos) << program.out();
}

/// x of each marker's reading, mm.
std::vector<double> pointed(const std::string& wheel) {
    const auto events = played("0 plug\n10 axis x\n20 feed 0.1\n" + wheel +
                               "31000 press probe-z\n31010 release\n60000 press probe-z\n60010 release\n"
                               "90000 press probe-z\n90010 release\n120000 press probe-z\n120010 release\n");
    const auto out = events.parent_path() / "p";
    Program program("scribecell", {"calibrate", "pointing", "--out", out.string(), "--markers", "4", "--looks", "1",
                                   "--pendant-reports", events.string()});
    EXPECT_EQ(program.wait(), 0) << program.err();
    std::istringstream rows(read_file(out / "pointing.csv"));
    std::vector<double> x;
    std::string line;
    std::getline(rows, line);
    while (std::getline(rows, line)) {
        x.push_back(std::stod(line.substr(line.find(',') + 1)));
    }
    return x;
}

TEST(PendantAtMarkers, PointsAtThoseOfTheCalibration) {
    const std::vector<double> still = pointed("");
    const std::vector<double> turned = pointed("30000 wheel 2\n");
    ASSERT_EQ(still.size(), 4U);
    ASSERT_EQ(turned.size(), 4U);
    EXPECT_NEAR(turned[0] - still[0], 0.2, 4e-3);
    EXPECT_NEAR(turned[1], still[1], 4e-3);
    EXPECT_NEAR(turned[3], still[3], 4e-3);
}

TEST(PendantInAJob, PausesItAndLetsItGoOnWithEveryPulse) {
    const auto events =
        played("0 plug\n10 axis z\n20000 press start\n20010 release\n26000 press start\n26010 release\n");
    Program program("scribecell", {"scribe", "--json", "--pendant-reports", events.string()});
    EXPECT_EQ(program.wait(), 0) << program.err();
    EXPECT_NE(program.err().find("paused by the pendant"), std::string::npos);
    const auto done = nlohmann::json::parse(program.out());
    Program straight("scribecell", {"scribe", "--json"});
    EXPECT_EQ(straight.wait(), 0);
    const auto other = nlohmann::json::parse(straight.out());
    EXPECT_EQ(done["pulses"], other["pulses"]);
    EXPECT_GT(done["cell_seconds"].get<double>(), other["cell_seconds"].get<double>() + 5.0);
}

TEST(PendantInAJob, StopsItAsAPersonDoes) {
    const auto events = played("0 plug\n20000 press stop\n20010 release\n");
    Program program("scribecell", {"scribe", "--pendant-reports", events.string()});
    EXPECT_EQ(program.wait(), 130);
    EXPECT_NE(program.err().find("disabled"), std::string::npos) << program.err();
}

}  // namespace
}  // namespace sc::test
