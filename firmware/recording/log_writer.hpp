// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/recording/log_format.hpp"
#include "firmware/recording/tick_codec.hpp"

namespace sc::recording {

/// Makes the bytes of a log; whoever calls stores them. Bounded: one chunk of memory (32 kB), no heap; control tick
/// context or behind it.
///
///     store(writer.begin(header, limit));
///     each tick: store(writer.add(inputs, digest));  // mostly empty, else a whole chunk
///     store(writer.flush());
///     store(writer.close());
///
/// A chunk that would take the log beyond its limit is dropped; the end chunk comes in its place, and nothing after it.
class LogWriter {
public:
    static constexpr std::size_t kPayloadCapacity = 32'768;
    static constexpr std::uint32_t kTicksPerChunk = 1000;

    /// Least limit that is of any use: head, a full chunk, end.
    static constexpr std::uint64_t kLeastLimit =
        kLogHeadSize + kChunkHeadSize + kPayloadCapacity + kChunkTailSize + kLogEndSize;

    /// Magic and header chunk. The spans that this class returns are valid until its next call.
    [[nodiscard]] std::span<const std::uint8_t> begin(const LogHeader& header, std::uint64_t limit_bytes) noexcept;
    /// Adds a tick; returns the chunk that it has filled, or nothing. Inputs that hold more than a tick may are not
    /// added (`refused()` counts them).
    [[nodiscard]] std::span<const std::uint8_t> add(const ServoInputs& inputs, const OutputsDigest& digest) noexcept;
    /// The chunk begun, if it holds a tick.
    [[nodiscard]] std::span<const std::uint8_t> flush() noexcept;
    /// The end chunk, after `flush`; nothing if the log has ended already.
    [[nodiscard]] std::span<const std::uint8_t> close() noexcept;
    /// The end chunk has been returned, because the limit was reached or by `close`.
    [[nodiscard]] bool ended() const noexcept { return ended_; }
    [[nodiscard]] bool full() const noexcept { return full_; }

    /// Ticks and bytes returned so far.
    [[nodiscard]] std::uint64_t ticks() const noexcept { return ticks_; }
    [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }
    [[nodiscard]] std::uint32_t refused() const noexcept { return refused_; }

private:
    [[nodiscard]] std::span<const std::uint8_t> end(EndReason reason) noexcept;
    [[nodiscard]] std::span<std::uint8_t> payload() noexcept;
    [[nodiscard]] std::span<const std::uint8_t> seal(ChunkKind kind, std::int64_t first_tick, std::uint32_t ticks,
                                                     std::size_t payload_size) noexcept;

    std::array<std::uint8_t, kLogMagic.size() + kChunkHeadSize + kPayloadCapacity + kChunkTailSize> buffer_{};
    TickMemory memory_;
    std::size_t payload_size_ = 0;
    std::int64_t first_tick_ = 0;
    std::int64_t next_tick_ = 0;
    std::uint32_t chunk_ticks_ = 0;
    std::uint32_t number_ = 0;
    std::uint64_t ticks_ = 0;
    std::uint32_t refused_ = 0;
    std::uint64_t limit_ = 0;
    std::uint64_t bytes_ = 0;
    bool ended_ = true;
    bool full_ = false;
};

}  // namespace sc::recording
