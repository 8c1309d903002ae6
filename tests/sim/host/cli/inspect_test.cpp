// SPDX-License-Identifier: Apache-2.0
// scribecell inspect as a person runs it, on the published casting and its scan.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(SC_TEST_DATA) / "casting-blank";

struct Answer {
    int exit_code = -1;
    nlohmann::json json;
    std::string err;
};
Answer inspect(const std::string& cad, const std::string& scan, std::vector<std::string> more = {}) {
    std::vector<std::string> words{"inspect", "--cad", cad, "--scan", scan, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    Program program("scribecell", words);
    Answer run;
    run.exit_code = program.wait();
    run.json = nlohmann::json::parse(program.out(), nullptr, false);
    run.err = program.err();
    return run;
}
Answer inspect_casting(const std::vector<std::string>& more) {
    return inspect((kData / "finished.stl").string(), (kData / "scan.ply").string(), more);
}
void expect_refused(const Answer& run, const std::string& part) {
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << "'" << part << "' is not in: " << run.err;
    ASSERT_TRUE(run.json.is_object());
    EXPECT_EQ(run.json["error"]["name"], "bad_input");
}

/// 4x4 as rows of [R|t] in mm, of the pose that the scan was made with, inverted.
double worst_corner_mm(const nlohmann::json& w_from_c) {
    const std::string text = read_file(kData / "truth_pose.txt");
    std::istringstream in(text.substr(text.find('\n') + 1));
    double r[3][4];
    for (auto& row : r) {
        for (double& v : row) {
            in >> v;
        }
    }
    double worst = 0.0;
    for (const auto& p :
         {std::array<double, 3>{50, 50, 50}, std::array<double, 3>{-50, 50, -50}, std::array<double, 3>{50, -50, 50}}) {
        double c[3];
        for (int i = 0; i < 3; ++i) {
            c[i] = r[i][0] * p[0] + r[i][1] * p[1] + r[i][2] * p[2] + r[i][3];
        }
        double squared = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            double w = w_from_c["translation_mm"][i].get<double>();
            for (std::size_t k = 0; k < 3; ++k) {
                w += w_from_c["rotation"][i][k].get<double>() * c[k];
            }
            squared += (w - p[i]) * (w - p[i]);
        }
        worst = std::max(worst, std::sqrt(squared));
    }
    return worst;
}

TEST(Inspect, FindsTheCastingAndSaysWhereMetalIsMissing) {
    const Answer run = inspect_casting({"--part", (kData / "part.toml").string()});
    EXPECT_EQ(run.exit_code, 1) << "front and back ask for 0.7 together and have 0.5";
    ASSERT_TRUE(run.json.is_object()) << run.err;
    EXPECT_EQ(run.json["enough"], false);
    EXPECT_EQ(run.json["alignment"]["by"], "rps");
    EXPECT_LT(worst_corner_mm(run.json["alignment"]["w_from_c"]), 0.15);
    const auto& borrowing = run.json["borrowing"];
    EXPECT_LE(borrowing["kkt_residual"].get<double>(), 1e-9);
    EXPECT_GT(borrowing["margin_mm"].get<double>(), borrowing["margin_before_mm"].get<double>());
    const std::string first = borrowing["stopped_by"][0]["face"];
    const std::string second = borrowing["stopped_by"][1]["face"];
    EXPECT_TRUE((first == "frontface") != (second == "frontface")) << first << " against " << second;
    EXPECT_TRUE(first.starts_with("backface") != second.starts_with("backface"));
    for (const auto& face : run.json["before"]["faces"]) {
        EXPECT_GT(face["points"].get<int>(), 100) << face["id"];
    }
}

