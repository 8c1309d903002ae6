// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/carrier/can_bus.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace sc::sim {
namespace {

constexpr int kPassive = 128;
constexpr int kOff = 256;
constexpr int kFailed = 8;
/// Error flag of six bits, its echo by the others, delimiter, interframe space.
constexpr std::int64_t kErrorFrame = 6 + 6 + 8 + 3;
constexpr std::int64_t kRecovery = 128 * 11;

}  // namespace

std::int64_t CanBus::nominal_bits_ns(std::int64_t bits) const noexcept { return bits * 1'000'000'000 / rates_.nominal; }

CanBus::NodeState CanBus::state(std::size_t node) const noexcept {
    if (nodes_[node].back_ns) {
        return NodeState::off;
    }
    return nodes_[node].errors >= kPassive ? NodeState::passive : NodeState::active;
}

void CanBus::send(std::size_t node, const link::LinkCanFrame& frame, std::int64_t now_ns) {
    run(now_ns);
    if (!nodes_[node].back_ns) {
        nodes_[node].queue.push_back({now_ns, frame});
    }
}

void CanBus::receive(std::size_t node, std::int64_t now_ns, std::vector<link::LinkCanFrame>& out) {
    run(now_ns);
    auto& arrived = nodes_[node].arrived;
    while (!arrived.empty() && arrived.front().due_ns <= now_ns) {
        out.push_back(arrived.front().frame);
        arrived.pop_front();
    }
}

void CanBus::reset(std::size_t node) {
    Node& n = nodes_[node];
    n.queue.clear();
    n.arrived.clear();
    n.errors = 0;
    n.back_ns.reset();
}

std::optional<std::size_t> CanBus::winner(std::int64_t now_ns, std::int64_t& next_ns) const {
    std::optional<std::size_t> best;
    next_ns = std::numeric_limits<std::int64_t>::max();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        const Node& node = nodes_[i];
        if (node.queue.empty()) {
            continue;
        }
        const Waiting& first = node.queue.front();
        next_ns = std::min(next_ns, first.ready_ns);
        if (first.ready_ns <= now_ns && (!best || first.frame.id < nodes_[*best].queue.front().frame.id)) {
            best = i;
        }
    }
    return best;
}

void CanBus::run(std::int64_t until_ns) {
    while (now_ns_ < until_ns) {
        for (Node& node : nodes_) {
            if (node.back_ns && *node.back_ns <= now_ns_) {
                node.back_ns.reset();
                node.errors = 0;
            }
        }
        std::int64_t next = 0;
        const auto from = winner(now_ns_, next);
        if (from) {
            transmit(*from);
        } else {
            now_ns_ = std::max(now_ns_, std::min(next, until_ns));
        }
    }
}

void CanBus::transmit(std::size_t from) {
    Node& node = nodes_[from];
    const std::size_t to = 1 - from;
    const TroubleRates& rates = troubles_.rates();
    const link::LinkCanFrame frame = node.queue.front().frame;
    const std::int64_t time = frame_ns(frame, rates_);
    const bool alone = nodes_[to].back_ns.has_value() || troubles_.cut(now_ns_);
    const bool destroyed = troubles_.chance(rates.destroy);
    if (alone || destroyed) {
        // Nobody acknowledges: known at the frame's end. A bit error: anywhere in it.
        const std::int64_t spent = (alone ? time : troubles_.up_to(time)) + nominal_bits_ns(kErrorFrame);
        now_ns_ += spent;
        busy_ns_ += spent;
        fail(from, alone);
        return;
    }
    now_ns_ += time;
    busy_ns_ += time;
    ++frames_;
    node.errors = std::max(0, node.errors - 1);
    const bool again = troubles_.chance(rates.repeat);
    if (!again) {
        node.queue.pop_front();  // otherwise its sender saw an error in the last bit, and the receiver none
    }
    hand_over(to, frame);
}

void CanBus::fail(std::size_t from, bool no_acknowledge) {
    ++error_frames_;
    Node& node = nodes_[from];
    if (no_acknowledge && node.errors >= kPassive) {
        return;
    }
    node.errors += kFailed;
    if (node.errors >= kOff) {
        ++bus_offs_;
        node.queue.clear();
        node.back_ns = now_ns_ + nominal_bits_ns(kRecovery);
    }
}

void CanBus::hand_over(std::size_t to, link::LinkCanFrame frame) {
    Node& node = nodes_[to];
    const TroubleRates& rates = troubles_.rates();
    if (troubles_.chance(rates.lose)) {
        return;
    }
    if (troubles_.chance(rates.spoil)) {
        troubles_.spoil(std::span(frame.data).first(frame.size));
    }
    std::int64_t due = now_ns_;
    if (troubles_.chance(rates.late)) {
        due += troubles_.up_to(rates.late_ns);
    }
    node.last_due_ns = std::max(node.last_due_ns, due);
    node.arrived.push_back({node.last_due_ns, frame});
    if (troubles_.chance(rates.swap) && node.arrived.size() > 1) {
        std::swap(node.arrived.back().frame, node.arrived[node.arrived.size() - 2].frame);
    }
}

}  // namespace sc::sim
