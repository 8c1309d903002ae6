// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace sc::host {

/// Threads that work of this folder uses when asked for 0: all cores.
[[nodiscard]] inline unsigned thread_count(unsigned asked) noexcept {
    return asked > 0 ? asked : std::max(1U, std::thread::hardware_concurrency());
}

/// Calls work(begin, end, worker) for pieces of [0, count) of at most `piece`, on `threads` threads, the caller's among
/// them. Which worker gets which piece differs from run to run. `work` must not throw.
template <class Work>
void parallel_pieces(std::size_t count, std::size_t piece, unsigned threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    const auto run = [&](unsigned worker) {
        while (true) {
            const std::size_t begin = next.fetch_add(piece, std::memory_order_relaxed);
            if (begin >= count) {
                return;
            }
            work(begin, std::min(begin + piece, count), worker);
        }
    };
    std::vector<std::thread> others;
    for (unsigned worker = 1; worker < threads && piece * worker < count; ++worker) {
        others.emplace_back(run, worker);
    }
    run(0);
    for (std::thread& thread : others) {
        thread.join();
    }
}

}  // namespace sc::host
