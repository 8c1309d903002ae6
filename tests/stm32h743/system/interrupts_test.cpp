// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/interrupts.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/interrupt_control.hpp"

namespace sc::stm32h743 {
namespace {

TEST(Interrupts, NumbersAreThoseOfTheChip) {
    std::ifstream file(SC_TEST_DATA "/stm32h743/interrupts.csv");
    std::string line;
    std::getline(file, line);
    std::map<std::string, int> table;
    while (std::getline(file, line)) {
        std::string name = line.substr(0, line.find(','));
        std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        table[name + "_isr"] = std::stoi(line.substr(line.find(',') + 1));
    }
    EXPECT_EQ(table.at("wwdg_isr"), 0);
    table.erase("wwdg_isr");
    std::map<std::string, int> ours;
    for (const Context& one : kContexts) {
        if (one.number >= 0) {
            ours[std::string(one.name)] = one.number;
        }
    }
    EXPECT_EQ(ours, table);
}

TEST(Interrupts, PreparedFromWhateverABootLoaderLeft) {
    model::Machine machine;
    model::InterruptControl control(machine);
    for (unsigned number = 0; number < model::InterruptControl::kInterrupts; ++number) {
        control.preset(number, number % 3 == 0, number % 5 == 0, 0x70);
    }
    prepare_interrupts();
    EXPECT_TRUE(control.all_bits_preempt());
    EXPECT_EQ(control.fault_priorities(), 0U);
    for (unsigned number = 0; number < model::InterruptControl::kInterrupts; ++number) {
        EXPECT_FALSE(control.enabled(number)) << number;
        EXPECT_FALSE(control.pending(number)) << number;
    }
    for (const Context& one : kContexts) {
        if (one.number >= 0) {
            EXPECT_EQ(control.priority(static_cast<unsigned>(one.number)), one.priority) << one.name;
            EXPECT_LT(one.priority, control.servo_priority()) << one.name;
        }
    }
    EXPECT_EQ(control.priority(0), 0U);
    EXPECT_EQ(control.servo_priority(), 14U);
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(Interrupts, OnlyWhatTheTableHasIsEnabled) {
    model::Machine machine;
    model::InterruptControl control(machine);
    prepare_interrupts();
    for (int number = -16; number < 200; ++number) {
        const bool known =
            std::ranges::any_of(kContexts, [&](const Context& one) { return one.number == number && number >= 0; });
        EXPECT_EQ(enable_interrupt(number), known) << number;
        if (number >= 0 && number < 150) {
            EXPECT_EQ(control.enabled(static_cast<unsigned>(number)), known) << number;
        }
    }
    EXPECT_FALSE(control.enabled(0));
    enable_warning();
    EXPECT_TRUE(control.enabled(0));
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(Interrupts, WhatWasPendingBeforeTheDriverWasReadyIsForgotten) {
    model::Machine machine;
    model::InterruptControl control(machine);
    prepare_interrupts();
    control.preset(38, false, true, 0x40);
    EXPECT_TRUE(enable_interrupt(38));
    EXPECT_TRUE(control.enabled(38));
    EXPECT_FALSE(control.pending(38));
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(Interrupts, ServoStepIsAskedForByPendSv) {
    model::Machine machine;
    const model::InterruptControl control(machine);
    EXPECT_FALSE(control.servo_asked());
    ask_for_servo_step();
    EXPECT_TRUE(control.servo_asked());
    EXPECT_EQ(machine.violations_text(), "");
}

/// The bounds of interrupts.hpp against a run of time: everything asks as soon as it may, all at once at first.
TEST(InterruptBudget, NoRunOfTimeIsSlowerThanTheBound) {
    struct Job {
        std::uint64_t next = 0, left = 0, asked = 0, worst = 0;
    };
    std::array<Job, kContexts.size()> jobs{};
    for (std::uint64_t now = 0; now < 40'000'000; now += 20) {
        for (std::size_t i = 0; i < jobs.size(); ++i) {
            if (now >= jobs[i].next) {
                ASSERT_EQ(jobs[i].left, 0U) << kContexts[i].name << " is not done when it is due again";
                jobs[i].left = cost_ns(kContexts[i]);
                jobs[i].asked = jobs[i].next;
                jobs[i].next += kContexts[i].period_ns;
            }
        }
        const auto first = std::ranges::find_if(jobs, [](const Job& job) { return job.left > 0; });
        if (first == jobs.end()) {
            continue;
        }
        first->left -= std::min<std::uint64_t>(first->left, 20);
        if (first->left == 0) {
            first->worst = std::max(first->worst, now + 20 - first->asked);
        }
    }
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        EXPECT_GT(jobs[i].worst, 0U) << kContexts[i].name;
        EXPECT_LE(jobs[i].worst, response_ns(i)) << kContexts[i].name;
        EXPECT_LE(response_ns(i), kContexts[i].deadline_ns) << kContexts[i].name;
        RecordProperty(std::string(kContexts[i].name), std::to_string(response_ns(i)));
    }
    // The bound is not idle either: planning, which waits for all, comes near it.
    EXPECT_GT(jobs.back().worst * 10, response_ns(jobs.size() - 1) * 8);
}

}  // namespace
}  // namespace sc::stm32h743
