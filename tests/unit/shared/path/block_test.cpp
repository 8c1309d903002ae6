// SPDX-License-Identifier: Apache-2.0
#include "shared/path/block.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/shared/path/sound_block.hpp"

namespace {

using sc::Item;
using sc::PathPoint;

constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
using Buffer = std::vector<std::uint8_t>;

sc::PathBegin some_begin() { return {7, sc::Actuator::galvo, 3, 100'000, 2'000, 500'000, 5'000, -1, kMin, kMax}; }

Buffer encode(const std::vector<Item>& items, std::size_t room = 4096) {
    Buffer bytes(room);
    const sc::BlockSize size = sc::encode_block(items, bytes);
    EXPECT_EQ(size.items, items.size());
    bytes.resize(size.bytes);
    return bytes;
}
/// All items, or nothing if the block is malformed.
std::optional<std::vector<Item>> decode(const Buffer& bytes, std::size_t count) {
    sc::BlockReader reader(bytes, count);
    std::vector<Item> items;
    Item item;
    while (true) {
        const auto step = reader.next(item);
        if (!step) {
            EXPECT_EQ(step.error(), sc::Refusal::malformed_block);
            EXPECT_FALSE(reader.next(item).has_value()) << "an error is final";
            return std::nullopt;
        }
        if (!*step) {
            return items;
        }
        items.push_back(item);
    }
}

TEST(Block, EveryKindOfItemComesBack) {
    const std::vector<Item> items{sc::Turn{-9'000'000},
                                  some_begin(),
                                  PathPoint{1, 2, 3},
                                  PathPoint{4, 6, 8},
                                  PathPoint{8, 9, 10},
                                  sc::PathEnd{},
                                  PathPoint{0, 0, 0},
                                  sc::PathArc{{kMin, 1, 2}, {kMax, -3, 4}},
                                  PathPoint{7, 7, 7},
                                  sc::PathLight{false},
                                  sc::StageCurve{0xFFFFFFFF},
                                  sc::StageKnot{kMin, -1, kMax},
                                  PathPoint{7, 7, 8},
                                  sc::PathLight{true},
                                  sc::Look{0xFFFFFFFF, kMin, -1, kMax},
                                  sc::JobEnd{}};
    EXPECT_EQ(decode(encode(items), items.size()), items);
}

TEST(Block, HasThisLayout) {
    const std::vector<Item> items{sc::Turn{-2}, PathPoint{1, 2, 3}, PathPoint{3, 1, 67}, PathPoint{5, 0, 67},
                                  sc::PathEnd{}};
    // First differences 2, -1, 64; their changes then 0, 0, -64: zigzag 4, 1, 128 and 0, 0, 127.
    const Buffer expected{4, 0xFE, 0xFF, 0xFF, 0xFF, 1, 3, 1,    0,    0, 0, 2,   0, 0,
                          0, 3,    0,    0,    0,    4, 1, 0x80, 0x01, 0, 0, 127, 3};
    EXPECT_EQ(encode(items), expected);
}

TEST(Block, LightAndStageHaveThisLayout) {
    const Buffer expected{7, 1, 8, 0x40, 0x9C, 0, 0, 9, 1, 0, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF, 3, 0, 0, 0};
    EXPECT_EQ(encode({sc::PathLight{true}, sc::StageCurve{40'000}, sc::StageKnot{1, -2, 3}}), expected);
    const Buffer look{10, 0x50, 0xC3, 0, 0, 1, 0, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF, 3, 0, 0, 0};
    EXPECT_EQ(encode({sc::Look{50'000, 1, -2, 3}}), look);
    EXPECT_FALSE(decode({look.begin(), look.end() - 1}, 1).has_value());
    EXPECT_FALSE(decode({7, 2}, 1).has_value()) << "neither on nor off";
    EXPECT_FALSE(decode({7}, 1).has_value());
    EXPECT_FALSE(decode({8, 1, 0, 0}, 1).has_value());
}

TEST(Block, AnArcHasThisLayout) {
    const Buffer expected{6, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF, 5, 0, 0, 0, 6, 0, 0, 0};
    EXPECT_EQ(encode({sc::PathArc{{1, 2, 3}, {-2, 5, 6}}}), expected);
    for (std::size_t size = 0; size < expected.size(); ++size) {
        EXPECT_FALSE(sc::block_is_sound(std::span(expected).first(size), 1)) << size;
    }
}

TEST(Block, LongestItemFillsThirtyFiveBytes) { EXPECT_EQ(encode({some_begin()}).size(), sc::kLongestItem); }

TEST(Block, CarriesJumpsAcrossTheWholeRange) {
    std::vector<Item> items;
    for (int i = 0; i < 12; ++i) {
        items.emplace_back(i % 2 == 0 ? PathPoint{kMin, kMax, 0} : PathPoint{kMax, kMin, -1});
    }
    EXPECT_EQ(decode(encode(items), items.size()), items);
}

TEST(Block, TakesAsManyItemsAsFit) {
    const std::vector<Item> items(100, PathPoint{5, 5, 5});
    Buffer bytes(14 + 3 * 9 + 2, 0xAA);
    const sc::BlockSize size = sc::encode_block(items, bytes);
    EXPECT_EQ(size.items, 10U);
    EXPECT_EQ(size.bytes, 14U + 27U);
    EXPECT_EQ(bytes[size.bytes], 0xAA);
    bytes.resize(size.bytes);
    EXPECT_EQ(decode(bytes, 10), std::vector<Item>(10, PathPoint{5, 5, 5}));
}

TEST(Block, TakesNothingWhereNothingFits) {
    Buffer bytes(13);
    EXPECT_EQ(sc::encode_block(std::vector<Item>{PathPoint{}}, bytes).items, 0U);
    EXPECT_EQ(sc::encode_block(std::vector<Item>{sc::JobEnd{}}, {}).items, 0U);
    EXPECT_EQ(sc::encode_block({}, bytes).bytes, 0U);
}

TEST(Block, HoldsNoMoreItemsThanItsCountCanSay) {
    Buffer bytes(4096);
    EXPECT_EQ(sc::encode_block(std::vector<Item>(300, PathPoint{1, 1, 1}), bytes).items, sc::kBlockItems);
    EXPECT_EQ(sc::encode_block(std::vector<Item>(300, sc::PathEnd{}), bytes).items, sc::kBlockItems);
    EXPECT_TRUE(sc::block_is_sound(encode(std::vector<Item>(255, PathPoint{1, 1, 1})), 255));
}

TEST(Block, EmptyIsSoundOnlyWithCountZero) {
    EXPECT_TRUE(sc::block_is_sound({}, 0));
    EXPECT_FALSE(sc::block_is_sound({}, 1));
}

TEST(BlockReader, RefusesAWrongCount) {
    const std::vector<Item> items{PathPoint{1, 2, 3}, PathPoint{4, 6, 8}, sc::PathEnd{}};
    const Buffer bytes = encode(items);
    EXPECT_TRUE(sc::block_is_sound(bytes, 3));
    EXPECT_FALSE(sc::block_is_sound(bytes, 2));
    EXPECT_FALSE(sc::block_is_sound(bytes, 4));
    EXPECT_FALSE(sc::block_is_sound(encode({PathPoint{}, PathPoint{}}), 1)) << "ends within a run of points";
}

TEST(BlockReader, RefusesEveryCutOfABlock) {
    const Buffer bytes = encode({some_begin(), PathPoint{1, 2, 3}, PathPoint{400'000, 6, 8}, sc::Turn{5}});
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_FALSE(sc::block_is_sound(std::span(bytes).first(size), 4)) << size;
    }
}

TEST(BlockReader, RefusesMalformedSegments) {
    const Buffer point{1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    const auto with = [&point](std::initializer_list<std::uint8_t> tail) {
        Buffer bytes = point;
        bytes.insert(bytes.end(), tail);
        return bytes;
    };
    EXPECT_TRUE(sc::block_is_sound(with({0, 0, 0}), 2));
    EXPECT_FALSE(sc::block_is_sound(with({0, 0, 0, 0}), 2)) << "a byte left over";
    EXPECT_FALSE(sc::block_is_sound(with({0x80, 0x00, 0, 0}), 2)) << "a varint not of minimal length";
    EXPECT_FALSE(sc::block_is_sound(with({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01, 0, 0}), 2)) << "six groups";
    EXPECT_FALSE(sc::block_is_sound(with({0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 0, 0}), 2)) << "leaves 32 bits";
    EXPECT_FALSE(sc::block_is_sound(Buffer{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 0)) << "an empty run";
    EXPECT_FALSE(sc::block_is_sound(Buffer{0}, 1));
    EXPECT_FALSE(sc::block_is_sound(Buffer{7}, 1));
    Buffer begin = encode({some_begin()});
    begin[5] = 3;
    EXPECT_FALSE(sc::block_is_sound(begin, 1)) << "an unknown actuator";
}

TEST(BlockReader, RefusesACoordinateJustOutside32Bits) {
    Buffer bytes = encode({PathPoint{kMax, 0, 0}, PathPoint{kMax, 0, 0}});
    bytes[14] = 1;
    EXPECT_TRUE(sc::block_is_sound(bytes, 2)) << "one less";
    bytes[14] = 2;
    EXPECT_FALSE(sc::block_is_sound(bytes, 2)) << "one more";
}

std::vector<Item> dense_line() {
    std::ifstream file(SC_TEST_DATA "/motion/a_dense.csv");
    std::string line;
    std::getline(file, line);
    std::vector<Item> items;
    while (std::getline(file, line)) {
        std::istringstream row(line);
        std::array<double, 3> mm{};
        char comma = 0;
        row >> mm[0] >> comma >> mm[1] >> comma >> mm[2];
        const auto wire = [](double v) {
            return static_cast<std::int32_t>(std::lround(v * sc::kWireUnitsPerMetre / 1e3));
        };
        items.emplace_back(PathPoint{wire(mm[0]), wire(mm[1]), wire(mm[2])});
    }
    return items;
}

TEST(Block, ADenseLineCostsAtMostSixBytesAPoint) {
    const std::vector<Item> items = dense_line();
    ASSERT_EQ(items.size(), 20'000U);
    std::size_t bytes = 0;
    std::size_t blocks = 0;
    std::vector<Item> back;
    for (std::size_t done = 0; done < items.size(); ++blocks) {
        Buffer block(224);
        const sc::BlockSize size = sc::encode_block(std::span(items).subspan(done), block);
        ASSERT_GT(size.items, 0U);
        block.resize(size.bytes);
        const auto part = decode(block, size.items);
        ASSERT_TRUE(part.has_value());
        back.insert(back.end(), part->begin(), part->end());
        done += size.items;
        bytes += size.bytes;
    }
    EXPECT_EQ(back, items);
    // A block's message: 7 bytes around it, 10 of its own, 2 of COBS.
    const double payload = static_cast<double>(bytes) / static_cast<double>(items.size());
    const double on_the_wire = static_cast<double>(bytes + blocks * 19) / static_cast<double>(items.size());
    std::cout << "bytes per point: " << payload << " in blocks, " << on_the_wire << " on a serial line\n";
    EXPECT_LE(on_the_wire, 6.0);
    EXPECT_GE(payload, 3.0) << "three varints cannot take less";
}

}  // namespace
