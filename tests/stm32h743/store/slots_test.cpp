// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/slots.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shared/hash/crc.hpp"
#include "shared/wire/bytes.hpp"
#include "tests/stm32h743/store/rig.hpp"

namespace sc::stm32h743 {
namespace {

using Word = Slots::Word;
using Image = std::vector<Word>;
using Refusal = Slots::Refusal;

constexpr unsigned kErasesAndStates = 11;    ///< works of an update besides the image's words
constexpr std::uint32_t kHangs = 1'000'000;  ///< an image of this version or a higher one never confirms itself

Image image(std::uint32_t version, std::size_t words) {
    std::mt19937 random(version);
    Image image(words);
    Crc32 crc;
    for (std::size_t i = 1; i < words; ++i) {
        for (std::uint8_t& byte : image[i]) {
            byte = static_cast<std::uint8_t>(random());
        }
        crc.update(image[i]);
    }
    ByteWriter out(image[0]);
    out.put(version);
    out.put(static_cast<std::uint32_t>(words));
    out.put(crc.value());
    return image;
}

class SlotsTest : public StoreRig {
protected:
    SlotsTest() {
        start();
        flash_directly(Slot::a, image(1, 20));
    }
    void start() {
        power_on();
        states = std::make_unique<FlashStore>(*memory, flash_layout::kStates[0], flash_layout::kStates[1]);
        (void)states->start();
        slots = std::make_unique<Slots>(*memory, *states);
        slots->start();
        if (cut_at && *cut_at >= chip.works()) {
            chip.cut(*cut_at - chip.works(), outcome);
        }
    }
    /// As a debugger does it.
    void flash_directly(Slot slot, const Image& image) {
        for (std::size_t i = 0; i < image.size(); ++i) {
            ASSERT_EQ(memory->program(Slots::start_of(slot) + static_cast<Address>(32 * i), image[i]),
                      FlashMemory::Begin::begun);
            machine.advance_to(machine.now_ns() + 110'000);
            ASSERT_EQ(memory->step(0), FlashMemory::Progress::done);
        }
    }
    /// Of the image that is whole in this slot; 0: none is.
    [[nodiscard]] std::uint32_t version_in(Slot slot) const {
        Word word{};
        if (memory->read(Slots::start_of(slot), word) != FlashMemory::Read::good) {
            return 0;
        }
        ByteReader in(word);
        const auto version = in.get<std::uint32_t>();
        const auto words = in.get<std::uint32_t>();
        const auto check = in.get<std::uint32_t>();
        Crc32 crc;
        for (std::uint32_t i = 1; i < words && words <= Slots::kWords; ++i) {
            if (memory->read(Slots::start_of(slot) + 32 * i, word) != FlashMemory::Read::good) {
                return 0;
            }
            crc.update(word);
        }
        return words > 0 && words <= Slots::kWords && crc.value() == check ? version : 0;
    }
    /// True when it has been done; false when the power is gone.
    bool finish_slots() {
        const Progress progress = finish([this](std::uint32_t now_ms) { return slots->step(now_ms); });
        EXPECT_TRUE(chip.dead() || progress == Progress::done) << static_cast<int>(progress);
        return !chip.dead();
    }
    /// The version that runs then; 0: none may, nothing: the power is gone.
    std::optional<std::uint32_t> boot() {
        start();
        EXPECT_TRUE(slots->begin_choice(version_in(Slot::a) != 0, version_in(Slot::b) != 0));
        if (!finish_slots()) {
            return std::nullopt;
        }
        if (!slots->chosen()) {
            return 0;
        }
        running = *slots->chosen();
        return version_in(running);
    }
    /// False: the power is gone.
    bool update(const Image& image) {
        EXPECT_EQ(slots->begin_update(running), Refusal::none);
        if (!finish_slots()) {
            return false;
        }
        for (const Word& word : image) {
            EXPECT_EQ(slots->write(word), Refusal::none);
            if (!finish_slots()) {
                return false;
            }
        }
        EXPECT_EQ(slots->finish(version_in(running == Slot::a ? Slot::b : Slot::a) != 0), Refusal::none);
        return finish_slots();
    }
    bool confirm() {
        EXPECT_EQ(slots->confirm(running), Refusal::none);
        return !slots->busy() || finish_slots();
    }
    /// An update, its first start, and its word that all is well.
    bool update_boot_confirm(const Image& image) {
        if (!update(image)) {
            return false;
        }
        const auto version = boot();
        if (!version) {
            return false;
        }
        EXPECT_EQ(*version, ByteReader(image[0]).get<std::uint32_t>());
        return confirm();
    }
    void check_after_cut(unsigned n, unsigned works_to_trial, std::uint32_t old_version, std::uint32_t new_version) {
        const auto version = boot();
        ASSERT_TRUE(version == old_version || version == new_version) << version.value_or(999);
        if (n + 1 < works_to_trial) {
            ASSERT_EQ(version, old_version) << "the record that it is whole was not whole";
        }
        ASSERT_TRUE(confirm());
        ASSERT_TRUE(update_boot_confirm(image(3, 11)));
        ASSERT_EQ(boot(), 3U);
        ASSERT_EQ(boot(), 3U);
    }
    /// From what the flash holds, the power goes at each of the works of an update, or at those that `wanted` takes.
    template <class Wanted>
    void cut_update(const Image& next, std::size_t outcomes, const Wanted& wanted) {
        const std::uint32_t new_version = ByteReader(next[0]).get<std::uint32_t>();
        const model::Flash::Content content = chip.content();
        const auto old_version = boot();
        ASSERT_TRUE(old_version && *old_version != 0);
        unsigned before = chip.works();
        ASSERT_TRUE(update(next));
        const unsigned works_to_trial = chip.works() - before;
        ASSERT_EQ(boot(), new_version);
        ASSERT_TRUE(confirm());
        const unsigned works = chip.works() - before;
        works_of_update = works;
        ASSERT_GE(works, next.size() + kErasesAndStates);
        for (unsigned n = 0; n < works; ++n) {
            if (!wanted(n, works)) {
                continue;
            }
            for (std::size_t i = 0; i < outcomes; ++i) {
                SCOPED_TRACE(testing::Message() << "work " << n << " of " << works << ", outcome " << i);
                chip.set_content(content);
                ASSERT_EQ(boot(), old_version);
                before = chip.works();
                cut_at = before + n;
                outcome = kOutcomes.at((i + n) % kOutcomes.size());
                chip.cut(n, outcome);
                ASSERT_FALSE(update_boot_confirm(next));
                cut_at.reset();
                ASSERT_NO_FATAL_FAILURE(check_after_cut(n, works_to_trial, *old_version, new_version));
            }
        }
        chip.set_content(content);
        (void)boot();
    }

    std::unique_ptr<FlashStore> states;
    std::unique_ptr<Slots> slots;
    Slot running = Slot::a;
    unsigned works_of_update = 0;
    std::optional<unsigned> cut_at;  ///< so many works of the chip are whole
    Cut outcome = Cut::whole;
};

constexpr auto kEveryWork = [](unsigned, unsigned) { return true; };

TEST_F(SlotsTest, ANewBoardStartsWhatIsThere) {
    EXPECT_EQ(slots->record(), std::nullopt);
    EXPECT_EQ(slots->begin_update(Slot::a), Refusal::not_ready) << "before the boot loader has chosen";
    EXPECT_EQ(boot(), 1U);
    EXPECT_EQ(running, Slot::a);
    const SlotRecord expected{{SlotState::confirmed, SlotState::empty}, 0, Slot::a};
    EXPECT_EQ(slots->record(), expected);
    const unsigned works = chip.works();
    EXPECT_EQ(boot(), 1U);
    EXPECT_EQ(chip.works(), works) << "nothing is written where nothing has changed";
}

TEST_F(SlotsTest, AnUpdateRunsOnTrialAndThenForGood) {
    ASSERT_EQ(boot(), 1U);
    for (std::uint32_t version = 2; version < 10; ++version) {
        const Slot before = running;
        ASSERT_TRUE(update(image(version, 5 + 7 * version)));
        EXPECT_EQ(slots->record()->state[static_cast<std::size_t>(running)], SlotState::confirmed);
        ASSERT_EQ(boot(), version);
        EXPECT_NE(running, before);
        EXPECT_EQ(slots->record()->state[static_cast<std::size_t>(running)], SlotState::on_trial);
        EXPECT_EQ(slots->begin_update(running), Refusal::not_ready) << "on trial";
        ASSERT_TRUE(confirm());
        ASSERT_TRUE(confirm()) << "again";
        EXPECT_EQ(slots->record()->newest, running);
        ASSERT_EQ(boot(), version);
    }
}

TEST_F(SlotsTest, AnImageThatDoesNotConfirmItselfIsLeftForTheOther) {
    ASSERT_EQ(boot(), 1U);
    ASSERT_TRUE(update(image(kHangs, 30)));
    for (unsigned i = 0; i < kTrialStarts; ++i) {
        ASSERT_EQ(boot(), kHangs);
        EXPECT_EQ(slots->record()->starts, i + 1);
    }
    for (unsigned i = 0; i < 3; ++i) {
        ASSERT_EQ(boot(), 1U);
        EXPECT_EQ(slots->record()->state[1], SlotState::bad);
    }
    ASSERT_TRUE(update_boot_confirm(image(2, 30))) << "the next one gets all its starts";
    ASSERT_EQ(boot(), 2U);
}

TEST_F(SlotsTest, AnImageThatIsNotWholeIsNotStarted) {
    ASSERT_EQ(boot(), 1U);
    ASSERT_TRUE(update_boot_confirm(image(2, 30)));
    chip.spoil(Slots::start_of(Slot::b) + 64);
    ASSERT_EQ(boot(), 1U) << "the confirmed one before it";
    ASSERT_TRUE(update(image(3, 30)));
    chip.spoil(Slots::start_of(Slot::b) + 96);
    ASSERT_EQ(boot(), 1U);
    EXPECT_EQ(slots->record()->state[1], SlotState::bad);
    chip.spoil(Slots::start_of(Slot::a));
    ASSERT_EQ(boot(), 0U) << "neither";
}

TEST_F(SlotsTest, AnUpdateThatIsNotVerifiedIsNotWritten) {
    ASSERT_EQ(boot(), 1U);
    EXPECT_EQ(slots->write(Word{}), Refusal::order);
    EXPECT_EQ(slots->finish(true), Refusal::order);
    EXPECT_EQ(slots->begin_update(Slot::a), Refusal::none);
    EXPECT_EQ(slots->begin_update(Slot::a), Refusal::busy);
    EXPECT_EQ(slots->write(Word{}), Refusal::busy);
    EXPECT_EQ(slots->finish(true), Refusal::busy);
    EXPECT_EQ(slots->confirm(Slot::a), Refusal::busy);
    EXPECT_FALSE(slots->begin_choice(true, false));
    ASSERT_TRUE(finish_slots());
    EXPECT_EQ(slots->write(Word{}), Refusal::none);
    ASSERT_TRUE(finish_slots());
    EXPECT_EQ(slots->finish(false), Refusal::order);
    EXPECT_EQ(slots->finish(true), Refusal::order) << "it is over";
    EXPECT_EQ(slots->record()->state[1], SlotState::empty);
    ASSERT_EQ(boot(), 1U);
}

TEST_F(SlotsTest, NothingIsWrittenWhileMarking) {
    ASSERT_EQ(boot(), 1U);
    memory->set_marking(true);
    EXPECT_EQ(slots->begin_update(Slot::a), Refusal::marking);
    EXPECT_EQ(slots->step(0), Progress::idle);
    memory->set_marking(false);
    EXPECT_EQ(slots->begin_update(Slot::a), Refusal::none);
    const auto marking_again = [this] {
        memory->set_marking(true);
        const Progress progress = finish([this](std::uint32_t now_ms) { return slots->step(now_ms); });
        EXPECT_EQ(progress, Progress::put_off);
        EXPECT_TRUE(slots->busy());
        memory->set_marking(false);
    };
    marking_again();
    ASSERT_TRUE(finish_slots());
    EXPECT_EQ(slots->write(Word{}), Refusal::none);
    marking_again();
    ASSERT_TRUE(finish_slots());
}

TEST_F(SlotsTest, AWordThatFailsEndsTheUpdate) {
    ASSERT_EQ(boot(), 1U);
    EXPECT_EQ(slots->begin_update(Slot::a), Refusal::none);
    ASSERT_TRUE(finish_slots());
    EXPECT_EQ(slots->write(Word{}), Refusal::none);
    chip.fail_next(1U << 22U);
    EXPECT_EQ(finish([this](std::uint32_t now_ms) { return slots->step(now_ms); }), Progress::failed);
    EXPECT_EQ(slots->write(Word{}), Refusal::order);
    ASSERT_TRUE(update_boot_confirm(image(2, 30)));
}

TEST_F(SlotsTest, WhereNoRecordCanBeWrittenNothingIsErased) {
    ASSERT_EQ(boot(), 1U);
    ASSERT_TRUE(update_boot_confirm(image(2, 30)));
    const auto record = slots->record();
    EXPECT_EQ(slots->begin_update(running), Refusal::none);
    EXPECT_EQ(slots->record(), record) << "not yet";
    unsigned steps = 0;
    EXPECT_EQ(finish([&](std::uint32_t now_ms) {
                  chip.fail_next(++steps <= 6 ? 1U << 22U : 0);  // three tries
                  return slots->step(now_ms);
              }),
              Progress::failed);
    EXPECT_EQ(slots->record(), record);
    EXPECT_EQ(slots->write(Word{}), Refusal::order);
    chip.fail_next(0);
    EXPECT_EQ(version_in(Slot::a), 1U);
    ASSERT_EQ(boot(), 2U);
    ASSERT_TRUE(update_boot_confirm(image(3, 30)));
}

TEST_F(SlotsTest, ATrialThatCannotBeCountedIsNotBegun) {
    ASSERT_EQ(boot(), 1U);
    ASSERT_TRUE(update(image(2, 30)));
    start();
    EXPECT_TRUE(slots->begin_choice(true, true));
    EXPECT_EQ(slots->chosen(), Slot::b);
    EXPECT_EQ(finish([this](std::uint32_t now_ms) {
                  chip.fail_next(1U << 22U);
                  return slots->step(now_ms);
              }),
              Progress::done);
    EXPECT_EQ(slots->chosen(), Slot::a);
    chip.fail_next(0);
    ASSERT_EQ(boot(), 2U);
}

TEST_F(SlotsTest, ThePowerGoesAtEachWorkOfAnUpdate) {
    cut_update(image(2, 40), kOutcomes.size(), kEveryWork);
    ASSERT_TRUE(update_boot_confirm(image(5, 20)));
    ASSERT_EQ(running, Slot::b);
    cut_update(image(6, 9), kOutcomes.size(), kEveryWork);
}

TEST_F(SlotsTest, ThePowerGoesAtEachWorkOfAnUpdateWhoseStatesAreMovedMeanwhile) {
    ASSERT_EQ(boot(), 1U);
    const auto content = states->get(0);
    ASSERT_TRUE(content);
    const auto put_again = [&] {
        ASSERT_TRUE(states->put(0, *content));
        ASSERT_EQ(finish([this](std::uint32_t now_ms) { return states->step(now_ms); }), Progress::done);
    };
    for (unsigned i = 0; i < FlashMemory::kSectorBytes / 64 - 12; ++i) {
        put_again();
    }
    // A start leaves out a place, too: by twos, from an even place and from an odd one, each state is the one that
    // moves.
    unsigned moved = 0;
    const model::Flash::Content full = chip.content();
    for (const bool odd : {false, true}) {
        chip.set_content(full);
        ASSERT_EQ(boot(), 1U);
        if (odd) {
            put_again();
        }
        for (unsigned i = 0; i < 6; ++i) {
            cut_update(image(2, 4), 2, kEveryWork);
            moved += works_of_update > 4 + kErasesAndStates ? 1 : 0;
            put_again();
        }
    }
    EXPECT_GE(moved, 6U);
}

TEST_F(SlotsTest, ThePowerGoesAgainAndAgainAndSomeImagesHang) {
    ASSERT_EQ(boot(), 1U);
    std::mt19937 random(3);
    std::uint32_t good = 1;
    for (std::uint32_t round = 0; round < 500; ++round) {
        SCOPED_TRACE(round);
        const bool hangs = random() % 4 == 0;
        const std::uint32_t next = (hangs ? kHangs : 0) + round + 2;
        outcome = kOutcomes.at(random() % kOutcomes.size());
        cut_at = chip.works() + static_cast<unsigned>(random() % 50);
        chip.cut(*cut_at - chip.works(), outcome);
        (void)update(image(next, 3 + random() % 20));
        unsigned starts = 0;
        for (bool well = false; !well; ++starts) {
            ASSERT_LE(starts, kTrialStarts + 2U);
            const auto version = boot();
            if (!version) {
                continue;  // the power went in the boot loader
            }
            ASSERT_TRUE(*version == good || *version == next) << *version;
            well = (*version == good || !hangs) && confirm();
            good = well ? *version : good;
        }
    }
    EXPECT_GT(good, 300U);
}

TEST_F(SlotsTest, ThePowerGoesDuringAnUpdateOfFullSize) {
    const auto some = [](unsigned n, unsigned works) { return n < 7 || works - n < 8 || n % 1201 == 0; };
    cut_update(image(2, Slots::kWords), 1, some);
    ASSERT_EQ(slots->begin_update(running), Refusal::none);
    ASSERT_TRUE(finish_slots());
    for (const Word& word : image(3, Slots::kWords)) {
        ASSERT_EQ(slots->write(word), Refusal::none);
        ASSERT_TRUE(finish_slots());
    }
    EXPECT_EQ(slots->write(Word{}), Refusal::order) << "the slot is full";
}

/// All records there can be, and what boot loaders do with them.
TEST(SlotChoice, WhatIsChosenIsWholeAndTrialsEnd) {
    constexpr std::array kStates{SlotState::empty, SlotState::written, SlotState::on_trial, SlotState::confirmed,
                                 SlotState::bad};
    unsigned trials = 0;
    for (unsigned i = 0; i < 5 * 5 * 6 * 2 * 4; ++i) {
        SlotRecord record;
        record.state = {kStates.at(i % 5), kStates.at(i / 5 % 5)};
        record.starts = static_cast<std::uint8_t>(i / 25 % 6);
        record.newest = i / 150 % 2 == 0 ? Slot::a : Slot::b;
        const std::array<bool, 2> verified{i / 300 % 2 != 0, i / 600 != 0};
        SCOPED_TRACE(i);
        const auto possible = [&](std::size_t one) {
            const SlotState state = record.state.at(one);
            return verified.at(one) && state != SlotState::bad &&
                   (state != SlotState::on_trial || record.starts < kTrialStarts);
        };
        for (const bool trial : {true, false}) {
            const Choice choice = choose(record, verified[0], verified[1], trial);
            const SlotRecord next = choice.record.value_or(record);
            EXPECT_NE(choice.record, record);
            if (!choice.slot) {
                EXPECT_TRUE(!trial || (!possible(0) && !possible(1)));
                continue;
            }
            const auto chosen = static_cast<std::size_t>(*choice.slot);
            EXPECT_TRUE(possible(chosen));
            EXPECT_NE(next.state.at(chosen), SlotState::bad);
            if (next.state.at(chosen) == SlotState::on_trial) {
                ++trials;
                EXPECT_TRUE(trial);
                EXPECT_EQ(next.starts, record.state.at(chosen) == SlotState::written ? 1 : record.starts + 1);
                EXPECT_LE(next.starts, kTrialStarts);
            }
            for (std::size_t one = 0; one < 2; ++one) {
                if (record.state.at(one) == SlotState::confirmed) {
                    EXPECT_EQ(next.state.at(one), SlotState::confirmed);
                }
            }
            EXPECT_EQ(next.newest, record.newest);
        }
        // Nobody confirms: at last a confirmed one is started, or none on trial any more.
        std::optional<SlotRecord> now = record;
        Choice choice;
        for (unsigned starts = 0; starts < 2 * kTrialStarts + 2; ++starts) {
            choice = choose(now, verified[0], verified[1]);
            now = choice.record ? choice.record : now;
        }
        EXPECT_FALSE(choice.record);
        if (choice.slot) {
            EXPECT_NE(now->state.at(static_cast<std::size_t>(*choice.slot)), SlotState::on_trial);
        }
    }
    EXPECT_GT(trials, 100U);
}

TEST(SlotChoice, OfTwoConfirmedOnesTheNewerStarts) {
    for (const Slot newest : {Slot::a, Slot::b}) {
        const SlotRecord record{{SlotState::confirmed, SlotState::confirmed}, 0, newest};
        EXPECT_EQ(choose(record, true, true).slot, newest);
        EXPECT_EQ(choose(record, true, false).slot, Slot::a);
        EXPECT_EQ(choose(record, false, true).slot, Slot::b);
        EXPECT_EQ(choose(record, false, false).slot, std::nullopt);
    }
}

TEST(SlotChoice, WithoutARecordWhatIsVerifiedCounts) {
    EXPECT_EQ(choose(std::nullopt, false, false).slot, std::nullopt);
    EXPECT_EQ(choose(std::nullopt, false, false).record, std::nullopt);
    EXPECT_EQ(choose(std::nullopt, true, true).slot, Slot::a);
    EXPECT_EQ(choose(std::nullopt, false, true).slot, Slot::b);
    const SlotRecord expected{{SlotState::empty, SlotState::confirmed}, 0, Slot::b};
    EXPECT_EQ(choose(std::nullopt, false, true).record, expected);
}

}  // namespace
}  // namespace sc::stm32h743
