// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/backup_ram.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/backup_ram.hpp"

namespace sc::stm32h743 {
namespace {

using Result = BackupStart::Result;

JobRecord job(std::uint32_t seed) {
    JobRecord record;
    record.job = 77;
    record.items = 1000;
    record.certain = {seed, {seed + 1, 2, seed + 3, seed * 100}};
    record.reached = {seed, {seed + 1, 2, seed + 3, seed * 100 + 40}};
    return record;
}

class BackupRamTest : public ::testing::Test {
protected:
    BackupRamTest() {
        ram.power_cycle();  // the first time: whatever it holds
    }
    ~BackupRamTest() override {
        EXPECT_EQ(machine.violations_text(), "");
        EXPECT_TRUE(core.clean());
    }
    BackupRamTest(const BackupRamTest&) = delete;
    BackupRamTest& operator=(const BackupRamTest&) = delete;

    static constexpr std::size_t kWords = sizeof(RetainedMemory) / 4;
    using Words = std::array<std::uint32_t, kWords>;
    [[nodiscard]] Words words() {
        Words words{};
        std::memcpy(words.data(), ram.bytes().data(), sizeof words);
        return words;
    }
    void set_words(const Words& words) { std::memcpy(ram.bytes().data(), words.data(), sizeof words); }
    /// As the controller sees the RAM: plain memory.
    [[nodiscard]] RetainedMemory& retained() {
        return *std::launder(reinterpret_cast<RetainedMemory*>(ram.bytes().data()));
    }

    model::Machine machine;
    model::Core core{machine, [](std::uint32_t /*at*/) {}};
    model::BackupRam ram{machine, core};
};

TEST_F(BackupRamTest, TheFirstStartMakesEveryWordReadable) {
    const BackupStart start = start_backup_ram();
    EXPECT_EQ(start.result, Result::ready);
    EXPECT_EQ(start.lost_words, kBackupRamBytes / 4);
    EXPECT_TRUE(ram.whole());
    EXPECT_EQ(retained().read(), std::nullopt);
    const BackupStart again = start_backup_ram();
    EXPECT_EQ(again.result, Result::ready);
    EXPECT_EQ(again.lost_words, 0U);
}

TEST_F(BackupRamTest, ItOutlivesThePowerAfterItsStart) {
    (void)start_backup_ram();
    retained().write(job(1));
    ram.power_cycle();
    EXPECT_EQ(start_backup_ram().lost_words, 0U);
    EXPECT_EQ(retained().read(), job(1));
    retained().write(job(2));
    ram.power_cycle();
    (void)start_backup_ram();
    EXPECT_EQ(retained().read(), job(2));
}

TEST_F(BackupRamTest, ARegulatorThatDoesNotComeIsTold) {
    ram.regulator_ns = -1;
    EXPECT_EQ(start_backup_ram().result, Result::no_regulator);
    EXPECT_LT(machine.now_ns(), 4'000'000);
    EXPECT_TRUE(ram.whole()) << "it can be used all the same";
}

TEST_F(BackupRamTest, AProtectionThatStaysIsTold) {
    ram.access_stuck = true;
    EXPECT_EQ(start_backup_ram().result, Result::read_only);
    EXPECT_LT(machine.now_ns(), 10'000);
}

/// Whichever of the words of a write have reached the RAM when the power goes, and if the one under way has lost its
/// ECC: the older record is found or the newer, and the next one can be written.
TEST_F(BackupRamTest, ThePowerGoesAtAnyWordOfARecord) {
    (void)start_backup_ram();
    retained().write(job(1));
    for (std::uint32_t round = 2; round < 6; ++round) {
        const Words before = words();
        retained().write(job(round));
        const Words after = words();
        std::vector<std::size_t> changed;
        for (std::size_t i = 0; i < kWords; ++i) {
            if (before.at(i) != after.at(i)) {
                changed.push_back(i);
            }
        }
        ASSERT_GE(changed.size(), 8U);
        std::mt19937 random(round);
        for (unsigned order = 0; order < 50; ++order) {
            for (std::size_t done = 0; done <= changed.size(); ++done) {
                for (const bool broken : {false, true}) {
                    Words cut = before;
                    for (std::size_t i = 0; i < done; ++i) {
                        cut.at(changed.at(i)) = after.at(changed.at(i));
                    }
                    set_words(cut);
                    if (broken && done < changed.size()) {
                        ram.spoil(static_cast<std::uint32_t>(4 * changed.at(done)));
                    }
                    ram.power_cycle();
                    ASSERT_EQ(start_backup_ram().lost_words, broken && done < changed.size() ? 1U : 0U);
                    const auto found = retained().read();
                    ASSERT_TRUE(found == job(round - 1) || (found == job(round) && done > 0));
                    ASSERT_TRUE(done < changed.size() || found == job(round));
                    retained().write(job(100));
                    ASSERT_EQ(retained().read(), job(100));
                }
            }
            std::ranges::shuffle(changed, random);
        }
        set_words(after);
        (void)retained().read();
    }
}

}  // namespace
}  // namespace sc::stm32h743
