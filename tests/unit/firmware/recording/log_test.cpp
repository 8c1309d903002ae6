// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/unit/firmware/recording/log_support.hpp"

namespace sc::recording {
namespace {

TEST(Log, GivesBackEveryTickAndItsHead) {
    const std::vector<FedTick> ticks = plain_ticks(2500);
    const std::vector<std::uint8_t> log = log_of(ticks);
    const ReadLog back = read(log);
    EXPECT_EQ(back.end, LogEnd::closed);
    EXPECT_EQ(back.ticks, ticks);
    const LogReader reader(log);
    EXPECT_EQ(reader.header().boot_id, 7U);
    EXPECT_EQ(reader.header().plan_units, 160U);
    EXPECT_EQ(reader.header().build_id, plain_header().build_id);
    std::array<std::uint8_t, link::kConfigSize> written{};
    std::array<std::uint8_t, link::kConfigSize> found{};
    link::serialise(reference_machine(), written);
    link::serialise(reader.header().machine, found);
    EXPECT_EQ(written, found);
    EXPECT_EQ(chunk_starts(log).size(), 1U + 3U + 1U + 1U) << "head, three chunks of a second at most, end";
}

TEST(Log, UnchangedInputsCostTwoBytesBesidesTheDigest) {
    std::vector<FedTick> ticks(500);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        ticks[i].tick = static_cast<std::int64_t>(i);
        ticks[i].drives = {status_frame(1, 5), status_frame(2, 6), status_frame(3, 7), status_frame(4, 8)};
    }
    const std::size_t overhead = kLogHeadSize + kLogEndSize + kChunkHeadSize + kChunkTailSize;
    const std::size_t first = 60;
    constexpr std::size_t kDigest = 4 + 1;  // CRC-32 and the mask of the parts
    EXPECT_LE(log_of(ticks).size(), overhead + first + ticks.size() * (2 + kDigest));
}

TEST(Log, AChangeOfAnyBitIsFound) {
    const std::vector<FedTick> ticks = plain_ticks(40);
    std::vector<std::uint8_t> log = log_of(ticks);
    ASSERT_LT(log.size(), 2500U);
    for (std::size_t byte = 0; byte < log.size(); ++byte) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            log[byte] = static_cast<std::uint8_t>(log[byte] ^ (1U << bit));
            const ReadLog back = read(log);
            EXPECT_FALSE(readable(back.end)) << "byte " << byte << ", bit " << bit;
            EXPECT_TRUE(is_prefix(back.ticks, ticks));
            log[byte] = static_cast<std::uint8_t>(log[byte] ^ (1U << bit));
        }
    }
}

TEST(Log, CutAnywhereIsReadableUpToTheCutAndSaysSo) {
    const std::vector<FedTick> ticks = plain_ticks(1100);
    const std::vector<std::uint8_t> log = log_of(ticks);
    const std::vector<std::size_t> starts = chunk_starts(log);
    for (std::size_t size = 0; size < log.size(); size += size < 1000 ? 1 : 7) {
        const ReadLog back = read(std::span(log).first(size));
        EXPECT_EQ(back.end, size < kLogHeadSize ? LogEnd::not_a_log : LogEnd::torn) << size;
        EXPECT_TRUE(is_prefix(back.ticks, ticks));
        EXPECT_EQ(back.ticks.size(), size >= starts[3] ? 1100U : (size >= starts[2] ? 1000U : 0U)) << size;
    }
}

