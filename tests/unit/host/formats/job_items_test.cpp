// SPDX-License-Identifier: Apache-2.0
#include "host/formats/job_items.hpp"

#include <random>

#include "host/formats/file.hpp"
#include "shared/path/job_hash.hpp"
#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

std::vector<Item> items() {
    std::vector<Item> all{Turn{-9'000'000}, PathBegin{.path = 7, .pitch_nm = 20'000}};
    std::mt19937 random(4);
    PathPoint at{100, -200, 300};
    for (int i = 0; i < 1000; ++i) {
        at.x += static_cast<std::int32_t>(random() % 4000) - 1500;
        at.z -= static_cast<std::int32_t>(random() % 4000) - 1500;
        all.emplace_back(at);
    }
    all.emplace_back(PathArc{{1, 2, 3}, {4, 5, 6}});
    all.emplace_back(PathLight{false});
    all.emplace_back(PathEnd{});
    all.emplace_back(JobEnd{});
    return all;
}

TEST(JobItems, ComeBackAsTheyWere) {
    const TempDir dir;
    const auto file = dir.path() / "job.items";
    write_job_items(file, items());
    const std::vector<Item> back = read_job_items(file);
    EXPECT_EQ(job_hash(back), job_hash(items()));
    EXPECT_EQ(back.size(), items().size());
    write_job_items(file, {});
    EXPECT_TRUE(read_job_items(file).empty());
}

TEST(JobItems, RefuseWhatIsBrokenAndSayWhere) {
    const TempDir dir;
    const auto file = dir.path() / "job.items";
    write_job_items(file, items());
    const std::string good = read_text_file(file);
    for (std::size_t size = 1; size < good.size(); size += size < 40 ? 1 : 97) {
        write_text_file(file, good.substr(0, size));
        EXPECT_THROW(static_cast<void>(read_job_items(file)), InputError) << size;
    }
    write_text_file(file, good.substr(0, good.size() - 1));
    const auto refused = [&](const std::string& value, const std::string& problem) {
        expect_refusal([&] { static_cast<void>(read_job_items(file)); },
                       {.file = file.string(), .value = value, .problem = problem});
    };
    EXPECT_THROW(static_cast<void>(read_job_items(file)), InputError);
    std::string other = good;
    other[0] = 'X';
    write_text_file(file, other);
    refused("XCITEM01", "is not a file of a job's items");
    other = good;
    other[8] = 9;
    write_text_file(file, other);
    refused("9", "another version");
    other = good;
    other[9] = static_cast<char>(other[9] + 1);
    write_text_file(file, other);
    refused("1006 of 1006", "other items than it says");
    EXPECT_THROW(static_cast<void>(read_job_items(dir.path() / "none")), InputError);
}

}  // namespace
}  // namespace sc::host
