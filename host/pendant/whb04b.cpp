// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/whb04b.hpp"

#include <algorithm>
#include <cmath>

namespace sc::host::pendant {
namespace {

constexpr std::uint8_t kInputReport = 0x04;
constexpr std::uint8_t kFeatureReport = 0x06;
/// Of the checksum: what a display block brings along, and what holds before the first one has come.
constexpr std::uint8_t kSeed = 0xFE;
constexpr std::uint8_t kSeedBefore = 0xFF;
constexpr std::array<std::uint8_t, 2> kHeader{0xFE, 0xFD};
constexpr std::size_t kPayload = kFeatureBytes - 1;

constexpr std::uint8_t kStepFlag = 0x01;
constexpr std::uint8_t kMachineFlag = 0x80;
constexpr std::uint16_t kMinus = 0x8000;
constexpr double kPlaces = 1e4;
constexpr double kMost = 65535.9999;

bool is_key(std::uint8_t code) { return code <= static_cast<std::uint8_t>(Key::macro_10); }

std::optional<AxisKnob> axis_of(std::uint8_t code) {
    if (code == 0 || code == 0x06 || (code >= 0x11 && code <= 0x16)) {
        return static_cast<AxisKnob>(code);
    }
    return std::nullopt;
}

std::optional<FeedKnob> feed_of(std::uint8_t code) {
    if (code == 0 || (code >= 0x0D && code <= 0x10) || (code >= 0x1A && code <= 0x1C)) {
        return static_cast<FeedKnob>(code);
    }
    return std::nullopt;
}

void put(std::span<std::uint8_t> out, std::size_t at, std::uint16_t value) {
    out[at] = static_cast<std::uint8_t>(value & 0xFF);
    out[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

void put_line(std::span<std::uint8_t> out, std::size_t at, double value) {
    const double bounded = std::isfinite(value) ? std::clamp(value, -kMost, kMost) : 0.0;
    const auto size = static_cast<std::int64_t>(std::llround(std::abs(bounded) * kPlaces));
    const auto places = static_cast<std::int64_t>(kPlaces);
    put(out, at, static_cast<std::uint16_t>(size / places));
    const auto fraction = static_cast<std::uint16_t>(size % places);
    put(out, at + 2, bounded < 0.0 && size != 0 ? static_cast<std::uint16_t>(fraction | kMinus) : fraction);
}

}  // namespace

std::optional<Report> parse_report(std::span<const std::uint8_t> bytes) {
    if (bytes.size() != kInputBytes || bytes[0] != kInputReport || !is_key(bytes[2]) || !is_key(bytes[3])) {
        return std::nullopt;
    }
    const auto feed = feed_of(bytes[4]);
    const auto axis = axis_of(bytes[5]);
    if (!feed || !axis) {
        return std::nullopt;
    }
    Report out;
    out.keys = {static_cast<Key>(bytes[2]), static_cast<Key>(bytes[3])};
    out.feed = *feed;
    out.axis = *axis;
    const int wheel = bytes[6];
    out.detents = wheel < 128 ? wheel : wheel - 256;
    const bool pressed = bytes[2] != 0 || bytes[3] != 0;
    out.proven = pressed || bytes[7] == (bytes[1] & kSeed) || bytes[7] == (bytes[1] & kSeedBefore);
    return out;
}

std::array<std::uint8_t, kInputBytes> to_bytes(const Report& report, std::uint8_t random) {
    const auto sum = static_cast<std::uint8_t>((random & kSeed) ^ (report.proven ? 0x00 : 0x55));
    return {kInputReport,
            random,
            static_cast<std::uint8_t>(report.keys[0]),
            static_cast<std::uint8_t>(report.keys[1]),
            static_cast<std::uint8_t>(report.feed),
            static_cast<std::uint8_t>(report.axis),
            static_cast<std::uint8_t>(static_cast<std::int8_t>(std::clamp(report.detents, -128, 127))),
            sum};
}

std::array<std::array<std::uint8_t, kFeatureBytes>, 3> to_reports(const Display& display) {
    std::array<std::uint8_t, 3 * kPayload> block{};
    block[0] = kHeader[0];
    block[1] = kHeader[1];
    block[2] = kSeed;
    block[3] = static_cast<std::uint8_t>((display.stepping ? kStepFlag : 0) | (display.machine ? kMachineFlag : 0));
    for (std::size_t i = 0; i < display.lines.size(); ++i) {
        put_line(block, 4 + 4 * i, display.lines[i]);
    }
    put(block, 16, display.feed);
    put(block, 18, display.speed);
    std::array<std::array<std::uint8_t, kFeatureBytes>, 3> out{};
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i][0] = kFeatureReport;
        std::copy_n(block.begin() + static_cast<std::ptrdiff_t>(i * kPayload), kPayload, out[i].begin() + 1);
    }
    return out;
}

}  // namespace sc::host::pendant
