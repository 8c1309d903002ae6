// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/key_file.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

namespace fs = std::filesystem;

class KeyFile : public testing::Test {
protected:
    KeyFile() : folder_(fs::path(testing::TempDir()) / ("key_file_" + std::to_string(::getpid()))) {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    ~KeyFile() override { fs::remove_all(folder_); }

    fs::path write(const std::string& text, mode_t mode = 0600) {
        const fs::path file = folder_ / "cell.key";
        std::ofstream(file) << text;
        ::chmod(file.c_str(), mode);
        return file;
    }
    std::string problem_of(const fs::path& file) {
        try {
            (void)read_key_file(file);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    fs::path folder_;
};

constexpr const char* kDigits = "000102030405060708090a0b0c0d0e0f";

TEST_F(KeyFile, AKeyThatWasMadeIsReadAgainByItsOwnerAlone) {
    const fs::path file = folder_ / "new.key";
    const crypto::Key key = make_key_file(file);
    EXPECT_EQ(read_key_file(file), key);
    struct stat info{};
    ASSERT_EQ(::stat(file.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 07777U, 0600U);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing is left beside it";
    EXPECT_NE(make_key_file(folder_ / "other.key"), key);
    EXPECT_THROW(make_key_file(file), InputError) << "and is never written over";
    EXPECT_EQ(read_key_file(file), key);
    EXPECT_THROW(make_key_file(folder_ / "no" / "such.key"), InputError);
}

TEST_F(KeyFile, OnlyThirtyTwoHexDigitsAreAKey) {
    EXPECT_EQ(read_key_file(write(std::string(kDigits) + "\n"))[15], 15);
    EXPECT_EQ(read_key_file(write(kDigits))[15], 15) << "without a line's end";
    EXPECT_EQ(read_key_file(write(std::string(kDigits) + "\r\n"))[15], 15);
    EXPECT_NE(problem_of(write("00010203")).find("cell.key:1: a key has 32 hex digits, this line: 8"),
              std::string::npos);
    EXPECT_NE(problem_of(write("0001020304050607x8090a0b0c0d0e0f")).find("column: 17"), std::string::npos);
    EXPECT_NE(problem_of(write(std::string(kDigits) + "\n" + kDigits)).find("cell.key:2"), std::string::npos);
    EXPECT_NE(problem_of(write("")), "");
    EXPECT_NE(problem_of(folder_ / "none"), "");
    EXPECT_NE(problem_of(folder_), "");
}

TEST_F(KeyFile, OneThatOthersMayReadIsRefused) {
    for (const mode_t mode : {0640U, 0604U, 0620U, 0602U, 0644U}) {
        EXPECT_NE(problem_of(write(kDigits, mode)).find("others may read or write this key, mode: 0"),
                  std::string::npos);
    }
    EXPECT_EQ(problem_of(write(kDigits, 0400)), "");
}

TEST_F(KeyFile, ProblemsNeverShowTheDigits) {
    const std::string secret = "deadbeefdeadbeefdeadbeefdeadbee";
    EXPECT_EQ(problem_of(write(secret)).find("dead"), std::string::npos);
    EXPECT_EQ(problem_of(write(secret + "z")).find("dead"), std::string::npos);
    EXPECT_EQ(problem_of(write(secret + "f", 0644)).find("dead"), std::string::npos);
}

TEST_F(KeyFile, TheCheckTellsKeysApart) {
    crypto::Key key{};
    const std::string check = key_check_text(key);
    EXPECT_EQ(check.size(), 8U);
    key[0] = 1;
    EXPECT_NE(key_check_text(key), check);
}

}  // namespace
}  // namespace sc::host
