// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/flash_memory.hpp"

#include <gtest/gtest.h>

#include "tests/stm32h743/model/flash.hpp"

namespace sc::stm32h743 {
namespace {

using Begin = FlashMemory::Begin;
using Progress = FlashMemory::Progress;
using Read = FlashMemory::Read;
using Word = FlashMemory::Word;

Word pattern(std::uint8_t seed) {
    Word word{};
    for (std::size_t i = 0; i < word.size(); ++i) {
        word.at(i) = static_cast<std::uint8_t>(seed + 7 * i);
    }
    return word;
}

class FlashMemoryTest : public ::testing::Test {
protected:
    FlashMemoryTest() { memory.set_marking(false); }
    ~FlashMemoryTest() override {
        EXPECT_EQ(machine.violations_text(), "");
        EXPECT_TRUE(chip.core().clean());
    }
    FlashMemoryTest(const FlashMemoryTest&) = delete;
    FlashMemoryTest& operator=(const FlashMemoryTest&) = delete;

    Progress finish() {
        for (int i = 0; i < 10'000; ++i) {
            const Progress progress = memory.step(static_cast<std::uint32_t>(machine.now_ns() / 1'000'000));
            if (progress != Progress::working) {
                return progress;
            }
            machine.advance_to(machine.now_ns() + 1'000'000);
        }
        return Progress::working;
    }
    Progress write(Address at, const Word& word) {
        EXPECT_EQ(memory.program(at, word), Begin::begun);
        return finish();
    }
    Word read(Address at) {
        Word word{};
        EXPECT_EQ(memory.read(at, word), Read::good);
        return word;
    }

