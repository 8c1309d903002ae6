// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/drives/sdo_service.hpp"

namespace sc::drives {

/// Reads or writes one object of any length: expedited where four bytes suffice, else in segments (CiA 301, 7.2.4.3).
/// For what a board wants to know of a drive besides: its name (1008), its versions. One transfer at a time; the
/// caller's bytes must stay until it has ended. A request that stays unanswered for kTimeoutTicks is given up with an
/// abort: a segment cannot be asked for twice, its toggle bit would not fit. No heap.
class SdoTransfer final : public SdoService {
public:
    enum class Result : std::uint8_t { idle, busy, done, aborted, timed_out, too_long };
    static constexpr std::int64_t kTimeoutTicks = 200;

    void read(std::uint16_t index, std::uint8_t sub, std::span<std::uint8_t> into) noexcept;
    void write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> from) noexcept;

    [[nodiscard]] Result result() const noexcept { return result_; }
    /// Bytes read or written so far.
    [[nodiscard]] std::size_t size() const noexcept { return at_; }
    [[nodiscard]] std::uint32_t abort_code() const noexcept { return abort_; }

    [[nodiscard]] std::optional<DriveFrame> poll(std::uint8_t node, std::int64_t tick) noexcept override;
    void receive(const DriveFrame& frame) noexcept override;
    void restarted() noexcept override;

private:
    using Bytes = std::array<std::uint8_t, 8>;
    void begin(std::uint16_t index, std::uint8_t sub) noexcept;
    [[nodiscard]] Bytes request() noexcept;
    [[nodiscard]] Bytes opening() const noexcept;
    void give_up(Result result, std::uint32_t code) noexcept;
    void take_opening(const Bytes& reply) noexcept;
    void take_segment(const Bytes& reply) noexcept;
    void store(std::span<const std::uint8_t> bytes) noexcept;

    std::span<std::uint8_t> into_{};
    std::span<const std::uint8_t> from_{};
    std::int64_t sent_tick_ = 0;
    std::size_t at_ = 0;
    std::size_t segment_ = 0;  ///< bytes of the segment under way
    std::uint32_t abort_ = 0;
    std::uint16_t index_ = 0;
    std::uint8_t sub_ = 0;
    bool reading_ = false;
    bool opened_ = false;
    bool toggle_ = false;
    bool waiting_ = false;    ///< for an answer
    bool abort_due_ = false;  ///< the server is to be told
    Result result_ = Result::idle;
};

}  // namespace sc::drives
