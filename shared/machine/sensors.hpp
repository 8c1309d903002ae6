// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Which distance sensors a cell has, and on which RS485 bus. Part of the machine's configuration.

namespace sc {

inline constexpr std::size_t kSensorBuses = 2;
/// Place of a sensor in every array of four: the triangulation sensor beside the head that looks along −y, then the
/// three of the triple head.
inline constexpr std::size_t kSensorCount = 4;
inline constexpr std::size_t kYSensor = 0;
inline constexpr std::size_t kFirstTriple = 1;
inline constexpr std::size_t kTripleCount = 3;

/// What the controller remembers of the surface that the Y sensor has looked at: so many places, a bin of the line
/// each.
inline constexpr std::size_t kSurfacePlaces = 256;
inline constexpr double kSurfaceBin = 1.0e-3;    ///< m of line
inline constexpr double kSurfaceReach = 1.5e-3;  ///< m in x and z: how far what was seen is taken to hold
inline constexpr double kSurfaceGap = 2.0e-3;    ///< m: a look that saw nothing for longer has not seen the line

/// Distances of sensors are integers of 10 nm (the link's wire units).
using SensorValue = std::int32_t;

enum class SensorKind : std::uint8_t {
    none = 0,
    triangulation = 1,  ///< RF602 type: Modbus RTU, value = base + D · range / 16384
    phase = 2,          ///< TW10S / L1s type: Modbus RTU, 32-bit value of 0.1 mm, its top bit a fault
    ascii = 3,          ///< HL-G1 type: lines of text with a block check
};
enum class SensorParity : std::uint8_t { none = 0, even = 1 };

struct SensorBusConfig {
    std::uint32_t baud = 0;  ///< 2400..230400; 0: no such bus
    SensorParity parity = SensorParity::none;
    /// Silence between telegrams of 3.5 characters at any rate. The standard has 1.75 ms above 19 200 baud; only where
    /// every sensor of the bus allows it.
    std::uint8_t short_gaps = 0;
    /// A broadcast latches all triangulation sensors of the bus at one instant before each round.
    std::uint8_t latch = 0;
};

struct SensorConfig {
    SensorKind kind = SensorKind::none;
    std::uint8_t bus = 0;
    std::uint8_t address = 0;  ///< 1..247
    /// What the sensor must say of itself: serial number (triangulation) or stored offset (phase); 0 = any.
    std::uint32_t identity = 0;
    SensorValue near = 0;          ///< values below are out of range
    SensorValue far = 0;           ///< and above
    SensorValue jump = 0;          ///< a value so far from the last one must be confirmed by a second; 0 = none is
    std::int64_t update_ns = 0;    ///< the sensor has a new value so often
    std::int64_t patience_ns = 0;  ///< an answer that has not begun so long after the request will not come
    std::int64_t stuck_ns = 0;     ///< the same value for so long means that the sensor has frozen
    std::int64_t too_old_ns = 0;   ///< a value older than this is stale
};

struct SensorsConfig {
    std::array<SensorBusConfig, kSensorBuses> bus{};
    std::array<SensorConfig, kSensorCount> sensor{};
};

}  // namespace sc
