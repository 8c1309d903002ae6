// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/carrier/troubles.hpp"

#include <algorithm>

namespace sc::sim {

bool Troubles::chance(double share) {
    if (share <= 0.0) {
        return false;
    }
    constexpr double kPerDraw = 1.0 / 9007199254740992.0;
    return static_cast<double>(random_() >> 11U) * kPerDraw < share;
}

std::int64_t Troubles::up_to(std::int64_t most) {
    return most <= 0 ? 0 : static_cast<std::int64_t>(random_() % (static_cast<std::uint64_t>(most) + 1));
}

bool Troubles::cut(std::int64_t now_ns) const noexcept {
    return std::any_of(partitions_.begin(), partitions_.end(),
                       [now_ns](const Partition& p) { return p.from_ns <= now_ns && now_ns < p.until_ns; });
}

void Troubles::spoil(std::span<std::uint8_t> bytes) {
    if (!bytes.empty()) {
        const std::size_t at = random_() % bytes.size();
        bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1U << (random_() % 8)));
    }
}

}  // namespace sc::sim
