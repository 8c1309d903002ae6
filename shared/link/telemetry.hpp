// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "shared/link/cobs.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/later_messages.hpp"

/// The channels of `telemetry`: their numbers, groups and values, and what a subscription costs on the line. One table
/// for both ends. Everything but the table's look-up is arithmetic; any context.

namespace sc::link {

enum class TelemetryGroup : std::uint8_t { motion = 0, state = 1, counters = 2, sensors = 3 };
inline constexpr std::array<std::string_view, TelemetryRequest::kGroups> kTelemetryGroups{"motion", "state", "counters",
                                                                                          "sensors"};

/// Bit of each channel in `channels`.
enum class TelemetryChannel : std::uint8_t {
    set_point = 0,
    actual = 1,
    following_error = 2,
    state = 3,
    first_fault = 4,
    limited_by = 5,
    override_percent = 6,
    flags = 7,
    queue = 8,
    pulses = 9,
    starvations = 10,
    frames_bad = 11,
    messages_lost = 12,
    y_sensor = 13,
    surface_depth = 14,
    shift = 15,
    triple = 16,
};

struct TelemetryColumn {
    std::string_view name;
    TelemetryGroup group = TelemetryGroup::motion;
    std::uint8_t bytes = 0;  ///< of one value: 1 and 2 without sign, 4 as `sign` says
    std::uint8_t count = 0;  ///< of values: 4 axes, 3 sensors
    bool sign = false;
    bool place = false;  ///< wire units: 10 nm, of C 0.00001 degrees
};

/// In the order of the bits.
inline constexpr std::array<TelemetryColumn, 17> kTelemetryColumns{{
    {"set_point", TelemetryGroup::motion, 4, 4, true, true},
    {"actual", TelemetryGroup::motion, 4, 4, true, true},
    {"following_error", TelemetryGroup::motion, 4, 4, true, true},
    {"state", TelemetryGroup::state, 1, 1, false, false},
    {"first_fault", TelemetryGroup::state, 1, 1, false, false},
    {"limited_by", TelemetryGroup::state, 1, 1, false, false},
    {"override_percent", TelemetryGroup::state, 1, 1, false, false},
    {"flags", TelemetryGroup::state, 1, 1, false, false},
    {"queue", TelemetryGroup::state, 2, 1, false, false},
    {"pulses", TelemetryGroup::counters, 4, 1, false, false},
    {"starvations", TelemetryGroup::counters, 4, 1, false, false},
    {"frames_bad", TelemetryGroup::counters, 4, 1, false, false},
    {"messages_lost", TelemetryGroup::counters, 4, 1, false, false},
    {"y_sensor", TelemetryGroup::sensors, 4, 1, true, true},
    {"surface_depth", TelemetryGroup::sensors, 4, 1, true, true},
    {"shift", TelemetryGroup::sensors, 4, 1, true, true},
    {"triple", TelemetryGroup::sensors, 4, 3, true, true},
}};

[[nodiscard]] constexpr std::uint32_t telemetry_bit(TelemetryChannel channel) noexcept {
    return std::uint32_t{1} << static_cast<unsigned>(channel);
}
inline constexpr std::uint32_t kTelemetryChannels = (std::uint32_t{1} << kTelemetryColumns.size()) - 1;

/// Bits of a group's channels.
[[nodiscard]] constexpr std::uint32_t telemetry_group_bits(TelemetryGroup group) noexcept {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kTelemetryColumns.size(); ++i) {
        bits |= kTelemetryColumns[i].group == group ? std::uint32_t{1} << i : 0U;
    }
    return bits;
}
/// Bytes of the values of these channels.
[[nodiscard]] constexpr std::uint32_t telemetry_value_bytes(std::uint32_t channels) noexcept {
    std::uint32_t bytes = 0;
    for (std::size_t i = 0; i < kTelemetryColumns.size(); ++i) {
        const TelemetryColumn& column = kTelemetryColumns[i];
        bytes += ((channels >> i) & 1U) != 0 ? std::uint32_t{column.bytes} * column.count : 0U;
    }
    return bytes;
}
static_assert(telemetry_value_bytes(kTelemetryChannels) <= sizeof(Bytes::data));

/// A sample on a serial line without its values.
inline constexpr std::uint32_t kTelemetryOverhead = cobs_capacity(kMessageOverhead + 4 + 8 + 2 + 1);
/// Of a line whose rate the host does not know: 115 200 baud.
inline constexpr std::uint32_t kTelemetryLine = 11'520;
/// Telemetry may take this part of the line: the rest is for acknowledgements, states and what is asked for.
inline constexpr std::uint32_t kTelemetryPart = 4;
/// Two samples are never nearer: in the tick of an acknowledgement or a state there is none.
inline constexpr std::uint16_t kTelemetryShortest = 2;
inline constexpr std::uint16_t kTelemetryLongest = 60'000;

[[nodiscard]] constexpr std::uint32_t telemetry_budget(std::uint32_t line_bytes_per_s) noexcept {
    return (line_bytes_per_s == 0 ? kTelemetryLine : line_bytes_per_s) / kTelemetryPart;
}

/// Bytes a second that a subscription takes at most, each group in messages of its own, if no period were shorter than
/// `shortest` ticks.
[[nodiscard]] constexpr std::uint64_t telemetry_bytes_per_s(const TelemetryRequest& request, std::uint32_t period_ns,
                                                            std::uint16_t shortest) noexcept {
    std::uint64_t bytes = 0;
    for (std::size_t g = 0; g < TelemetryRequest::kGroups; ++g) {
        const std::uint32_t wanted = request.channels & telemetry_group_bits(static_cast<TelemetryGroup>(g));
        if (wanted == 0) {
            continue;
        }
        const std::uint16_t ticks = request.period_ticks[g] < shortest ? shortest : request.period_ticks[g];
        const std::uint64_t each_ns = std::uint64_t{ticks} * period_ns;
        bytes += ((kTelemetryOverhead + telemetry_value_bytes(wanted)) * 1'000'000'000ULL + each_ns - 1) / each_ns;
    }
    return bytes;
}

/// The shortest period that all groups may have, none of them a shorter one than it asks for; kTelemetryLongest + 1 if
/// none fits. Bisection, 16 times the above.
[[nodiscard]] constexpr std::uint16_t telemetry_fitting_period(const TelemetryRequest& request,
                                                               std::uint32_t period_ns) noexcept {
    const std::uint32_t budget = telemetry_budget(request.line_bytes_per_s);
    std::uint16_t low = kTelemetryShortest - 1;  // does not fit, or is not allowed
    std::uint16_t high = kTelemetryLongest + 1;
    while (high - low > 1) {
        const auto middle = static_cast<std::uint16_t>((std::uint32_t{low} + high) / 2);
        if (telemetry_bytes_per_s(request, period_ns, middle) <= budget) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

}  // namespace sc::link
