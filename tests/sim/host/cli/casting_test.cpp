// SPDX-License-Identifier: Apache-2.0
// scribecell casting as a person runs it: a casting at a random pose, scanned, inspected, its datum lines burnt.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;

TEST(Casting, ItsDatumLinesAreBurntWhereTheyBelong) {
    const fs::path folder = fresh_folder();
    Program program("scribecell", {"casting", "--seed", "4", "--json", "--out", folder.string()});
    ASSERT_EQ(program.wait(), 0) << program.err();
    const auto report = nlohmann::json::parse(program.out());
    EXPECT_EQ(report["enough"], true) << report["least_margin_mm"];
    EXPECT_GT(report["points"].get<int>(), 500'000);
    EXPECT_GT(report["line_job"]["burnt_mm"].get<double>(), 600.0);
    EXPECT_GT(report["pulses"].get<int>(), 30'000);
    EXPECT_EQ(report["missed_pulses"], 0);
    EXPECT_EQ(report["limit_violations"], 0);
    EXPECT_LE(report["burnt_95_um"].get<double>(), 30.0);
    EXPECT_LE(report["burnt_max_um"].get<double>(), 50.0);
    // Every line, from more than two sides, and what was not burnt has its reason.
    std::size_t faces = 0;
    std::string datums;
    double last = -1.0;
    for (const auto& piece : report["line_job"]["burnt"]) {
        faces += piece["face_deg"].get<double>() != last ? 1U : 0U;
        last = piece["face_deg"].get<double>();
        datums += piece["datum"].get<std::string>();
        EXPECT_LE(piece["worst_incidence_deg"].get<double>(), 60.0);
    }
    EXPECT_GT(faces, 2U);
    for (const char* id : {"A", "B", "C"}) {
        EXPECT_NE(datums.find(id), std::string::npos) << id;
    }
    for (const auto& piece : report["line_job"]["missed"]) {
        EXPECT_NE(piece["why"], "reached");
    }
    for (const char* file : {"scan.ply", "lines.dxf", "lines.csv", "job.toml", "run/pulses.trace"}) {
        EXPECT_TRUE(fs::exists(folder / file)) << file;
    }
    fs::remove_all(folder);
}

TEST(Casting, NoiseIsMadeFromTheSeedAlone) {
    const fs::path folder = fresh_folder();
    const std::vector<std::string> words{"--base",
                                         std::string(SC_SOURCE_DIR) + "/boards/sim/world/default/world.toml",
                                         "--casting",
                                         std::string(SC_TEST_DATA) + "/casting-blank/rough.stl",
                                         "--h-from-c=1,0,0,0,1,0,0,0,1,-250,-330,-400",
                                         "--axis=-250,-330,0,0,0,1",
                                         "--seed",
                                         "9",
                                         "--out"};
    for (const char* run : {"a", "b"}) {
        std::vector<std::string> all = words;
        all.push_back((folder / run).string());
        Program program("scribecell-scanner", all);
        ASSERT_EQ(program.wait(), 0) << program.err();
    }
    EXPECT_EQ(read_file(folder / "a/scan.ply"), read_file(folder / "b/scan.ply"));
    EXPECT_EQ(read_file(folder / "a/truth.json"), read_file(folder / "b/truth.json"));
    fs::remove_all(folder);
}

}  // namespace
}  // namespace sc::test