TEST(Log, EndsCleanlyAtItsLimit) {
    const std::vector<FedTick> ticks = plain_ticks(9000);
    const std::size_t whole = log_of(ticks).size();
    for (const std::uint64_t limit : {LogWriter::kLeastLimit, std::uint64_t{50'000}, std::uint64_t{whole - 1}}) {
        const std::vector<std::uint8_t> log = log_of(ticks, limit);
        EXPECT_LE(log.size(), limit);
        const ReadLog back = read(log);
        EXPECT_EQ(back.end, LogEnd::full);
        EXPECT_GE(back.ticks.size(), 1000U);
        EXPECT_LT(back.ticks.size(), ticks.size());
        EXPECT_TRUE(is_prefix(back.ticks, ticks));
    }
    EXPECT_EQ(read(log_of(ticks, whole)).end, LogEnd::closed);
}

TEST(Log, NothingIsAddedBehindTheEnd) {
    LogWriter writer;
    EXPECT_TRUE(writer.add(FedTick{}.inputs(), {}).empty()) << "not begun";
    (void)writer.begin(plain_header(), 100'000);
    EXPECT_TRUE(writer.add(FedTick{}.inputs(), {}).empty());
    EXPECT_FALSE(writer.flush().empty());
    EXPECT_FALSE(writer.close().empty());
    EXPECT_TRUE(writer.add(FedTick{}.inputs(), {}).empty());
    EXPECT_TRUE(writer.flush().empty());
    EXPECT_TRUE(writer.close().empty());
    EXPECT_EQ(writer.ticks(), 1U);
}

TEST(Log, MissingRepeatedAndSwappedChunksAreFound) {
    const std::vector<std::uint8_t> log = log_of(plain_ticks(2500));
    const std::vector<std::size_t> starts = chunk_starts(log);
    const auto piece = [&](std::size_t chunk) {
        return std::span(log).subspan(starts[chunk], starts[chunk + 1] - starts[chunk]);
    };
    const auto joined = [&](const std::vector<std::size_t>& chunks) {
        std::vector<std::uint8_t> other(kLogMagic.begin(), kLogMagic.end());
        for (const std::size_t chunk : chunks) {
            append(other, piece(chunk));
        }
        return other;
    };
    EXPECT_EQ(read(joined({0, 1, 2, 3, 4})).end, LogEnd::closed);
    EXPECT_EQ(read(joined({0, 1, 3, 4})).end, LogEnd::out_of_order);
    EXPECT_EQ(read(joined({0, 1, 1, 2, 3, 4})).end, LogEnd::out_of_order);
    EXPECT_EQ(read(joined({0, 2, 1, 3, 4})).end, LogEnd::out_of_order);
    EXPECT_EQ(read(joined({0, 1, 2, 3, 4, 4})).end, LogEnd::out_of_order);
    EXPECT_EQ(read(joined({0, 1, 2, 3})).end, LogEnd::torn);
    EXPECT_EQ(read(joined({1, 2, 3, 4})).end, LogEnd::out_of_order);
    std::vector<std::uint8_t> longer = log;
    longer.push_back(0);
    EXPECT_EQ(read(longer).end, LogEnd::out_of_order);
}

TEST(Log, SaysWhetherTheControllerHadAKeyAndWhichButNotTheKey) {
    LogHeader header = plain_header();
    header.sealed = true;
    header.key_check = 0x1234'5678;
    header.entropy.fill(0x5A);
    LogWriter writer;
    const auto begun = writer.begin(header, LogWriter::kLeastLimit);
    const std::vector<std::uint8_t> log(begun.begin(), begun.end());
    const LogReader reader(log);
    ASSERT_EQ(reader.end(), LogEnd::none);
    EXPECT_TRUE(reader.header().sealed);
    EXPECT_EQ(reader.header().key_check, 0x1234'5678U);
    EXPECT_EQ(reader.header().entropy, header.entropy);
}

TEST(Log, OtherVersionsAndMachinesAreRefused) {
    const std::vector<std::uint8_t> good = log_of(plain_ticks(3));
    const std::size_t payload = kLogMagic.size() + kChunkHeadSize;
    const auto with_byte = [&](std::size_t at, std::uint8_t value) {
        std::vector<std::uint8_t> log = good;
        log[at] = value;
        reseal(std::span(log).subspan(kLogMagic.size(), kLogHeadSize - kLogMagic.size()));
        return log;
    };
    EXPECT_EQ(read(with_byte(payload, kLogVersion)).end, LogEnd::closed) << "the resealing itself is right";
    const std::vector<std::uint8_t> newer = with_byte(payload, kLogVersion + 1);
    EXPECT_EQ(read(newer).end, LogEnd::other_version);
    EXPECT_EQ(LogReader(newer).version(), kLogVersion + 1);
    const std::size_t config = payload + kHeaderPayloadSize - link::kConfigSize;
    EXPECT_EQ(read(with_byte(config, 0x55)).end, LogEnd::bad_machine) << "version of the configuration";
    EXPECT_EQ(read(with_byte(config + 2 + 7, 0xFF)).end, LogEnd::bad_machine) << "the control period is negative";
    EXPECT_EQ(read(with_byte(payload + 2, 2)).end, LogEnd::malformed);
    EXPECT_EQ(read(std::vector<std::uint8_t>(5000, 0)).end, LogEnd::not_a_log);
}

TEST(Log, ContentThatMakesNoSenseIsRefusedThoughItsChecksumsAgree) {
    const std::vector<std::uint8_t> good = log_of(plain_ticks(40));
    const std::vector<std::size_t> starts = chunk_starts(good);
    const std::size_t first = starts[1] + kChunkHeadSize;
    std::size_t refused = 0;
    for (std::size_t at = first; at < starts[2] - kChunkTailSize; ++at) {
        std::vector<std::uint8_t> log = good;
        log[at] = 0xFF;
        reseal(std::span(log).subspan(starts[1], starts[2] - starts[1]));
        const ReadLog back = read(log);
        refused += back.end == LogEnd::malformed ? 1U : 0U;
        EXPECT_TRUE(back.end == LogEnd::malformed || back.ticks.size() == 40U) << at;
    }
    EXPECT_GT(refused, 40U) << "flags and counts, at least";
}

TEST(Log, InputsThatAreTooManyAreCountedAndLeftOut) {
    LogWriter writer;
    (void)writer.begin(plain_header(), 100'000);
    FedTick wide;
    wide.link.resize(kLinkBytesPerTick + 1);
    EXPECT_TRUE(writer.add(wide.inputs(), {}).empty());
    EXPECT_EQ(writer.refused(), 1U);
}

TEST(OutputsDigester, NamesThePartThatDiffers) {
    const auto digester = std::make_unique<OutputsDigester>();
    const auto outputs = std::make_unique<ServoOutputs>();
    outputs->pulses_size = 1;
    outputs->laser_size = 1;
    outputs->drive_tx_size = 1;
    outputs->link_tx_size = 1;
    const OutputsDigest before = digester->digest(*outputs);
    EXPECT_EQ(before, digester->digest(*outputs));
    const auto changed = [&](OutputPart part) {
        const OutputsDigest after = digester->digest(*outputs);
        EXPECT_NE(after.crc, before.crc);
        for (std::size_t i = 0; i < kOutputParts; ++i) {
            EXPECT_EQ(after.check[i] != before.check[i], i == static_cast<std::size_t>(part)) << i;
        }
    };
    outputs->link_tx[0] = 1;
    changed(OutputPart::link);
    outputs->link_tx[0] = 0;
    outputs->drive_tx[0].data[7] = 1;
    changed(OutputPart::drives);
    outputs->drive_tx[0].data[7] = 0;
    outputs->set_point[3] = 1;
    changed(OutputPart::set_points);
    outputs->set_point[3] = 0;
    outputs->galvo[99].word_z = 1;
    changed(OutputPart::mirrors);
    outputs->galvo[99].word_z = 0;
    outputs->laser[0].change_ns256 = 1;
    changed(OutputPart::laser);
    outputs->laser[0].change_ns256 = 0;
    outputs->pulses[0].place_pm[2] = 1;
    changed(OutputPart::pulses);
    outputs->pulses[0].place_pm[2] = 0;
    outputs->cancel_laser = true;
    changed(OutputPart::lines);
}

}  // namespace
}  // namespace sc::recording
