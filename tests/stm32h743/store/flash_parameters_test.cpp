// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/flash_parameters.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/store/parameter_store.hpp"
#include "tests/stm32h743/store/rig.hpp"

namespace sc::stm32h743 {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes content(std::size_t size, unsigned seed) {
    std::mt19937 random(seed);
    Bytes bytes(size);
    std::ranges::generate(bytes, [&] { return static_cast<std::uint8_t>(random()); });
    return bytes;
}

JobRecord job(std::uint32_t seed) {
    JobRecord record;
    record.job = 0x1234'5678'9ABC'DEF0ULL + seed;
    record.items = 1000 + seed;
    record.certain = {seed, {seed + 1, static_cast<std::uint8_t>(seed + 2), seed + 3, 0xFFFF'FFFFU - seed}};
    record.reached = {seed + 10, {seed + 11, static_cast<std::uint8_t>(seed + 12), seed + 13, 0xFFFF'0000U - seed}};
    return record;
}

class FlashParametersTest : public StoreRig {
protected:
    FlashParametersTest() { start(); }
    void start() {
        power_on();
        memory_in_flash = std::make_unique<FlashParameters>(*store);
        memory_in_flash->start();
        fired = std::make_unique<FiredRecord>(*store);
        fired->start();
        parameters = std::make_unique<sc::store::ParameterStore>();
        parameters->keep_in(memory_in_flash.get());
    }
    [[nodiscard]] Bytes kept() const {
        const auto& stored = parameters->stored();
        return stored ? Bytes(stored->bytes.begin(), stored->bytes.end()) : Bytes{};
    }
    /// A control tick, as the controller makes it.
    Progress tick(std::uint32_t now_ms, bool allowed = true) {
        (void)memory_in_flash->step(now_ms);
        using Stored = sc::store::ParameterStore::Progress;
        switch (parameters->step(allowed)) {
            case Stored::idle: return Progress::idle;
            case Stored::writing: return Progress::working;
            case Stored::done: return Progress::done;
            case Stored::failed: break;
        }
        return Progress::failed;
    }
    Progress write(const Bytes& bytes) {
        parameters->begin(bytes, 1);
        return finish([this](std::uint32_t now_ms) { return tick(now_ms); });
    }
    Progress finish_fired() {
        return finish([this](std::uint32_t now_ms) { return fired->step(now_ms); });
    }

    std::unique_ptr<FlashParameters> memory_in_flash;
    std::unique_ptr<FiredRecord> fired;
    std::unique_ptr<sc::store::ParameterStore> parameters;
};

TEST_F(FlashParametersTest, ParametersOutliveThePower) {
    EXPECT_EQ(kept(), Bytes{});
    for (unsigned i = 1; i <= 60; ++i) {
        const Bytes bytes = content(i == 1 ? sc::store::kMostBytes : 37 * i % 1200 + 1, i);
        ASSERT_EQ(write(bytes), Progress::done) << i;
        EXPECT_EQ(kept(), bytes);
        start();
        EXPECT_EQ(kept(), bytes);
        EXPECT_EQ(parameters->stored()->generation, i);
    }
    ASSERT_EQ(write({}), Progress::done) << "what the board was built with counts again";
    start();
    EXPECT_EQ(kept(), Bytes{});
}

TEST_F(FlashParametersTest, ThePowerGoesAtEachWordOfAWriting) {
    const Bytes before = content(100, 1);
    const Bytes after = content(70, 2);
    ASSERT_EQ(write(content(130, 0)), Progress::done);
    ASSERT_EQ(write(before), Progress::done);
    const model::Flash::Content begin = chip.content();
    const unsigned first = chip.works();
    start();
    ASSERT_EQ(write(after), Progress::done);
    const unsigned works = chip.works() - first;
    ASSERT_EQ(works, 10U) << "erase, three units, the head";
    for (unsigned n = 0; n < works; ++n) {
        for (const Cut outcome : kOutcomes) {
            SCOPED_TRACE(testing::Message() << "work " << n << ", " << static_cast<int>(outcome));
            chip.set_content(begin);
            start();
            ASSERT_EQ(kept(), before);
            chip.cut(n, outcome);
            ASSERT_EQ(write(after), Progress::working);
            start();
            const bool last = n + 1 == works && outcome == Cut::whole;
            ASSERT_EQ(kept(), last ? after : before);
            ASSERT_EQ(write(content(99, n)), Progress::done);
            start();
            ASSERT_EQ(kept(), content(99, n));
        }
    }
}

TEST_F(FlashParametersTest, AUnitThatCannotBeWrittenIsAFailureAndTheOldOnesStay) {
    const Bytes before = content(100, 1);
    ASSERT_EQ(write(before), Progress::done);
    const Bytes after = content(100, 2);
    parameters->begin(after, 1);
    EXPECT_EQ(finish([this](std::uint32_t now_ms) {
                  chip.fail_next(1U << 22U);
                  return tick(now_ms);
              }),
              Progress::failed);
    EXPECT_EQ(kept(), before);
    chip.fail_next(0);
    start();
    EXPECT_EQ(kept(), before);
    EXPECT_EQ(write(after), Progress::done);
}

TEST_F(FlashParametersTest, NothingIsWrittenWhileMarking) {
    ASSERT_EQ(write(content(100, 1)), Progress::done);
    const unsigned works = chip.works();
    const Bytes after = content(100, 2);
    parameters->begin(after, 1);
    memory->set_marking(true);
    for (unsigned i = 0; i < 100; ++i) {
        EXPECT_EQ(tick(i), Progress::working);
    }
    EXPECT_EQ(chip.works(), works);
    EXPECT_FALSE(memory_in_flash->ready());
    EXPECT_EQ(memory_in_flash->step(0), Progress::put_off);
    memory->set_marking(false);
    EXPECT_EQ(finish([this](std::uint32_t now_ms) { return tick(now_ms); }), Progress::done);
    EXPECT_EQ(kept(), after);
}

TEST_F(FlashParametersTest, AJobsPlaceIsKeptAndTakenBackBeforeMarking) {
    EXPECT_TRUE(fired->may_mark());
    EXPECT_EQ(fired->record(), std::nullopt);
    ASSERT_TRUE(fired->keep(job(1)));
    EXPECT_FALSE(fired->may_mark());
    EXPECT_FALSE(fired->keep(job(2)));
    EXPECT_FALSE(fired->forget());
    EXPECT_EQ(finish_fired(), Progress::done);
    EXPECT_FALSE(fired->may_mark());
    start();
    EXPECT_EQ(fired->record(), job(1));
    EXPECT_FALSE(fired->may_mark());
    ASSERT_TRUE(fired->forget());
    EXPECT_FALSE(fired->may_mark()) << "not before it is gone";
    EXPECT_EQ(finish_fired(), Progress::done);
    EXPECT_TRUE(fired->may_mark());
    EXPECT_EQ(fired->record(), std::nullopt);
    start();
    EXPECT_TRUE(fired->may_mark());
    EXPECT_EQ(fired->record(), std::nullopt);
    FiredRecord unread(*store);
    EXPECT_FALSE(unread.may_mark()) << "what the flash holds is not known";
}

TEST_F(FlashParametersTest, ThePowerGoesWhileAJobsPlaceIsKeptOrTakenBack) {
    for (const bool forget : {false, true}) {
        start();
        ASSERT_TRUE(fired->keep(job(1)));
        ASSERT_EQ(finish_fired(), Progress::done);
        const model::Flash::Content begin = chip.content();
        for (unsigned n = 0; n < 2; ++n) {
            for (const Cut outcome : kOutcomes) {
                chip.set_content(begin);
                start();
                chip.cut(n, outcome);
                ASSERT_TRUE(forget ? fired->forget() : fired->keep(job(2)));
                ASSERT_EQ(finish_fired(), Progress::working);
                ASSERT_FALSE(fired->may_mark());
                start();
                const auto after = forget ? std::nullopt : std::optional(job(2));
                ASSERT_EQ(fired->record(), n == 1 && outcome == Cut::whole ? after : job(1));
                ASSERT_EQ(fired->may_mark(), !fired->record().has_value());
            }
        }
    }
}

TEST_F(FlashParametersTest, AFailureLeavesNoLeaveToMark) {
    ASSERT_TRUE(fired->keep(job(1)));
    const auto failing = [this](std::uint32_t now_ms) {
        chip.fail_next(1U << 22U);
        return fired->step(now_ms);
    };
    EXPECT_EQ(finish(failing), Progress::failed);
    EXPECT_FALSE(fired->may_mark()) << "it may be there all the same";
    chip.fail_next(0);
    ASSERT_TRUE(fired->keep(job(1)));
    EXPECT_EQ(finish_fired(), Progress::done);
    ASSERT_TRUE(fired->forget());
    EXPECT_EQ(finish(failing), Progress::failed);
    EXPECT_FALSE(fired->may_mark());
    EXPECT_EQ(fired->record(), job(1));
}

TEST_F(FlashParametersTest, OneOfBothIsWrittenAtATime) {
    ASSERT_TRUE(fired->keep(job(1)));
    EXPECT_FALSE(memory_in_flash->ready());
    memory_in_flash->erase(0);
    EXPECT_EQ(memory_in_flash->step(0), Progress::idle);
    EXPECT_EQ(finish_fired(), Progress::done);
    EXPECT_TRUE(memory_in_flash->ready());
    memory_in_flash->write(1, 39, ParameterMemory::Unit{1, 2, 3});
    EXPECT_FALSE(fired->keep(job(2)));
    EXPECT_FALSE(fired->forget());
    EXPECT_EQ(fired->step(0), Progress::idle);
    EXPECT_EQ(finish([this](std::uint32_t now_ms) { return memory_in_flash->step(now_ms); }), Progress::done);
    start();
    EXPECT_EQ(fired->record(), job(1)) << "the last unit's number is another";
    EXPECT_EQ(memory_in_flash->slot(1)[39 * 32 + 2], 3);
}

TEST_F(FlashParametersTest, TheBackupRamCountsBeforeTheFlash) {
    RetainedMemory retained;
    EXPECT_EQ(starting_record(retained, *fired), std::nullopt);
    ASSERT_TRUE(fired->keep(job(1)));
    ASSERT_EQ(finish_fired(), Progress::done);
    retained.write(job(5));
    EXPECT_EQ(starting_record(retained, *fired), job(5));
    RetainedMemory without_battery;
    EXPECT_EQ(starting_record(without_battery, *fired), job(1));
    EXPECT_EQ(without_battery.read(), job(1));
}

}  // namespace
}  // namespace sc::stm32h743
