// SPDX-License-Identifier: Apache-2.0
#include "shared/trace/trace.hpp"

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace sc::trace;  // NOLINT(google-build-using-namespace): the subject of this file

/// The bytes of integers of the given widths, by shifting only: an independent writing of the layout.
struct Field {
    std::int64_t value;
    int bytes;
};
std::vector<std::uint8_t> layout(std::initializer_list<Field> fields) {
    std::vector<std::uint8_t> out;
    for (const Field& field : fields) {
        for (int i = 0; i < field.bytes; ++i) {
            out.push_back(static_cast<std::uint8_t>((static_cast<std::uint64_t>(field.value) >> (8 * i)) & 0xFFU));
        }
    }
    return out;
}
template <std::size_t N>
std::vector<std::uint8_t> vector_of(const std::array<std::uint8_t, N>& bytes) {
    return {bytes.begin(), bytes.end()};
}

constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();

TEST(PulseRecord, HasThisLayout) {
    const PulseRecord record{0x0102030405060708, {1, -2, kMin}, {kMax, 5, -6}, -7, 90'000'000'000, 0xDEADBEEFU, 1};
    std::array<std::uint8_t, kPulseRecordSize> bytes{};
    pack(record, bytes);
    EXPECT_EQ(vector_of(bytes), layout({{0x0102030405060708, 8},
                                        {1, 8},
                                        {-2, 8},
                                        {kMin, 8},
                                        {kMax, 8},
                                        {5, 8},
                                        {-6, 8},
                                        {-7, 8},
                                        {90'000'000'000, 8},
                                        {0xDEADBEEF, 4},
                                        {1, 1}}));
    EXPECT_EQ(bytes.front(), 0x08);
}

TEST(PulseRecord, ComesBackAsItWas) {
    const PulseRecord record{-1, {1, 2, 3}, {-4, kMax, kMin}, 7, -8, 9, 1};
    std::array<std::uint8_t, kPulseRecordSize> bytes{};
    pack(record, bytes);
    const PulseRecord back = unpack_pulse(bytes);
    EXPECT_EQ(back.t_ns, record.t_ns);
    EXPECT_EQ(back.place_pm, record.place_pm);
    EXPECT_EQ(back.table_pm, record.table_pm);
    EXPECT_EQ(back.defocus_pm, record.defocus_pm);
    EXPECT_EQ(back.c_ndeg, record.c_ndeg);
    EXPECT_EQ(back.energy_nj, record.energy_nj);
    EXPECT_EQ(back.hit, record.hit);
}

TEST(SampleRecord, HasThisLayout) {
    const SampleRecord record{3, {10, -20, 30, -40}, {11, -21, 31, kMin}, 9, 1, 100};
    std::array<std::uint8_t, kSampleRecordSize> bytes{};
    pack(record, bytes);
    EXPECT_EQ(vector_of(bytes), layout({{3, 8},
                                        {10, 8},
                                        {-20, 8},
                                        {30, 8},
                                        {-40, 8},
                                        {11, 8},
                                        {-21, 8},
                                        {31, 8},
                                        {kMin, 8},
                                        {9, 1},
                                        {1, 1},
                                        {100, 2}}));
}

TEST(SampleRecord, ComesBackAsItWas) {
    const SampleRecord record{kMax, {1, 2, 3, 4}, {-1, -2, -3, kMin}, 14, 1, 0xFFFF};
    std::array<std::uint8_t, kSampleRecordSize> bytes{};
    pack(record, bytes);
    const SampleRecord back = unpack_sample(bytes);
    EXPECT_EQ(back.tick, record.tick);
    EXPECT_EQ(back.set_point, record.set_point);
    EXPECT_EQ(back.actual, record.actual);
    EXPECT_EQ(back.state, record.state);
    EXPECT_EQ(back.gate, record.gate);
    EXPECT_EQ(back.galvo_frames, record.galvo_frames);
}

TEST(GalvoSample, HasThisLayoutAndComesBack) {
    const GalvoSample record{-123'456'789'012, 5};
    std::array<std::uint8_t, kGalvoSampleSize> bytes{};
    pack(record, bytes);
    EXPECT_EQ(vector_of(bytes), layout({{-123'456'789'012, 8}, {5, 8}}));
    EXPECT_EQ(unpack_galvo(bytes).x_pm, record.x_pm);
    EXPECT_EQ(unpack_galvo(bytes).z_pm, record.z_pm);
}

TEST(CommandRecord, HasThisLayout) {
    const CommandRecord record{0x01020304, 5, 6, -7, {8, -9, 10}, 255, 1'000'000};
    std::array<std::uint8_t, kCommandRecordSize> bytes{};
    pack(record, bytes);
    EXPECT_EQ(vector_of(bytes),
              layout({{0x01020304, 4}, {5, 1}, {6, 4}, {-7, 8}, {8, 8}, {-9, 8}, {10, 8}, {255, 1}, {1'000'000, 8}}));
}

}  // namespace
