// SPDX-License-Identifier: Apache-2.0
#include "shared/path/block.hpp"

#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/shared/path/sound_block.hpp"

namespace {

using sc::Item;
using Random = std::mt19937_64;

std::uint64_t below(Random& random, std::uint64_t bound) { return random() % bound; }

/// A coordinate near the last one, anywhere, or at an end of the range.
std::int32_t coordinate(Random& random, std::int32_t last) {
    switch (below(random, 8)) {
        case 0: return static_cast<std::int32_t>(static_cast<std::uint32_t>(random()));
        case 1: return below(random, 2) == 0 ? INT32_MIN : INT32_MAX;
        default: {
            const std::int64_t near = std::int64_t{last} + static_cast<std::int64_t>(below(random, 10'001)) - 5'000;
            return near < INT32_MIN || near > INT32_MAX ? last : static_cast<std::int32_t>(near);
        }
    }
}

std::vector<Item> random_items(Random& random) {
    std::vector<Item> items;
    sc::PathPoint last;
    const std::uint64_t count = below(random, 300);
    for (std::uint64_t i = 0; i < count; ++i) {
        switch (below(random, 24)) {
            case 20: items.emplace_back(sc::PathLight{below(random, 2) == 0}); break;
            case 21: items.emplace_back(sc::StageCurve{static_cast<std::uint32_t>(random())}); break;
            case 22: items.emplace_back(sc::StageKnot{coordinate(random, 0), coordinate(random, 0), 7}); break;
            case 23:
                items.emplace_back(sc::Look{static_cast<std::uint32_t>(random()), coordinate(random, 0), 7, 8});
                break;
            case 0: items.emplace_back(sc::PathEnd{}); break;
            case 1: items.emplace_back(sc::JobEnd{}); break;
            case 4: {
                const sc::PathPoint via{coordinate(random, 0), coordinate(random, 0), coordinate(random, 0)};
                last = {coordinate(random, last.x), coordinate(random, last.y), coordinate(random, last.z)};
                items.emplace_back(sc::PathArc{via, last});
                break;
            }
            case 2: items.emplace_back(sc::Turn{coordinate(random, 0)}); break;
            case 3: {
                sc::PathBegin begin;
                begin.path = static_cast<std::uint32_t>(random());
                begin.actuator = static_cast<sc::Actuator>(below(random, 3));
                begin.energy_nj = static_cast<std::uint32_t>(random());
                begin.anchor_z = coordinate(random, 0);
                items.emplace_back(begin);
                break;
            }
            default:
                last = {coordinate(random, last.x), coordinate(random, last.y), coordinate(random, last.z)};
                items.emplace_back(last);
        }
    }
    return items;
}

TEST(BlockProperty, AnyItemsComeBackFromBlocksOfAnySize) {
    Random random(20240501);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    for (int round = 0; round < 500; ++round) {
        const std::vector<Item> items = random_items(random);
        std::vector<Item> back;
        while (back.size() < items.size()) {
            std::vector<std::uint8_t> bytes(sc::kLongestItem + below(random, 300));
            const sc::BlockSize size = sc::encode_block(std::span(items).subspan(back.size()), bytes);
            ASSERT_GT(size.items, 0U);
            sc::BlockReader reader{std::span(bytes).first(size.bytes), size.items};
            Item item;
            while (reader.next(item).value_or(false)) {
                back.push_back(item);
            }
            ASSERT_TRUE(sc::block_is_sound(std::span(bytes).first(size.bytes), size.items));
        }
        ASSERT_EQ(back, items) << "round " << round;
    }
}

TEST(BlockProperty, AnyBytesAreEitherRefusedOrYieldTheirCount) {
    Random random(7);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    int sound = 0;
    for (int round = 0; round < 200'000; ++round) {
        // Exact-size storage, so that a sanitizer sees any read outside.
        std::vector<std::uint8_t> bytes(below(random, 40));
        for (std::uint8_t& byte : bytes) {
            byte = static_cast<std::uint8_t>(below(random, 3) == 0 ? below(random, 256) : below(random, 10));
        }
        const std::size_t count = below(random, 6);
        sc::BlockReader reader(bytes, count);
        Item item;
        std::size_t items = 0;
        auto step = reader.next(item);
        for (; step.value_or(false); step = reader.next(item)) {
            ++items;
        }
        ASSERT_LE(items, count);
        if (step.has_value()) {
            ASSERT_EQ(items, count);
            ++sound;
        }
    }
    EXPECT_GT(sound, 1000) << "the generator must reach sound blocks too";
}

}  // namespace
