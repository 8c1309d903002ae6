// SPDX-License-Identifier: Apache-2.0
#include "shared/hash/sha256.hpp"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace {

std::string hex_of(std::string_view text) {
    const std::vector<std::uint8_t> data(text.begin(), text.end());
    const auto hex = sc::to_hex(sc::Sha256{}.update(data).digest());
    return {hex.begin(), hex.end()};
}

TEST(Sha256, GivesThePublishedDigests) {
    EXPECT_EQ(hex_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hex_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hex_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, OfAMillionA) {
    EXPECT_EQ(hex_of(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, IsTheSameInStepsAroundTheChunkSize) {
    const std::string text(200, 'x');
    const std::vector<std::uint8_t> data(text.begin(), text.end());
    for (std::size_t length = 0; length <= data.size(); ++length) {
        const auto whole = sc::Sha256{}.update(std::span(data).first(length)).digest();
        sc::Sha256 steps;
        for (std::size_t i = 0; i < length; ++i) {
            steps.update(std::span(data).subspan(i, 1));
        }
        EXPECT_EQ(steps.digest(), whole) << length;
    }
}

TEST(Sha256, GoesOnAfterADigest) {
    const std::vector<std::uint8_t> ab{'a', 'b'};
    const std::vector<std::uint8_t> c{'c'};
    sc::Sha256 hash;
    hash.update(ab);
    const auto early = hash.digest();
    EXPECT_EQ(hash.digest(), early);
    const auto hex = sc::to_hex(hash.update(c).digest());
    EXPECT_EQ(std::string(hex.begin(), hex.end()), hex_of("abc"));
}

}  // namespace
