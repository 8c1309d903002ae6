// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "firmware/recording/log_reader.hpp"
#include "firmware/recording/log_writer.hpp"
#include "shared/hash/crc.hpp"

namespace sc::recording {

/// One tick's inputs with the memory behind its spans, and a digest.
struct FedTick {
    std::int64_t tick = 0;
    std::vector<std::uint8_t> link;
    std::vector<DriveFrame> drives;
    DigitalInputs digital{true, true, true, true};
    std::uint16_t galvo_status = kGalvoStatusOk;
    std::uint8_t guard_causes = 0;
    std::vector<std::uint8_t> source{};
    EncoderInputs encoders{};
    std::array<std::vector<SensorByte>, kSensorBuses> sensors{};
    OutputsDigest digest;

    [[nodiscard]] ServoInputs inputs() const {
        return {tick, link, drives, digital, galvo_status, guard_causes, source, encoders, {sensors[0], sensors[1]}};
    }
    bool operator==(const FedTick&) const = default;
};

inline FedTick fed(const LoggedTick& logged) {
    const ServoInputs& in = logged.stored.inputs;
    return {in.tick,
            {in.link_rx.begin(), in.link_rx.end()},
            {in.drive_rx.begin(), in.drive_rx.end()},
            in.digital,
            in.galvo_status,
            in.guard_causes,
            {in.source_rx.begin(), in.source_rx.end()},
            in.encoders,
            {std::vector(in.sensor_rx[0].begin(), in.sensor_rx[0].end()),
             std::vector(in.sensor_rx[1].begin(), in.sensor_rx[1].end())},
            logged.digest};
}

inline DriveFrame status_frame(unsigned node, std::uint32_t position) {
    DriveFrame frame;
    frame.id = static_cast<std::uint16_t>(0x180 + node);
    frame.size = 6;
    frame.data = {0x37, 0x12};
    for (unsigned i = 0; i < 4; ++i) {
        frame.data[2 + i] = static_cast<std::uint8_t>(position >> (8 * i));
    }
    return frame;
}

/// A cell as it is in motion: status of four drives every second tick, a message now and then.
inline std::vector<FedTick> plain_ticks(std::size_t count) {
    std::vector<FedTick> ticks(count);
    for (std::size_t i = 0; i < count; ++i) {
        FedTick& t = ticks[i];
        t.tick = static_cast<std::int64_t>(i);
        if (i % 2 == 0) {
            for (unsigned node = 1; node <= 4; ++node) {
                t.drives.push_back(status_frame(node, node <= 2 ? 1000 * node + static_cast<unsigned>(i) : node));
            }
        }
        if (i % 20 == 7) {
            t.link = {3, 1, 4, 1, 5, 9, 2, 6, 0};
        }
        if (i % 50 == 11) {
            t.source = {0xA5, 0x00, static_cast<std::uint8_t>(i)};
        }
        if (i % 70 == 13) {
            t.encoders = {true, 20'000, {static_cast<std::int64_t>(i), -5, 0, 1}};
        }
        if (i % 70 == 13 || i % 9 == 4) {
            t.sensors[i % 2] = {{0x01, 0, 900}, {static_cast<std::uint8_t>(i), 0, 500}};
        }
        if (i % 35 == 13) {
            t.sensors[1] = {{0xFF, 4, 999}, {0x04, 0, 992}, {0x02, 1, 0}};
        }
        t.digital.source_status = static_cast<std::uint8_t>(i % 300 == 0 ? 4 : 7);
        t.digital.interlock_closed = i < count / 2;
        t.digest.crc = static_cast<std::uint32_t>(i * 2654435761U);
        t.digest.check[1] = static_cast<std::uint8_t>(i % 2);
        t.digest.state = i < count / 2 ? 3 : 14;
        t.digest.faults = i < count / 2 ? 0U : 4U;
    }
    return ticks;
}

inline LogHeader plain_header() {
    LogHeader header;
    header.machine = reference_machine();
    header.boot_id = 7;
    header.plan_units = 160;
    header.build_id = {'t', 'e', 's', 't'};
    return header;
}

inline void append(std::vector<std::uint8_t>& log, std::span<const std::uint8_t> bytes) {
    log.insert(log.end(), bytes.begin(), bytes.end());
}

inline std::vector<std::uint8_t> log_of(const std::vector<FedTick>& ticks, std::uint64_t limit = 100'000'000) {
    const auto writer = std::make_unique<LogWriter>();
    std::vector<std::uint8_t> log;
    append(log, writer->begin(plain_header(), limit));
    for (const FedTick& t : ticks) {
        append(log, writer->add(t.inputs(), t.digest));
    }
    append(log, writer->flush());
    append(log, writer->close());
    return log;
}

struct ReadLog {
    LogEnd end = LogEnd::none;
    std::vector<FedTick> ticks;
};
inline ReadLog read(std::span<const std::uint8_t> log) {
    LogReader reader(log);
    ReadLog result;
    const auto tick = std::make_unique<LoggedTick>();
    while (reader.next(*tick)) {
        result.ticks.push_back(fed(*tick));
    }
    result.end = reader.end();
    return result;
}

inline bool is_prefix(const std::vector<FedTick>& part, const std::vector<FedTick>& whole) {
    return part.size() <= whole.size() && std::equal(part.begin(), part.end(), whole.begin());
}

/// Where the chunks begin, and the end of the log.
inline std::vector<std::size_t> chunk_starts(std::span<const std::uint8_t> log) {
    std::vector<std::size_t> starts{kLogMagic.size()};
    while (starts.back() < log.size()) {
        ByteReader reader(log.subspan(starts.back() + 12, 4));
        starts.push_back(starts.back() + kChunkHeadSize + reader.get<std::uint32_t>() + kChunkTailSize);
    }
    return starts;
}

/// Makes the checksums of a chunk right again.
inline void reseal(std::span<std::uint8_t> chunk) {
    const auto put = [&](std::size_t at) {
        ByteWriter writer(chunk.subspan(at, 4));
        writer.put(crc32(chunk.first(at)));
    };
    put(kChunkHeadSize - 4);
    put(chunk.size() - kChunkTailSize);
}

}  // namespace sc::recording
