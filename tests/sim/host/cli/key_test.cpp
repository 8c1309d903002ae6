// SPDX-License-Identifier: Apache-2.0
// Sealed commands, by the built programs.
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Key : public testing::Test {
protected:
    Key() : folder_(fresh_folder()), key_((folder_ / "cell.key").string()) {}

    int run(const std::string& name, const std::vector<std::string>& words) {
        Program program(name, words);
        const int code = program.wait();
        out_ = program.out();
        said_ = program.err();
        return code;
    }
    void make_key() { ASSERT_EQ(run("scribecell", {"key", "--out", key_}), 0) << said_; }
    Json scribe(std::vector<std::string> more) {
        std::vector<std::string> words{"scribe", "--face", "0", "--json"};
        words.insert(words.end(), more.begin(), more.end());
        EXPECT_EQ(run("scribecell", words), 0) << said_;
        return Json::parse(out_, nullptr, false);
    }

    fs::path folder_;
    std::string key_;
    std::string out_;
    std::string said_;
};

std::string hash_of(const Json& json) {
    const Json* found = nullptr;
    const auto look = [&](const auto& self, const Json& part) -> void {
        if (part.is_object()) {
            if (part.contains("command_trace_sha256")) {
                found = &part.at("command_trace_sha256");
            }
            for (const auto& [name, value] : part.items()) {
                self(self, value);
            }
        }
    };
    look(look, json);
    return found == nullptr ? "" : found->get<std::string>();
}

TEST_F(Key, AJobIsTheSameWithAndWithoutOverEveryCarrier) {
    make_key();
    const std::string hash = hash_of(scribe({}));
    ASSERT_EQ(hash.size(), 64U) << out_;
    EXPECT_EQ(hash_of(scribe({"--key", key_})), hash);
    EXPECT_EQ(hash_of(scribe({"--key", key_, "--link", "sim:?carrier=can"})), hash);
    EXPECT_EQ(hash_of(scribe({"--key", key_, "--link", "sim:?carrier=canfd"})), hash);
}

TEST_F(Key, ARecordingIsReplayedWithItsKeyAlone) {
    make_key();
    const std::string log = (folder_ / "inputs.rec").string();
    (void)scribe({"--key", key_, "--record", log});
    EXPECT_EQ(run("scribecell", {"replay", log, "--key", key_}), 0) << said_;
    EXPECT_EQ(run("scribecell", {"replay", log}), 2);
    EXPECT_NE(said_.find("--key"), std::string::npos) << said_;
    const std::string other = (folder_ / "other.key").string();
    ASSERT_EQ(run("scribecell", {"key", "--out", other}), 0);
    EXPECT_EQ(run("scribecell", {"replay", log, "--key", other}), 2);
    EXPECT_NE(said_.find("another key"), std::string::npos) << said_;
    EXPECT_EQ(read_file(log).find(read_file(key_).substr(0, 32)), std::string::npos);
}

TEST_F(Key, ACellWithAKeyRefusesHostsWithoutAndTheOtherWayRound) {
    make_key();
    const std::string other = (folder_ / "other.key").string();
    ASSERT_EQ(run("scribecell", {"key", "--out", other}), 0);
    Program keyed("scribecell-cell", {"--pty", "--key", key_});
    ASSERT_TRUE(keyed.wait_for_out("\n"));
    const std::string link = "serial:" + keyed.out().substr(0, keyed.out().find('\n'));
    EXPECT_EQ(run("scribecell", {"monitor", "--once", "--link", link}), 1);
    EXPECT_NE(said_.find("164 seal_required"), std::string::npos) << said_;
    EXPECT_EQ(run("scribecell", {"monitor", "--once", "--link", link, "--key", other}), 1);
    EXPECT_NE(said_.find("167 seal_wrong_key"), std::string::npos) << said_;
    EXPECT_EQ(run("scribecell", {"monitor", "--once", "--link", link, "--key", key_}), 0) << said_;
    Program plain("scribecell-cell", {"--pty"});
    ASSERT_TRUE(plain.wait_for_out("\n"));
    const std::string open = "serial:" + plain.out().substr(0, plain.out().find('\n'));
    EXPECT_EQ(run("scribecell", {"monitor", "--once", "--link", open, "--key", key_}), 1);
    EXPECT_NE(said_.find("165 seal_not_fitted"), std::string::npos) << said_;
}

TEST_F(Key, AKilledHostsJobGoesOnWithTheKey) {
    make_key();
    adopt_orphans();
    const std::string socket = (folder_ / "cell.socket").string();
    const std::string journal = (folder_ / "journal.sqlite").string();
    Program cell("scribecell-cell", {"--lockstep", socket, "--out", (folder_ / "cell").string(), "--kill-host-at",
                                     "9.43", "--gap", "1", "--key", key_});
    for (int i = 0; i < 500 && !fs::exists(socket); ++i) {
        ::usleep(10'000);
    }
    const std::vector<std::string> words{"scribe", "--face", "0",         "--link", "lockstep:" + socket,
                                         "--key",  key_,     "--journal", journal};
    EXPECT_NE(run("scribecell", words), 0) << "it was to be killed";
    std::vector<std::string> again = words;
    again.emplace_back("--resume");
    EXPECT_EQ(run("scribecell", again), 0) << said_;
    cell.signal(15);
    EXPECT_EQ(cell.wait(), 0) << cell.err();
    const Json whole = scribe({});
    const Json report = Json::parse(read_file(folder_ / "cell" / "cell.json"));
    EXPECT_EQ(hash_of(report), hash_of(whole));
}

TEST_F(Key, BadKeysAreNamed) {
    make_key();
    EXPECT_EQ(run("scribecell", {"key", "--out", key_}), 2) << "never written over";
    EXPECT_EQ(run("scribecell", {"key"}), 2);
    ASSERT_EQ(::chmod(key_.c_str(), 0644), 0);
    for (const std::string& name : {std::string("scribecell"), std::string("scribecell-cell")}) {
        const std::vector<std::string> words = name == "scribecell"
                                                   ? std::vector<std::string>{"monitor", "--once", "--key", key_}
                                                   : std::vector<std::string>{"--pty", "--key", key_};
        EXPECT_EQ(run(name, words), 2);
        EXPECT_NE(said_.find(key_ + ": others may read"), std::string::npos) << said_;
        EXPECT_NE(said_.find("chmod 600"), std::string::npos) << said_;
    }
    write_file(key_, "12345\n");
    ASSERT_EQ(::chmod(key_.c_str(), 0600), 0);
    EXPECT_EQ(run("scribecell-cell", {"--pty", "--key", key_}), 2);
    EXPECT_NE(said_.find(key_ + ":1: "), std::string::npos) << said_;
    EXPECT_EQ(run("scribecell", {"monitor", "--once", "--link", "tcp:127.0.0.1:1", "--key", key_}), 1)
        << "no cell comes first";
}

}  // namespace
}  // namespace sc::test
