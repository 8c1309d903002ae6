// SPDX-License-Identifier: Apache-2.0
#include "shared/crypto/cmac.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "shared/crypto/key_text.hpp"

namespace {

using namespace sc::crypto;  // NOLINT(google-build-using-namespace): the subject of this file
using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(std::string_view hex) {
    Bytes bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
        bytes.push_back(static_cast<std::uint8_t>(16 * *hex_digit(hex[i]) + *hex_digit(hex[i + 1])));
    }
    return bytes;
}
Block block_of(std::string_view hex) {
    Block block{};
    const Bytes bytes = bytes_of(hex);
    std::copy_n(bytes.begin(), block.size(), block.begin());
    return block;
}
Block encrypted(const char* key, const char* plain) {
    Block block = block_of(plain);
    Aes128(block_of(key)).encrypt(block);
    return block;
}

TEST(Aes128, EncryptsTheExamplesOfFips197) {
    EXPECT_EQ(encrypted("2b7e151628aed2a6abf7158809cf4f3c", "3243f6a8885a308d313198a2e0370734"),
              block_of("3925841d02dc09fbdc118597196a0b32"));  // appendix B
    EXPECT_EQ(encrypted("000102030405060708090a0b0c0d0e0f", "00112233445566778899aabbccddeeff"),
              block_of("69c4e0d86a7b0430d8cdb78070b4c55a"));  // appendix C.1
}

TEST(Cmac, GivesTheTagsOfRfc4493) {
    const CmacKey key(block_of("2b7e151628aed2a6abf7158809cf4f3c"));
    const Bytes message = bytes_of(
        "6bc1bee22e409f96e93d7e117393172aae2d8a571e03ac9c9eb76fac45af8e5130c81c46a35ce411e5fbc1191a0a52ef"
        "f69f2445df4f9b17ad2b417be66c3710");
    const std::span<const std::uint8_t> all(message);
    EXPECT_EQ(cmac(key, {}), block_of("bb1d6929e95937287fa37d129b756746"));
    EXPECT_EQ(cmac(key, all.first(16)), block_of("070a16b46b4d4144f79bdd9dd04a287c"));
    EXPECT_EQ(cmac(key, all.first(40)), block_of("dfa66747de9ae63030ca32611497c827"));
    EXPECT_EQ(cmac(key, all), block_of("51f0bebf7e3b9d92fc49741779363cfe"));
}

TEST(Cmac, AgreesWithOpenSslForMessagesOfAnyLength) {
    std::ifstream file(SC_SOURCE_DIR "/tests/data/cmac/vectors.txt");
    std::string key;
    std::string message;
    std::string tag;
    std::getline(file, key);
    std::size_t count = 0;
    while (file >> key >> message >> tag) {
        EXPECT_EQ(cmac(CmacKey(block_of(key)), bytes_of(message == "-" ? "" : message)), block_of(tag)) << message;
        ++count;
    }
    EXPECT_EQ(count, 73U);
}

TEST(Cmac, TakesAsManyStepsAsBlocks) {
    const CmacKey key(block_of("000102030405060708090a0b0c0d0e0f"));
    for (std::size_t size = 0; size < 80; ++size) {
        const Bytes message(size, 0x5A);
        CmacRun run;
        run.begin();
        std::size_t steps = 1;
        while (!run.step(key, message)) {
            ++steps;
        }
        EXPECT_EQ(steps, cmac_blocks(size)) << size;
        EXPECT_EQ(run.tag(), cmac(key, message)) << size;
    }
}

TEST(Cmac, ATagIsTheSameOnlyWhole) {
    const Block tag = block_of("070a16b46b4d4144f79bdd9dd04a287c");
    EXPECT_TRUE(same_tag(std::span(tag).first(8), tag));
    EXPECT_TRUE(same_tag(tag, tag));
    EXPECT_FALSE(same_tag({}, tag)) << "no tag is no tag";
    for (std::size_t bit = 0; bit < 64; ++bit) {
        Block other = tag;
        other[bit / 8] = static_cast<std::uint8_t>(other[bit / 8] ^ (1U << (bit % 8)));
        EXPECT_FALSE(same_tag(std::span(other).first(8), tag)) << bit;
    }
}

TEST(KeyText, TakesThirtyTwoHexDigitsAndNothingElse) {
    const auto key = key_from_text("000102030405060708090a0B0c0D0e0f");
    ASSERT_TRUE(key);
    EXPECT_EQ((*key)[11], 0x0B);
    EXPECT_FALSE(key_from_text("000102030405060708090a0b0c0d0e0"));
    EXPECT_FALSE(key_from_text("000102030405060708090a0b0c0d0e0f0"));
    EXPECT_FALSE(key_from_text("000102030405060708090a0b0c0d0e0g"));
    EXPECT_FALSE(key_from_text(" 00102030405060708090a0b0c0d0e0f "));
    EXPECT_FALSE(key_from_text(""));
}

}  // namespace
