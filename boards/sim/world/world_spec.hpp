// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "firmware/hal/io.hpp"
#include "shared/geometry/vec.hpp"

namespace sc::sim {

/// A shift that repeats along an axis: amplitude · sin(2π · reading / period + phase).
struct Periodic {
    double amplitude = 0.0;  ///< metres
    double period = 1.0;     ///< metres
    double phase = 0.0;      ///< radians
};

/// True error of the linear axes; the formula is in machine_errors.hpp.
struct AxesTruth {
    double squareness_xy = 0.0;  ///< rad
    double squareness_xz = 0.0;
    double squareness_yz = 0.0;
    std::array<double, 3> scale{};                      ///< relative, x y z
    std::array<std::array<Periodic, 3>, 3> periodic{};  ///< [shift of][along the reading of]
};

struct TurntableTruth {
    Vec3 axis_point;                  ///< metres, h
    Vec3 direction{0.0, 0.0, 1.0};    ///< as written; the world normalises it
    double runout = 0.0;              ///< metres, radial, once a turn
    double runout_phase = 0.0;        ///< rad
    double wobble = 0.0;              ///< rad, once a turn
    double wobble_phase = 0.0;        ///< rad
    double wobble_pivot_z = 0.0;      ///< metres: height on the axis that the wobble leaves in place
    double pitch_error = 0.0;         ///< degrees: true angle minus encoder, once a turn
    double pitch_error_phase = 0.0;   ///< rad
    double radial2 = 0.0;             ///< metres: shift across the axis, twice a turn
    double radial2_phase = 0.0;       ///< rad
    double axial = 0.0;               ///< metres: shift along the axis, once a turn
    double axial_phase = 0.0;         ///< rad
    double tilt2 = 0.0;               ///< rad, twice a turn, about the wobble's pivot
    double tilt2_phase = 0.0;         ///< rad
    double pitch_error2 = 0.0;        ///< degrees, twice a turn
    double pitch_error2_phase = 0.0;  ///< rad
};

struct GalvoTruth {
    double offset_x = 0.0;  ///< metres
    double offset_z = 0.0;
    double gain_x = 1.0;
    double gain_z = 1.0;
    double rotation = 0.0;        ///< rad, from +x towards +z
    double skew = 0.0;            ///< rad, of the z mirror's direction beyond the rotation
    double focal_length = 0.160;  ///< metres: a command of g asks for the optical angle g / focal_length
    /// F-theta lens: image height r(t) = f1·t + f2·t² + f3·t³ + f4·t⁴ at the field angle t (rad); metres.
    std::array<double, 4> lens{0.160, 0.0, 0.0, 0.0};
    /// Metres: from where, before the focal plane, the rays deflected by a mirror seem to come. Unequal, since the
    /// mirrors stand one behind the other.
    double exit_pupil_x = 0.160;
    double exit_pupil_z = 0.160;
    double exit_bend = 0.0;        ///< 1/m²: the lean grows by (1 + exit_bend · r²)
    double field_curvature = 0.0;  ///< 1/m: the best focus lies field_curvature · r² nearer to the head
    /// What no model of a lens knows: ripple_x sin(2π u / period + 0.6) cos(2π w / period) along x, and
    /// ripple_z cos(2π u / period) sin(2π w / period + 0.3) along z, at the image (u, w). Metres.
    double ripple_x = 0.0;
    double ripple_z = 0.0;
    double ripple_period = 0.070;
    double beam_tilt_x = 0.0;        ///< rad, of the undeflected beam
    double beam_tilt_z = 0.0;        ///< rad
    double ack_limit = 0.5e-3;       ///< metres: a mirror further from its command does not acknowledge its position
    double tracking = 160e-6;        ///< seconds behind the command at constant speed
    double natural_frequency = 2e3;  ///< Hz
    double damping = 0.75;
};

struct LaserTruth {
    /// Average power at byte b, of the greatest: x · (1 + power_bend · (1 − x)) with x = b / 255.
    double power_bend = 0.0;
    double power_time_constant = 0.0;  ///< seconds, 0 = the power follows its byte at once
    /// After a long pause the first pulse has (1 + first_pulse_excess) times the energy of a steady one; the excess
    /// builds up again with gain_build_up (seconds) and each pulse leaves 1 − 1/first_pulses of it.
    double first_pulse_excess = 0.0;
    double gain_build_up = 300e-6;
    double first_pulses = 5.0;
    double waist = 16e-6;          ///< metres, 1/e² radius at the focus
    double rayleigh_length = 1.0;  ///< metres: there the spot's area has doubled
    double mark_threshold = 0.0;   ///< J/m²: a pulse of lower peak fluence leaves no mark
};

/// The triangulation sensor beside the head. It looks along (lean_x, −1, lean_z) from a place that moves with the
/// focus.
struct YSensorTruth {
    double offset_x = 0.0;  ///< metres, of its beam from the focus
    double offset_z = 0.0;
    double standoff = 0.125;  ///< metres: its reading of a surface in focus
    double lean_x = 0.0;      ///< rad
    double lean_z = 0.0;
    double gain = 0.0;           ///< relative error, about the standoff
    double bend = 0.0;           ///< metres: amplitude of what is left of its linearisation
    double bend_period = 0.020;  ///< metres
    double tilt = 0.0;           ///< metres, times the tangent of the angle at which the beam meets the surface
    double noise = 0.0;          ///< metres, 1 σ, white
    double steepest = 1.2;       ///< rad: a surface more inclined gives no light back
    double dropouts = 0.0;       ///< share of the measurements that fail and leave the value of before
    double update = 0.005;       ///< seconds between measurements
    double delay = 0.0;          ///< seconds from a measurement to its value on the bus
    double base = 0.100;         ///< metres, nearest distance, as the sensor says
    double range = 0.050;        ///< metres
    double serial = 1.0;
};

/// The three phase-shift sensors of the triple head, which stands beside the table and looks along −x.
struct TripleTruth {
    struct Beam {
        Vec3 place;           ///< metres, h: from where its distance counts
        double lean_y = 0.0;  ///< rad
        double lean_z = 0.0;
        double zero = 0.0;           ///< metres, added to every distance
        double gain = 0.0;           ///< relative
        double stored_offset = 0.0;  ///< what its offset register says
    };
    std::array<Beam, 3> beam{};
    double cycle = 0.150;       ///< metres: half the wavelength of the fine modulation
    double coarse_noise = 0.0;  ///< metres, 1 σ, of the coarse phase that counts whole cycles
    double cyclic = 0.0;        ///< metres: error that goes round with the phase
    double noise = 0.0;         ///< metres, 1 σ, white, square to the surface
    double tilt_noise = 0.0;    ///< noise grows by (1 + tilt_noise · tan²) with the inclination
    double tilt = 0.0;          ///< metres, times the tangent of the inclination
    double steepest = 1.2;      ///< rad
    double dropouts = 0.0;      ///< share of the measurements that end in a fault code
    double update = 0.050;      ///< seconds
    double delay = 0.0;         ///< seconds
};

struct SensorsTruth {
    double seed = 1.0;
    YSensorTruth y;
    TripleTruth triple;
};

struct MeshFile {
    std::string name;
    std::filesystem::path path;
    double unit = 1e-3;  ///< metres
};

/// Play between the motor, whose encoder the drive reads, and what it moves: the whole width. Metres, degrees for C.
struct DrivesTruth {
    std::array<double, kAxisCount> backlash{};
    /// A force that swings: the following error that it makes while a drive follows targets.
    std::array<double, kAxisCount> disturbance{};
    double disturbance_frequency = 0.0;  ///< Hz
};

/// All that a world file says, in SI units (angles of C in degrees).
struct WorldSpec {
    std::string title;
    AxesTruth axes;
    TurntableTruth turntable;
    DrivesTruth drives;
    GalvoTruth galvo;
    LaserTruth laser;
    SensorsTruth sensors;
    DigitalInputs inputs;
    std::vector<MeshFile> meshes;
};

/// One number of a world file: where it stands, its unit and limits, and whether it is an error of the machine. From
/// this one list come the reader, the refusal of unknown keys, and the report's list of errors.
struct NumberKey {
    std::string path;  ///< dotted, unit suffix included
    std::function<double&(WorldSpec&)> field;
    double si = 1.0;   ///< SI value of one unit of the file
    double min = 0.0;  ///< in the file's unit
    double max = 0.0;
    std::string name{};            ///< of the error, empty when it is none
    std::string unit{};            ///< as printed
    std::string compensated_by{};  ///< what takes it out
};
[[nodiscard]] const std::vector<NumberKey>& number_keys();

/// One bit of a world file.
struct FlagKey {
    std::string path;
    bool DigitalInputs::* field;
};
[[nodiscard]] const std::vector<FlagKey>& flag_keys();

/// Reads a world file and, first, the `base` it names. Mesh paths come out resolved against the file that names them.
/// Throws WorldError: missing file, broken TOML, unknown or missing key, wrong type, value out of its limits, bases
/// nested deeper than eight.
[[nodiscard]] WorldSpec read_world_spec(const std::filesystem::path& file);

}  // namespace sc::sim
