// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/histogram.hpp"

#include <algorithm>

namespace sc::linux_rt {

void Histogram::add(std::int64_t ns) noexcept {
    const std::int64_t us = std::clamp<std::int64_t>(ns / 1000, 0, kBuckets);
    const auto relaxed = std::memory_order_relaxed;
    buckets_[static_cast<std::size_t>(us)].fetch_add(1, relaxed);
    count_.fetch_add(1, relaxed);
    sum_ns_.fetch_add(ns, relaxed);
    if (ns > max_ns_.load(relaxed)) {
        max_ns_.store(ns, relaxed);
    }
}

double Histogram::mean_us() const noexcept {
    const std::uint64_t n = count();
    return n == 0 ? 0.0 : static_cast<double>(sum_ns_.load(std::memory_order_relaxed)) * 1e-3 / static_cast<double>(n);
}

std::size_t Histogram::quantile_us(double share) const noexcept {
    const double wanted = share * static_cast<double>(count());
    std::uint64_t seen = 0;
    for (std::size_t us = 0; us <= kBuckets; ++us) {
        seen += at(us);
        if (static_cast<double>(seen) >= wanted) {
            return us;
        }
    }
    return kBuckets;
}

}  // namespace sc::linux_rt
