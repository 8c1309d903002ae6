// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/trace_file.hpp"

#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include <gtest/gtest.h>

#include "world/temporary_directory.hpp"

namespace sc::sim {
namespace {

constexpr std::array<char, 8> kMagic{'S', 'C', 'T', 'E', 'S', 'T', '0', '1'};

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(TraceFile, HasMagicHeaderAndRecordsUnderItsNameOnceClosed) {
    const TemporaryDirectory dir;
    const auto path = dir.path() / "a.trace";
    TraceFile file(path, kMagic, "{}");
    file.write(std::array<std::uint8_t, 3>{1, 2, 3});
    EXPECT_FALSE(std::filesystem::exists(path));
    file.close();
    EXPECT_EQ(bytes_of(path), std::string("SCTEST01\x02\x00\x00\x00{}\x01\x02\x03", 17));
    EXPECT_FALSE(std::filesystem::exists(dir.path() / "a.trace.part"));
}

TEST(TraceFile, FlushedRecordsSurviveWithoutClose) {
    const TemporaryDirectory dir;
    const auto part = dir.path() / "a.trace.part";
    {
        TraceFile file(dir.path() / "a.trace", kMagic, "{}");
        file.write(std::array<std::uint8_t, 2>{7, 8});
        file.flush();
        EXPECT_EQ(bytes_of(part).size(), 16U) << "readable while the cell runs";
        file.write(std::array<std::uint8_t, 2>{9, 10});
    }
    EXPECT_EQ(bytes_of(part).size(), 16U);
    EXPECT_FALSE(std::filesystem::exists(dir.path() / "a.trace"));
}

TEST(TraceFile, ManyRecordsKeepTheirOrder) {
    const TemporaryDirectory dir;
    const auto path = dir.path() / "a.trace";
    TraceFile file(path, kMagic, "");
    for (unsigned i = 0; i < 100'000; ++i) {
        file.write(std::array<std::uint8_t, 2>{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8U)});
    }
    file.close();
    const std::string all = bytes_of(path);
    ASSERT_EQ(all.size(), 12U + 200'000U);
    for (unsigned i = 0; i < 100'000; ++i) {
        ASSERT_EQ(static_cast<std::uint8_t>(all[12 + 2 * i]), i & 0xFFU);
        ASSERT_EQ(static_cast<std::uint8_t>(all[13 + 2 * i]), i >> 8U & 0xFFU);
    }
}

TEST(TraceFile, UnwritableDirectoryThrows) {
    EXPECT_THROW(TraceFile("/nowhere/a.trace", kMagic, ""), std::system_error);
    EXPECT_THROW(write_whole_file("/nowhere/a.json", ""), std::system_error);
}

TEST(TraceFile, WholeFileReplacesTheOldOne) {
    const TemporaryDirectory dir;
    write_whole_file(dir.path() / "a.json", "one");
    write_whole_file(dir.path() / "a.json", "two");
    EXPECT_EQ(bytes_of(dir.path() / "a.json"), "two");
}

}  // namespace
}  // namespace sc::sim
