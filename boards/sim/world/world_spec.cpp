// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/world_spec.hpp"

#include <string_view>
#include <utility>

#include "shared/units/quantity.hpp"

namespace sc::sim {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr std::string_view kByAxes = "calibration: axes";
constexpr std::string_view kByTable = "calibration: turntable axis";
constexpr std::string_view kByMap = "calibration: axis map";
constexpr std::string_view kBySensors = "calibration: sensors";
constexpr std::string_view kByGalvo = "calibration: galvo field";

using Field = std::function<double&(WorldSpec&)>;

/// The error's name is the key without its unit suffix.
NumberKey error_key(std::string_view stem, std::string_view suffix, std::string_view unit, double si, double limit,
                    std::string_view by, Field field) {
    NumberKey key{std::string(stem) + std::string(suffix), std::move(field), si, -limit, limit};
    key.name = stem;
    key.unit = unit;
    key.compensated_by = by;
    return key;
}

void add_axes(std::vector<NumberKey>& keys) {
    const auto squareness = [&](std::string_view stem, double AxesTruth::* member) {
        keys.push_back(error_key(stem, "_mrad", "mrad", 1e-3, 20.0, kByAxes,
                                 [member](WorldSpec& w) -> double& { return w.axes.*member; }));
    };
    squareness("axes.squareness_xy", &AxesTruth::squareness_xy);
    squareness("axes.squareness_xz", &AxesTruth::squareness_xz);
    squareness("axes.squareness_yz", &AxesTruth::squareness_yz);
    constexpr std::string_view kLetters = "xyz";
    for (std::size_t i = 0; i < 3; ++i) {
        keys.push_back(error_key(std::string("axes.scale_") + kLetters[i], "_ppm", "ppm", 1e-6, 10'000.0, kByAxes,
                                 [i](WorldSpec& w) -> double& { return w.axes.scale[i]; }));
    }
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            const std::string stem = std::string("axes.periodic.") + kLetters[i] + "_of_" + kLetters[j];
            const auto entry = [i, j](WorldSpec& w) -> Periodic& { return w.axes.periodic[i][j]; };
            NumberKey amplitude = error_key(stem, ".amplitude_um", "um", 1e-6, 1000.0, kByMap,
                                            [entry](WorldSpec& w) -> double& { return entry(w).amplitude; });
            keys.push_back(std::move(amplitude));
            keys.push_back(
                {stem + ".period_mm", [entry](WorldSpec& w) -> double& { return entry(w).period; }, 1e-3, 0.001, 1e6});
            keys.push_back({stem + ".phase_deg", [entry](WorldSpec& w) -> double& { return entry(w).phase; }, kDegree,
                            -360.0, 360.0});
        }
    }
}

template <class Part>
Field member_of(Part WorldSpec::* part, double Part::* member) {
    return [part, member](WorldSpec& w) -> double& { return w.*part.*member; };
}

Field turntable(double TurntableTruth::* member) { return member_of(&WorldSpec::turntable, member); }
Field point(double Vec3::* member) {
    return [member](WorldSpec& w) -> double& { return w.turntable.axis_point.*member; };
}
Field direction(double Vec3::* member) {
    return [member](WorldSpec& w) -> double& { return w.turntable.direction.*member; };
}

