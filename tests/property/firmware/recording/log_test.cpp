// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/firmware/recording/log_support.hpp"

namespace sc::recording {
namespace {

constexpr std::uint32_t kSeed = 20260101;

class RandomCell {
public:
    explicit RandomCell(std::uint32_t seed) : random_(seed), ids_(1 + below(90)), busy_(1 + below(8)) {}

    std::vector<FedTick> ticks(std::size_t count) {
        std::vector<FedTick> ticks;
        std::int64_t tick = static_cast<std::int64_t>(random_());
        for (std::size_t i = 0; i < count; ++i) {
            tick += below(50) == 0 ? 1 + below(1000) : 1;
            ticks.push_back(next(tick, ticks.empty() ? nullptr : &ticks.back()));
        }
        return ticks;
    }

private:
    unsigned below(unsigned limit) { return static_cast<unsigned>(random_() % limit); }
    std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }

    DriveFrame frame() {
        DriveFrame frame;
        frame.id = static_cast<std::uint16_t>(below(20) == 0 ? random_() : 0x180 + below(ids_));
        frame.size = static_cast<std::uint8_t>(below(30) == 0 ? below(256) : 6 + below(2));
        for (std::uint8_t& value : frame.data) {
            value = below(4) == 0 ? byte() : std::uint8_t{0};
        }
        return frame;
    }

    FedTick next(std::int64_t tick, const FedTick* last) {
        FedTick t;
        t.tick = tick;
        if (below(busy_) == 0) {
            t.link.resize(below(20) == 0 ? kLinkBytesPerTick : below(200));
            std::ranges::generate(t.link, [this] { return byte(); });
        }
        if (last != nullptr && below(3) == 0) {
            t.drives = last->drives;
        } else if (below(busy_) == 0) {
            t.drives.resize(below(kDriveFramesPerTick + 1));
            std::ranges::generate(t.drives, [this] { return frame(); });
        }
        t.digital = {below(9) != 0, below(9) != 0, below(9) != 0,
                     below(9) != 0, below(9) != 0, below(9) != 0,
                     below(9) != 0, below(9) != 0, static_cast<std::uint8_t>(below(16))};
        if (below(busy_) == 0) {
            t.source.resize(below(kSourceBytesPerTick + 1));
            std::ranges::generate(t.source, [this] { return byte(); });
        }
        if (below(busy_) == 0) {
            t.encoders = {true, static_cast<std::int32_t>(below(1'000'000)), {}};
            for (std::int64_t& counts : t.encoders.counts) {
                counts = static_cast<std::int64_t>(random_());
            }
        }
        for (std::vector<SensorByte>& bus : t.sensors) {
            if (below(busy_) == 0) {
                bus.resize(below(kSensorBytesPerTick + 1));
                const bool flags = below(3) == 0;
                std::ranges::generate(bus, [this, flags] {
                    SensorByte heard;
                    heard.data = byte();
                    heard.flags = flags ? byte() : std::uint8_t{0};
                    heard.age_us = static_cast<std::uint16_t>(random_());
                    return heard;
                });
            }
        }
        t.galvo_status = static_cast<std::uint16_t>(below(5) == 0 ? random_() : kGalvoStatusOk);
        t.guard_causes = below(5) == 0 ? byte() : std::uint8_t{0};
        t.digest.crc = static_cast<std::uint32_t>(random_());
        for (std::uint8_t& check : t.digest.check) {
            check = below(2) == 0 ? byte() : std::uint8_t{0};
        }
        t.digest.state = byte();
        t.digest.faults = below(4) == 0 ? random_() : 0;
        return t;
    }

    std::mt19937_64 random_;
    unsigned ids_;
    unsigned busy_;
};

class LogOfRandomInputs : public testing::TestWithParam<std::uint32_t> {};

TEST_P(LogOfRandomInputs, ComesBackAsItWas) {
    const std::vector<FedTick> ticks = RandomCell(kSeed + GetParam()).ticks(1500);
    const ReadLog back = read(log_of(ticks));
    EXPECT_EQ(back.end, LogEnd::closed);
    ASSERT_EQ(back.ticks.size(), ticks.size());
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        ASSERT_EQ(back.ticks[i], ticks[i]) << i;
    }
}

TEST_P(LogOfRandomInputs, CutOrChangedGivesNoOtherTickThanWasWritten) {
    std::mt19937_64 random(kSeed + 1000 + GetParam());
    const std::vector<FedTick> ticks = RandomCell(kSeed + GetParam()).ticks(300);
    const std::vector<std::uint8_t> log = log_of(ticks);
    for (int i = 0; i < 20; ++i) {
        const ReadLog cut = read(std::span(log).first(random() % log.size()));
        EXPECT_TRUE(cut.end == LogEnd::torn || cut.end == LogEnd::not_a_log);
        EXPECT_TRUE(is_prefix(cut.ticks, ticks));
        std::vector<std::uint8_t> changed = log;
        const std::size_t at = random() % log.size();
        const std::size_t length = std::min<std::size_t>(1 + random() % 4, log.size() - at);
        for (std::size_t k = 0; k < length; ++k) {
            changed[at + k] = static_cast<std::uint8_t>(changed[at + k] ^ (1 + random() % 255));
        }
        const ReadLog other = read(changed);
        EXPECT_FALSE(readable(other.end)) << at;
        EXPECT_TRUE(is_prefix(other.ticks, ticks));
    }
}

TEST_P(LogOfRandomInputs, GarbageBehindRightChecksumsIsBounded) {
    std::mt19937_64 random(kSeed + 2000 + GetParam());
    std::vector<std::uint8_t> log = log_of(RandomCell(kSeed + GetParam()).ticks(200));
    const std::vector<std::size_t> starts = chunk_starts(log);
    for (int i = 0; i < 20; ++i) {
        const std::size_t at = starts[1] + kChunkHeadSize + random() % (starts[2] - starts[1] - kChunkHeadSize);
        log[at] = static_cast<std::uint8_t>(random());
        reseal(std::span(log).subspan(starts[1], starts[2] - starts[1]));
        EXPECT_LE(read(log).ticks.size(), 200U);
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, LogOfRandomInputs, testing::Range(0U, 25U));

}  // namespace
}  // namespace sc::recording
