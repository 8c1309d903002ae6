// SPDX-License-Identifier: Apache-2.0
#include "shared/path/item_queue.hpp"

#include <gtest/gtest.h>

namespace {

using Queue = sc::BasicItemQueue<3>;

sc::Item turn(int c) { return sc::Turn{c}; }

TEST(ItemQueue, IsEmptyAtFirst) {
    Queue queue;
    EXPECT_TRUE(queue.empty());
    EXPECT_EQ(queue.front(), nullptr);
    EXPECT_EQ(queue.free(), 3U);
    queue.pop();
    EXPECT_EQ(queue.size(), 0U);
}

TEST(ItemQueue, RefusesPushWhenFull) {
    Queue queue;
    for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(queue.push(turn(i)));
    }
    EXPECT_FALSE(queue.push(turn(3)));
    EXPECT_EQ(queue.free(), 0U);
    EXPECT_EQ(*queue.front(), turn(0));
}

TEST(ItemQueue, KeepsOrderAroundTheEnd) {
    Queue queue;
    int in = 0;
    for (int out = 0; out < 20; ++out) {
        while (queue.push(turn(in))) {
            ++in;
        }
        ASSERT_NE(queue.front(), nullptr);
        EXPECT_EQ(*queue.front(), turn(out));
        EXPECT_EQ(*queue.peek(2), turn(out + 2));
        EXPECT_EQ(queue.peek(3), nullptr);
        queue.pop();
    }
}

TEST(ItemQueue, IsEmptyAfterClear) {
    Queue queue;
    EXPECT_TRUE(queue.push(turn(1)));
    queue.clear();
    EXPECT_EQ(queue.front(), nullptr);
    EXPECT_EQ(queue.free(), Queue::capacity());
}

TEST(ItemQueue, HoldsTwoThousandAndFortyEightItems) { EXPECT_EQ(sc::ItemQueue::capacity(), 2048U); }

}  // namespace
