// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/geometry/vec.hpp"
#include "shared/machine/sensors.hpp"
#include "shared/units/quantity.hpp"

/// What a cell is made of: travel, limits, keep-out volumes, latencies. The board hands it to the controller; the host
/// reads it from the controller over the link and checks a job against it before anything moves.

namespace sc {

inline constexpr std::size_t kAxisCount = 4;
/// Index of an axis in every array of four: X, Y, Z linear (metres, picometres), C turntable (degrees, nanodegrees).
enum class Axis : std::uint8_t { x = 0, y = 1, z = 2, c = 3 };
constexpr std::size_t index(Axis axis) noexcept { return static_cast<std::size_t>(axis); }

/// Integer position of an axis as the control path commands it: picometres for X, Y, Z, nanodegrees for C. (A 1 nm grid
/// already costs 4 m/s³ in the third difference of 1 kHz samples.)
using AxisPositions = std::array<std::int64_t, kAxisCount>;
inline constexpr double kPmPerMetre = 1e12;
inline constexpr double kNdegPerDegree = 1e9;

/// One axis. Base unit: the metre for X, Y, Z, the degree for C; C has its own limits in its own unit.
struct AxisConfig {
    double travel_min = 0.0;  ///< base units, in h
    double travel_max = 0.0;
    double speed = 0.0;             ///< base units / s
    double acceleration = 0.0;      ///< base units / s²
    double jerk = 0.0;              ///< base units / s³
    double counts_per_unit = 0.0;   ///< drive counts per base unit (1e6: 1 µm; 1000: 0.001°)
    double following_window = 0.0;  ///< base units: more than this apart is a following error
    double home_position = 0.0;     ///< where the axis stands after homing, base units
    std::int64_t latency_ns = 0;    ///< from the sample's act time to the axis being there, at constant speed
    std::uint8_t drive_node = 0;    ///< CANopen node id
    /// Counts per base unit of an encoder that the board itself reads each tick (EncoderInputs). 0: there is none.
    double encoder_counts_per_unit = 0.0;
};

/// How the XY2-100 position is to be read by the head; unset refuses to arm.
enum class GalvoConvention : std::uint8_t { unset = 0, offset_binary = 1, twos_complement = 2 };
/// Format of the position words: XY2-100 with 16 bits, or XY2-100-18 ("enhanced") with 18.
enum class GalvoWord : std::uint8_t { bits16 = 0, bits18 = 1 };

/// Whether the mirrors take up what the axes are off the path that they drive, and who says how far they are.
enum class FollowAxes : std::uint8_t {
    off = 0,
    drives = 1,    ///< the drives' position actual values, once a drive cycle
    encoders = 2,  ///< encoders of X, Z and C that the board reads each tick
};

struct GalvoConfig {
    Length half_field;  ///< commanded |x|, |z| stays within
    Speed speed;        ///< per mirror, at the surface
    Acceleration acceleration;
    Jerk jerk;
    double counts_per_metre = 0.0;  ///< 16-bit counts per metre at the surface, whatever the word's format
    std::int64_t latency_ns = 0;    ///< behind the frames at constant speed: hold of a frame, transport delay and lag
    GalvoConvention convention = GalvoConvention::unset;
    GalvoWord word = GalvoWord::bits16;
    /// Of the servo of each mirror, a second-order one; its lag 2 · damping / (2π f) is part of latency_ns. Frames then
    /// lead by its inverse. 0: unknown, and latency_ns alone is made up for.
    Frequency natural_frequency;
    double damping = 0.0;
    FollowAxes follow = FollowAxes::off;
};

/// What a frame leads its place by, so that a second-order servo is where it should be: place + velocity · per_velocity
/// + acceleration · per_acceleration. Zero where the servo is not known.
struct GalvoLead {
    double per_velocity = 0.0;      ///< s: 2 · damping / ω
    double per_acceleration = 0.0;  ///< s²: 1 / ω², less what holding a command for a frame does (period² / 24)
};
[[nodiscard]] GalvoLead galvo_lead(const GalvoConfig& galvo, std::int64_t frame_period_ns) noexcept;

/// What the power byte of a source sets.
enum class PowerByte : std::uint8_t {
    average_power = 0,  ///< the energy of a pulse falls with the rate, so the byte goes with it
    pulse_energy = 1,   ///< at any rate; the byte stays
};

/// Whose source it is: how its status pins read (source_status.hpp). none: its pins are not wired.
enum class LaserSource : std::uint8_t { none = 0, ipg = 1, raycus = 2, jpt = 3 };

struct LaserConfig {
    Power power;        ///< average at power code 255
    Frequency prr_min;  ///< the source must run within [prr_min, prr_nominal]
    Frequency
        prr_nominal;  ///< full power byte belongs to this rate; at others the byte is scaled, so that energy stays
    std::int64_t warning_ns = 0;       ///< emission warning on → master oscillator on
    std::int64_t mo_wait_ns = 0;       ///< master oscillator on → gate allowed
    std::int64_t latency_ns = 0;       ///< from trigger edge to light
    Speed mark_speed_min;              ///< the gate stays shut below this path speed
    Speed guide_speed_max;             ///< of a path in a preview: an eye must be able to follow the guide laser
    std::int64_t shutter_time_ns = 0;  ///< the shutter's read-back may disagree with its command for so long
    std::int64_t latch_setup_ns = 0;   ///< the power byte stands on its lines so long before the latch rises
    std::int64_t latch_width_ns = 0;   ///< and the latch stays up so long
    LaserSource source = LaserSource::none;
    PowerByte power_byte = PowerByte::average_power;
};

/// Axis-aligned box in h that the laser focus must not enter.
struct KeepOut {
    Vec3 min;  ///< metres
    Vec3 max;
    constexpr bool operator==(const KeepOut&) const noexcept = default;
};
inline constexpr std::size_t kKeepOutCapacity = 8;

struct MachineConfig {
    std::int64_t control_period_ns = 1'000'000;
    std::int64_t galvo_period_ns = 10'000;
    std::int64_t guard_period_ns = 100'000;
    std::uint32_t drive_cycle_ticks = 2;  ///< SYNC every so many ticks
    std::array<AxisConfig, kAxisCount> axis{};
    GalvoConfig galvo{};
    LaserConfig laser{};
    Length y_retracted;          ///< C turns only with y at or above this
    Length park_tolerance;       ///< axes this near to their target count as standing
    std::int64_t settle_ns = 0;  ///< standing for so long before a galvo path starts
    std::array<KeepOut, kKeepOutCapacity> keep_out{};
    std::uint8_t keep_out_count = 0;
    std::int64_t heartbeat_timeout_ns = 100'000'000;
    std::int64_t held_link_timeout_ns = 10'000'000'000;
    Length table_y;  ///< of the turntable's axis in h, to some millimetres: how far the surface moves when C is off
    SensorsConfig sensors{};
};

/// Geometric errors that calibration measured and the controller takes out. Set over the link; identity by default.
struct Compensation {
    /// Axis set-point = matrix · place + offset (place in h, metres). Holds squareness and scale.
    Mat3 axis_from_h;
    Vec3 axis_offset;  ///< metres
    /// Galvo command (x, z) = matrix · field place + offset. Row-major 2×2.
    std::array<double, 4> galvo_from_field{1.0, 0.0, 0.0, 1.0};
    std::array<double, 2> galvo_offset{};  ///< metres
    constexpr bool operator==(const Compensation&) const noexcept = default;
};

/// The reference cell: the machine that `boards/sim` simulates and every example is written for.
[[nodiscard]] MachineConfig reference_machine() noexcept;

}  // namespace sc
