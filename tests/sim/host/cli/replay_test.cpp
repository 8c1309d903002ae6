// SPDX-License-Identifier: Apache-2.0
// Recording and replay as a person uses them.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Ended {
    int code = 0;
    std::string out;
    std::string err;
};
Ended run(const std::vector<std::string>& arguments) {
    Program program("scribecell", arguments);
    Ended result;
    result.code = program.wait();
    result.out = program.out();
    result.err = program.err();
    return result;
}

TEST(ReplayCommand, RunsAScribedFaceAgainAndTellsItsState) {
    const fs::path folder = fresh_folder();
    const std::string log = (folder / "out/inputs.rec").string();
    const Ended scribed = run({"scribe", "--face", "0", "--json", "--out", (folder / "out").string()});
    ASSERT_EQ(scribed.code, 0) << scribed.err;
    const Json report = Json::parse(scribed.out);
    EXPECT_LT(static_cast<double>(fs::file_size(log)), 22.0e3 * report["cell_seconds"].get<double>() * 1.1)
        << "22 bytes a tick";

    const Ended whole = run({"replay", log, "--json"});
    ASSERT_EQ(whole.code, 0) << whole.err;
    const Json json = Json::parse(whole.out);
    EXPECT_EQ(json["equal"], true);
    EXPECT_EQ(json["end"], "closed");
    EXPECT_EQ(json["command_trace_sha256"], report["command_trace_sha256"]);
    EXPECT_EQ(json["pulses"], report["pulses"]);
    EXPECT_EQ(json["difference"], nullptr);
    EXPECT_GT(json["ticks_per_s"].get<double>(), 0.0);

    const Ended until = run({"replay", log, "--until", "100", "--print-state", "--out", (folder / "tables").string()});
    EXPECT_EQ(until.code, 0) << until.err;
    EXPECT_NE(until.out.find("tick: 100\n"), std::string::npos) << until.out;
    EXPECT_NE(until.out.find("\nplanner:\n"), std::string::npos) << until.out;
    EXPECT_NE(read_file(folder / "tables/ticks.csv").find("\n100,"), std::string::npos);
    EXPECT_EQ(read_file(folder / "tables/ticks.csv").find("\n101,"), std::string::npos);
    EXPECT_TRUE(fs::exists(folder / "tables/commands.csv"));
    fs::remove_all(folder);
}

TEST(ReplayCommand, NamesWhatIsWrongWithALog) {
    const fs::path folder = fresh_folder();
    const std::string log = (folder / "inputs.rec").string();
    ASSERT_EQ(run({"jog", "--axis", "X", "--distance-mm", "-1", "--record", log}).code, 0);
    const std::string good = read_file(log);
    ASSERT_EQ(run({"replay", log}).code, 0);

    std::string bytes = good;
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    write_file(log, bytes);
    const Ended changed = run({"replay", log});
    EXPECT_EQ(changed.code, 2);
    EXPECT_NE(changed.err.find("does not match its checksum"), std::string::npos) << changed.err;
    EXPECT_EQ(changed.out.find("equal: every tick"), std::string::npos) << changed.out;

    write_file(log, good.substr(0, good.size() / 4));
    const Ended empty = run({"replay", log});
    EXPECT_EQ(empty.code, 2);
    EXPECT_NE(empty.err.find("nothing to replay"), std::string::npos) << empty.err;

    write_file(log, good.substr(0, good.size() - 20));
    const Ended torn = run({"replay", log});
    EXPECT_EQ(torn.code, 0);
    EXPECT_NE(torn.out.find("breaks off"), std::string::npos) << torn.out;

    write_file(log, "no log");
    const Ended other = run({"replay", log});
    EXPECT_EQ(other.code, 2);
    EXPECT_NE(other.err.find("not a recording"), std::string::npos) << other.err;

    EXPECT_EQ(run({"replay", (folder / "nothing.rec").string()}).code, 2);
    EXPECT_EQ(run({"replay"}).code, 2);
    EXPECT_EQ(run({"replay", "--help"}).code, 0);
    EXPECT_EQ(run({"scribe", "--record", (folder / "no/such/folder/x.rec").string()}).code, 2);
    fs::remove_all(folder);
}

}  // namespace
}  // namespace sc::test
