// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_master.hpp"

#include <gtest/gtest.h>

namespace sc::drives {
namespace {

TEST(Period, BeginsAtEachMultipleInWhateverOrderTheTicksCome) {
    for (const std::int64_t count : {1, 2, 3, 7, 50}) {
        Period one_by_one(count);
        for (std::int64_t tick = 0; tick < 400; ++tick) {
            EXPECT_EQ(one_by_one.begins(tick), tick % count == 0) << count << ' ' << tick;
            EXPECT_EQ(one_by_one.begins(tick), tick % count == 0) << "asked again " << count << ' ' << tick;
        }
        Period leaping(count);
        for (const std::int64_t tick : {5, 14, 14, 1'000'000'007, 1'000'000'050, 49, 50, 0, -7, -50, 3, 700}) {
            EXPECT_EQ(leaping.begins(tick), tick % count == 0) << count << ' ' << tick;
        }
    }
}

TEST(Period, OfLessThanOneTickIsEachTick) {
    Period period(0);
    EXPECT_EQ(period.count(), 1);
    EXPECT_TRUE(period.begins(0));
    EXPECT_TRUE(period.begins(1));
}

}  // namespace
}  // namespace sc::drives