    model::Machine machine;
    model::Flash chip{machine};
    FlashMemory memory;
};

TEST_F(FlashMemoryTest, WordsOfBothBanksAreWrittenAndSectorsErased) {
    for (const unsigned sector : {1U, 7U, 8U, 15U}) {
        const Address at = FlashMemory::sector_start(sector);
        EXPECT_TRUE(FlashMemory::erased(read(at)));
        EXPECT_EQ(write(at, pattern(1)), Progress::done);
        EXPECT_EQ(write(at + 32, pattern(2)), Progress::done);
        EXPECT_EQ(read(at), pattern(1));
        EXPECT_EQ(read(at + 32), pattern(2));
    }
    EXPECT_EQ(memory.erase(7), Begin::begun);
    EXPECT_TRUE(memory.working());
    EXPECT_EQ(finish(), Progress::done);
    EXPECT_EQ(memory.step(0), Progress::idle);
    EXPECT_TRUE(chip.locked());
    EXPECT_TRUE(FlashMemory::erased(read(FlashMemory::sector_start(7))));
    EXPECT_TRUE(FlashMemory::erased(read(FlashMemory::sector_start(7) + 32)));
    EXPECT_EQ(read(FlashMemory::sector_start(1)), pattern(1));
    EXPECT_EQ(read(FlashMemory::sector_start(8)), pattern(1));
    EXPECT_EQ(read(FlashMemory::sector_start(15)), pattern(1));
}

TEST_F(FlashMemoryTest, AWordTakesAsLongAsTheChipNeeds) {
    EXPECT_EQ(memory.erase(9), Begin::begun);
    machine.advance_to(900'000'000);
    EXPECT_EQ(memory.step(900), Progress::working);
    machine.advance_to(1'001'000'000);
    EXPECT_EQ(memory.step(1001), Progress::done);
}

TEST_F(FlashMemoryTest, NothingIsBegunWhileMarking) {
    memory.set_marking(true);
    EXPECT_EQ(memory.erase(9), Begin::marking);
    EXPECT_EQ(memory.program(FlashMemory::sector_start(9), pattern(0)), Begin::marking);
    FlashMemory fresh;
    EXPECT_EQ(fresh.erase(9), Begin::marking) << "until told otherwise";
    EXPECT_EQ(chip.works(), 0U);
    memory.set_marking(false);
    EXPECT_EQ(memory.erase(9), Begin::begun);
    EXPECT_EQ(finish(), Progress::done);
}

TEST_F(FlashMemoryTest, PlacesThatAreNoWordAreRefused) {
    Word word{};
    for (const Address at : {0x07FFFFE0U, 0x08200000U, 0x08000004U, 0x08000010U, 0x0U}) {
        EXPECT_EQ(memory.program(at, word), Begin::place);
        EXPECT_EQ(memory.read(at, word), Read::away);
    }
    EXPECT_EQ(memory.erase(16), Begin::place);
    EXPECT_EQ(write(0x081FFFE0, pattern(3)), Progress::done) << "the last one";
}

TEST_F(FlashMemoryTest, OneWorkAtATimeAndNoReadOfABankThatWorks) {
    EXPECT_EQ(memory.erase(9), Begin::begun);
    Word word{};
    EXPECT_EQ(memory.erase(2), Begin::busy);
    EXPECT_EQ(memory.program(FlashMemory::sector_start(2), word), Begin::busy);
    EXPECT_EQ(memory.read(FlashMemory::sector_start(10), word), Read::away);
    EXPECT_EQ(memory.read(FlashMemory::sector_start(2), word), Read::good) << "the other bank";
    EXPECT_EQ(finish(), Progress::done);
}

TEST_F(FlashMemoryTest, AWordIsProgrammedOnce) {
    const Address at = FlashMemory::sector_start(10);
    EXPECT_EQ(write(at, pattern(1)), Progress::done);
    EXPECT_EQ(memory.program(at, pattern(2)), Begin::not_erased);
    chip.spoil(at + 64);
    EXPECT_EQ(memory.program(at + 64, pattern(2)), Begin::not_erased);
    EXPECT_EQ(memory.erase(10), Begin::begun);
    EXPECT_EQ(finish(), Progress::done);
    EXPECT_EQ(write(at, pattern(2)), Progress::done);
    EXPECT_EQ(write(at + 64, pattern(4)), Progress::done);
}

TEST_F(FlashMemoryTest, ALostWordIsToldAndItsNeighboursAreRead) {
    const Address at = FlashMemory::sector_start(3);
    EXPECT_EQ(write(at, pattern(1)), Progress::done);
    EXPECT_EQ(write(at + 64, pattern(3)), Progress::done);
    chip.spoil(at + 32);
    Word word = pattern(9);
    EXPECT_EQ(memory.read(at + 32, word), Read::lost);
    EXPECT_EQ(word, Word{});
    EXPECT_EQ(read(at), pattern(1));
    EXPECT_EQ(read(at + 64), pattern(3));
    EXPECT_EQ(write(at + 96, pattern(4)), Progress::done) << "and writing goes on";
}

TEST_F(FlashMemoryTest, AnErrorOfTheChipIsToldAndDoesNotStayInTheWay) {
    constexpr std::uint32_t kWriteProtection = 1U << 17U;
    const Address at = FlashMemory::sector_start(12);
    chip.fail_next(kWriteProtection);
    EXPECT_EQ(write(at, pattern(1)), Progress::failed);
    EXPECT_EQ(memory.failure(), kWriteProtection);
    EXPECT_EQ(write(at, pattern(1)), Progress::done);
    chip.fail_next(1U << 22U);
    EXPECT_EQ(memory.erase(12), Begin::begun);
    EXPECT_EQ(finish(), Progress::failed);
    EXPECT_EQ(memory.erase(12), Begin::begun);
    EXPECT_EQ(finish(), Progress::done);
}

TEST_F(FlashMemoryTest, AWordThatReadsBackWrongHasFailed) {
    const Address at = FlashMemory::sector_start(12);
    for (const auto outcome : {model::Flash::Cut::untouched, model::Flash::Cut::random, model::Flash::Cut::broken}) {
        chip.cut(0, outcome);
        EXPECT_EQ(write(at, pattern(1)), Progress::failed);
        EXPECT_EQ(memory.failure(), 0U);
        chip.power_on();
        EXPECT_EQ(memory.erase(12), Begin::begun);
        EXPECT_EQ(finish(), Progress::done);
    }
}

TEST_F(FlashMemoryTest, WorkWithoutEndIsAFailureAfterItsLimit) {
    chip.set_times(60'000'000'000, 60'000'000'000);
    EXPECT_EQ(memory.erase(9), Begin::begun);
    EXPECT_EQ(memory.step(0xFFFFFF00U), Progress::working);
    EXPECT_EQ(memory.step(0xFFFFFF00U + FlashMemory::kEraseLimitMs), Progress::working);
    EXPECT_EQ(memory.step(0xFFFFFF01U + FlashMemory::kEraseLimitMs), Progress::failed);
    EXPECT_EQ(memory.erase(9), Begin::busy) << "the chip is still at it";
    EXPECT_EQ(memory.program(FlashMemory::sector_start(2), pattern(1)), Begin::begun) << "the other bank is not";
    EXPECT_EQ(memory.step(0), Progress::working);
    EXPECT_EQ(memory.step(FlashMemory::kProgramLimitMs + 1), Progress::failed);
    machine.advance_to(200'000'000'000);
    chip.set_times(1'000'000'000, 100'000);
    EXPECT_EQ(memory.erase(9), Begin::begun) << "it has come to its end, its bank is not locked";
    EXPECT_EQ(finish(), Progress::done);
    EXPECT_EQ(memory.erase(2), Begin::begun);
    EXPECT_EQ(finish(), Progress::done);
    EXPECT_TRUE(chip.locked());
}

}  // namespace
}  // namespace sc::stm32h743
