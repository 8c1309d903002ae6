// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <random>

#include "boards/bench/bus/bus_load.hpp"
#include "boards/sim/carrier/frame_bits.hpp"
#include "shared/drives/bus_budget.hpp"

namespace sc::bench {
namespace {

/// Changes one bit, one byte, or takes a pattern that makes a stuff bit each four bits.
void change(link::LinkCanFrame& frame, std::mt19937& random) {
    const auto pick = [&random](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    switch (frame.size == 0 ? 0 : pick(3)) {
        case 0: frame.id = 0x080 + pick(0x700); break;
        case 1: {
            std::uint8_t& byte = frame.data.at(pick(frame.size));
            byte = static_cast<std::uint8_t>(byte ^ (1U << pick(8)));
            break;
        }
        default: {
            const std::uint64_t pattern = 0x8787'8787'8787'8787ULL << pick(8);
            const std::uint32_t from = pick(frame.size);
            for (std::uint32_t i = from; i < frame.size; ++i) {
                frame.data.at(i) = static_cast<std::uint8_t>(pattern >> (8U * i % 56U));
            }
        }
    }
}

}  // namespace

std::vector<StuffingResult> search_stuffing(std::uint32_t seed, int rounds) {
    std::vector<StuffingResult> results;
    std::mt19937 random(seed);
    for (const std::uint8_t bytes : std::array<std::uint8_t, 5>{0, 1, 2, 6, 8}) {
        StuffingResult result;
        result.bytes = bytes;
        result.bound = static_cast<int>(drives::worst_frame_bits(bytes));
        for (int round = 0; round < rounds; ++round) {
            link::LinkCanFrame best;
            best.size = bytes;
            int bits = sim::frame_bits(best).nominal;
            for (int k = 0; k < 400; ++k) {
                link::LinkCanFrame next = best;
                change(next, random);
                const int longer = sim::frame_bits(next).nominal;
                if (longer >= bits) {
                    best = next;
                    bits = longer;
                }
            }
            result.found = bits > result.found ? bits : result.found;
        }
        results.push_back(result);
    }
    return results;
}

}  // namespace sc::bench
