// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_objects.hpp"

#include <array>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

using Bytes = std::array<std::uint8_t, 8>;

Bytes request(std::uint8_t command, std::uint16_t index, std::uint8_t sub, std::uint32_t value = 0) {
    return {command,
            static_cast<std::uint8_t>(index),
            static_cast<std::uint8_t>(index >> 8U),
            sub,
            static_cast<std::uint8_t>(value),
            static_cast<std::uint8_t>(value >> 8U),
            static_cast<std::uint8_t>(value >> 16U),
            static_cast<std::uint8_t>(value >> 24U)};
}
std::uint32_t value_of(const Bytes& b) {
    return b[4] | (std::uint32_t{b[5]} << 8U) | (std::uint32_t{b[6]} << 16U) | (std::uint32_t{b[7]} << 24U);
}
/// 0 if it was written, else the abort code.
std::uint32_t write(ObjectDictionary& objects, std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
    const auto unused = static_cast<unsigned>(4 - objects.size_of(index, sub));
    const Bytes reply = objects.serve(request(static_cast<std::uint8_t>(0x23U | (unused << 2U)), index, sub, value));
    return reply[0] == 0x60 ? 0 : value_of(reply);
}

TEST(ObjectDictionary, ReadsWithTheSizeOfTheObject) {
    ObjectDictionary objects(3);
    const Bytes mode = objects.serve(request(0x40, 0x6098, 0));
    EXPECT_EQ(mode[0], 0x4F);
    const Bytes type = objects.serve(request(0x40, 0x1000, 0));
    EXPECT_EQ(type[0], 0x43);
    EXPECT_EQ(value_of(type) & 0xFFFF, 402U);
    EXPECT_EQ(objects.serve(request(0x40, 0x1017, 0))[0], 0x4B);
}

TEST(ObjectDictionary, WritesAndReadsBack) {
    ObjectDictionary objects(1);
    EXPECT_EQ(write(objects, 0x607C, 0, 0xFFFFFFF0), 0U);
    EXPECT_EQ(objects.get(0x607C), 0xFFFFFFF0U);
}

TEST(ObjectDictionary, AbortsSayWhy) {
    ObjectDictionary objects(1);
    EXPECT_EQ(value_of(objects.serve(request(0x40, 0x5555, 0))), 0x06020000U);
    EXPECT_EQ(value_of(objects.serve(request(0x40, 0x6099, 9))), 0x06090011U);
    EXPECT_EQ(value_of(objects.serve(request(0x23, 0x6060, 0, 8))), 0x06070010U);
    EXPECT_EQ(value_of(objects.serve(request(0x21, 0x607C, 0, 8))), 0x05040001U) << "segmented";
    EXPECT_EQ(write(objects, 0x6041, 0, 0), 0x06010002U);
    EXPECT_EQ(write(objects, 0x6060, 0, 1), 0x06090030U);
    EXPECT_EQ(write(objects, 0x6098, 0, 3), 0x06090030U);
    EXPECT_EQ(write(objects, 0x60C2, 1, 0), 0x06090030U);
    EXPECT_EQ(write(objects, 0x605A, 0, 6), 0x06090030U);
}

TEST(ObjectDictionary, MappingChangesOnlyWhileThePdoIsOffAndEmpty) {
    ObjectDictionary objects(1);
    EXPECT_EQ(write(objects, 0x1600, 1, 0x60400010), 0U) << "off after power-up";
    EXPECT_EQ(write(objects, 0x1600, 0, 1), 0U);
    EXPECT_EQ(write(objects, 0x1600, 1, 0x607A0020), 0x08000022U) << "not empty";
    EXPECT_EQ(write(objects, 0x1400, 1, 0x201), 0U);
    EXPECT_EQ(write(objects, 0x1600, 0, 0), 0x08000022U) << "on";
    EXPECT_EQ(write(objects, 0x1400, 1, 0x301), 0x06090030U) << "identifier changes while on";
    EXPECT_EQ(write(objects, 0x1400, 1, 0x80000301), 0U);
    EXPECT_EQ(write(objects, 0x1600, 0, 0), 0U);
    EXPECT_EQ(write(objects, 0x1600, 1, 0x55550020), 0x06040041U);
    EXPECT_EQ(write(objects, 0x1600, 1, 0x60400020), 0x06040041U) << "wrong length";
    EXPECT_EQ(write(objects, 0x1600, 0, 5), 0x06040042U);
}

TEST(ObjectDictionary, MappingMustFitAFrame) {
    ObjectDictionary objects(1);
    for (std::uint8_t sub = 1; sub <= 3; ++sub) {
        EXPECT_EQ(write(objects, 0x1A00, sub, 0x60640020), 0U);
    }
    EXPECT_EQ(write(objects, 0x1A00, 0, 3), 0x06040042U);
    EXPECT_EQ(write(objects, 0x1A00, 0, 2), 0U);
}

}  // namespace
}  // namespace sc::sim
