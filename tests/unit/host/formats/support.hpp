// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/formats/error.hpp"

namespace sc::host::test {

/// An empty folder that goes away with the test.
class TempDir {
public:
    TempDir() {
        const std::string name = std::string("scribecell-test-") + std::to_string(::getpid()) + "-" +
                                 ::testing::UnitTest::GetInstance()->current_test_info()->name();
        path_ = std::filesystem::temp_directory_path() / name;
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~TempDir() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TempDir(const TempDir&) = delete;
    TempDir& operator=(const TempDir&) = delete;

    [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    std::filesystem::path write(const std::string& name, std::string_view text) const {
        std::ofstream(path_ / name, std::ios::binary) << text;
        return path_ / name;
    }
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

private:
    std::filesystem::path path_;
};

inline std::string slurp(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// What a refusal must say. `problem` is a part of it; every refusal must also say what to do.
struct Refused {
    std::string file = {};
    int line = 0;
    std::string value = {};
    std::string problem = {};
};

inline void expect_refusal(const std::function<void()>& act, const Refused& expected) {
    try {
        act();
        ADD_FAILURE() << "not refused: " << expected.problem;
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), expected.file) << error.what();
        EXPECT_EQ(error.line(), expected.line) << error.what();
        EXPECT_EQ(error.value(), expected.value) << error.what();
        EXPECT_NE(error.problem().find(expected.problem), std::string::npos) << error.what();
        EXPECT_FALSE(error.action().empty()) << error.what();
        EXPECT_NE(std::string(error.what()).find(expected.value), std::string::npos);
    }
}

/// `text` with the first `from` replaced; fails the test if it is not there.
inline std::string replaced(std::string text, std::string_view from, std::string_view to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << "not in the text: " << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Number of the line (from 1) on which `needle` first stands.
inline int line_with(std::string_view text, std::string_view needle) {
    const std::size_t at = text.find(needle);
    EXPECT_NE(at, std::string_view::npos) << needle;
    int line = 1;
    for (const char c : text.substr(0, at)) {
        line += c == '\n' ? 1 : 0;
    }
    return line;
}

}  // namespace sc::host::test
