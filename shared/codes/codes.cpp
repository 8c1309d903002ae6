// SPDX-License-Identifier: Apache-2.0
#include "shared/codes/codes.hpp"

#include <array>

namespace sc {
namespace {

constexpr auto row(Fault code, std::string_view name, std::string_view text, std::string_view action) noexcept {
    return CodeText{static_cast<std::uint16_t>(code), name, text, action};
}
constexpr auto row(Refusal code, std::string_view name, std::string_view text, std::string_view action) noexcept {
    return CodeText{static_cast<std::uint16_t>(code), name, text, action};
}
constexpr auto row(LimitedBy code, std::string_view name, std::string_view text, std::string_view action) noexcept {
    return CodeText{static_cast<std::uint16_t>(code), name, text, action};
}

constexpr auto row(SensorCode code, std::string_view name, std::string_view text, std::string_view action) noexcept {
    return CodeText{static_cast<std::uint16_t>(code), name, text, action};
}

constexpr std::array kRows{
    row(Fault::estop_open, "estop_open", "the emergency stop chain is open",
        "close the chain, then reset the fault and arm again"),
    row(Fault::interlock_open, "interlock_open", "the laser interlock (door, hood) is open",
        "close the enclosure, then reset the fault and arm again"),
    row(Fault::laser_alarm, "laser_alarm", "the laser source reports an alarm",
        "read the source's own display; back reflection and temperature are the usual causes"),
    row(Fault::galvo_not_ready, "galvo_not_ready", "the galvo head reports that it is not ready",
        "check the head's supply, its temperature and the XY2-100 cable"),
    row(Fault::drive_fault, "drive_fault", "a servo drive is in its fault state",
        "read the drive's error code in the fault record, remove the cause, reset the fault"),
    row(Fault::drive_lost, "drive_lost", "a servo drive has gone silent on the drive bus",
        "check the drive's supply and the bus cable and terminators"),
    row(Fault::following_error, "following_error", "an axis does not follow its set-point",
        "look for a collision, a brake that holds or a limit set too high"),
    row(Fault::encoder_frozen, "encoder_frozen", "an axis is commanded to move and its encoder stands still",
        "check the encoder and the coupling before moving the axis again"),
    row(Fault::homing_failed, "homing_failed", "an axis did not find its reference",
        "check the reference switch, then home again"),
    row(Fault::link_lost, "link_lost", "the host link stayed silent for longer than a job can be held",
        "reconnect, reset the fault; the journal says how far the job came"),
    row(Fault::planner_late, "planner_late", "the planner did not publish its result in its fixed time",
        "report this: the work budget of this board is too small"),
    row(Fault::soft_limit, "soft_limit", "a set-point lies outside an axis' travel",
        "report this: the path was accepted and should not have been"),
    row(Fault::keep_out, "keep_out", "a set-point lies inside a keep-out volume",
        "report this: the path was accepted and should not have been"),
    row(Fault::turn_not_retracted, "turn_not_retracted", "the turntable was about to turn with y not retracted",
        "report this, and look at the fault record before moving"),
    row(Fault::mark_rule, "mark_rule", "a pulse was about to leave outside the rule for marking",
        "report this, with the log of the job"),
    row(Fault::arithmetic_state, "arithmetic_state", "rounding mode, flush-to-zero or a number that is none",
        "report this: another part of the program changed the floating-point state"),
    row(Fault::galvo_absent, "galvo_absent",
        "no galvo head answers: its acknowledge does not follow a jump of its mirror",
        "check that the head is connected, not its converter alone, and that its status line is"),
    row(Fault::shutter, "shutter", "the beam's shutter is not where it was sent, or its two end switches contradict it",
        "do not look into the beam's way; check the shutter, its air or coil and both end switches"),
    row(Fault::key_turned, "key_turned", "the key was turned away from production while the laser was armed",
        "turn it back, then reset the fault and arm again"),
    row(Fault::laser_back_reflection, "laser_back_reflection", "the source reports light reflected back into its fibre",
        "look at what the beam meets: a shiny face square to the beam; tilt it or defocus"),
    row(Fault::laser_temperature, "laser_temperature", "the source reports a temperature out of its range",
        "check its fans, its cooling and the air about it; wait until it has cooled"),
    row(Fault::laser_main_supply, "laser_main_supply",
        "the source reports that its main supply of 24 V is out of range",
        "check the supply's voltage at the source under load, and its cable"),
    row(Fault::laser_housekeeping, "laser_housekeeping",
        "the source reports that its housekeeping supply of 24 V is out of range",
        "check the small supply's voltage at the source, and its cable"),
    row(Fault::laser_system, "laser_system", "the source reports an error of its own",
        "switch the source off and on; if it stays, ask its maker"),
    row(Fault::laser_code_unknown, "laser_code_unknown",
        "the source's status pins show a code that its maker's table has not",
        "check the cable of pins 11, 12, 16 and 21, and which maker the configuration names"),
    row(Fault::surface_off, "surface_off",
        "while marking, the beam came to where the Y sensor had seen the surface further from its place than the job "
        "allows",
        "look at the workpiece: its clamping, its alignment, a step that the job does not know"),
    row(Fault::surface_lost, "surface_lost", "while marking, the beam came to where the Y sensor has not looked",
        "`scribecell sensors` says why; check the sensor, its window and its cable"),
    row(Refusal::schema_mismatch, "schema_mismatch", "host and controller speak different messages",
        "install host and firmware of the same version"),
    row(Refusal::version_mismatch, "version_mismatch", "host and controller differ in protocol version",
        "install host and firmware of the same version"),
    row(Refusal::not_connected, "not_connected", "no session is open", "connect first"),
    row(Refusal::wrong_state, "wrong_state", "the command does not fit the state the cell is in",
        "see the state in `scribecell monitor`"),
    row(Refusal::not_homed, "not_homed", "the axes have not been homed", "home first"),
    row(Refusal::estop_open, "estop_open_refused", "the emergency stop chain is open", "close the chain first"),
    row(Refusal::interlock_open, "interlock_open_refused", "the laser interlock is open", "close the enclosure first"),
    row(Refusal::laser_not_ready, "laser_not_ready", "the laser source is not ready",
        "wait for the source, or read its alarm"),
    row(Refusal::galvo_convention_unset, "galvo_convention_unset", "the galvo's sign convention has not been set",
        "set it in the machine's configuration: a wrong guess throws the beam to the edge of the field"),
    row(Refusal::unknown_command, "unknown_command", "the controller does not know this command",
        "install host and firmware of the same version"),
    row(Refusal::job_mismatch, "job_mismatch", "the message belongs to another job",
        "open the job again, or resume with its own journal"),
    row(Refusal::malformed_block, "malformed_block", "a block of points cannot be decoded",
        "report this: its checksum was right, so the sender is wrong"),
    row(Refusal::item_out_of_order, "item_out_of_order", "an item of the job stands where it may not",
        "report this: a path must begin, have points, and end"),
    row(Refusal::out_of_travel, "out_of_travel", "a point lies outside the travel of an axis",
        "move the workpiece, or scribe this line from another face"),
    row(Refusal::in_keep_out, "in_keep_out", "a point lies in a keep-out volume",
        "move the workpiece, or change the volume in the machine's configuration"),
    row(Refusal::travel_through_keep_out, "travel_through_keep_out",
        "the way to a path leads through a keep-out volume",
        "change the order of the paths, or turn the face between them"),
    row(Refusal::turn_out_of_range, "turn_out_of_range", "the turntable cannot reach this angle",
        "use an angle within the range of C"),
    row(Refusal::jog_out_of_range, "jog_out_of_range", "the jog is longer than one step may be, or leaves the travel",
        "use smaller steps"),
    row(Refusal::galvo_out_of_field, "galvo_out_of_field",
        "a path, run-in included, leaves the field of the galvo, or its depth of 10 mm either way",
        "mark it with the axes, or nearer to the anchor"),
    row(Refusal::c_motion_in_path, "c_motion_in_path",
        "a path that moves the turntable while marking is not possible yet", "split the line by face"),
    row(Refusal::bad_speed, "bad_speed", "the speed of a path is zero, negative or above what the machine can do",
        "see the limits in `scribecell monitor --config`"),
    row(Refusal::bad_pitch, "bad_pitch", "the pulse pitch does not fit the speed and the pulse rates of the source",
        "keep speed / pitch within the rates of the source"),
    row(Refusal::bad_energy, "bad_energy", "the pulse energy is zero or above what the source gives at this rate",
        "lower the energy or the pulse rate"),
    row(Refusal::path_too_short, "path_too_short", "a path has fewer than two distinct points", "remove it"),
    row(Refusal::too_many_points, "too_many_points", "more points than announced",
        "report this: the stream does not match its job"),
    row(Refusal::bad_config, "bad_config", "a parameter is not a number or out of its range", "correct the parameter"),
    row(Refusal::fault_present, "fault_present", "the cause of a fault is still there", "remove it, then reset again"),
    row(Refusal::bad_override, "bad_override", "the feed override is not within 10..200 %",
        "use 10..200; to stop on the path, hold"),
    row(Refusal::bad_map, "bad_map", "an axis map is malformed, too large or shorter than the travel of its axis",
        "calibrate again; a correction of more than 0.3 mm is a matter of mechanics"),
    row(Refusal::map_too_steep, "map_too_steep",
        "an axis map would add more speed, acceleration or jerk to an axis than its share of the limits",
        "look at the named axis and node: an outlier of the measurement, or a take-up of backlash that is too quick"),
    row(Refusal::map_incomplete, "map_incomplete", "pieces of an axis map are missing, or its checksum is wrong",
        "send the map again from its beginning"),
    row(Refusal::bad_arc, "bad_arc",
        "an arc begins a path, has no circle through its three places, a radius above 100 m, or no tolerance to be run "
        "within",
        "begin with a point; give three distinct places and a tolerance of 0.1 µm or more; or send points"),
    row(Refusal::key_not_production, "key_not_production", "the key does not stand at production",
        "turn the key to production; at setup a job can be previewed with the guide laser"),
    row(Refusal::key_off, "key_off", "the key is off, or its contacts contradict each other",
        "turn the key to setup or to production"),
    row(Refusal::bad_power_curve, "bad_power_curve",
        "a power curve has one point or more than 17, does not rise, or does not end at byte 255",
        "measure it again from low to high; the refusal names the first point that is wrong"),
    row(Refusal::pulse_width_refused, "pulse_width_refused",
        "the source does not take this pulse width, or confirms another one",
        "use one of the widths of its data sheet, 1 to 999 ns"),
    row(Refusal::pulse_width_no_answer, "pulse_width_no_answer", "the source does not answer on its serial port",
        "check the cable, and that the configuration names the source's maker"),
    row(Refusal::pulse_width_wrong_source, "pulse_width_wrong_source",
        "what answers on the serial port is not a source of the maker that the configuration names",
        "correct the source in the machine's configuration"),
    row(Refusal::pulse_width_while_armed, "pulse_width_while_armed",
        "the pulse width cannot be changed while the laser is armed", "disarm first"),
    row(Refusal::pulse_width_unsupported, "pulse_width_unsupported", "this source's pulse width cannot be set",
        "leave pulse_width_ns out of the job, or fit a MOPA source"),
    row(Refusal::bad_stage_curve, "bad_stage_curve",
        "the stage's curve of a split path ends before the path, has knots closer than 1 mm, more than 1 m apart or "
        "more "
        "than two to a line or arc, or the axes are too quick or too slow behind their set-points to be split with",
        "report this: the host plans the curve; or mark it with the galvo or the axes"),
    row(Refusal::stage_too_fast, "stage_too_fast",
        "the stage's curve of a split path takes more of an axis than its share of speed, acceleration or jerk",
        "mark slower, or in an order that moves the stage less"),
    row(Refusal::bad_galvo_lag, "bad_galvo_lag",
        "a lag of the galvo is out of range, or far from what the machine states; the refusal's detail says 1 latency, "
        "2 frequency, 3 damping, 4 a latency that does not hold the servo's lag",
        "tune it again with scribecell calibrate galvo-lag; correct the machine's configuration if another head is "
        "fitted"),
    row(Refusal::sensor_not_fitted, "sensor_not_fitted", "the machine has no such distance sensor",
        "leave the check out of the job, or configure the sensor"),
    row(Refusal::seating_no_value, "seating_no_value",
        "a sensor of the triple head gave too few good values to prove the workpiece's seat",
        "`scribecell sensors` says what that sensor lacks"),
    row(Refusal::seating_off, "seating_off", "the workpiece sits nearer or further than its reference",
        "seat it again; the refusal names by how much"),
    row(Refusal::seating_tilted, "seating_tilted", "the workpiece sits at the right distance, but tilted",
        "look for a chip under it, and clamp it again"),
    row(Refusal::seating_swapped, "seating_swapped",
        "the distances of the triple head fit their reference only in another order: its sensors are swapped",
        "put the sensors or their addresses back into order, then calibrate the head again"),
    row(Refusal::seating_not_proven, "seating_not_proven",
        "the last check of the workpiece's seat failed, and none has passed since", "seat the workpiece, check again"),
    row(Refusal::surface_not_seen, "surface_not_seen",
        "the Y sensor has no good value of the surface for 2 mm of the line that is to be burnt, or has not looked at "
        "it",
        "`scribecell sensors` says why; or leave the check out of the job"),
    row(Refusal::surface_not_there, "surface_not_there",
        "the surface of the line that is to be burnt is further from its place than the job allows",
        "check clamping and alignment; the refusal names the depth that the sensor sees"),
    row(Refusal::telemetry_over_budget, "telemetry_over_budget",
        "the channels and rates asked for take more of the line than telemetry may have, a quarter",
        "ask for fewer channels or lower rates; the refusal's detail is the period in ticks that would fit"),
    row(Refusal::parameters_not_kept, "parameters_not_kept",
        "this board has no memory that keeps parameters without power", "change the board's own configuration"),
    row(Refusal::parameters_bad, "parameters_bad",
        "the parameters to store are incomplete, of another layout, or none that a controller can run with",
        "send them again; install host and firmware of the same version"),
    row(Refusal::parameters_not_written, "parameters_not_written", "the memory for parameters did not take them",
        "those stored before are still there; try again, and replace the board if it stays"),
    row(Refusal::seal_required, "seal_required", "this controller has a key and takes sealed commands only",
        "give the host the cell's key: --key FILE"),
    row(Refusal::seal_not_fitted, "seal_not_fitted", "the host has a key, and this controller has none",
        "leave --key out, or fit the controller with the key; what answers may be another controller"),
    row(Refusal::seal_expired, "seal_expired",
        "the sealed session is over: the host was silent, or the controller has started anew",
        "open it again, with a new challenge; scribecell does so by itself"),
    row(Refusal::seal_wrong_key, "seal_wrong_key", "the controller does not prove that it has the host's key",
        "give the host the key of this cell; scribecell key --check tells two keys apart without showing them"),
    row(Refusal::drive_bus_full, "drive_bus_full",
        "the cyclic frames of the drives and their reserve do not fit on the drive bus",
        "`scribecell drives` shows the sum: a longer drive cycle, status with every 2nd SYNC, paired targets, or two "
        "buses"),
    row(LimitedBy::path_speed, "path_speed", "programmed speed", ""),
    row(LimitedBy::axis_speed, "axis_speed", "speed of an axis", ""),
    row(LimitedBy::axis_acceleration, "axis_acceleration", "acceleration of an axis", ""),
    row(LimitedBy::axis_jerk, "axis_jerk", "jerk of an axis", ""),
    row(LimitedBy::corner, "corner", "a corner within its tolerance", ""),
    row(LimitedBy::pulse_rate, "pulse_rate", "pulse rate of the source", ""),
    row(LimitedBy::starved, "starved", "points do not arrive fast enough", ""),
    row(LimitedBy::override_zero, "override_zero", "feed hold", ""),
    row(SensorCode::timeout, "sensor_timeout", "the sensor does not answer",
        "check its supply, its cable, its address and the rate of the bus"),
    row(SensorCode::bad_crc, "sensor_bad_crc", "the checksum of the sensor's answers is wrong",
        "look for noise: screen, terminators, ground; two sensors of one address answer at once"),
    row(SensorCode::bad_frame, "sensor_bad_frame",
        "the sensor's answers are no telegrams: length, silence within, parity or an answer to something else",
        "check rate and parity of the bus; look for noise"),
    row(SensorCode::wrong_slave, "sensor_wrong_slave", "another sensor answered than the one that was asked",
        "two devices may share the line with wrong addresses: connect them one by one"),
    row(SensorCode::exception, "sensor_exception", "the sensor refuses the request (Modbus exception)",
        "this is not the type of sensor that the configuration names, or its firmware lacks the register"),
    row(SensorCode::out_of_range, "sensor_out_of_range",
        "there is nothing within the range in which the sensor may measure", "normal while the head is retracted"),
    row(SensorCode::own_fault, "sensor_own_fault", "the sensor reports a fault of its own",
        "clean its window; too little light comes back, or too much"),
    row(SensorCode::frozen, "sensor_frozen", "the sensor gives exactly the same value for too long",
        "its measurement stands still although it answers: switch it off and on"),
    row(SensorCode::wrong_device, "sensor_wrong_device",
        "another device answers at this address than the configuration names",
        "a sensor was exchanged: calibrate, and write its number into the machine's configuration"),
    row(SensorCode::too_old, "sensor_too_old", "the last good value is too old to be used",
        "the codes counted beside it say what went wrong since"),
    row(SensorCode::unconfirmed, "sensor_unconfirmed",
        "the value jumped by more than the surface can, and no second value has confirmed it yet",
        "normal for one sample at an edge; if it stays, the surface is out of the sensor's reach or it is disturbed"),
    row(SensorCode::not_read, "sensor_not_read", "no value has been read yet", "wait for the bus to come round"),
};

constexpr bool ascending() noexcept {
    for (std::size_t i = 1; i < kRows.size(); ++i) {
        if (kRows.at(i - 1).number >= kRows.at(i).number) {
            return false;
        }
    }
    return true;
}
static_assert(ascending(), "codes are listed once each, in order of number");

}  // namespace

std::span<const CodeText> code_list() noexcept { return kRows; }

const CodeText* find_code(std::uint16_t number) noexcept {
    for (const CodeText& candidate : kRows) {
        if (candidate.number == number) {
            return &candidate;
        }
    }
    return nullptr;
}
const CodeText* find_code(Fault code) noexcept { return find_code(static_cast<std::uint16_t>(code)); }
const CodeText* find_code(Refusal code) noexcept { return find_code(static_cast<std::uint16_t>(code)); }
const CodeText* find_code(LimitedBy code) noexcept { return find_code(static_cast<std::uint16_t>(code)); }
const CodeText* find_code(SensorCode code) noexcept { return find_code(static_cast<std::uint16_t>(code)); }

}  // namespace sc
