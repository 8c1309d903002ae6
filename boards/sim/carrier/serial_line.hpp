// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "boards/sim/carrier/troubles.hpp"

namespace sc::sim {

/// A serial line with two ends, 0 and 1, full duplex, ten bits a byte. Troubles befall whole frames (bytes up to a
/// 0x00); on a line there is nobody to send a destroyed one again, so it is lost.
class SerialLine {
public:
    SerialLine(std::uint32_t baud, const Troubles& troubles) : baud_(baud), troubles_(troubles) {}

    /// Hands bytes to the sender at `end`, at time `now_ns`.
    void send(std::size_t end, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
    /// Appends what has reached `end` by `now_ns`. Time never goes back.
    void receive(std::size_t end, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    /// Drops all that one end has in its buffers: it starts anew.
    void reset(std::size_t end);
    [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }

private:
    struct Frame {
        std::int64_t due_ns = 0;
        std::vector<std::uint8_t> bytes;
    };
    struct Way {
        std::vector<std::uint8_t> begun;  ///< a frame without its end yet
        std::int64_t free_ns = 0;         ///< the wire is free from here on
        std::int64_t last_due_ns = 0;
        std::deque<Frame> frames;
    };
    void put(Way& way, std::vector<std::uint8_t> bytes, std::int64_t now_ns);

    std::uint32_t baud_;
    Troubles troubles_;
    std::array<Way, 2> to_;  ///< by the receiving end
    std::uint64_t frames_ = 0;
};

}  // namespace sc::sim
