// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/log_writer.hpp"

#include "shared/hash/crc.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::recording {

static_assert(LogWriter::kPayloadCapacity >= 2 * kTickCapacity);
static_assert(LogWriter::kPayloadCapacity >= kHeaderPayloadSize);

std::span<std::uint8_t> LogWriter::payload() noexcept {
    return std::span(buffer_).subspan(kLogMagic.size() + kChunkHeadSize, kPayloadCapacity);
}

std::span<const std::uint8_t> LogWriter::seal(ChunkKind kind, std::int64_t first_tick, std::uint32_t ticks,
                                              std::size_t payload_size) noexcept {
    const auto chunk = std::span(buffer_).subspan(kLogMagic.size(), kChunkHeadSize + payload_size + kChunkTailSize);
    ByteWriter head(chunk.first(kChunkHeadSize));
    head.put_bytes(kChunkMark);
    head.put(static_cast<std::uint32_t>(kind));
    head.put(number_);
    head.put(static_cast<std::uint32_t>(payload_size));
    head.put(first_tick);
    head.put(ticks);
    head.put(crc32(head.written()));
    ByteWriter tail(chunk.last(kChunkTailSize));
    tail.put(crc32(chunk.first(chunk.size() - kChunkTailSize)));
    ++number_;
    bytes_ += chunk.size();
    return chunk;
}

std::span<const std::uint8_t> LogWriter::begin(const LogHeader& header, std::uint64_t limit_bytes) noexcept {
    limit_ = limit_bytes;
    ended_ = false;
    full_ = false;
    number_ = 0;
    ticks_ = 0;
    refused_ = 0;
    chunk_ticks_ = 0;
    next_tick_ = 0;
    std::array<std::uint8_t, link::kConfigSize> config{};
    link::serialise(header.machine, config);
    ByteWriter writer(payload());
    writer.put(kLogVersion);
    writer.put(static_cast<std::uint16_t>(header.sealed ? 1 : 0));
    writer.put(header.boot_id);
    writer.put(header.plan_units);
    for (const char character : header.build_id) {
        writer.put(static_cast<std::uint8_t>(character));
    }
    writer.put(header.key_check);
    writer.put_bytes(header.entropy);
    writer.put_bytes(config);
    ByteWriter magic{std::span(buffer_).first(kLogMagic.size())};
    magic.put_bytes(kLogMagic);
    bytes_ = kLogMagic.size();
    const std::size_t chunk = seal(ChunkKind::header, 0, 0, writer.size()).size();
    return std::span(buffer_).first(kLogMagic.size() + chunk);
}

std::span<const std::uint8_t> LogWriter::add(const ServoInputs& inputs, const OutputsDigest& digest) noexcept {
    if (ended_) {
        return {};
    }
    if (chunk_ticks_ == 0) {
        memory_ = TickMemory{};
        memory_.tick = inputs.tick;
        first_tick_ = inputs.tick;
        payload_size_ = 0;
    }
    ByteWriter writer(payload().subspan(payload_size_));
    if (!encode(inputs, digest, memory_, writer)) {
        ++refused_;
        return {};
    }
    payload_size_ += writer.size();
    next_tick_ = memory_.tick;
    ++chunk_ticks_;
    const bool filled = chunk_ticks_ == kTicksPerChunk || kPayloadCapacity - payload_size_ < kTickCapacity;
    return filled ? flush() : std::span<const std::uint8_t>{};
}

std::span<const std::uint8_t> LogWriter::flush() noexcept {
    if (chunk_ticks_ == 0) {
        return {};
    }
    if (bytes_ + kChunkHeadSize + payload_size_ + kChunkTailSize + kLogEndSize > limit_) {
        full_ = true;
        next_tick_ = first_tick_;
        chunk_ticks_ = 0;
        return end(EndReason::full);
    }
    const auto chunk = seal(ChunkKind::ticks, first_tick_, chunk_ticks_, payload_size_);
    ticks_ += chunk_ticks_;
    chunk_ticks_ = 0;
    return chunk;
}

std::span<const std::uint8_t> LogWriter::close() noexcept {
    return ended_ ? std::span<const std::uint8_t>{} : end(EndReason::closed);
}

std::span<const std::uint8_t> LogWriter::end(EndReason reason) noexcept {
    ended_ = true;
    ByteWriter writer(payload());
    writer.put(static_cast<std::uint8_t>(reason));
    writer.put(ticks_);
    return seal(ChunkKind::end, next_tick_, 0, writer.size());
}

}  // namespace sc::recording
