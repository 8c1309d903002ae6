// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace sc::sim {

/// One direction of a serial line: ten bits a byte, bytes come out at tick boundaries and never faster than the baud
/// rate. Line time that no byte used is lost, as on a real line. The queue before it has no bound (the sender's
/// buffer).
class SerialWire {
public:
    /// `most_per_tick`: never more bytes than this at one boundary, whatever the rate.
    SerialWire(std::uint32_t baud, std::int64_t tick_ns, std::size_t most_per_tick);

    void push(std::span<const std::uint8_t> bytes);
    /// One tick has passed: appends what has come through to `out`.
    void tick(std::vector<std::uint8_t>& out);
    /// Cuts or joins the line. While it is cut all bytes are lost, those on their way too.
    void set_connected(bool connected);
    [[nodiscard]] std::size_t waiting() const noexcept { return queue_.size(); }

private:
    std::int64_t earned_per_tick_;  ///< bit·ns/s: baud · tick
    std::size_t most_per_tick_;
    std::int64_t earned_ = 0;
    bool connected_ = true;
    std::deque<std::uint8_t> queue_;
};

}  // namespace sc::sim
