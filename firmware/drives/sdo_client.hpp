// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/drives/canopen.hpp"

namespace sc::drives {

/// Expedited SDO client of one node: one request at a time, repeated when it stays unanswered. Time is counted in
/// control ticks. Never blocks; no heap.
class SdoClient {
public:
    enum class Result : std::uint8_t { idle, busy, done, aborted, timed_out };

    static constexpr std::int64_t kTimeoutTicks = 50;
    static constexpr std::uint8_t kAttempts = 3;

    /// Starts a request and drops an unfinished one. The frame leaves with the next `poll`.
    void write(const canopen::ObjectKey& key, std::uint32_t value) noexcept;
    void read(const canopen::ObjectKey& key) noexcept;
    void cancel() noexcept { result_ = Result::idle; }

    /// Once a tick in which SDO frames may be sent: the frame to send, if any. Counts time-outs.
    [[nodiscard]] std::optional<DriveFrame> poll(std::uint8_t node, std::int64_t tick) noexcept;
    /// An SDO answer of this node; one that does not belong to the open request is ignored.
    void receive(const DriveFrame& frame) noexcept;

    [[nodiscard]] Result result() const noexcept { return result_; }
    /// Data read (zero-extended), or the abort code.
    [[nodiscard]] std::uint32_t value() const noexcept { return value_; }

private:
    void begin(const canopen::ObjectKey& key) noexcept;

    canopen::ObjectKey key_{};
    std::uint32_t value_ = 0;
    std::int64_t sent_tick_ = 0;
    std::uint8_t attempts_ = 0;
    bool reading_ = false;
    Result result_ = Result::idle;
};

}  // namespace sc::drives
