// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/flash_store.hpp"

#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "tests/stm32h743/store/rig.hpp"

namespace sc::stm32h743 {
namespace {

using Content = FlashStore::Content;
using All = std::array<std::optional<Content>, FlashStore::kKeys>;

constexpr unsigned kRecordBytes = 64;
constexpr unsigned kRecords = FlashMemory::kSectorBytes / kRecordBytes - 1;  ///< a sector's, less its head

Content pattern(unsigned seed) {
    std::mt19937 random(seed);
    Content content{};
    for (std::uint8_t& byte : content) {
        byte = static_cast<std::uint8_t>(random());
    }
    return content;
}

class FlashStoreTest : public StoreRig {
protected:
    [[nodiscard]] All all() const {
        All found;
        for (std::size_t key = 0; key < FlashStore::kKeys; ++key) {
            found.at(key) = store->get(key);
            EXPECT_EQ(found.at(key).has_value(), store->has(key));
        }
        return found;
    }
    void put(std::size_t key, unsigned seed) {
        ASSERT_TRUE(store->put(key, pattern(seed)));
        ASSERT_EQ(finish(), Progress::done);
        ASSERT_EQ(store->get(key), pattern(seed));
    }
    /// Puts until a sector has room for no more.
    void fill() {
        for (unsigned i = 0; i < 8; ++i) {
            put(i, i);
        }
        for (unsigned i = 8; i < kRecords; ++i) {
            put(8 + i % 4, i);
        }
    }
    void drop(std::size_t first, std::size_t count) {
        ASSERT_TRUE(store->drop(first, count));
        ASSERT_EQ(finish(), Progress::done);
    }
    /// The power goes at each word and sector that `change` works upon, each in every way: what is found then is what
    /// was before or what the change makes, and the store can be written.
    void cut_everywhere(const std::function<bool()>& change, unsigned least_works) {
        power_on();
        const model::Flash::Content start = chip.content();
        const All before = all();
        const unsigned first_work = chip.works();
        ASSERT_TRUE(change());
        ASSERT_EQ(finish(), Progress::done);
        const unsigned works = chip.works() - first_work;
        ASSERT_GE(works, least_works);
        power_on();
        const All after = all();
        ASSERT_NE(before, after);
        for (unsigned n = 0; n < works; ++n) {
            for (const Cut outcome : kOutcomes) {
                SCOPED_TRACE(testing::Message()
                             << "work " << n << " of " << works << ", " << static_cast<int>(outcome));
                chip.set_content(start);
                power_on();
                chip.cut(n, outcome);
                ASSERT_TRUE(change());
                ASSERT_EQ(finish(), Progress::working);
                ASSERT_TRUE(chip.dead());
                power_on();
                All found = all();
                const bool last = n + 1 == works && outcome == Cut::whole;
                ASSERT_TRUE(found == after || (found == before && !last));
                put(5, 1000 + n);
                found.at(5) = pattern(1000 + n);
                power_on();
                ASSERT_EQ(all(), found);
            }
        }
        chip.set_content(start);
        power_on();
    }
};

TEST_F(FlashStoreTest, AnEmptyFlashHoldsNothingAndTakesRecords) {
    EXPECT_FALSE(store->start());
    EXPECT_EQ(all(), All{});
    put(3, 1);
    put(95, 2);
    put(3, 3);
    power_on();
    All expected;
    expected[3] = pattern(3);
    expected[95] = pattern(2);
    EXPECT_EQ(all(), expected);
    EXPECT_TRUE(store->start());
    drop(0, 4);
    EXPECT_FALSE(store->has(3));
    power_on();
    expected[3].reset();
    EXPECT_EQ(all(), expected);
}

TEST_F(FlashStoreTest, ShortContentIsFilledAndWhatDoesNotExistIsRefused) {
    const Content content = pattern(1);
    EXPECT_FALSE(store->put(FlashStore::kKeys, content));
    EXPECT_FALSE(store->put(0, std::array<std::uint8_t, FlashStore::kBytes + 1>{}));
    EXPECT_FALSE(store->drop(FlashStore::kKeys, 0));
    EXPECT_FALSE(store->drop(90, 7));
    EXPECT_EQ(store->step(0), Progress::idle);
    ASSERT_TRUE(store->put(7, std::span(content).first(3)));
    EXPECT_FALSE(store->put(8, content)) << "busy";
    EXPECT_FALSE(store->get(7)) << "not while busy";
    EXPECT_EQ(finish(), Progress::done);
    Content expected{};
    std::copy_n(content.begin(), 3, expected.begin());
    EXPECT_EQ(store->get(7), expected);
}

TEST_F(FlashStoreTest, AFullSectorIsCopiedIntoTheOther) {
    fill();
    drop(6, 1);
    put(10, 7);
    for (unsigned round = 0; round < 5000; ++round) {
        put(20 + round % 3, round);
    }
    power_on();
    All expected;
    for (unsigned i = 0; i < 6; ++i) {
        expected.at(i) = pattern(i);
    }
    expected[7] = pattern(7);
    for (unsigned i = kRecords - 4; i < kRecords; ++i) {
        expected.at(8 + i % 4) = pattern(i);
    }
    expected[10] = pattern(7);
    for (unsigned round = 4997; round < 5000; ++round) {
        expected.at(20 + round % 3) = pattern(round);
    }
    EXPECT_EQ(all(), expected);
}

TEST_F(FlashStoreTest, ThePowerGoesDuringTheVeryFirstRecord) {
    cut_everywhere([this] { return store->put(1, pattern(1)); }, 5);
}

TEST_F(FlashStoreTest, ThePowerGoesDuringARecord) {
    put(1, 1);
    put(2, 2);
    cut_everywhere([this] { return store->put(3, pattern(3)); }, 2);
    cut_everywhere([this] { return store->put(1, pattern(4)); }, 2);
    cut_everywhere([this] { return store->drop(1, 2); }, 2);
}

TEST_F(FlashStoreTest, ThePowerGoesWhileAFullSectorIsCopied) {
    fill();
    // erase; 12 records, the head and the new one of two words each
    cut_everywhere([this] { return store->put(1, pattern(4)); }, 29);
    cut_everywhere([this] { return store->drop(1, 5); }, 29);
    put(1, 4);
    cut_everywhere([this] { return store->put(1, pattern(5)); }, 2);
}

TEST_F(FlashStoreTest, ThePowerGoesAgainAndAgain) {
    std::mt19937 random(7);
    fill();
    All expected = all();
    for (unsigned round = 0; round < 1000; ++round) {
        const std::size_t key = random() % 12;
        const bool is_drop = random() % 8 == 0;
        All changed = expected;
        if (is_drop) {
            changed.at(key).reset();
            changed.at(key + 1).reset();
        } else {
            changed.at(key) = pattern(round);
        }
        if (random() % 2 == 0) {
            chip.cut(static_cast<unsigned>(random() % (round % 2 == 0 ? 2 : 30)), kOutcomes.at(random() % 5));
        }
        ASSERT_TRUE(is_drop ? store->drop(key, 2) : store->put(key, pattern(round)));
        const Progress progress = finish();
        if (chip.dead()) {
            power_on();
            const All found = all();
            ASSERT_TRUE(found == expected || found == changed) << round;
            expected = found;
        } else {
            ASSERT_EQ(progress, Progress::done);
            expected = changed;
        }
    }
    power_on();
    EXPECT_EQ(all(), expected);
}

TEST_F(FlashStoreTest, AWordThatReadsAsErasedButMayHaveBeenBegunIsLeftOut) {
    put(1, 1);
    chip.cut(0, Cut::untouched);
    ASSERT_TRUE(store->put(1, pattern(2)));
    EXPECT_EQ(finish(), Progress::working);
    for (unsigned i = 0; i < 4; ++i) {
        power_on();
        put(2, i);
    }
    power_on();
    EXPECT_EQ(store->get(1), pattern(1));
    EXPECT_EQ(store->get(2), pattern(3));
    FlashMemory::Word word{};
    ASSERT_EQ(memory->read(FlashMemory::sector_start(kFirst) + 2 * kRecordBytes, word), FlashMemory::Read::good);
    EXPECT_TRUE(FlashMemory::erased(word));
}

TEST_F(FlashStoreTest, ARecordThatHasChangedIsNoRecord) {
    put(1, 1);
    put(1, 2);
    const std::size_t second = FlashMemory::sector_start(kFirst) - FlashMemory::kStart + std::size_t{2} * kRecordBytes;
    for (const std::size_t byte : {std::size_t{0}, std::size_t{40}, std::size_t{57}, std::size_t{63}}) {
        const model::Flash::Content content = chip.content();
        chip.cells().at(second + byte) ^= 0x10U;
        power_on();
        EXPECT_EQ(store->get(1), pattern(1)) << byte;
        chip.set_content(content);
    }
    chip.spoil(static_cast<Address>(FlashMemory::kStart + second));
    power_on();
    EXPECT_EQ(store->get(1), pattern(1));
    put(1, 3);
    power_on();
    EXPECT_EQ(store->get(1), pattern(3));
}

TEST_F(FlashStoreTest, AWordThatFailsIsPassedOverAndManyAreAFailure) {
    constexpr std::uint32_t kOperation = 1U << 22U;
    put(1, 1);
    chip.fail_next(kOperation);
    put(1, 2);
    chip.spoil(FlashMemory::sector_start(kFirst) + 3 * kRecordBytes);
    chip.spoil(FlashMemory::sector_start(kFirst) + 4 * kRecordBytes);
    put(1, 3);
    power_on();
    EXPECT_EQ(store->get(1), pattern(3));
    // Every word fails: the change is given up, then the sector, and neither takes what was kept.
    for (unsigned i = 0; i < 10; ++i) {
        ASSERT_TRUE(store->put(1, pattern(4)));
        EXPECT_EQ(finish([&](std::uint32_t now_ms) {
                      chip.fail_next(kOperation);
                      return store->step(now_ms);
                  }),
                  Progress::failed);
        EXPECT_EQ(store->get(1), pattern(3));
    }
    chip.fail_next(0);
    put(1, 5);
    power_on();
    EXPECT_EQ(store->get(1), pattern(5));
}

TEST_F(FlashStoreTest, WhileMarkingAChangeIsPutOffAndTold) {
    fill();
    const unsigned works = chip.works();
    memory->set_marking(true);
    ASSERT_TRUE(store->put(1, pattern(9)));
    for (unsigned i = 0; i < 10; ++i) {
        EXPECT_EQ(finish(), Progress::put_off);
        EXPECT_TRUE(store->busy());
    }
    EXPECT_EQ(chip.works(), works);
    // The laser may come on between two words, too.
    for (unsigned i = 1; i <= 29; ++i) {
        memory->set_marking(false);
        EXPECT_EQ(store->step(0), Progress::working);
        memory->set_marking(true);
        EXPECT_EQ(finish(), i < 29 ? Progress::put_off : Progress::done);
        EXPECT_EQ(chip.works(), works + i);
    }
    EXPECT_EQ(store->get(1), pattern(9));
}

TEST_F(FlashStoreTest, WorkForSomebodyElseIsWaitedFor) {
    put(1, 1);
    ASSERT_EQ(memory->erase(9), FlashMemory::Begin::begun);
    ASSERT_TRUE(store->put(1, pattern(2)));
    EXPECT_EQ(store->step(0), Progress::working);
    machine.advance_to(machine.now_ns() + 3'000'000);
    EXPECT_EQ(store->step(0), Progress::working) << "the one who began it ends it";
    EXPECT_EQ(memory->step(0), FlashMemory::Progress::done);
    EXPECT_EQ(finish(), Progress::done);
}

}  // namespace
}  // namespace sc::stm32h743
