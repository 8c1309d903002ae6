// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "firmware/laser/xy2_100.hpp"

/// Proof that a galvo head is there. A converter without a head may well answer "all well" for ever, and a line that
/// floats reads as ones or zeros; so each mirror is sent on a jump, dark, and its own position acknowledge must fall,
/// the other's stay, and both be there again when the mirror has arrived.

namespace sc::laser {

/// Once a tick while the cell is arming, on mirrors that are otherwise at rest. Some 20 ticks for a good head. Servo
/// context, no heap.
class HeadProof {
public:
    explicit HeadProof(const GalvoConfig& galvo) noexcept : format_(galvo.word, galvo.convention) {}

    /// Forgets what was proven.
    void restart() noexcept;
    /// `status` as sampled at this tick; `frames` are this tick's, which act in the next: the jump is laid into them
    /// 100 µs before its end, so that the tick after that samples a mirror on its way.
    void step(std::uint16_t status, std::span<GalvoFrame, kGalvoFramesPerTick> frames) noexcept;

    [[nodiscard]] bool proven() const noexcept { return stage_ == Stage::proven; }
    /// No head answers as a head does.
    [[nodiscard]] bool failed() const noexcept { return stage_ == Stage::failed; }

private:
    enum class Stage : std::uint8_t { rest, jump, moving, arrive, proven, failed };
    void displace(std::span<GalvoFrame> frames) const noexcept;
    void next_jump() noexcept;

    WordFormat format_;
    Stage stage_ = Stage::rest;
    std::uint8_t jump_ = 0;  ///< 0, 1: mirror x out and back; 2, 3: mirror z
    std::uint16_t ticks_ = 0;
    bool out_ = false;  ///< the mirror under test is displaced
};

}  // namespace sc::laser
