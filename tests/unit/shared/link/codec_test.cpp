// SPDX-License-Identifier: Apache-2.0
#include "shared/link/codec.hpp"

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/link/blocks.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file
using Buffer = std::vector<std::uint8_t>;

template <class Message>
Buffer encoded(const Message& message, std::uint16_t counter = 0) {
    Buffer out(kMessageCapacity);
    out.resize(encode_message(message, counter, out));
    return out;
}

TEST(Codec, AMessageHasThisLayout) {
    const Command command{0x01020304, 11, 3, -2, 0x7F};
    const Buffer bytes = encoded(command, 0xABCD);
    const Buffer expected{3, 0xCD, 0xAB, 4, 3, 2, 1, 11, 3, 0, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF, 0x7F, 0, 0, 0};
    ASSERT_EQ(bytes.size(), expected.size() + 4);
    EXPECT_EQ(Buffer(bytes.begin(), bytes.end() - 4), expected);
    // The checksum, made by hand: the schema's hash first, then the bytes.
    Buffer covered;
    for (int i = 0; i < 8; ++i) {
        covered.push_back(static_cast<std::uint8_t>((kSchemaHash >> (8 * i)) & 0xFFU));
    }
    covered.insert(covered.end(), expected.begin(), expected.end());
    const std::uint32_t crc = sc::crc32(covered);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(bytes[expected.size() + i], (crc >> (8 * i)) & 0xFFU);
    }
}

TEST(Codec, BytesOfAnotherSchemaFailTheCheck) {
    Buffer bytes = encoded(Heartbeat{5});
    bytes.resize(bytes.size() - 4);
    Buffer covered;
    for (int i = 0; i < 8; ++i) {
        covered.push_back(static_cast<std::uint8_t>(((kSchemaHash + 1) >> (8 * i)) & 0xFFU));
    }
    covered.insert(covered.end(), bytes.begin(), bytes.end());
    const std::uint32_t crc = sc::crc32(covered);
    for (int i = 0; i < 4; ++i) {
        bytes.push_back(static_cast<std::uint8_t>((crc >> (8 * i)) & 0xFFU));
    }
    EXPECT_FALSE(open_message(bytes).has_value());
    EXPECT_TRUE(open_message(encoded(Heartbeat{5})).has_value());
}

TEST(Codec, HelloCanBeReadWhateverTheSchema) {
    // The handshake's data id is a constant of the protocol: if this value changes, old and new cannot even refuse.
    EXPECT_EQ(sc::fnv1a64("scribecell handshake"), 0xA13CC3E8F33FAB2EULL);
    Hello hello;
    hello.schema = 1;
    const Buffer bytes = encoded(hello);
    const auto envelope = open_message(bytes);
    ASSERT_TRUE(envelope.has_value());
    Hello back;
    EXPECT_TRUE(decode_payload(envelope->payload, back));
    EXPECT_EQ(back.schema, 1U);
}

TEST(Codec, RefusesShortAndLongPayloads) {
    const Buffer bytes = encoded(JobOpen{1, 2, 3});
    const auto envelope = open_message(bytes);
    ASSERT_TRUE(envelope.has_value());
    JobOpen out;
    EXPECT_TRUE(decode_payload(envelope->payload, out));
    EXPECT_FALSE(decode_payload(envelope->payload.first(envelope->payload.size() - 1), out));
    Buffer longer(envelope->payload.begin(), envelope->payload.end());
    longer.push_back(0);
    EXPECT_FALSE(decode_payload(longer, out));
    EXPECT_FALSE(decode_payload({}, out));
}

TEST(Codec, RefusesARunOfBytesThatClaimsMoreThanItHolds) {
    ConfigChunk chunk;
    chunk.data.size = 225;
    Buffer out(kMessageCapacity);
    EXPECT_EQ(encode_message(chunk, 0, out), 0U);
    const Buffer payload{0, 0, 4, 1, 2, 3};
    EXPECT_FALSE(decode_payload(payload, chunk));
    Buffer huge(3 + 225, 0);
    huge[2] = 225;
    EXPECT_FALSE(decode_payload(huge, chunk));
}

TEST(Codec, WritesNothingPastAShortSpan) {
    const std::size_t needed = encoded(Status{}).size();
    for (std::size_t room = 0; room < needed; ++room) {
        Buffer out(room + 1, 0xAA);
        EXPECT_EQ(encode_message(Status{}, 0, std::span(out).first(room)), 0U);
        EXPECT_EQ(out[room], 0xAA);
    }
}

