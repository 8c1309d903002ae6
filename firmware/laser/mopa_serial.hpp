// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "shared/machine/machine.hpp"

/// Pulse width of a MOPA source over its serial protocol. Raycus: A5 01 HH LL, answered by A5 HH LL with the width in
/// force. JPT: $34;WWW*, answered by the same with the width in force, or by E.

namespace sc::laser {

enum class WidthAnswer : std::uint8_t {
    none,     ///< nothing new
    set,      ///< the source confirms the width that was asked for
    refused,  ///< it refuses, or confirms another
    silent,   ///< it has not answered in its time
    foreign,  ///< it answers as a source of another maker does
};

/// One request at a time. Servo context, once a tick, a few instructions a byte; never waits.
class MopaSerial {
public:
    static constexpr std::int32_t kMostWidth = 999;  ///< ns; three digits
    static constexpr std::int64_t kPatienceNs = 150'000'000;

    MopaSerial(LaserSource source, std::int64_t period_ns) noexcept : source_(source), period_ns_(period_ns) {}

    /// The source has such a port.
    [[nodiscard]] bool speaks() const noexcept { return source_ == LaserSource::raycus || source_ == LaserSource::jpt; }
    [[nodiscard]] bool busy() const noexcept { return wanted_ != 0; }
    /// 1 … kMostWidth ns, while not busy.
    void begin(std::uint16_t width_ns) noexcept;
    /// What is to be sent in this tick; returns its size.
    [[nodiscard]] std::size_t transmit(std::span<std::uint8_t, kSourceBytesPerTick> out) noexcept;
    /// Takes what has come. An answer other than none ends the request.
    [[nodiscard]] WidthAnswer step(std::span<const std::uint8_t> received) noexcept;
    /// Width that the last answer named, ns; 0 if it named none.
    [[nodiscard]] std::uint16_t answered() const noexcept { return answered_; }

private:
    [[nodiscard]] WidthAnswer judge() noexcept;
    [[nodiscard]] WidthAnswer judge_raycus() noexcept;
    [[nodiscard]] WidthAnswer judge_jpt() noexcept;
    [[nodiscard]] WidthAnswer compare(std::uint16_t width) noexcept;

    LaserSource source_;
    std::int64_t period_ns_;
    std::int64_t waited_ns_ = 0;
    std::uint16_t wanted_ = 0;
    std::uint16_t answered_ = 0;
    bool sent_ = false;
    std::array<std::uint8_t, 8> heard_{};
    std::size_t heard_size_ = 0;
};

}  // namespace sc::laser