void add_turntable(std::vector<NumberKey>& keys) {
    using T = TurntableTruth;
    keys.push_back(error_key("turntable.axis_x", "_mm", "mm", 1e-3, 10'000.0, kByTable, point(&Vec3::x)));
    keys.push_back(error_key("turntable.axis_y", "_mm", "mm", 1e-3, 10'000.0, kByTable, point(&Vec3::y)));
    keys.push_back(error_key("turntable.axis_z", "_mm", "mm", 1e-3, 10'000.0, kByTable, point(&Vec3::z)));
    keys.push_back(error_key("turntable.direction_x", "", "1", 1.0, 1.0, kByTable, direction(&Vec3::x)));
    keys.push_back(error_key("turntable.direction_y", "", "1", 1.0, 1.0, kByTable, direction(&Vec3::y)));
    keys.push_back({"turntable.direction_z", direction(&Vec3::z), 1.0, 0.5, 1.0});
    keys.push_back(error_key("turntable.runout", "_um", "um", 1e-6, 1000.0, kByMap, turntable(&T::runout)));
    keys.push_back({"turntable.runout_phase_deg", turntable(&T::runout_phase), kDegree, -360.0, 360.0});
    keys.push_back(error_key("turntable.wobble", "_urad", "urad", 1e-6, 10'000.0, kByMap, turntable(&T::wobble)));
    keys.push_back({"turntable.wobble_phase_deg", turntable(&T::wobble_phase), kDegree, -360.0, 360.0});
    keys.push_back({"turntable.wobble_pivot_z_mm", turntable(&T::wobble_pivot_z), 1e-3, -10'000.0, 10'000.0});
    keys.push_back(
        error_key("turntable.pitch_error", "_mdeg", "mdeg", 1e-3, 1000.0, kByMap, turntable(&T::pitch_error)));
    keys.push_back({"turntable.pitch_error_phase_deg", turntable(&T::pitch_error_phase), kDegree, -360.0, 360.0});
    keys.push_back(error_key("turntable.radial2", "_um", "um", 1e-6, 1000.0, kByMap, turntable(&T::radial2)));
    keys.push_back({"turntable.radial2_phase_deg", turntable(&T::radial2_phase), kDegree, -360.0, 360.0});
    keys.push_back(error_key("turntable.axial", "_um", "um", 1e-6, 1000.0, kByMap, turntable(&T::axial)));
    keys.push_back({"turntable.axial_phase_deg", turntable(&T::axial_phase), kDegree, -360.0, 360.0});
    keys.push_back(error_key("turntable.tilt2", "_urad", "urad", 1e-6, 10'000.0, kByMap, turntable(&T::tilt2)));
    keys.push_back({"turntable.tilt2_phase_deg", turntable(&T::tilt2_phase), kDegree, -360.0, 360.0});
    keys.push_back(
        error_key("turntable.pitch_error2", "_mdeg", "mdeg", 1e-3, 1000.0, kByMap, turntable(&T::pitch_error2)));
    keys.push_back({"turntable.pitch_error2_phase_deg", turntable(&T::pitch_error2_phase), kDegree, -360.0, 360.0});
}

void add_drives(std::vector<NumberKey>& keys) {
    constexpr std::string_view kLetters = "xyzc";
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const bool turn = i == index(Axis::c);
        NumberKey key = error_key(std::string("drives.backlash_") + kLetters[i], turn ? "_mdeg" : "_um",
                                  turn ? "mdeg" : "um", turn ? 1e-3 : 1e-6, 1000.0, kByMap,
                                  [i](WorldSpec& w) -> double& { return w.drives.backlash[i]; });
        key.min = 0.0;
        keys.push_back(std::move(key));
        keys.push_back({std::string("drives.disturbance_") + kLetters[i] + (turn ? "_mdeg" : "_um"),
                        [i](WorldSpec& w) -> double& { return w.drives.disturbance[i]; }, turn ? 1e-3 : 1e-6, 0.0,
                        1000.0});
    }
    keys.push_back({"drives.disturbance_hz", [](WorldSpec& w) -> double& { return w.drives.disturbance_frequency; },
                    1.0, 0.0, 1000.0});
}

Field galvo(double GalvoTruth::* member) { return member_of(&WorldSpec::galvo, member); }

void add_galvo(std::vector<NumberKey>& keys) {
    using G = GalvoTruth;
    const auto gain = [&](std::string_view stem, double G::* member) {
        NumberKey key = error_key(stem, "", "1", 1.0, 1.0, kByGalvo, galvo(member));
        key.min = 0.5;
        key.max = 1.5;
        keys.push_back(std::move(key));
    };
    keys.push_back(error_key("galvo.offset_x", "_um", "um", 1e-6, 50'000.0, kByGalvo, galvo(&G::offset_x)));
    keys.push_back(error_key("galvo.offset_z", "_um", "um", 1e-6, 50'000.0, kByGalvo, galvo(&G::offset_z)));
    gain("galvo.gain_x", &G::gain_x);
    gain("galvo.gain_z", &G::gain_z);
    keys.push_back(error_key("galvo.rotation", "_mrad", "mrad", 1e-3, 500.0, kByGalvo, galvo(&G::rotation)));
    keys.push_back(error_key("galvo.skew", "_mrad", "mrad", 1e-3, 500.0, kByGalvo, galvo(&G::skew)));
    keys.push_back({"galvo.focal_length_mm", galvo(&G::focal_length), 1e-3, 10.0, 2000.0});
    for (std::size_t i = 0; i < 4; ++i) {
        const auto lens = [i](WorldSpec& w) -> double& { return w.galvo.lens[i]; };
        const double least = i == 0 ? 10.0 : -1000.0;
        keys.push_back({"galvo.lens_f" + std::to_string(i + 1) + "_mm", lens, 1e-3, least, 2000.0});
    }
    keys.push_back({"galvo.exit_pupil_x_mm", galvo(&G::exit_pupil_x), 1e-3, 10.0, 1e6});
    keys.push_back({"galvo.exit_pupil_z_mm", galvo(&G::exit_pupil_z), 1e-3, 10.0, 1e6});
    keys.push_back({"galvo.exit_bend_per_m2", galvo(&G::exit_bend), 1.0, -100.0, 100.0});
    keys.push_back({"galvo.field_curvature_per_m", galvo(&G::field_curvature), 1.0, -10.0, 10.0});
    keys.push_back(error_key("galvo.ripple_x", "_um", "um", 1e-6, 1000.0, kByGalvo, galvo(&G::ripple_x)));
    keys.push_back(error_key("galvo.ripple_z", "_um", "um", 1e-6, 1000.0, kByGalvo, galvo(&G::ripple_z)));
    keys.push_back({"galvo.ripple_period_mm", galvo(&G::ripple_period), 1e-3, 1.0, 1e6});
    keys.push_back(error_key("galvo.beam_tilt_x", "_mrad", "mrad", 1e-3, 100.0, kByGalvo, galvo(&G::beam_tilt_x)));
    keys.push_back(error_key("galvo.beam_tilt_z", "_mrad", "mrad", 1e-3, 100.0, kByGalvo, galvo(&G::beam_tilt_z)));
    keys.push_back({"galvo.ack_limit_um", galvo(&G::ack_limit), 1e-6, 1.0, 100'000.0});
    keys.push_back({"galvo.tracking_us", galvo(&G::tracking), 1e-6, 1.0, 2000.0});
    keys.push_back({"galvo.natural_frequency_khz", galvo(&G::natural_frequency), 1e3, 0.1, 20.0});
    keys.push_back({"galvo.damping", galvo(&G::damping), 1.0, 0.3, 0.99});
}

Field laser(double LaserTruth::* member) { return member_of(&WorldSpec::laser, member); }

void add_laser(std::vector<NumberKey>& keys) {
    using L = LaserTruth;
    keys.push_back({"laser.power_bend", laser(&L::power_bend), 1.0, -0.9, 0.9});
    keys.push_back({"laser.power_time_constant_us", laser(&L::power_time_constant), 1e-6, 0.0, 1e6});
    keys.push_back({"laser.first_pulse_excess", laser(&L::first_pulse_excess), 1.0, -1.0, 10.0});
    keys.push_back({"laser.gain_build_up_us", laser(&L::gain_build_up), 1e-6, 0.001, 1e6});
    keys.push_back({"laser.first_pulses", laser(&L::first_pulses), 1.0, 1.0, 1e6});
    keys.push_back({"laser.waist_um", laser(&L::waist), 1e-6, 0.1, 10'000.0});
    keys.push_back({"laser.rayleigh_length_mm", laser(&L::rayleigh_length), 1e-3, 0.001, 1e6});
    keys.push_back({"laser.mark_threshold_j_cm2", laser(&L::mark_threshold), 1e4, 0.0, 1e6});
}

Field y_sensor(double YSensorTruth::* member) {
    return [member](WorldSpec& w) -> double& { return w.sensors.y.*member; };
}
Field triple(double TripleTruth::* member) {
    return [member](WorldSpec& w) -> double& { return w.sensors.triple.*member; };
}

void add_y_sensor(std::vector<NumberKey>& keys) {
    using Y = YSensorTruth;
    const auto error = [&](std::string_view stem, std::string_view suffix, std::string_view unit, double si,
                           double limit, double Y::* member) {
        keys.push_back(
            error_key("sensors.y." + std::string(stem), suffix, unit, si, limit, kBySensors, y_sensor(member)));
    };
    const auto plain = [&](std::string_view name, double si, double min, double max, double Y::* member) {
        keys.push_back({"sensors.y." + std::string(name), y_sensor(member), si, min, max});
    };
    error("offset_x", "_mm", "mm", 1e-3, 500.0, &Y::offset_x);
    error("offset_z", "_mm", "mm", 1e-3, 500.0, &Y::offset_z);
    plain("standoff_mm", 1e-3, 1.0, 2000.0, &Y::standoff);
    error("lean_x", "_mrad", "mrad", 1e-3, 500.0, &Y::lean_x);
    error("lean_z", "_mrad", "mrad", 1e-3, 500.0, &Y::lean_z);
    error("gain", "_ppm", "ppm", 1e-6, 100'000.0, &Y::gain);
    error("bend", "_um", "um", 1e-6, 1000.0, &Y::bend);
    plain("bend_period_mm", 1e-3, 0.1, 1000.0, &Y::bend_period);
    error("tilt", "_um", "um", 1e-6, 1000.0, &Y::tilt);
    plain("noise_um", 1e-6, 0.0, 1000.0, &Y::noise);
    plain("steepest_deg", kDegree, 1.0, 89.0, &Y::steepest);
    plain("dropouts", 1.0, 0.0, 1.0, &Y::dropouts);
    plain("update_ms", 1e-3, 0.1, 1000.0, &Y::update);
    plain("delay_ms", 1e-3, 0.0, 1000.0, &Y::delay);
    plain("base_mm", 1e-3, 1.0, 10'000.0, &Y::base);
    plain("range_mm", 1e-3, 1.0, 10'000.0, &Y::range);
    plain("serial", 1.0, 0.0, 65'535.0, &Y::serial);
}

void add_triple(std::vector<NumberKey>& keys) {
    using T = TripleTruth;
    const auto plain = [&](std::string_view name, double si, double min, double max, double T::* member) {
        keys.push_back({"sensors.triple." + std::string(name), triple(member), si, min, max});
    };
    for (std::size_t i = 0; i < 3; ++i) {
        const std::string stem = "sensors.triple.beam" + std::to_string(i + 1) + ".";
        const auto beam = [i](double T::Beam::* member) {
            return [i, member](WorldSpec& w) -> double& { return w.sensors.triple.beam.at(i).*member; };
        };
        const auto place = [&](std::string_view name, double Vec3::* member) {
            keys.push_back(
                error_key(stem + std::string(name), "_mm", "mm", 1e-3, 10'000.0, kBySensors,
                          [i, member](WorldSpec& w) -> double& { return w.sensors.triple.beam.at(i).place.*member; }));
        };
        place("x", &Vec3::x);
        place("y", &Vec3::y);
        place("z", &Vec3::z);
        keys.push_back(error_key(stem + "lean_y", "_mrad", "mrad", 1e-3, 500.0, kBySensors, beam(&T::Beam::lean_y)));
        keys.push_back(error_key(stem + "lean_z", "_mrad", "mrad", 1e-3, 500.0, kBySensors, beam(&T::Beam::lean_z)));
        keys.push_back(error_key(stem + "zero", "_mm", "mm", 1e-3, 100.0, kBySensors, beam(&T::Beam::zero)));
        keys.push_back(error_key(stem + "gain", "_ppm", "ppm", 1e-6, 100'000.0, kBySensors, beam(&T::Beam::gain)));
        keys.push_back({stem + "stored_offset", beam(&T::Beam::stored_offset), 1.0, 0.0, 65'535.0});
    }
    plain("cycle_mm", 1e-3, 1.0, 100'000.0, &T::cycle);
    plain("coarse_noise_mm", 1e-3, 0.0, 10'000.0, &T::coarse_noise);
    plain("cyclic_um", 1e-6, -10'000.0, 10'000.0, &T::cyclic);
    plain("noise_um", 1e-6, 0.0, 10'000.0, &T::noise);
    plain("tilt_noise", 1.0, 0.0, 100.0, &T::tilt_noise);
    plain("tilt_um", 1e-6, -10'000.0, 10'000.0, &T::tilt);
    plain("steepest_deg", kDegree, 1.0, 89.0, &T::steepest);
    plain("dropouts", 1.0, 0.0, 1.0, &T::dropouts);
    plain("update_ms", 1e-3, 1.0, 10'000.0, &T::update);
    plain("delay_ms", 1e-3, 0.0, 10'000.0, &T::delay);
}

std::vector<NumberKey> make_number_keys() {
    std::vector<NumberKey> keys;
    add_axes(keys);
    add_turntable(keys);
    add_drives(keys);
    add_galvo(keys);
    add_laser(keys);
    keys.push_back({"sensors.seed", [](WorldSpec& w) -> double& { return w.sensors.seed; }, 1.0, 0.0, 1e9});
    add_y_sensor(keys);
    add_triple(keys);
    return keys;
}

}  // namespace

const std::vector<NumberKey>& number_keys() {
    static const std::vector<NumberKey> keys = make_number_keys();
    return keys;
}

const std::vector<FlagKey>& flag_keys() {
    static const std::vector<FlagKey> keys{{"inputs.estop_closed", &DigitalInputs::estop_closed},
                                           {"inputs.interlock_closed", &DigitalInputs::interlock_closed},
                                           {"inputs.laser_ready", &DigitalInputs::laser_ready},
                                           {"inputs.laser_no_alarm", &DigitalInputs::laser_no_alarm},
                                           {"inputs.key_setup", &DigitalInputs::key_setup},
                                           {"inputs.key_production", &DigitalInputs::key_production}};
    return keys;
}

}  // namespace sc::sim
