// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/machine/machine.hpp"

namespace sc::sim {

/// What a line of a script does to the cell.
enum class FaultAction : std::uint8_t {
    estop_open,
    estop_close,
    interlock_open,
    interlock_close,
    laser_alarm,
    laser_ok,
    laser_not_ready,
    laser_back_reflection,  ///< as the source's status pins show it, like the six below
    laser_temperature,
    laser_main_supply,
    laser_housekeeping,
    laser_system,
    laser_strange,
    laser_warning,
    laser_starting,
    laser_mute,           ///< its serial port does not answer
    laser_stubborn,       ///< its serial port confirms, and the width stays as it is
    laser_speaks_raycus,  ///< another maker's source is on the port
    laser_speaks_jpt,
    shutter_stuck,      ///< stays where it is
    shutter_dropped,    ///< its coil burns out, its spring shuts it
    shutter_unplugged,  ///< neither of its switches reads
    shutter_ok,
    key_off,
    key_setup,
    key_production,
    galvo_fail,
    galvo_absent,      ///< no head, and a converter that says "all well" for ever
    galvo_float_high,  ///< no head, and a status line that reads as ones
    galvo_float_low,   ///< or as zeros
    galvo_ok,
    drive_freeze,   ///< encoder stands still
    drive_stall,    ///< axis runs against an obstacle
    drive_silent,   ///< sends nothing, hears nothing
    drive_fault,    ///< enters fault with an EMCY code
    drive_recover,  ///< takes freeze, stall and silence back
    sensor_silent,
    sensor_crc,
    sensor_wrong_slave,
    sensor_exception,
    sensor_chopped,
    sensor_stale,
    sensor_foreign,
    sensor_blind,
    sensor_slipped,
    sensor_swapped,  ///< with the next one of the triple head
    sensor_ok,
    link_cut,
    link_restore,
};

/// One line. Exactly one of `at_ns` and `after_pulse` is set.
struct FaultEvent {
    std::size_t line = 0;                      ///< in the script; orders events of one moment
    std::optional<std::int64_t> at_ns;         ///< control time
    std::optional<std::uint64_t> after_pulse;  ///< right after this many pulses have been lit
    FaultAction action = FaultAction::estop_open;
    Axis axis = Axis::x;           ///< drive actions only
    std::uint16_t error_code = 0;  ///< drive_fault only
    std::size_t sensor = 0;        ///< sensor actions only: 0 the Y sensor, 1..3 the triple head
    std::string text;              ///< the line as written, for reports
};

/// A script: one event a line, `#` begins a comment.
///
///     at 3.5 estop open            # seconds of the cell's time
///     pulse 1000 interlock open    # after the 1000th pulse
///     at 4 drive x fault 0x2310
///
/// Subjects: estop open|close, interlock open|close, laser alarm|not_ready (its contacts), laser back_reflection|
/// temperature|main_supply|housekeeping|system|strange|warning|starting (its pins), laser
/// mute|stubborn|speaks_raycus|speaks_jpt (its serial port), laser ok, shutter
/// stuck|dropped|unplugged|ok, key off|setup|production, galvo fail|absent|float_high|float_low|ok, drive x|y|z|c
/// freeze|stall|silent|recover, drive … fault CODE, sensor y|1|2|3
/// silent|crc|wrong_slave|exception|chopped|stale|foreign|blind|slipped|swapped|ok, link cut|restore. Throws WorldError
/// with file name and line for anything else. Events at a time come out in order of time.
[[nodiscard]] std::vector<FaultEvent> parse_fault_script(std::string_view text, const std::string& file);
[[nodiscard]] std::vector<FaultEvent> read_fault_script(const std::filesystem::path& file);

}  // namespace sc::sim
