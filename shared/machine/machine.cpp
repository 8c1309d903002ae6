// SPDX-License-Identifier: Apache-2.0
#include "shared/machine/machine.hpp"

namespace sc {

MachineConfig reference_machine() noexcept {
    using namespace literals;
    MachineConfig m;
    // Linear axes: 0.2 m/s, 5 m/s², 200 m/s³, 1 µm drive counts. Travel holds the RAS3DM workpiece on all four faces.
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
        AxisConfig& a = m.axis[index(axis)];
        a.speed = 0.2;
        a.acceleration = 5.0;
        a.jerk = 200.0;
        a.counts_per_unit = 1e6;
        a.following_window = 0.2e-3;
        a.latency_ns = 4'000'000;
        a.drive_node = static_cast<std::uint8_t>(index(axis) + 1);
    }
    m.axis[index(Axis::x)].travel_min = -0.450;
    m.axis[index(Axis::x)].travel_max = 0.005;
    m.axis[index(Axis::x)].home_position = 0.0;
    m.axis[index(Axis::y)].travel_min = -0.400;
    m.axis[index(Axis::y)].travel_max = 0.005;
    m.axis[index(Axis::y)].home_position = 0.0;
    m.axis[index(Axis::z)].travel_min = -0.500;
    m.axis[index(Axis::z)].travel_max = 0.005;
    m.axis[index(Axis::z)].home_position = 0.0;
    AxisConfig& c = m.axis[index(Axis::c)];
    c.travel_min = -365.0;
    c.travel_max = 365.0;
    c.speed = 45.0;
    c.acceleration = 180.0;
    c.jerk = 1800.0;
    c.counts_per_unit = 1000.0;
    c.following_window = 0.05;
    c.home_position = 0.0;
    c.latency_ns = 4'000'000;
    c.drive_node = 4;

    // A 10 mm aperture head behind an f = 160 mm lens with a field of 110 mm; its words reach 7 mm further, so that the
    // lens' distortion can be taken out at the edge too.
    m.galvo.half_field = 55_mm;
    m.galvo.speed = 2.0_m_s;
    m.galvo.acceleration = 8000.0_m_s2;
    m.galvo.jerk = 8e7_m_s3;
    m.galvo.counts_per_metre = 65536.0 / 0.124;
    m.galvo.latency_ns = 160'000;
    m.galvo.convention = GalvoConvention::offset_binary;
    m.galvo.natural_frequency = 2_kHz;
    m.galvo.damping = 0.75;

    m.laser.power = 80.0_W;
    m.laser.prr_min = 20_kHz;
    m.laser.prr_nominal = 80_kHz;
    m.laser.warning_ns = 500'000'000;
    m.laser.mo_wait_ns = 8'000'000;
    m.laser.latency_ns = 1'000;
    m.laser.mark_speed_min = 2.0_mm_s;
    m.laser.guide_speed_max = 100.0_mm_s;
    m.laser.shutter_time_ns = 500'000'000;
    // Type D asks for 1 us and 2 us.
    m.laser.latch_setup_ns = 1'250;
    m.laser.latch_width_ns = 2'500;
    m.laser.source = LaserSource::jpt;

    // The workpiece swings within 240 mm of the table's axis at y = -470 mm: at y >= -200 mm nothing can be met.
    m.y_retracted = Length::from_si(-0.200);
    m.table_y = Length::from_si(-0.470);
    m.park_tolerance = 3_um;
    m.settle_ns = 50'000'000;
    // The focus must not be driven into the table top, nor below it.
    m.keep_out[0] = {{-0.460, -0.410, -0.510}, {0.010, 0.010, -0.480}};
    m.keep_out_count = 1;

    // Bus 0: the Y sensor beside the head, 100 mm base, 50 mm range. Bus 1: the triple head.
    m.sensors.bus[0] = {115'200, SensorParity::even, 0, 0};
    m.sensors.bus[1] = {115'200, SensorParity::none, 0, 0};
    SensorConfig& y = m.sensors.sensor[kYSensor];
    y.kind = SensorKind::triangulation;
    y.bus = 0;
    y.address = 1;
    y.identity = 10'602;
    y.near = 10'000'000;
    y.far = 15'000'000;
    y.jump = 100'000;
    y.update_ns = 5'000'000;
    y.patience_ns = 20'000'000;
    y.stuck_ns = 500'000'000;
    y.too_old_ns = 50'000'000;
    for (std::size_t i = 0; i < kTripleCount; ++i) {
        SensorConfig& s = m.sensors.sensor[kFirstTriple + i];
        s.kind = SensorKind::phase;
        s.bus = 1;
        s.address = static_cast<std::uint8_t>(1 + i);
        s.identity = static_cast<std::uint32_t>(3 + 4 * i);
        s.near = 5'000'000;
        s.far = 50'000'000;
        s.jump = 200'000;
        s.update_ns = 50'000'000;
        s.patience_ns = 60'000'000;
        s.stuck_ns = 3'000'000'000;
        s.too_old_ns = 500'000'000;
    }
    return m;
}

GalvoLead galvo_lead(const GalvoConfig& galvo, std::int64_t frame_period_ns) noexcept {
    constexpr double kTwoPi = 6.2831853071795862;
    const double omega = kTwoPi * galvo.natural_frequency.si();
    if (!(omega > 0.0)) {
        return {};
    }
    const double period = static_cast<double>(frame_period_ns) * 1e-9;
    return {2.0 * galvo.damping / omega, 1.0 / (omega * omega) - period * period * (1.0 / 24.0)};
}

}  // namespace sc
