// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/sensors/sensor_hub.hpp"
#include "shared/codes/codes.hpp"

namespace sc::sensors {

/// Where the workpiece should sit, as the triple head sees it. 10 nm.
struct SeatingWanted {
    std::array<SensorValue, kTripleCount> expected{};
    SensorValue tolerance = 0;  ///< each distance may be so far off
    SensorValue tilt = 0;       ///< and the three may differ by so much in how far off they are
    std::uint8_t samples = 0;   ///< measurements of each sensor that are averaged, 1..kMostSamples
};

/// Checks a workpiece's seat: takes `samples` new measurements of each of the three sensors and compares their means.
/// Servo context, once a tick while busy; some 100 instructions.
class SeatingCheck {
public:
    static constexpr std::uint8_t kMostSamples = 100;
    /// For each measurement; then the check ends without a value.
    static constexpr std::int64_t kPatienceNs = 1'000'000'000;

    struct Result {
        bool done = false;
        Refusal refusal = Refusal::none;
        /// seating_no_value: sensor (1..3) · 1000 + its code; seating_off: the mean deviation; seating_tilted: by how
        /// much the deviations differ; seating_swapped: the order that fits, e.g. 213. 10 nm where a distance.
        std::int64_t detail = 0;
    };

    /// False for numbers that make no sense.
    [[nodiscard]] bool begin(const SeatingWanted& wanted, std::int64_t now_ns) noexcept;
    [[nodiscard]] bool busy() const noexcept { return busy_; }
    [[nodiscard]] Result step(const SensorHub& hub, std::int64_t now_ns) noexcept;
    /// Deviation of each sensor in the last check that had values, 10 nm.
    [[nodiscard]] const std::array<SensorValue, kTripleCount>& deviation() const noexcept { return deviation_; }

private:
    [[nodiscard]] Result compare() noexcept;

    SeatingWanted wanted_;
    bool busy_ = false;
    std::int64_t until_ns_ = 0;
    std::int64_t begun_ns_ = 0;
    std::array<std::uint32_t, kTripleCount> seen_{};
    std::array<std::uint8_t, kTripleCount> taken_{};
    std::array<std::int64_t, kTripleCount> sum_{};
    std::array<SensorValue, kTripleCount> deviation_{};
};

}  // namespace sc::sensors
