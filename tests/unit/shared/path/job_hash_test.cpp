// SPDX-License-Identifier: Apache-2.0
#include "shared/path/job_hash.hpp"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "shared/path/block.hpp"

namespace {

using sc::Item;

std::vector<Item> some_job() {
    return {sc::Turn{-9'000'000},   sc::PathBegin{.path = 4, .speed_um_s = 50'000},
            sc::PathPoint{1, 2, 3}, sc::PathPoint{4, 5, 6},
            sc::PathEnd{},          sc::JobEnd{}};
}

TEST(JobHash, IsFnvOverTheWordsOfTheItems) {
    const std::vector<Item> items{sc::Turn{-2}, sc::PathPoint{1, 2, 3}};
    std::uint64_t hash = 0xCBF29CE484222325U;
    for (const std::uint32_t word : {4U, 0xFFFFFFFEU, 1U, 1U, 2U, 3U}) {
        hash = (hash ^ word) * 0x100000001B3U;
    }
    EXPECT_EQ(sc::job_hash(items), hash);
}

TEST(JobHash, DoesNotDependOnHowTheItemsAreCutIntoBlocks) {
    const std::vector<Item> items = some_job();
    for (std::size_t room = sc::kLongestItem; room < 120; ++room) {
        sc::JobHasher hasher;
        for (std::size_t done = 0; done < items.size();) {
            std::vector<std::uint8_t> bytes(room);
            const sc::BlockSize size = sc::encode_block(std::span(items).subspan(done), bytes);
            ASSERT_GT(size.items, 0U);
            sc::BlockReader reader{std::span(bytes).first(size.bytes), size.items};
            Item item;
            while (reader.next(item).value_or(false)) {
                hasher.add(item);
            }
            done += size.items;
        }
        EXPECT_EQ(hasher.value(), sc::job_hash(items)) << room;
    }
}

TEST(JobHash, ChangesWithEveryFieldAndWithTheOrder) {
    const std::vector<Item> items = some_job();
    const std::uint64_t hash = sc::job_hash(items);
    std::vector<std::vector<Item>> others(9, items);
    others[0][0] = sc::Turn{-9'000'001};
    others[1][1] = sc::PathBegin{.path = 5, .speed_um_s = 50'000};
    others[2][1] = sc::PathBegin{.path = 4, .pass = 1, .speed_um_s = 50'000};
    others[3][1] = sc::PathBegin{.path = 4, .actuator = sc::Actuator::galvo, .speed_um_s = 50'000};
    others[4][1] = sc::PathBegin{.path = 4, .speed_um_s = 50'000, .anchor_z = 1};
    others[5][3] = sc::PathPoint{4, 5, 7};
    std::swap(others[6][2], others[6][3]);
    others[7].pop_back();
    others[8].emplace_back(sc::JobEnd{});
    for (const auto& other : others) {
        EXPECT_NE(sc::job_hash(other), hash);
    }
}

TEST(JobHash, ChangesWithLightAndStage) {
    const auto hash = [](const Item& item) { return sc::job_hash(std::vector<Item>{item}); };
    const std::vector<std::uint64_t> hashes{
        hash(sc::PathLight{false}),   hash(sc::PathLight{true}),    hash(sc::StageCurve{1}),
        hash(sc::StageCurve{2}),      hash(sc::StageKnot{1, 2, 3}), hash(sc::StageKnot{2, 2, 3}),
        hash(sc::StageKnot{1, 3, 3}), hash(sc::StageKnot{1, 2, 4}), hash(sc::PathPoint{1, 2, 3}),
        hash(sc::Look{1, 1, 2, 3}),   hash(sc::Look{2, 1, 2, 3}),   hash(sc::Look{1, 2, 2, 3}),
        hash(sc::Look{1, 1, 3, 3}),   hash(sc::Look{1, 1, 2, 4})};
    for (std::size_t i = 0; i < hashes.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_NE(hashes[i], hashes[k]) << i << " " << k;
        }
    }
}

TEST(JobHash, ChangesWithEachCoordinateOfAnArc) {
    const auto hash = [](const sc::PathArc& arc) { return sc::job_hash(std::vector<Item>{arc}); };
    const std::uint64_t plain = hash({});
    std::vector<std::uint64_t> others;
    for (const auto member : {&sc::PathPoint::x, &sc::PathPoint::y, &sc::PathPoint::z}) {
        sc::PathArc arc;
        arc.via.*member = 1;
        others.push_back(hash(arc));
        arc = {};
        arc.to.*member = 1;
        others.push_back(hash(arc));
    }
    for (std::size_t i = 0; i < others.size(); ++i) {
        EXPECT_NE(others[i], plain);
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_NE(others[i], others[k]);
        }
    }
}

TEST(JobHash, OfNoItemsIsTheStartOfFnv) { EXPECT_EQ(sc::job_hash({}), sc::fnv1a64("")); }

}  // namespace
