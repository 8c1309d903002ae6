// SPDX-License-Identifier: Apache-2.0
#include "firmware/store/parameter_store.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace sc;
using namespace sc::store;
using Progress = ParameterStore::Progress;

/// Flash that takes some ticks for each act, and whose power can be cut before any of them, or in its midst.
class Flash final : public ParameterMemory {
public:
    Flash() {
        for (auto& slot : slots_) {
            slot.fill(0xFF);
        }
    }
    [[nodiscard]] std::span<const std::uint8_t, kSlotBytes> slot(std::size_t slot) const noexcept override {
        return slots_.at(slot);
    }
    [[nodiscard]] bool ready() const noexcept override { return waits_ == 0; }
    void erase(std::size_t slot) noexcept override {
        act([&] { slots_.at(slot).fill(0xFF); },
            [&] {
                std::generate_n(slots_.at(slot).begin(), kSlotBytes / 2,
                                [&] { return static_cast<std::uint8_t>(random_()); });
            });
    }
    void write(std::size_t slot, std::size_t unit, const Unit& bytes) noexcept override {
        const auto at = slots_.at(slot).begin() + static_cast<std::ptrdiff_t>(unit * kUnit);
        EXPECT_TRUE(dead_ || std::all_of(at, at + kUnit, [](std::uint8_t b) { return b == 0xFF; })) << "written twice";
        act([&] { std::copy(bytes.begin(), bytes.end(), at); },
            [&] { std::generate_n(at, kUnit, [&] { return static_cast<std::uint8_t>(random_()); }); });
    }
    void tick() noexcept { waits_ -= waits_ > 0 ? 1 : 0; }
    /// The power goes at the n-th act from now: it is not done, or half done.
    void cut(int act, bool midst) {
        cut_at_ = acts + act;
        midst_ = midst;
    }
    void power_on() {
        dead_ = false;
        cut_at_ = -1;
        waits_ = 0;
    }
    [[nodiscard]] bool dead() const { return dead_; }
    int acts = 0;
    std::array<std::array<std::uint8_t, kSlotBytes>, kSlots> slots_{};

private:
    template <class Whole, class Half>
    void act(const Whole& whole, const Half& half) {
        EXPECT_TRUE(ready());
        waits_ = 3;
        if (acts++ == cut_at_) {
            dead_ = true;
            if (midst_) {
                half();
            }
        } else if (!dead_) {
            whole();
        }
    }
    int waits_ = 0;
    int cut_at_ = -1;
    bool midst_ = false;
    bool dead_ = false;
    std::mt19937 random_{1};
};

std::vector<std::uint8_t> content(std::size_t size, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes(size);
    std::ranges::generate(bytes, [&] { return static_cast<std::uint8_t>(random()); });
    return bytes;
}

Progress run(ParameterStore& store, Flash& flash) {
    for (int i = 0; i < 1000 && !flash.dead(); ++i) {
        const Progress progress = store.step(true);
        if (progress != Progress::writing) {
            return progress;
        }
        flash.tick();
    }
    return Progress::writing;
}

TEST(ParameterStore, KeepsWhatItIsGivenAndTheNewestCounts) {
    Flash flash;
    ParameterStore store;
    EXPECT_FALSE(store.fitted());
    store.keep_in(&flash);
    EXPECT_FALSE(store.stored());
    EXPECT_EQ(store.step(true), Progress::idle);
    for (unsigned i = 1; i <= 5; ++i) {
        const auto bytes = content(i == 5 ? kMostBytes : 1000 + i, i);
        store.begin(bytes, static_cast<std::uint16_t>(10 + i));
        EXPECT_EQ(run(store, flash), Progress::done);
        const auto stored = store.stored();
        ASSERT_TRUE(stored);
        EXPECT_EQ(stored->generation, i);
        EXPECT_EQ(stored->layout, 10 + i);
        EXPECT_TRUE(std::ranges::equal(stored->bytes, bytes));
    }
    store.begin({}, 0);
    EXPECT_EQ(run(store, flash), Progress::done);
    EXPECT_FALSE(store.stored());
}

TEST(ParameterStore, NothingIsBegunWhileItIsNotAllowed) {
    Flash flash;
    ParameterStore store;
    store.keep_in(&flash);
    const auto bytes = content(200, 1);
    store.begin(bytes, 1);
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(store.step(false), Progress::writing);
    }
    EXPECT_EQ(flash.acts, 0);
    EXPECT_EQ(run(store, flash), Progress::done);
    EXPECT_EQ(flash.acts, 1 + 7 + 1);
}

TEST(ParameterStore, WhereverThePowerGoesTheOldOrTheNewIsThereWhole) {
    const auto old = content(1162, 1);
    const auto fresh = content(1162, 2);
    const auto older = content(1162, 3);
    int survived = 0;
    for (int at = 0; at < 45; ++at) {
        for (const bool midst : {false, true}) {
            Flash flash;
            ParameterStore store;
            store.keep_in(&flash);
            store.begin(older, 1);
            ASSERT_EQ(run(store, flash), Progress::done);
            store.begin(old, 1);
            ASSERT_EQ(run(store, flash), Progress::done);
            flash.cut(at, midst);
            store.begin(fresh, 1);
            (void)run(store, flash);
            flash.power_on();
            const auto stored = newest(flash);
            ASSERT_TRUE(stored) << at;
            const bool is_old = std::ranges::equal(stored->bytes, old);
            EXPECT_TRUE(is_old || std::ranges::equal(stored->bytes, fresh)) << at;
            survived += is_old ? 1 : 0;
            ParameterStore again;
            again.keep_in(&flash);
            again.begin(fresh, 1);
            EXPECT_EQ(run(again, flash), Progress::done) << "and it can be written again";
            EXPECT_TRUE(std::ranges::equal(again.stored()->bytes, fresh));
        }
    }
    EXPECT_EQ(survived, 2 * (1 + 37 + 1)) << "the new one counts only once its head is written";
}

TEST(ParameterStore, ASpoiltBitIsNoticedAndTheOlderCounts) {
    Flash flash;
    ParameterStore store;
    store.keep_in(&flash);
    const auto first = content(300, 1);
    const auto second = content(300, 2);
    store.begin(first, 1);
    ASSERT_EQ(run(store, flash), Progress::done);
    store.begin(second, 1);
    ASSERT_EQ(run(store, flash), Progress::done);
    const std::size_t slot = store.stored()->slot;
    for (const std::size_t at : {0U, 5U, 9U, 11U, 13U, 32U, 331U}) {
        auto& byte = flash.slots_.at(slot).at(at);
        byte ^= 0x10U;
        const auto now = newest(flash);
        ASSERT_TRUE(now) << at;
        EXPECT_TRUE(std::ranges::equal(now->bytes, first)) << at;
        byte ^= 0x10U;
    }
}

TEST(ParameterStore, FlashThatDoesNotTakeTheBytesIsAFailure) {
    Flash flash;
    ParameterStore store;
    store.keep_in(&flash);
    flash.cut(20, true);
    const auto bytes = content(1162, 1);
    store.begin(bytes, 1);
    Progress progress = Progress::writing;
    for (int i = 0; i < 1000 && progress == Progress::writing; ++i) {
        progress = store.step(true);
        flash.tick();
    }
    EXPECT_EQ(progress, Progress::failed);
    EXPECT_FALSE(store.stored());
}

}  // namespace
