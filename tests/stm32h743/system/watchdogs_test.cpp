// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/watchdogs.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/watchdog.hpp"
#include "boards/stm32h743/system/clock_start.hpp"
#include "tests/stm32h743/model/watchdogs.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A chip at 480 MHz whose watchdogs are started.
class Chip {
public:
    explicit Chip(double lsi_hz = 32'000) : pair(machine, tree, lsi_hz) {
        clocks = start_clocks();
        machine.on_interrupt(0, [this] {
            warnings.push_back(machine.now_ns());
            Watchdogs::acknowledge_warning_isr();
        });
    }
    /// A feed `ns` after the last one.
    void cycle(std::int64_t ns, bool healthy = true) {
        machine.advance_to(machine.now_ns() + ns);
        dogs.feed(healthy);
    }

    model::Machine machine;
    model::ClockTree tree{machine};
    model::WatchdogPair pair;
    Clocks clocks;
    Watchdogs dogs;
    std::vector<std::int64_t> warnings;
};

TEST(Watchdogs, AHealthyCellIsNeverReset) {
    for (const double lsi : {29'700.0, 32'000.0, 33'600.0}) {
        Chip chip(lsi);
        ASSERT_TRUE(chip.dogs.start(chip.clocks.frequencies));
        std::mt19937 random(7);
        for (int i = 0; i < 5'000; ++i) {
            chip.cycle(650'000 + static_cast<std::int64_t>(random() % 850'000));
        }
        EXPECT_TRUE(chip.pair.resets().empty());
        EXPECT_TRUE(chip.warnings.empty());
        EXPECT_EQ(chip.machine.violations_text(), "");
    }
}

TEST(Watchdogs, AMissedCycleResetsAfterAWarning) {
    Chip chip;
    ASSERT_TRUE(chip.dogs.start(chip.clocks.frequencies));
    chip.cycle(kMs);
    chip.cycle(kMs);
    const std::int64_t last = chip.machine.now_ns();
    chip.machine.advance_to(last + 2 * kMs - 350'000);
    ASSERT_EQ(chip.pair.resets().size(), 1U);
    EXPECT_EQ(chip.pair.resets()[0].why, "window: fed too late");
    EXPECT_NEAR(static_cast<double>(chip.pair.resets()[0].ns - last), 1.604e6, 1e3);
    ASSERT_EQ(chip.warnings.size(), 1U);
    EXPECT_NEAR(static_cast<double>(chip.pair.resets()[0].ns - chip.warnings[0]), 34'133, 50);
    EXPECT_EQ(read32(wwdg::kSr), 0U);
    EXPECT_EQ(take_reset_cause(), ResetCause::window_watchdog);
    EXPECT_EQ(take_reset_cause(), ResetCause::other);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(Watchdogs, AnEarlyFeedResetsAtOnce) {
    Chip chip;
    ASSERT_TRUE(chip.dogs.start(chip.clocks.frequencies));
    chip.cycle(kMs);
    chip.cycle(kMs);
    chip.cycle(600'000);
    ASSERT_EQ(chip.pair.resets().size(), 1U);
    EXPECT_EQ(chip.pair.resets()[0].why, "window: fed too early");
    EXPECT_EQ(chip.pair.resets()[0].ns, chip.machine.now_ns());
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(Watchdogs, AFaultStopsFeedingForGood) {
    Chip chip;
    ASSERT_TRUE(chip.dogs.start(chip.clocks.frequencies));
    chip.cycle(kMs);
    chip.cycle(kMs, false);
    const std::int64_t fault = chip.machine.now_ns();
    chip.cycle(400'000);
    chip.cycle(kMs);
    ASSERT_EQ(chip.pair.resets().size(), 1U);
    EXPECT_EQ(chip.pair.resets()[0].why, "window: fed too late");
    EXPECT_LT(chip.pair.resets()[0].ns, fault + kMs);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(Watchdogs, WithoutAFirstFeedTheIndependentOneResets) {
    for (const double lsi : {29'700.0, 33'600.0}) {
        Chip chip(lsi);
        ASSERT_TRUE(chip.dogs.start(chip.clocks.frequencies));
        const std::int64_t started = chip.machine.now_ns();
        chip.machine.advance_to(started + 20 * kMs);
        ASSERT_EQ(chip.pair.resets().size(), 1U);
        EXPECT_EQ(chip.pair.resets()[0].why, "independent: not fed");
        EXPECT_NEAR(static_cast<double>(chip.pair.resets()[0].ns - started), 320 / lsi * 1e9, 1e4);
        EXPECT_EQ(take_reset_cause(), ResetCause::independent_watchdog);
        EXPECT_EQ(chip.machine.violations_text(), "");
    }
}

TEST(Watchdogs, DoNotStartWithOtherClocksOrWithoutLsi) {
    Chip chip;
    EXPECT_FALSE(chip.dogs.start(kSlow));
    chip.pair.stop_lsi();
    EXPECT_FALSE(chip.dogs.start(chip.clocks.frequencies));
    chip.cycle(kMs);
    chip.machine.advance_to(chip.machine.now_ns() + 20 * kMs);
    EXPECT_TRUE(chip.pair.resets().empty());
    EXPECT_EQ(chip.machine.violations_text(), "");
}

TEST(ResetCause, PowerBeatsWatchdogsBeatSoftwareBeatsThePin) {
    constexpr std::uint32_t kPor = 1U << 23U | 1U << 22U | 1U << 21U;
    EXPECT_EQ(reset_cause(kPor | 1U << 28U), ResetCause::power);
    EXPECT_EQ(reset_cause(1U << 21U), ResetCause::power);
    EXPECT_EQ(reset_cause(1U << 28U | 1U << 26U | 1U << 22U), ResetCause::window_watchdog);
    EXPECT_EQ(reset_cause(1U << 26U | 1U << 24U), ResetCause::independent_watchdog);
    EXPECT_EQ(reset_cause(1U << 24U | 1U << 22U), ResetCause::software);
    EXPECT_EQ(reset_cause(1U << 22U), ResetCause::pin);
    EXPECT_EQ(reset_cause(1U << 30U), ResetCause::other);
}

}  // namespace
}  // namespace sc::stm32h743
