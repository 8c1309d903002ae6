// SPDX-License-Identifier: Apache-2.0
// `scribecell calibration` and `scribecell verify`, as a person uses them.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"
#include "host/formats/table.hpp"
#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const fs::path kExamples = fs::path(SC_SOURCE_DIR) / "examples/ras3dm";
const fs::path kTable = fs::path(SC_SOURCE_DIR) / "tests/data/ras3dm-table1";

class CalibrationCommands : public ::testing::Test {
protected:
    void SetUp() override { folder_ = fresh_folder(); }
    void TearDown() override { fs::remove_all(folder_); }
    [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }

    std::string run(std::vector<std::string> arguments, int expected = 0) {
        Program program("scribecell", arguments);
        EXPECT_EQ(program.wait(), expected) << program.err() << program.out();
        err_ = program.err();
        return program.out();
    }
    std::string calibration(std::vector<std::string> arguments, int expected = 0) {
        arguments.insert(arguments.begin(), "calibration");
        arguments.insert(arguments.end(), {"--store", file("store")});
        return run(arguments, expected);
    }
    /// The example, changed and sealed again.
    std::string second_set() const {
        host::CalibrationSet set = host::read_calibration(kExamples / "calibration.toml");
        set.parents = {set.id};
        set.id = "second";
        set.transforms[0].translation.x += 40e-6;
        set.transforms[0].provenance.validity.days = 20.0;
        static_cast<void>(host::write_calibration(file("second.toml"), set));
        return file("second.toml");
    }

    fs::path folder_;
    std::string err_;
};

TEST_F(CalibrationCommands, AStoreFromImportToRollback) {
    calibration({"import", (kExamples / "calibration.toml").string()});
    calibration({"import", second_set(), "--note", "sensor remounted"});
    Json list = Json::parse(calibration({"list", "--json"}));
    ASSERT_EQ(list["sets"].size(), 2U);
    EXPECT_EQ(list["sets"][1]["current"], true);
    EXPECT_EQ(list["changes"][1]["note"], "sensor remounted");
    const std::string text = calibration({"list"});
    EXPECT_NE(text.find("h_from_c expired"), std::string::npos) << text;

    const Json diff = Json::parse(calibration({"diff", "1", "--json"}));
    EXPECT_EQ(diff["records"][0]["id"], "h_from_c");
    EXPECT_NEAR(diff["records"][0]["moves_um"][0].get<double>(), 40.0, 1e-3);
    calibration({"rollback", "1"});
    list = Json::parse(calibration({"list", "--json"}));
    EXPECT_EQ(list["sets"][0]["current"], true);
    EXPECT_EQ(list["changes"][2]["what"], "rollback");

    calibration({"export", "--out", file("out.toml")});
    EXPECT_EQ(read_file(file("out.toml")), read_file(kExamples / "calibration.toml"));
    calibration({"import", file("out.toml"), "--sha256", std::string(64, 'a')}, 2);
    EXPECT_NE(err_.find("is not the set that was asked for"), std::string::npos) << err_;
    calibration({"rollback", "7"}, 2);
    calibration({"show", "--svg", file("frames.svg")});
    const std::string picture = read_file(file("frames.svg"));
    EXPECT_NE(picture.find("h_from_c"), std::string::npos);
    EXPECT_NE(picture.find("days old"), std::string::npos);
}

TEST_F(CalibrationCommands, TransformsInEveryConventionReadBack) {
    const host::CalibrationSet set = host::read_calibration(kExamples / "calibration.toml");
    using enum host::PoseConvention;
    const std::vector<std::pair<std::string, host::PoseConvention>> all{
        {"quaternion", quaternion}, {"abb", abb}, {"matrix", matrix}, {"kuka", kuka}, {"fanuc", fanuc}};
    for (const auto& [as, convention] : all) {
        calibration({"export", (kExamples / "calibration.toml").string(), "--as", as, "--out", file("poses.csv")});
        const host::PoseFile poses = host::read_poses(file("poses.csv"));
        EXPECT_EQ(poses.convention, convention);
        ASSERT_EQ(poses.poses.size(), 1U);
        EXPECT_EQ(poses.poses[0].view, "h_from_c");
        EXPECT_NEAR(norm(poses.poses[0].translation - set.transforms[0].translation), 0.0, 1e-9);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_NEAR(norm(poses.poses[0].rotation.row[i] - set.transforms[0].rotation.row[i]), 0.0, 1e-9) << as;
        }
    }
    const Json json = Json::parse(calibration({"export", (kExamples / "calibration.toml").string(), "--as", "json"}));
    EXPECT_EQ(json["records"][0]["transform"]["matrix4_mm"][3], (std::vector<double>{0.0, 0.0, 0.0, 1.0}));
}

TEST_F(CalibrationCommands, BudgetOfTheExampleJob) {
    const Json json = Json::parse(calibration({"budget", "--job", (kExamples / "job.toml").string(), "--json"}));
    EXPECT_EQ(json["faces"].size(), 4U);
    EXPECT_EQ(json["all"]["places"], 38) << "36 markers, and the ends of a datum line";
    const double worst = json["all"]["worst_3d_95_um"].get<double>();
    EXPECT_GT(worst, 20.0) << "6 um and 10 urad of h_from_c, sensor 7.5, axes 2.5";
    EXPECT_LT(worst, 60.0);
    calibration({"budget", "--job", (kExamples / "job.toml").string(), "--table", (kTable / "table1.csv").string()}, 2);
    const std::string text = calibration({"budget", "--calibration", (kExamples / "calibration.toml").string(),
                                          "--table", (kTable / "table1.csv").string(), "--pointing-um", "55"});
    EXPECT_NE(text.find("a check by eye"), std::string::npos);
}

