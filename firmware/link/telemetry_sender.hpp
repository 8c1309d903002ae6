// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/link/telemetry.hpp"

namespace sc::link {

/// What the channels hold in a tick. Places in wire units.
struct TelemetryValues {
    std::array<std::int32_t, 4> set_point{};
    std::array<std::int32_t, 4> actual{};
    std::array<std::int32_t, 4> following_error{};
    std::uint8_t state = 0;
    std::uint8_t first_fault = 0;
    std::uint8_t limited_by = 0;
    std::uint8_t override_percent = 0;
    std::uint8_t flags = 0;
    std::uint16_t queue = 0;
    std::uint32_t pulses = 0;
    std::uint32_t starvations = 0;
    std::uint32_t frames_bad = 0;
    std::uint32_t messages_lost = 0;
    std::int32_t y_sensor = 0;
    std::int32_t surface_depth = 0;
    std::int32_t shift = 0;
    std::array<std::int32_t, 3> triple{};
};

/// Which channels are due, and whether the line has room for them. A model of the carrier, bytes in and bytes out at
/// the rate that the host has stated, says how much of what was sent is still on its way: a sample leaves only when
/// all of it will be gone within the tick, so that the next acknowledgement waits for one sample at most. Servo
/// context; a tick costs some 30 instructions.
class TelemetrySender {
public:
    /// Refusal::none: in force from this tick on; else nothing has changed, and `detail` is as in TelemetryRequest.
    [[nodiscard]] Refusal subscribe(const TelemetryRequest& request, std::uint32_t period_ns, std::int64_t tick,
                                    std::int64_t& detail) noexcept;
    void stop() noexcept { channels_ = due_ = 0; }
    /// Once a tick, with the bytes that other messages take of it.
    void step(std::int64_t tick, std::size_t bytes) noexcept;
    /// Channels that should be sent now; 0 also while the line is busy.
    [[nodiscard]] std::uint32_t due() const noexcept { return on_its_way_ <= per_tick_ ? due_ : 0; }
    /// The message of the channels that are due.
    [[nodiscard]] Telemetry message(const TelemetryValues& values, std::uint64_t cell_time_us) const noexcept;
    void sent(std::size_t bytes) noexcept;

private:
    static constexpr std::uint64_t kParts = 256;  ///< of a byte
    std::uint32_t channels_ = 0;
    std::uint32_t due_ = 0;
    std::array<std::uint16_t, TelemetryRequest::kGroups> period_{};
    std::array<std::int64_t, TelemetryRequest::kGroups> next_{};
    std::uint16_t skipped_ = 0;
    std::uint64_t per_tick_ = 0;    ///< 1/256 byte
    std::uint64_t on_its_way_ = 0;  ///< 1/256 byte
};

}  // namespace sc::link