TEST(Inspect, IsContentWhereTheMetalIsThere) {
    const fs::path folder = fresh_folder();
    std::string part = read_file(kData / "part.toml");
    for (std::size_t at = 0; (at = part.find("min_allowance = 0.", at)) != std::string::npos; at += 19) {
        part.replace(at, 19, "min_allowance = 0.0");
    }
    write_file(folder / "part.toml", part);
    const Answer run = inspect_casting({"--part", (folder / "part.toml").string(), "--align", "fit"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.json["alignment"]["by"], "fit");
    EXPECT_LT(worst_corner_mm(run.json["alignment"]["w_from_c"]), 0.03);
    const Answer measured =
        inspect_casting({"--part", (folder / "part.toml").string(), "--no-borrow", "--what-if", "0,0,0.1"});
    EXPECT_TRUE(measured.json["borrowing"].is_null());
    EXPECT_NEAR(measured.json["what_if"]["sides"]["+Z"]["mean_mm"].get<double>() -
                    measured.json["before"]["sides"]["+Z"]["mean_mm"].get<double>(),
                0.1, 0.01);
    fs::remove_all(folder);
}

TEST(Inspect, RefusesWhatDoesNotFit) {
    const std::string part = (kData / "part.toml").string();
    expect_refused(inspect_casting({"--scan-unit", "m"}), "1000 times too large");
    expect_refused(inspect_casting({"--scan-unit", "inch"}), "25.4 times too large");
    expect_refused(inspect_casting({"--cad-unit", "inch"}), "25.4 times too small");
    expect_refused(inspect_casting({"--cad-unit", "ell"}), "no unit of length");
    expect_refused(inspect_casting({"--part", part, "--lock", "Z"}), "names no datum plane");
    expect_refused(inspect_casting({"--free", "x,up"}), "names no motion");
    expect_refused(inspect_casting({"--align", "rps"}), "needs reference points");
    const fs::path folder = fresh_folder();
    write_file(folder / "nan.xyz", "nan nan nan\nnan nan nan\n");
    expect_refused(inspect((kData / "finished.stl").string(), (folder / "nan.xyz").string()), "no finite point");
    write_file(folder / "box.obj",
               "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 90 90 0\nv 0 0 60\nv 90 0 60\nv 0 90 60\nv 90 90 60\n"
               "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
    expect_refused(inspect((folder / "box.obj").string(), (kData / "scan.ply").string()), "scan of another part");
    write_file(folder / "open.obj",
               "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 90 90 0\nv 0 0 60\nv 90 0 60\nv 0 90 60\nv 90 90 60\n"
               "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n");
    expect_refused(inspect((folder / "open.obj").string(), (kData / "scan.ply").string()), "4 open edges");
    fs::remove_all(folder);
}

TEST(Inspect, ReadsStepOrNamesThePackage) {
    // The rod is 5 mm long: read it is, and then the scan is of another part; or Open CASCADE is named.
    const Answer run = inspect((kData / "linkrods.step").string(), (kData / "scan.ply").string());
    EXPECT_EQ(run.exit_code, 2);
    const bool read = run.err.find("the CAD model 5.") != std::string::npos;
    EXPECT_TRUE(read || run.err.find("libocct-data-exchange-dev") != std::string::npos) << run.err;
}

TEST(Inspect, LinesAreBurntAsARecipeSays) {
    const fs::path folder = fresh_folder();
    const std::string examples = std::string(SC_SOURCE_DIR) + "/examples/";
    const auto with = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{
            "--part",        examples + "casting/part.toml",       "--lines",  (folder / "lines").string(),
            "--calibration", examples + "ras3dm/calibration.toml", "--recipe", examples + "casting/recipe.toml"};
        words.insert(words.end(), more.begin(), more.end());
        return inspect_casting(words);
    };
    EXPECT_LE(with({"--entry", "seen"}).exit_code, 1);
    const std::string job = read_file(folder / "lines/job.toml");
    EXPECT_NE(job.find("width_um = 160.0\nfill = \"hatch\"\nfill_step_um = 80.0"), std::string::npos) << job;
    expect_refused(with({}), "recipe.toml: the recipe has several entries; name one of them with --entry: fine, seen");
    expect_refused(with({"--entry", "deep"}), "recipe.toml: is not in the recipe: deep");
    expect_refused(inspect_casting({"--part", examples + "casting/part.toml", "--lines", (folder / "lines").string(),
                                    "--calibration", (folder / "none.toml").string()}),
                   "none.toml");
    fs::remove_all(folder);
}

}  // namespace
}  // namespace sc::test
