// SPDX-License-Identifier: Apache-2.0
#include "host/formats/file.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

TEST(ReadTextFile, GivesAllBytes) {
    const TempDir dir;
    const std::string bytes("a\r\n\0b\xff", 6);
    EXPECT_EQ(read_text_file(dir.write("f", bytes)), bytes);
    EXPECT_EQ(read_text_file(dir.write("empty", "")), "");
}

TEST(ReadTextFile, NamesAMissingFileAndAFolder) {
    const TempDir dir;
    const auto missing = dir / "no.csv";
    expect_refusal([&] { static_cast<void>(read_text_file(missing)); },
                   {.file = missing.string(), .problem = "no such file"});
    expect_refusal([&] { static_cast<void>(read_text_file(dir.path())); },
                   {.file = dir.path().string(), .problem = "is not a file"});
}

TEST(ReadTextFile, RefusesWhatIsFarTooLarge) {
    const TempDir dir;
    const auto path = dir.write("large", "");
    std::filesystem::resize_file(path, kTextFileLimit + 1);
    expect_refusal(
        [&] { static_cast<void>(read_text_file(path)); },
        {.file = path.string(), .value = std::to_string(kTextFileLimit + 1) + " bytes", .problem = "too large"});
}

TEST(WriteTextFile, ReplacesTheFileAndLeavesNothingElse) {
    const TempDir dir;
    const auto path = dir.write("f", "old");
    write_text_file(path, "new");
    EXPECT_EQ(test::slurp(path), "new");
    EXPECT_EQ(dir.files(), 1U);
}

TEST(WriteTextFile, LeavesTheOldFileWhenItFails) {
    const TempDir dir;
    const auto nowhere = (dir / "missing") / "f";
    EXPECT_THROW(write_text_file(nowhere, "x"), InputError);
    // A folder with an entry cannot be renamed over: the temporary file must go again.
    std::filesystem::create_directories((dir / "folder") / "entry");
    EXPECT_THROW(write_text_file(dir / "folder", "x"), InputError);
    EXPECT_EQ(dir.files(), 1U);
}

TEST(Beside, ResolvesAgainstTheFileAndBack) {
    EXPECT_EQ(beside("jobs/a/job.toml", "../t.csv"), "jobs/t.csv");
    EXPECT_EQ(beside("job.toml", "t.csv"), "t.csv");
    EXPECT_EQ(beside("jobs/job.toml", "/data/t.csv"), "/data/t.csv");
    EXPECT_EQ(stored_path("jobs/a/job.toml", "jobs/t.csv"), "../t.csv");
    EXPECT_EQ(stored_path("job.toml", "t.csv"), "t.csv");
    EXPECT_EQ(stored_path("/x/job.toml", "/x/y/t.csv"), "y/t.csv");
    EXPECT_EQ(stored_path("job.toml", "/data/t.csv"), "/data/t.csv");
}

}  // namespace
}  // namespace sc::host
