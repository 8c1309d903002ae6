// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace sc::linux_rt {

/// Times in whole microseconds: each up to 999, then those beyond by themselves. One thread adds, any may read. No
/// heap.
class Histogram {
public:
    static constexpr std::size_t kBuckets = 1000;

    void add(std::int64_t ns) noexcept;

    [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
    [[nodiscard]] std::int64_t max_ns() const noexcept { return max_ns_.load(std::memory_order_relaxed); }
    [[nodiscard]] double mean_us() const noexcept;
    /// The least number of microseconds that so large a share (0..1) does not exceed; kBuckets: beyond them.
    [[nodiscard]] std::size_t quantile_us(double share) const noexcept;
    [[nodiscard]] std::uint64_t at(std::size_t us) const noexcept {
        return buckets_.at(us).load(std::memory_order_relaxed);
    }

private:
    std::array<std::atomic<std::uint64_t>, kBuckets + 1> buckets_{};
    std::atomic<std::uint64_t> count_{0};
    std::atomic<std::int64_t> sum_ns_{0};
    std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace sc::linux_rt
