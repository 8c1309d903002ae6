// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "shared/link/later_messages.hpp"
#include "shared/wire/bytes.hpp"

/// Records of the controller's black box as bytes: what the cell did in its last seconds. Fixed sizes, little-endian.
/// Any context.

namespace sc::link {

enum class BlackboxPart : std::uint8_t { samples = 0, events = 1 };

/// How the cell stood at a tick. Units: places 1 µm (C 0.001°), errors 0.1 µm (0.0001°), both limited to what fits.
struct BlackboxSample {
    static constexpr std::size_t kBytes = 30;
    std::uint16_t tick = 0;                ///< low bits; the newest is that of `newest_us`
    std::array<std::int32_t, 4> actual{};  ///< 24 bits on the wire
    std::array<std::int16_t, 4> error{};   ///< following error: how far outside the set-points that are due
    std::uint8_t state = 0;
    std::uint8_t limited_by = 0;
    std::uint8_t override_percent = 0;
    std::uint8_t flags = 0;    ///< StatusFlag bits
    std::uint16_t queue = 0;   ///< items that wait
    std::uint16_t pulses = 0;  ///< fired since start, low bits
    bool operator==(const BlackboxSample&) const noexcept = default;
};
inline constexpr std::int32_t kBlackboxPlaceLimit = 0x7F'FFFF;

enum class BlackboxKind : std::uint8_t {
    state = 1,         ///< a: new state, b: the one before
    fault = 2,         ///< a: axis or 255, b: Fault
    command = 3,       ///< a: Verb, b: Refusal or 0
    request = 4,       ///< another request than a command; a: 0, b: its Refusal
    link_silent = 5,   ///< the host is silent
    link_back = 6,     ///< a: 0 a new session, 1 the same again
    job_opened = 7,    ///< b: low bits of the job's hash
    item_refused = 8,  ///< a: axis, b: Refusal
    starved = 9,       ///< b: how often so far, low bits
    frames_bad = 10,   ///< link frames spoilt since the sample before; b: how many
};

struct BlackboxEvent {
    static constexpr std::size_t kBytes = 8;
    std::uint32_t tick = 0;  ///< low bits
    std::uint8_t kind = 0;   ///< BlackboxKind
    std::uint8_t a = 0;
    std::uint16_t b = 0;
    bool operator==(const BlackboxEvent&) const noexcept = default;
};

[[nodiscard]] constexpr std::string_view name_of(BlackboxKind kind) noexcept {
    switch (kind) {
        case BlackboxKind::state: return "state";
        case BlackboxKind::fault: return "fault";
        case BlackboxKind::command: return "command";
        case BlackboxKind::request: return "request";
        case BlackboxKind::link_silent: return "link_silent";
        case BlackboxKind::link_back: return "link_back";
        case BlackboxKind::job_opened: return "job_opened";
        case BlackboxKind::item_refused: return "item_refused";
        case BlackboxKind::starved: return "starved";
        case BlackboxKind::frames_bad: return "frames_bad";
    }
    return "unknown";
}

constexpr void pack(const BlackboxSample& sample, std::span<std::uint8_t, BlackboxSample::kBytes> out) noexcept {
    ByteWriter writer(out);
    writer.put(sample.tick);
    for (const std::int32_t place : sample.actual) {
        const auto bits = static_cast<std::uint32_t>(place);
        writer.put(static_cast<std::uint16_t>(bits & 0xFFFFU));
        writer.put(static_cast<std::uint8_t>((bits >> 16U) & 0xFFU));
    }
    for (const std::int16_t error : sample.error) {
        writer.put(error);
    }
    writer.put(sample.state);
    writer.put(sample.limited_by);
    writer.put(sample.override_percent);
    writer.put(sample.flags);
    writer.put(sample.queue);
    writer.put(sample.pulses);
}

[[nodiscard]] constexpr BlackboxSample unpack_sample(
    std::span<const std::uint8_t, BlackboxSample::kBytes> bytes) noexcept {
    ByteReader reader(bytes);
    BlackboxSample sample;
    sample.tick = reader.get<std::uint16_t>();
    for (std::int32_t& place : sample.actual) {
        std::uint32_t bits = reader.get<std::uint16_t>();
        bits |= std::uint32_t{reader.get<std::uint8_t>()} << 16U;
        place = static_cast<std::int32_t>(bits ^ 0x80'0000U) - 0x80'0000;
    }
    for (std::int16_t& error : sample.error) {
        error = reader.get<std::int16_t>();
    }
    sample.state = reader.get<std::uint8_t>();
    sample.limited_by = reader.get<std::uint8_t>();
    sample.override_percent = reader.get<std::uint8_t>();
    sample.flags = reader.get<std::uint8_t>();
    sample.queue = reader.get<std::uint16_t>();
    sample.pulses = reader.get<std::uint16_t>();
    return sample;
}

constexpr void pack(const BlackboxEvent& event, std::span<std::uint8_t, BlackboxEvent::kBytes> out) noexcept {
    ByteWriter writer(out);
    writer.put(event.tick);
    writer.put(event.kind);
    writer.put(event.a);
    writer.put(event.b);
}

[[nodiscard]] constexpr BlackboxEvent unpack_event(
    std::span<const std::uint8_t, BlackboxEvent::kBytes> bytes) noexcept {
    ByteReader reader(bytes);
    BlackboxEvent event;
    event.tick = reader.get<std::uint32_t>();
    event.kind = reader.get<std::uint8_t>();
    event.a = reader.get<std::uint8_t>();
    event.b = reader.get<std::uint16_t>();
    return event;
}

}  // namespace sc::link
