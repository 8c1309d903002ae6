// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "cell_rig.hpp"

namespace sc::test {

/// What an undisturbed run of the short job burns.
inline const CellRig& undisturbed() {
    static const auto rig = [] {
        auto cell = std::make_unique<CellRig>();
        cell->make_ready();
        EXPECT_EQ(cell->open_job(short_job()).refusal, 0);
        EXPECT_EQ(cell->command(link::Verb::start).refusal, 0);
        EXPECT_TRUE(cell->until([&] { return (cell->status().flags & link::kFlagJobDone) != 0; }));
        cell->ticks(100);
        return cell;
    }();
    return *rig;
}

}  // namespace sc::test
