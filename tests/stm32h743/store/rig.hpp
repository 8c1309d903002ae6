// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "boards/stm32h743/store/flash_store.hpp"
#include "tests/stm32h743/model/flash.hpp"

namespace sc::stm32h743 {

using Cut = model::Flash::Cut;
inline constexpr std::array kOutcomes{Cut::untouched, Cut::whole, Cut::broken, Cut::random, Cut::mixed};

/// A chip whose flash is quick, and a store in two of its sectors that starts anew with each power_on().
class StoreRig : public ::testing::Test {
protected:
    using Progress = FlashStore::Progress;
    static constexpr unsigned kFirst = 14;
    static constexpr unsigned kSecond = 15;

    StoreRig() {
        chip.set_times(2'000'000, 100'000);
        power_on();
    }
    ~StoreRig() override { EXPECT_EQ(machine.violations_text(), ""); }
    StoreRig(const StoreRig&) = delete;
    StoreRig& operator=(const StoreRig&) = delete;

    void power_on() {
        // What was under way when the power went has ended.
        machine.advance_to(machine.now_ns() + 10'000'000);
        chip.power_on();
        memory = std::make_unique<FlashMemory>();
        memory->set_marking(false);
        store = std::make_unique<FlashStore>(*memory, kFirst, kSecond);
        (void)store->start();
    }
    /// `step` until it neither works nor waits, or the power is gone.
    template <class Step>
    Progress finish(const Step& step) {
        for (int i = 0; i < 100'000 && !chip.dead(); ++i) {
            const Progress progress = step(static_cast<std::uint32_t>(machine.now_ns() / 1'000'000));
            if (progress != Progress::working) {
                return progress;
            }
            machine.advance_to(machine.now_ns() + 110'000);
        }
        return Progress::working;
    }
    Progress finish() {
        return finish([this](std::uint32_t now_ms) { return store->step(now_ms); });
    }

    model::Machine machine;
    model::Flash chip{machine};
    std::unique_ptr<FlashMemory> memory;
    std::unique_ptr<FlashStore> store;
};

}  // namespace sc::stm32h743
