// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

/// The one numbered list of what can go wrong, be refused, or limit the machine. Numbers are never reused. Every code
/// has a text, a line in docs/codes.md (a test compares the two) and a test that provokes it.
///
/// Faults (1..63) latch: laser off, axes stopped, leaving needs an explicit reset and re-arm.
/// Refusals (100..199) say that something asked for was not done; nothing has changed.
/// "Limited by" (200..219) says what holds the speed down; it is no error.
/// Sensor codes (300..319) say why a distance sensor has no good value; by themselves they stop nothing.

namespace sc {

enum class Fault : std::uint8_t {
    none = 0,
    estop_open = 1,
    interlock_open = 2,
    laser_alarm = 3,
    galvo_not_ready = 4,
    drive_fault = 5,
    drive_lost = 6,
    following_error = 7,
    encoder_frozen = 8,
    homing_failed = 9,
    link_lost = 10,
    planner_late = 11,
    soft_limit = 12,
    keep_out = 13,
    turn_not_retracted = 14,
    mark_rule = 15,
    arithmetic_state = 16,
    galvo_absent = 17,
    shutter = 18,
    key_turned = 19,
    laser_back_reflection = 20,
    laser_temperature = 21,
    laser_main_supply = 22,
    laser_housekeeping = 23,
    laser_system = 24,
    laser_code_unknown = 25,
    surface_off = 30,
    surface_lost = 31,
};

enum class Refusal : std::uint16_t {
    none = 0,
    schema_mismatch = 100,
    version_mismatch = 101,
    not_connected = 102,
    wrong_state = 103,
    not_homed = 104,
    estop_open = 105,
    interlock_open = 106,
    laser_not_ready = 107,
    galvo_convention_unset = 108,
    unknown_command = 109,
    job_mismatch = 110,
    malformed_block = 111,
    item_out_of_order = 112,
    out_of_travel = 113,
    in_keep_out = 114,
    travel_through_keep_out = 115,
    turn_out_of_range = 116,
    jog_out_of_range = 117,
    galvo_out_of_field = 118,
    c_motion_in_path = 119,
    bad_speed = 120,
    bad_pitch = 121,
    bad_energy = 122,
    path_too_short = 123,
    too_many_points = 124,
    bad_config = 125,
    fault_present = 126,
    bad_override = 127,
    bad_map = 128,
    map_too_steep = 129,
    map_incomplete = 130,
    bad_arc = 131,
    key_not_production = 132,
    key_off = 133,
    bad_power_curve = 134,
    pulse_width_refused = 135,
    pulse_width_no_answer = 136,
    pulse_width_wrong_source = 137,
    pulse_width_while_armed = 138,
    pulse_width_unsupported = 139,
    bad_stage_curve = 140,
    stage_too_fast = 141,
    bad_galvo_lag = 142,
    sensor_not_fitted = 150,
    seating_no_value = 151,
    seating_off = 152,
    seating_tilted = 153,
    seating_swapped = 154,
    seating_not_proven = 155,
    surface_not_seen = 156,
    surface_not_there = 157,
    telemetry_over_budget = 160,
    parameters_not_kept = 161,
    parameters_bad = 162,
    parameters_not_written = 163,
    seal_required = 164,
    seal_not_fitted = 165,
    seal_expired = 166,
    seal_wrong_key = 167,
    drive_bus_full = 170,
};

enum class LimitedBy : std::uint8_t {
    none = 0,
    path_speed = 200,
    axis_speed = 201,
    axis_acceleration = 202,
    axis_jerk = 203,
    corner = 204,
    pulse_rate = 205,
    starved = 206,
    override_zero = 207,
};

/// Why a distance sensor has no good value.
enum class SensorCode : std::uint16_t {
    none = 0,
    timeout = 300,
    bad_crc = 301,
    bad_frame = 302,
    wrong_slave = 303,
    exception = 304,
    out_of_range = 305,
    own_fault = 306,
    frozen = 307,
    wrong_device = 308,
    too_old = 309,
    unconfirmed = 310,
    not_read = 311,
};

/// One row of the list.
struct CodeText {
    std::uint16_t number;
    std::string_view name;    ///< as in the enum
    std::string_view text;    ///< what is wrong
    std::string_view action;  ///< what to do
};

/// All rows in order of number. Never empty; safe in any context (constant data).
[[nodiscard]] std::span<const CodeText> code_list() noexcept;
/// Row of a number, or nullptr. O(rows).
[[nodiscard]] const CodeText* find_code(std::uint16_t number) noexcept;
[[nodiscard]] const CodeText* find_code(Fault code) noexcept;
[[nodiscard]] const CodeText* find_code(Refusal code) noexcept;
[[nodiscard]] const CodeText* find_code(LimitedBy code) noexcept;
[[nodiscard]] const CodeText* find_code(SensorCode code) noexcept;

/// Bit of a fault in a 64-bit latched set.
constexpr std::uint64_t fault_bit(Fault fault) noexcept { return std::uint64_t{1} << static_cast<unsigned>(fault); }

}  // namespace sc
