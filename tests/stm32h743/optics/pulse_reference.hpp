// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "firmware/hal/io.hpp"

/// Where the triggers of runs belong, from absolute times alone: no state from trigger to trigger.

namespace sc::test {

struct Pulse {
    std::int64_t count = 0;  ///< of 240 MHz from control time 0
    bool picked = false;
};

/// Times in 1/256 ns below 2^53, so that long double holds every term.
inline std::vector<Pulse> expected_pulses(const std::vector<LaserRun>& runs) {
    std::vector<Pulse> all;
    const auto count_at = [](std::int64_t ns256) {
        return static_cast<std::int64_t>(std::floor(static_cast<long double>(ns256) * 6.0L / 6400.0L + 0.5L));
    };
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const LaserRun& run = runs[r];
        const std::int64_t end = r + 1 < runs.size() ? count_at(runs[r + 1].t0_ns * 256) : INT64_MAX;
        for (std::int64_t j = 0; j < run.count; ++j) {
            const std::int64_t pulse =
                run.t0_ns * 256 + j * run.period_ns256 + std::int64_t{run.change_ns256} * (j * (j - 1) / 2);
            const std::int64_t period = run.period_ns256 + std::int64_t{run.change_ns256} * j;
            for (std::int64_t m = 0; m < run.pick; ++m) {
                const std::int64_t at = count_at(pulse + period * m / run.pick);
                if (m == 0 || at + 120 <= end) {
                    all.push_back({at, m == 0});
                }
            }
        }
    }
    return all;
}

/// Runs of one window with triggers 500 ns apart or more, in order; `last_ns` is where the runs before it ended.
inline std::vector<LaserRun> random_window(std::mt19937& random, std::int64_t begin_ns, std::int64_t& last_ns) {
    const auto within = [&random](std::int64_t low, std::int64_t high) {
        return std::uniform_int_distribution<std::int64_t>(low, high)(random);
    };
    std::vector<LaserRun> runs;
    std::int64_t at = std::max(begin_ns, last_ns + 700) + within(0, within(0, 2) == 0 ? 400'000 : 3'000);
    const std::int64_t most = within(0, 6);
    while (at < begin_ns + 995'000 && static_cast<std::int64_t>(runs.size()) < most) {
        LaserRun run;
        run.t0_ns = at;
        run.pick = static_cast<std::uint8_t>(within(0, 1) == 0 ? 1 : within(1, 20));
        run.period_ns256 = within(520 * 256, within(0, 1) == 0 ? 800 * 256 : 30'000 * 256) * run.pick;
        run.count = static_cast<std::uint16_t>(within(1, 200));
        run.change_ns256 = static_cast<std::int32_t>(within(-200, 200));
        const auto pulse = [&run](std::int64_t j) {
            return run.t0_ns + (j * run.period_ns256 + run.change_ns256 * (j * (j - 1) / 2)) / 256;
        };
        while (run.count > 1 && (pulse(run.count - 1) >= begin_ns + 999'000 ||
                                 run.period_ns256 + run.count * run.change_ns256 < 510 * 256 * run.pick)) {
            --run.count;
        }
        if (run.count == 1 && run.period_ns256 + run.change_ns256 < 510 * 256 * run.pick) {
            run.change_ns256 = 0;
        }
        runs.push_back(run);
        const std::int64_t tail = within(0, 1) == 0 ? 0 : within(0, 60'000);
        at = pulse(run.count - 1) + 700 + tail;
        last_ns = pulse(run.count - 1);
    }
    return runs;
}

}  // namespace sc::test
