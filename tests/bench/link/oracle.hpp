// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/path/item.hpp"

namespace sc::bench {

/// Points in against points out. Point k of a campaign's job is (k, k mod 7, 1); that is all this knows. It includes
/// nothing of the link.
struct Tally {
    std::uint64_t points = 0;
    std::uint64_t lost = 0;
    std::uint64_t doubled = 0;
    std::uint64_t reordered = 0;
    std::uint64_t foreign = 0;

    void add(std::uint32_t sent, std::span<const PathPoint> out) {
        std::vector<std::uint8_t> seen(sent, 0);
        std::int64_t highest = -1;
        for (const PathPoint& p : out) {
            if (p.x < 0 || p.x >= static_cast<std::int64_t>(sent) || p.y != p.x % 7 || p.z != 1) {
                ++foreign;
                continue;
            }
            std::uint8_t& count = seen[static_cast<std::size_t>(p.x)];
            doubled += count > 0 ? 1U : 0U;
            reordered += count == 0 && p.x < highest ? 1U : 0U;
            count = 1;
            highest = p.x > highest ? p.x : highest;
        }
        for (const std::uint8_t count : seen) {
            lost += count == 0 ? 1U : 0U;
        }
        points += sent;
    }
};

}  // namespace sc::bench
