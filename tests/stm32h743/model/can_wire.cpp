// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/can_wire.hpp"

#include <algorithm>

namespace sc::model {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kErrorBits = 23;  // flag, its echo, delimiter, intermission

/// As the bits follow on the bus; lower wins.
std::uint64_t arbitration(const WireFrame& f) {
    const std::uint64_t first = f.extended ? f.id >> 18U : f.id;
    if (!f.extended) {
        return first << 21U | (f.remote ? 1ULL << 20U : 0ULL);
    }
    return first << 21U | 1ULL << 20U | 1ULL << 19U | std::uint64_t{f.id & 0x3FFFFU} << 1U | (f.remote ? 1ULL : 0ULL);
}

bool reads(const WireRates& receiver, const WireRates& sender, const WireFrame& frame) {
    return receiver.nominal == sender.nominal && (!frame.fd || receiver.data != 0) &&
           (!frame.fast || receiver.data == sender.data);
}

}  // namespace

std::int64_t CanWire::duration_ns(const WireFrame& frame, const WireRates& rates) {
    const auto bytes = static_cast<std::int64_t>(frame.data.size());
    if (!frame.fd) {
        return ((frame.extended ? 64 : 44) + 3 + 8 * bytes) * kSecond / rates.nominal;
    }
    const std::int64_t crc = bytes > 16 ? 4 + 21 + 6 : 4 + 17 + 5;
    const std::int64_t slow = (frame.extended ? 36 : 17) + 9 + 3;
    const std::int64_t quick = 1 + 4 + 8 * bytes + crc + 1;
    return slow * kSecond / rates.nominal + quick * kSecond / (frame.fast ? rates.data : rates.nominal);
}

std::int64_t CanWire::next_ns() const {
    if (sender_ != nullptr) {
        return end_ns_;
    }
    std::int64_t when = kNever;
    for (const CanNode* node : nodes_) {
        const std::int64_t ready = node->ready_ns();
        if (ready != kNever && node->wants()) {
            when = std::min(when, std::max(ready, end_ns_));
        }
    }
    return when;
}

void CanWire::act(std::int64_t now_ns) {
    if (sender_ == nullptr) {
        begin(now_ns);
    } else {
        end(now_ns);
    }
}

void CanWire::begin(std::int64_t now_ns) {
    for (CanNode* node : nodes_) {
        const std::optional<WireFrame> wanted = node->ready_ns() <= now_ns ? node->wants() : std::nullopt;
        if (!wanted) {
            continue;
        }
        if (sender_ != nullptr && arbitration(*wanted) == arbitration(frame_)) {
            machine_.violation("two nodes send the same identifier at once");
        }
        if (sender_ == nullptr || arbitration(*wanted) < arbitration(frame_)) {
            sender_ = node;
            frame_ = *wanted;
        }
    }
    if (sender_ != nullptr) {
        began_ns_ = now_ns;
        end_ns_ = now_ns + duration_ns(frame_, sender_->rates());
    }
}

void CanWire::end(std::int64_t now_ns) {
    CanNode& sender = *sender_;
    const WireRates rates = sender.rates();
    sender_ = nullptr;
    std::vector<CanNode*> others;
    for (CanNode* node : nodes_) {
        if (node != &sender && node->ready_ns() <= began_ns_) {
            others.push_back(node);
        }
    }
    if (sender.ready_ns() > began_ns_) {
        return;  // it was stopped meanwhile
    }
    const bool understood = std::ranges::all_of(others, [&](CanNode* n) { return reads(n->rates(), rates, frame_); });
    const bool blind = frame_.fast && !sender.hears_own_fast_bits();
    if (disturbed_ > 0 || !understood || blind) {
        disturbed_ -= disturbed_ > 0 ? 1 : 0;
        end_ns_ = now_ns + kErrorBits * kSecond / rates.nominal;
        for (CanNode* node : others) {
            node->failed(false, WireError::form);
        }
        sender.failed(true, WireError::bit);
        return;
    }
    if (others.empty()) {
        end_ns_ = now_ns + kErrorBits * kSecond / rates.nominal;
        sender.failed(true, WireError::ack);
        return;
    }
    sender.sent();
    for (CanNode* node : others) {
        node->heard(frame_, began_ns_);
    }
}

}  // namespace sc::model
