// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

/// One clock type per time domain; mixing them does not compile. All are signed 64-bit nanoseconds (292 years), so no
/// wrap-around arithmetic exists anywhere. None of them can be read here: a board or the host supplies the time.

namespace sc {

/// The controller's time: tick n begins at n control periods.
struct ControlClock {
    using rep = std::int64_t;
    using period = std::nano;
    using duration = std::chrono::nanoseconds;
    using time_point = std::chrono::time_point<ControlClock, duration>;
    static constexpr bool is_steady = true;
};
/// The host's monotonic time (virtual when the cell is simulated in lock-step).
struct HostClock {
    using rep = std::int64_t;
    using period = std::nano;
    using duration = std::chrono::nanoseconds;
    using time_point = std::chrono::time_point<HostClock, duration>;
    static constexpr bool is_steady = true;
};
/// Time along one path, from the moment its time law starts.
struct PathClock {
    using rep = std::int64_t;
    using period = std::nano;
    using duration = std::chrono::nanoseconds;
    using time_point = std::chrono::time_point<PathClock, duration>;
    static constexpr bool is_steady = true;
};

using Nanoseconds = std::chrono::nanoseconds;
using ControlTime = ControlClock::time_point;
using HostTime = HostClock::time_point;
using PathTime = PathClock::time_point;

}  // namespace sc
