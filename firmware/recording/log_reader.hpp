// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/recording/log_format.hpp"
#include "firmware/recording/tick_codec.hpp"

namespace sc::recording {

/// How a log came to its end, or what is wrong with it.
enum class LogEnd : std::uint8_t {
    none,           ///< there is more
    closed,         ///< whole
    full,           ///< whole; recording ended at the limit of its size
    torn,           ///< the file ends within or after a chunk without an end: power loss, or it is still being written
    not_a_log,      ///< another kind of file, or shorter than a header
    other_version,  ///< a log of another version of this format
    bad_machine,    ///< the machine's configuration is of another version, or cannot be run with
    damaged_head,   ///< the head of a chunk does not match its checksum
    damaged_chunk,  ///< a chunk does not match its checksum
    out_of_order,   ///< a chunk is missing, is there twice, or stands behind the end
    malformed,      ///< the checksums agree, the content makes no sense: not written by this program
};

/// The log may be replayed as far as it goes.
[[nodiscard]] constexpr bool readable(LogEnd end) noexcept {
    return end == LogEnd::closed || end == LogEnd::full || end == LogEnd::torn;
}

struct LoggedTick {
    StoredInputs stored;
    OutputsDigest digest;
};

/// Reads a log that lies in memory as a whole. Every chunk is checked before a tick of it is given out. No heap.
class LogReader {
public:
    /// `bytes` stay the caller's and must outlive this.
    explicit LogReader(std::span<const std::uint8_t> bytes) noexcept;

    /// Of use unless `end()` is not_a_log, other_version, bad_machine or damaged in the first chunk.
    [[nodiscard]] const LogHeader& header() const noexcept { return header_; }
    /// Version found in a log of another version.
    [[nodiscard]] std::uint16_t version() const noexcept { return version_; }
    /// The next tick; false when there is none, and `end()` then says why.
    [[nodiscard]] bool next(LoggedTick& tick) noexcept;
    [[nodiscard]] LogEnd end() const noexcept { return end_; }
    /// Where in the file the chunk begins that ended the reading.
    [[nodiscard]] std::size_t offset() const noexcept { return chunk_offset_; }

private:
    struct Chunk {
        ChunkHead head;
        std::span<const std::uint8_t> payload;
    };
    [[nodiscard]] bool fail(LogEnd end) noexcept;
    [[nodiscard]] bool next_chunk(Chunk& chunk) noexcept;
    [[nodiscard]] bool read_header() noexcept;
    [[nodiscard]] bool open_ticks() noexcept;
    [[nodiscard]] bool read_end(const Chunk& chunk) noexcept;

    std::span<const std::uint8_t> bytes_;
    LogHeader header_;
    LogEnd end_ = LogEnd::none;
    std::uint16_t version_ = 0;
    std::size_t place_ = 0;
    std::size_t chunk_offset_ = 0;
    std::uint32_t number_ = 0;
    ByteReader ticks_{std::span<const std::uint8_t>{}};
    TickMemory memory_;
    std::uint32_t ticks_left_ = 0;
    std::uint64_t ticks_read_ = 0;
    std::int64_t next_tick_ = 0;
};

}  // namespace sc::recording
