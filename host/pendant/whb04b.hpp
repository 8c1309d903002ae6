// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// What a pendant XHC WHB04B-6 says and shows, byte by byte (docs/pendant.md: what is known of it, and from where).

namespace sc::host::pendant {

inline constexpr std::uint16_t kVendor = 0x10CE;
inline constexpr std::uint16_t kProduct = 0xEB93;
inline constexpr std::size_t kInputBytes = 8;

enum class Key : std::uint8_t {
    none = 0x00,
    reset = 0x01,
    stop = 0x02,
    start_pause = 0x03,
    feed_plus = 0x04,
    feed_minus = 0x05,
    spindle_plus = 0x06,
    spindle_minus = 0x07,
    machine_home = 0x08,
    safe_z = 0x09,
    workpiece_home = 0x0A,
    spindle = 0x0B,
    fn = 0x0C,
    probe_z = 0x0D,
    continuous = 0x0E,
    step = 0x0F,
    macro_10 = 0x10,
};

/// Where the axis knob stands.
enum class AxisKnob : std::uint8_t { unknown = 0, off = 0x06, x = 0x11, y, z, a, b, c };

/// Where the feed knob stands, by what is printed there (mm a detent, or percent).
enum class FeedKnob : std::uint8_t {
    unknown = 0,
    mm_0_001 = 0x0D,
    mm_0_01 = 0x0E,
    mm_0_1 = 0x0F,
    mm_1 = 0x10,
    percent_60 = 0x1A,
    percent_100 = 0x1B,
    lead = 0x1C,
};

struct Report {
    std::array<Key, 2> keys{};  ///< held down
    FeedKnob feed = FeedKnob::unknown;
    AxisKnob axis = AxisKnob::unknown;
    int detents = 0;     ///< of the wheel since the last report, -128..127
    bool proven = true;  ///< the checksum is right. With a key down its rule is not known: taken as proven then

    [[nodiscard]] bool holds(Key key) const { return keys[0] == key || keys[1] == key; }
};

/// Nothing unless these are the bytes of an input report, with codes that are known.
[[nodiscard]] std::optional<Report> parse_report(std::span<const std::uint8_t> bytes);
/// The bytes of a report, for pendants that are played.
[[nodiscard]] std::array<std::uint8_t, kInputBytes> to_bytes(const Report& report, std::uint8_t random);

/// What the pendant shows: three lines, with four places behind the point, and two whole numbers below.
struct Display {
    std::array<double, 3> lines{};  ///< beyond ±65535.9999 they stay there
    std::uint16_t feed = 0;
    std::uint16_t speed = 0;
    bool stepping = true;  ///< the word STEP, not CONT
    bool machine = true;   ///< machine's coordinates, not the workpiece's

    friend bool operator==(const Display&, const Display&) = default;
};

inline constexpr std::size_t kFeatureBytes = 8;
/// The feature reports that show it, in this order, each with its number in front.
[[nodiscard]] std::array<std::array<std::uint8_t, kFeatureBytes>, 3> to_reports(const Display& display);

}  // namespace sc::host::pendant