TEST(Codec, RefusesEveryCutMessage) {
    const Buffer bytes = encoded(StreamAck{1, 2, 3, 4, 5, 6, 7, 8});
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_FALSE(open_message(std::span(bytes).first(size)).has_value()) << size;
    }
}

TEST(Codec, DispatchTellsUnknownFromMalformed) {
    int handled = 0;
    const auto count = [&handled](const auto& /*message*/) { ++handled; };
    const Buffer payload(8, 0);
    EXPECT_EQ(dispatch(HostMessages{}, Envelope{Heartbeat::kId, 0, payload}, count), Dispatch::handled);
    EXPECT_EQ(dispatch(HostMessages{}, Envelope{Command::kId, 0, payload}, count), Dispatch::malformed);
    EXPECT_EQ(dispatch(HostMessages{}, Envelope{Status::kId, 0, payload}, count), Dispatch::unknown_id);
    EXPECT_EQ(dispatch(CellMessages{}, Envelope{0, 0, payload}, count), Dispatch::unknown_id);
    EXPECT_EQ(handled, 1);
}

TEST(Codec, BlocksCarryItems) {
    const std::vector<sc::Item> items{sc::Turn{5}, sc::PathBegin{}, sc::PathPoint{1, 2, 3}, sc::PathEnd{}};
    const Block block = make_block(0x1122334455667788ULL, items, 1);
    EXPECT_EQ(block.job_low, 0x55667788U);
    EXPECT_EQ(block.first, 1U);
    EXPECT_EQ(block.count, 3U);
    sc::BlockReader reader = read_block(block);
    for (std::size_t i = 1; i < items.size(); ++i) {
        sc::Item item;
        ASSERT_TRUE(reader.next(item).value_or(false));
        EXPECT_EQ(item, items[i]);
    }
    sc::Item item;
    EXPECT_EQ(reader.next(item), false);
}

TEST(Schema, EveryNumberAndNameIsUsedOnce) {
    std::set<unsigned> ids;
    std::set<std::string> names;
    const auto note = [&](const auto& m) {
        ids.insert(m.kId);
        names.insert(std::string(m.kName));
    };
    for_each_message(HostMessages{}, note);
    for_each_message(CellMessages{}, note);
    EXPECT_EQ(ids.size(), HostMessages::size + CellMessages::size);
    EXPECT_EQ(names.size(), ids.size());
    for (const unsigned id : ids) {
        EXPECT_NE(id, 0U);
    }
}

struct FieldA {
    static constexpr std::uint8_t kId = 9;
    static constexpr std::string_view kName = "m";
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& /*m*/) {
        v("a", std::uint16_t{0});
    }
};
struct FieldB {
    static constexpr std::uint8_t kId = 9;
    static constexpr std::string_view kName = "m";
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& /*m*/) {
        v("b", std::uint16_t{0});
    }
};
struct FieldWide {
    static constexpr std::uint8_t kId = 9;
    static constexpr std::string_view kName = "m";
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& /*m*/) {
        v("a", std::uint32_t{0});
    }
};
struct FieldArray {
    static constexpr std::uint8_t kId = 9;
    static constexpr std::string_view kName = "m";
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& /*m*/) {
        v("a", std::array<std::uint16_t, 2>{});
    }
};
struct OtherId : FieldA {
    static constexpr std::uint8_t kId = 10;
};
struct OtherName : FieldA {
    static constexpr std::string_view kName = "n";
};
template <class Message>
std::uint64_t hash_of() {
    schema_detail::Hasher hasher;
    hasher.message(Message{});
    return hasher.hash.value();
}

TEST(Schema, HashSeesNumberNameFieldNameAndFieldType) {
    const std::set<std::uint64_t> hashes{hash_of<FieldA>(),     hash_of<FieldB>(),  hash_of<FieldWide>(),
                                         hash_of<FieldArray>(), hash_of<OtherId>(), hash_of<OtherName>()};
    EXPECT_EQ(hashes.size(), 6U);
}

TEST(Schema, HashIsAConstant) {
    static_assert(kSchemaHash == schema_hash());
    static_assert(kSchemaHashes[0] == 0x51d7'1a83'279a'0873ULL && kSchemaHashes[1] == 0xbfd3'e071'dc89'3732ULL,
                  "older minor versions must still be talked to");
    EXPECT_NE(kSchemaHash, 0U);
}

}  // namespace
