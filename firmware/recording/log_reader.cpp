// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/log_reader.hpp"

#include <algorithm>

#include "shared/hash/crc.hpp"

namespace sc::recording {
namespace {

bool begins_with(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> mark) noexcept {
    if (bytes.size() < mark.size()) {
        return false;
    }
    for (std::size_t i = 0; i < mark.size(); ++i) {
        if (bytes[i] != mark[i]) {
            return false;
        }
    }
    return true;
}

std::uint32_t number_at_end(std::span<const std::uint8_t> bytes) noexcept {
    ByteReader reader(bytes.last(sizeof(std::uint32_t)));
    return reader.get<std::uint32_t>();
}

/// The last four bytes are the CRC-32 of those before them.
bool sealed(std::span<const std::uint8_t> bytes) noexcept {
    return crc32(bytes.first(bytes.size() - sizeof(std::uint32_t))) == number_at_end(bytes);
}

}  // namespace

LogReader::LogReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) { (void)read_header(); }

bool LogReader::fail(LogEnd end) noexcept {
    end_ = end;
    return false;
}

bool LogReader::next_chunk(Chunk& chunk) noexcept {
    chunk_offset_ = place_;
    const auto rest = bytes_.subspan(place_);
    if (rest.size() < kChunkHeadSize) {
        return fail(LogEnd::torn);
    }
    const auto head = rest.first(kChunkHeadSize);
    if (!begins_with(head, kChunkMark) || !sealed(head)) {
        return fail(LogEnd::damaged_head);
    }
    ByteReader reader(head.subspan(kChunkMark.size()));
    const auto kind = reader.get<std::uint32_t>();
    chunk.head.number = reader.get<std::uint32_t>();
    chunk.head.payload_size = reader.get<std::uint32_t>();
    chunk.head.first_tick = reader.get<std::int64_t>();
    chunk.head.ticks = reader.get<std::uint32_t>();
    if (kind < static_cast<std::uint32_t>(ChunkKind::header) || kind > static_cast<std::uint32_t>(ChunkKind::end)) {
        return fail(LogEnd::malformed);
    }
    chunk.head.kind = static_cast<ChunkKind>(kind);
    if (chunk.head.number != number_) {
        return fail(LogEnd::out_of_order);
    }
    if (rest.size() - kChunkHeadSize < std::uint64_t{chunk.head.payload_size} + kChunkTailSize) {
        return fail(LogEnd::torn);
    }
    const auto whole = rest.first(kChunkHeadSize + chunk.head.payload_size + kChunkTailSize);
    if (!sealed(whole)) {
        return fail(LogEnd::damaged_chunk);
    }
    chunk.payload = whole.subspan(kChunkHeadSize, chunk.head.payload_size);
    place_ += whole.size();
    ++number_;
    return true;
}

bool LogReader::read_header() noexcept {
    if (!begins_with(bytes_, kLogMagic)) {
        return fail(LogEnd::not_a_log);
    }
    place_ = kLogMagic.size();
    Chunk chunk;
    if (!next_chunk(chunk)) {
        return fail(end_ == LogEnd::torn ? LogEnd::not_a_log : end_);
    }
    ByteReader reader(chunk.payload);
    version_ = reader.get<std::uint16_t>();
    if (chunk.head.kind != ChunkKind::header || !reader.ok()) {
        return fail(LogEnd::malformed);
    }
    if (version_ != kLogVersion) {
        return fail(LogEnd::other_version);
    }
    const auto sealed_word = reader.get<std::uint16_t>();
    if (chunk.payload.size() != kHeaderPayloadSize || sealed_word > 1) {
        return fail(LogEnd::malformed);
    }
    header_.sealed = sealed_word != 0;
    header_.boot_id = reader.get<std::uint32_t>();
    header_.plan_units = reader.get<std::uint32_t>();
    for (char& character : header_.build_id) {
        character = static_cast<char>(reader.get<std::uint8_t>());
    }
    header_.key_check = reader.get<std::uint32_t>();
    const auto entropy = reader.get_bytes(header_.entropy.size());
    std::copy(entropy.begin(), entropy.end(), header_.entropy.begin());
    const auto machine = link::deserialise(reader.get_bytes(link::kConfigSize));
    if (!machine) {
        return fail(LogEnd::bad_machine);
    }
    header_.machine = *machine;
    return true;
}

bool LogReader::read_end(const Chunk& chunk) noexcept {
    ByteReader reader(chunk.payload);
    const auto reason = reader.get<std::uint8_t>();
    const auto ticks = reader.get<std::uint64_t>();
    const bool known =
        reason == static_cast<std::uint8_t>(EndReason::closed) || reason == static_cast<std::uint8_t>(EndReason::full);
    if (!reader.exhausted() || !known || ticks != ticks_read_) {
        return fail(LogEnd::malformed);
    }
    if (place_ != bytes_.size()) {
        chunk_offset_ = place_;
        return fail(LogEnd::out_of_order);
    }
    return fail(reason == static_cast<std::uint8_t>(EndReason::full) ? LogEnd::full : LogEnd::closed);
}

bool LogReader::open_ticks() noexcept {
    Chunk chunk;
    if (!next_chunk(chunk)) {
        return false;
    }
    if (chunk.head.kind == ChunkKind::end) {
        return read_end(chunk);
    }
    if (chunk.head.kind != ChunkKind::ticks || chunk.head.ticks == 0) {
        return fail(LogEnd::malformed);
    }
    if (ticks_read_ != 0 && chunk.head.first_tick < next_tick_) {
        return fail(LogEnd::out_of_order);
    }
    ticks_ = ByteReader(chunk.payload);
    ticks_left_ = chunk.head.ticks;
    memory_ = TickMemory{};
    memory_.tick = chunk.head.first_tick;
    return true;
}

bool LogReader::next(LoggedTick& tick) noexcept {
    if (end_ != LogEnd::none || (ticks_left_ == 0 && !open_ticks())) {
        return false;
    }
    if (!decode(ticks_, memory_, tick.stored, tick.digest)) {
        return fail(LogEnd::malformed);
    }
    --ticks_left_;
    ++ticks_read_;
    next_tick_ = memory_.tick;
    if (ticks_left_ == 0 && !ticks_.exhausted()) {
        return fail(LogEnd::malformed);
    }
    return true;
}

}  // namespace sc::recording
