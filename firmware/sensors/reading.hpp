// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::sensors {

/// How far a value can be trusted. On the wire as its number.
enum class Quality : std::uint8_t {
    none = 0,          ///< nothing has been read yet
    good = 1,          ///< a new value of the sensor
    repeated = 2,      ///< the value of before: the sensor has not measured again since
    stale = 3,         ///< too old, or the sensor has frozen
    out_of_range = 4,  ///< there is nothing where the sensor may measure
    faulty = 5,        ///< no contact, a fault of its own, or another device
};
/// The value may be used.
[[nodiscard]] constexpr bool usable(Quality quality) noexcept {
    return quality == Quality::good || quality == Quality::repeated;
}

/// What is known of one sensor at one time.
struct Sample {
    SensorValue value = 0;         ///< 10 nm; the last good one
    std::int64_t measured_ns = 0;  ///< control time of the measurement, to within half the sensor's period
    Quality quality = Quality::none;
    SensorCode code = SensorCode::not_read;  ///< why it is not good; none when it is
    std::uint8_t detail = 0;                 ///< of the code: exception, who answered, the sensor's own fault
    std::uint32_t count = 0;                 ///< measurements taken since the start
    std::uint32_t repeats = 0;               ///< reads that brought nothing new
    std::uint32_t bad = 0;                   ///< telegrams that failed
    SensorCode last_bad = SensorCode::none;  ///< why the last of them did
};

/// Judges the values of one sensor as they come: new or repeated, in range, confirmed after a jump, frozen, too old.
/// A sensor that is read more often than it measures repeats itself; a value equal to the last counts as new once the
/// sensor's period has passed. Servo context, some 40 instructions a value.
class Reading {
public:
    /// Telegrams in a row that may fail before the sensor counts as faulty.
    static constexpr std::uint32_t kFailures = 3;

    explicit Reading(const SensorConfig& config) noexcept : config_(config) {}

    /// A value that was on the sensor's output at `asked_ns`.
    void take(SensorValue value, std::int64_t asked_ns) noexcept;
    /// The sensor says that it sees nothing.
    void take_nothing(std::int64_t asked_ns) noexcept;
    /// The sensor says that it is not well.
    void take_own_fault(std::uint8_t detail) noexcept;
    /// A telegram has failed.
    void fail(SensorCode code, std::uint8_t detail) noexcept;
    /// It is, or is not, the device that it should be.
    void identify(bool right) noexcept { foreign_ = !right; }
    /// Contact, whatever was said.
    void touch() noexcept { failures_ = 0; }
    [[nodiscard]] bool lost() const noexcept { return failures_ >= kFailures; }

    [[nodiscard]] Sample at(std::int64_t now_ns) const noexcept;
    [[nodiscard]] std::uint32_t count() const noexcept { return sample_.count; }

private:
    enum class Word : std::uint8_t { nothing, value, no_target, own_fault };

    [[nodiscard]] bool near_to(SensorValue a, SensorValue b) const noexcept;
    [[nodiscard]] bool believed(SensorValue value, std::int64_t asked_ns) noexcept;

    SensorConfig config_;
    Sample sample_;
    Word word_ = Word::nothing;
    std::uint32_t failures_ = 0;
    bool foreign_ = false;
    bool repeated_ = false;
    bool candidate_ = false;  ///< a value after a jump waits for a second
    SensorValue candidate_value_ = 0;
    std::int64_t candidate_ns_ = 0;
    std::int64_t asked_ns_ = 0;    ///< of the last value
    std::int64_t fresh_ns_ = 0;    ///< of the last new one
    std::int64_t changed_ns_ = 0;  ///< of the last that differed
};

}  // namespace sc::sensors