TEST_F(CalibrationCommands, DriftIsSeenAndKept) {
    const std::string header = "id,x_mm,y_mm,z_mm,sigma_um\n";
    const std::string then =
        "1,0.000,0.000,0.000,5\n2,100.004,0.002,0.000,5\n3,0.003,80.000,0.000,5\n4,99.999,80.001,20.0,5\n";
    const std::string now =
        "1,0.003,0.002,0.060,5\n2,100.000,-0.003,0.064,5\n3,-0.002,80.004,0.058,5\n4,100.001,79.998,20.06,5\n";
    write_file(file("then.csv"), header + then);
    write_file(file("now.csv"), header + now);
    calibration({"drift", "--target", file("then.csv"), "--seen", file("then.csv")});
    const Json json =
        Json::parse(calibration({"drift", "--target", file("then.csv"), "--seen", file("now.csv"), "--json"}, 1));
    EXPECT_EQ(json["suspect"], "target");
    const std::string history = read_file(file("store/drift.csv"));
    EXPECT_EQ(std::count(history.begin(), history.end(), '\n'), 3) << history;
    calibration({"drift", "--target", file("then.csv"), "--seen", file("now.csv"), "--limit-um", "200"});
    calibration({"drift", "--seen", file("now.csv")}, 2);
    calibration({"drift", "--seen", file("now.csv"), "--save", file("stored.csv")});
    calibration({"drift", "--target", file("stored.csv"), "--seen", file("now.csv")});
}

TEST_F(CalibrationCommands, VerifyTableOfThePaper) {
    const std::string table = (kTable / "table1.csv").string();
    const Json json = Json::parse(run({"verify", "--table", table, "--maxima", (kTable / "printed-maxima.csv").string(),
                                       "--svg", file("t.svg"), "--limit-mm", "0.15", "--json"}));
    EXPECT_NEAR(json["all"]["max_3d_mm"].get<double>(), 0.173, 5e-4);
    EXPECT_EQ(json["limit"]["beyond_by_axis"], 0);
    EXPECT_EQ(json["limit"]["beyond_in_3d"], 2);
    EXPECT_EQ(json["warnings"].size(), 8U);
    EXPECT_NE(read_file(file("t.svg")).find("jog_grid"), std::string::npos);
    run({"verify", "--table", table, "--limit-mm", "0.14"}, 1);
    run({"verify", "--table", table, "--strict"}, 1);
    run({"verify", "--table", file("none.csv")}, 2);
    run({"verify"}, 2);
}

TEST_F(CalibrationCommands, RecordsWithAPersonAndGoesOn) {
    const std::vector<std::string> places{"-314.090,-319.770,-425.944", "-266.127,-319.066,-413.494",
                                          "-224.815,-285.691,-404.515"};
    write_file(file("points.csv"), "face_deg,no,mx,my,mz,tx,ty,tz\n0,1," + places[0] + "," + places[0] + "\n0,2," +
                                       places[1] + "," + places[1] + "\n90,1," + places[2] + "," + places[2] + "\n");
    const std::vector<std::string> record{"verify",         "record", "--table",        file("points.csv"), "--out",
                                          file("seen.csv"), "--keys", file("keys.txt"), "--step-mm",        "0.05"};
    write_file(file("keys.txt"), "x+*2 z- step=0.01 y+*3 enter  # then the power goes\n");
    run(record);
    EXPECT_NE(err_.find("face 0, marker 2"), std::string::npos) << err_;
    host::VerificationTable table = host::read_table(file("seen.csv"));
    ASSERT_EQ(table.rows.size(), 1U);
    Vec3 moved = table.rows[0].truth.v - table.rows[0].measured.v;
    EXPECT_NEAR(moved.x, 100e-6, 4e-6);
    EXPECT_NEAR(moved.y, 30e-6, 4e-6);
    EXPECT_NEAR(moved.z, -50e-6, 4e-6);

    write_file(file("keys.txt"), "enter undo z+ enter x- enter quit\n");
    run(record);
    table = host::read_table(file("seen.csv"));
    ASSERT_EQ(table.rows.size(), 3U);
    EXPECT_EQ(table.rows[1].no, 2);
    moved = table.rows[1].truth.v - table.rows[1].measured.v;
    EXPECT_NEAR(moved.z, 50e-6, 4e-6) << "what was undone is gone";
    EXPECT_EQ(table.rows[2].face_deg, 90.0);
    run({"verify", "--table", file("seen.csv"), "--limit-mm", "0.2"});
    run(record);  // nothing is left to do, and no cell is started for it
    EXPECT_EQ(err_, "");

    write_file(file("points.csv"), replaced(read_file(file("points.csv")), "-266.127", "-266.227"));
    run(record, 2);
    EXPECT_NE(err_.find("another table"), std::string::npos) << err_;
    write_file(file("keys.txt"), "x+ sideways\n");
    fs::remove(file("seen.csv"));
    run(record, 2);
    EXPECT_NE(err_.find("keys.txt:1"), std::string::npos) << err_;
}

}  // namespace
}  // namespace sc::test
