// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "boards/sim/carrier/frame_bits.hpp"
#include "boards/sim/carrier/troubles.hpp"

namespace sc::sim {

/// A CAN bus with two nodes, 0 and 1, bit-timed. The lowest identifier among those that wait wins; what is destroyed on
/// the wire ends in an error frame and is sent again; a frame that nobody acknowledges too. A node's error counter
/// rises by 8 with each frame that fails and falls by 1 with each that does not; above 255 it is off the bus, loses
/// what it had to send, and comes back after 128 times 11 recessive bits. A node that has counted 127 no longer counts
/// a missing acknowledgement (ISO 11898-1, 12.1.4), so a lone node never goes off the bus.
class CanBus {
public:
    enum class NodeState : std::uint8_t { active, passive, off };

    CanBus(const CanRates& rates, const Troubles& troubles) : rates_(rates), troubles_(troubles) {}

    void send(std::size_t node, const link::LinkCanFrame& frame, std::int64_t now_ns);
    /// Lets the bus live up to `now_ns`, and appends what has reached `node`.
    void receive(std::size_t node, std::int64_t now_ns, std::vector<link::LinkCanFrame>& out);
    /// Drops all that one node has to send and has not yet taken; its error counter begins anew.
    void reset(std::size_t node);

    [[nodiscard]] NodeState state(std::size_t node) const noexcept;
    [[nodiscard]] std::size_t waiting(std::size_t node) const noexcept { return nodes_[node].queue.size(); }
    [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }  ///< that have passed
    [[nodiscard]] std::uint64_t error_frames() const noexcept { return error_frames_; }
    [[nodiscard]] std::uint64_t bus_offs() const noexcept { return bus_offs_; }
    [[nodiscard]] std::int64_t busy_ns() const noexcept { return busy_ns_; }  ///< that the wire was not idle

private:
    struct Waiting {
        std::int64_t ready_ns = 0;
        link::LinkCanFrame frame;
    };
    struct Arrived {
        std::int64_t due_ns = 0;
        link::LinkCanFrame frame;
    };
    struct Node {
        std::deque<Waiting> queue;
        std::deque<Arrived> arrived;
        std::int64_t last_due_ns = 0;
        int errors = 0;
        std::optional<std::int64_t> back_ns;  ///< off the bus until then
    };
    void run(std::int64_t until_ns);
    [[nodiscard]] std::optional<std::size_t> winner(std::int64_t now_ns, std::int64_t& next_ns) const;
    void transmit(std::size_t from);
    void fail(std::size_t from, bool no_acknowledge);
    void hand_over(std::size_t to, link::LinkCanFrame frame);
    [[nodiscard]] std::int64_t nominal_bits_ns(std::int64_t bits) const noexcept;

    CanRates rates_;
    Troubles troubles_;
    std::array<Node, 2> nodes_;
    std::int64_t now_ns_ = 0;
    std::uint64_t frames_ = 0;
    std::uint64_t error_frames_ = 0;
    std::uint64_t bus_offs_ = 0;
    std::int64_t busy_ns_ = 0;
};

}  // namespace sc::sim
