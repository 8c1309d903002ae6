// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/path/item.hpp"
#include "shared/units/time.hpp"

namespace sc::host {

/// What a person wants to know of a running job.
struct Progress {
    std::uint32_t items = 0;  ///< of the job
    std::uint32_t sent = 0;
    std::uint32_t planned = 0;
    std::uint32_t fired = 0;
    double fraction = 0.0;            ///< of the time the job takes, 0..1
    Nanoseconds elapsed{0};           ///< in the cell's time
    std::optional<Nanoseconds> left;  ///< not known before something is done
};

/// Weighs the items of a job by the time they take, so that "half done" means half of the time. The weights are rough
/// (distance over speed, a fixed time for turns and for the way to a path); the pace measured so far scales them.
class ProgressEstimate {
public:
    /// `expected_seconds` is the plan's own estimate for the whole; 0 = none. O(items), once.
    ProgressEstimate(std::span<const Item> items, double expected_seconds);

    /// Share of the job's time that the first `fired` items make up.
    [[nodiscard]] double fraction(std::uint32_t fired) const noexcept;
    /// Time to go: from the plan at first, from the pace so far as the job goes on.
    [[nodiscard]] std::optional<Nanoseconds> left(double fraction, Nanoseconds elapsed) const noexcept;

private:
    std::vector<double> until_;  ///< cumulative seconds: until_[i] is the time of the first i items
    double expected_ = 0.0;
};

}  // namespace sc::host
