// SPDX-License-Identifier: Apache-2.0
// The distance sensors in the loop: surface before and during marking, focus that follows it, the workpiece's seat.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "cell_rig.hpp"
#include "shared/codes/codes.hpp"

namespace {

using namespace sc;
using namespace sc::test;

constexpr std::int32_t kMm = 100'000;
constexpr double kPlateY = -0.330;

/// A world whose only surface is y(x) over x −420..−60 mm, z −480..−240 mm, in strips of 1 mm.
std::filesystem::path surface_world(const std::string& name, const std::function<double(double)>& y_mm) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / ("sensors_" + std::to_string(::getpid()) + "_" + name);
    std::filesystem::create_directories(folder);
    std::ofstream mesh(folder / "surface.obj");
    int strips = 0;
    for (double x = -420.0; x <= -60.0; x += 1.0, ++strips) {
        mesh << "v " << x << ' ' << y_mm(x) << " -480\nv " << x << ' ' << y_mm(x) << " -240\n";
    }
    for (int i = 1; i < strips; ++i) {
        const int a = 2 * i - 1;
        mesh << "f " << a << ' ' << a + 1 << ' ' << a + 3 << "\nf " << a << ' ' << a + 3 << ' ' << a + 2 << "\n";
    }
    std::ofstream(folder / "world.toml") << "base = \"" SC_SOURCE_DIR "/boards/sim/world/default/world.toml\"\n"
                                         << "[[mesh]]\nname = \"surface\"\nfile = \"surface.obj\"\nunit = \"mm\"\n";
    return folder / "world.toml";
}

/// The Y sensor as a calibration of the default world would have it, to within some 20 µm.
link::SetSurface watch(std::uint8_t mode, double window = 1.0e-3, double bound = 1.0e-3) {
    link::SetSurface message;
    message.mode = mode;
    message.origin = {0.03015, 0.0, -0.00018};
    message.direction = {0.0007, -0.99999963, -0.0005};
    message.zero = 0.12521;
    message.window = window;
    message.bound = bound;
    return message;
}

/// One line by the axes along +x at constant depth.
std::vector<Item> line_job(double y_mm, double length_mm = 60.0, std::uint32_t speed_um_s = 20'000) {
    const auto y = static_cast<std::int32_t>(std::lround(y_mm * kMm));
    const auto half = static_cast<std::int32_t>(length_mm / 2 * kMm);
    PathBegin line;
    line.actuator = Actuator::axes;
    line.speed_um_s = speed_um_s;
    line.pitch_nm = 20'000;
    line.energy_nj = 300'000;
    line.tolerance_nm = 10'000;
    return {
        Turn{0},   line,    PathPoint{-250 * kMm - half, y, -360 * kMm}, PathPoint{-250 * kMm + half, y, -360 * kMm},
        PathEnd{}, JobEnd{}};
}

/// The same, the Y sensor of `watch` looking at it first.
std::vector<Item> looked_at(std::vector<Item> job) {
    const auto from = std::get<PathPoint>(job[2]);
    const auto to = std::get<PathPoint>(job[3]);
    const Look begin{0, from.x - 3'015'000, from.y, from.z + 18'000};
    job.insert(job.begin() + 1, {begin, Look{50'000, to.x - 3'015'000, to.y, to.z + 18'000}});
    return job;
}

CellRig::Options in_world(const std::filesystem::path& world, const std::string& script = "") {
    CellRig::Options options;
    options.world = world;
    options.script = script;
    return options;
}

void start(CellRig& rig, const link::SetSurface& surface, const std::vector<Item>& job) {
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    ASSERT_EQ(rig.set_surface(surface).refusal, 0);
    rig.make_ready();
    ASSERT_EQ(rig.open_job(job).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
}

double flat(double) { return kPlateY * 1e3; }

/// Largest |defocus| of the pulses, mm.
double worst_defocus(const CellRig& rig) {
    double worst = 0.0;
    for (const trace::PulseRecord& pulse : rig.pulses()) {
        worst = std::max(worst, std::abs(static_cast<double>(pulse.defocus_pm)) * 1e-9);
    }
    return worst;
}

TEST(SensorsInTheLoop, AJobOnASurfaceThatIsThereIsBurntAndItsCommandsAreTheSameWithTheCheck) {
    const auto world = surface_world("flat", flat);
    std::string hash;
    for (std::uint8_t mode = 0; mode <= 2; ++mode) {
        CellRig rig(in_world(world));
        start(rig, watch(mode), mode == 0 ? line_job(-330.0) : looked_at(line_job(-330.0)));
        ASSERT_TRUE(rig.until_state(State::armed, 60'000)) << int{mode};
        EXPECT_EQ(rig.pulses().size(), 3001U);
        EXPECT_EQ(rig.cell().faults(), 0U);
        hash = hash.empty() ? rig.command_hash() : hash;
        EXPECT_EQ(rig.command_hash(), hash) << int{mode};
    }
}

/// Starts, and waits for the refusal; nothing has been burnt.
link::JobRefused refused_dark(CellRig& rig, const link::SetSurface& surface, const std::vector<Item>& job) {
    start(rig, surface, job);
    EXPECT_TRUE(rig.until([&] { return rig.refused().has_value(); }, 30'000));
    EXPECT_TRUE(rig.until_state(State::armed, 30'000));
    EXPECT_TRUE(rig.pulses().empty());
    return rig.refused().value_or(link::JobRefused{});
}

TEST(SensorsInTheLoop, ASurfaceThatIsNotWhereItShouldBeIsRefusedBeforeAnyLightWithItsDepth) {
    CellRig rig(in_world(surface_world("flat", flat)));
    const auto refused = refused_dark(rig, watch(1), looked_at(line_job(-327.0)));
    EXPECT_EQ(refused.refusal, static_cast<std::uint16_t>(Refusal::surface_not_there));
    EXPECT_EQ(refused.item, 1U);
    EXPECT_NEAR(static_cast<double>(refused.value), -330.0 * kMm, 0.1 * kMm);
}

TEST(SensorsInTheLoop, ASurfaceThatCannotBeSeenIsRefusedBeforeAnyLight) {
    for (const char* trouble : {"blind", "silent", "crc", "stale", "foreign"}) {
        CellRig rig(in_world(surface_world("flat", flat), std::string("at 0.5 sensor y ") + trouble));
        const auto refused = refused_dark(rig, watch(1), looked_at(line_job(-330.0)));
        EXPECT_EQ(refused.refusal, static_cast<std::uint16_t>(Refusal::surface_not_seen)) << trouble;
    }
}

TEST(SensorsInTheLoop, AStepInTheLineIsRefusedBeforeAnyLight) {
    const auto world = surface_world("step", [](double x) { return x < -225.0 ? -330.0 : -333.0; });
    CellRig rig(in_world(world));
    const auto refused = refused_dark(rig, watch(1), looked_at(line_job(-330.0, 100.0)));
    EXPECT_EQ(refused.refusal, static_cast<std::uint16_t>(Refusal::surface_not_there));
    EXPECT_EQ(refused.item, 2U);
    EXPECT_NEAR(static_cast<double>(refused.value), -333.0 * kMm, 0.1 * kMm);
}

TEST(SensorsInTheLoop, ALineThatNobodyHasLookedAtIsRefusedBeforeAnyLight) {
    CellRig rig(in_world(surface_world("flat", flat)));
    const auto refused = refused_dark(rig, watch(1), line_job(-330.0));
    EXPECT_EQ(refused.refusal, static_cast<std::uint16_t>(Refusal::surface_not_seen));
    CellRig without(in_world(surface_world("flat", flat)));
    const auto unused = refused_dark(without, watch(0), looked_at(line_job(-330.0)));
    EXPECT_EQ(unused.refusal, static_cast<std::uint16_t>(Refusal::surface_not_seen));
    EXPECT_EQ(unused.item, 1U);
}

TEST(SensorsInTheLoop, WhereTheLookEndedTheLaserStops) {
    // The look goes over 60 mm of a line of 100 mm.
    auto job = looked_at(line_job(-330.0, 60.0));
    const auto longer = line_job(-330.0, 100.0);
    job[4] = longer[2];
    job[4] = PathPoint{std::get<PathPoint>(job[4]).x + 20 * kMm, std::get<PathPoint>(job[4]).y,
                       std::get<PathPoint>(job[4]).z};
    job[5] = longer[3];
    CellRig rig(in_world(surface_world("flat", flat)));
    start(rig, watch(1), job);
    ASSERT_TRUE(rig.until_state(State::fault, 60'000));
    rig.ticks(50);
    EXPECT_EQ(static_cast<Fault>(rig.status().first_fault), Fault::surface_lost);
    ASSERT_FALSE(rig.pulses().empty());
    EXPECT_NEAR(static_cast<double>(rig.pulses().back().place_pm[0]) * 1e-9, -220.0 + 1.5, 0.5);
}

TEST(SensorsInTheLoop, AHoldInALookGoesOnWithIt) {
    CellRig rig(in_world(surface_world("flat", flat)));
    start(rig, watch(1), looked_at(line_job(-330.0)));
    ASSERT_TRUE(rig.until([&] { return rig.ack().fired == 2; }, 30'000));
    rig.ticks(500);
    ASSERT_EQ(rig.command(link::Verb::hold).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::held, 10'000));
    rig.ticks(2000);
    EXPECT_EQ(rig.ack().fired, 2U);
    ASSERT_EQ(rig.command(link::Verb::resume).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::armed, 60'000));
    EXPECT_EQ(rig.pulses().size(), 3001U);
}

TEST(SensorsInTheLoop, TheFocusFollowsASurfaceThatIsNotFlatWithinTheLimitsOfTheAxes) {
    const auto world = surface_world("wave", [](double x) { return -330.0 + 0.5 * std::sin(x * 6.2831853 / 80.0); });
    double without = 0.0;
    {
        CellRig rig(in_world(world));
        start(rig, watch(1, 2e-3), looked_at(line_job(-330.0, 100.0)));
        ASSERT_TRUE(rig.until_state(State::armed, 60'000));
        without = worst_defocus(rig);
    }
    CellRig rig(in_world(world));
    start(rig, watch(2, 2e-3), looked_at(line_job(-330.0, 100.0)));
    const std::size_t begun = rig.set_points().size();
    ASSERT_TRUE(rig.until_state(State::armed, 60'000));
    EXPECT_EQ(rig.pulses().size(), 5001U);
    EXPECT_GT(without, 0.45);
    EXPECT_LT(worst_defocus(rig), 0.12);
    // Set-points of y: speed, acceleration and jerk of every 1 kHz sample.
    const MachineConfig machine = reference_machine();
    const AxisConfig& y = machine.axis[index(Axis::y)];
    const auto& p = rig.set_points();
    for (std::size_t i = begun; i < p.size(); ++i) {
        const auto at = [&](std::size_t k) { return static_cast<double>(p[i - k][index(Axis::y)]) * 1e-12; };
        ASSERT_LE(std::abs(at(0) - 3 * at(1) + 3 * at(2) - at(3)) * 1e9, y.jerk * 1.005) << i;
        ASSERT_LE(std::abs(at(0) - 2 * at(1) + at(2)) * 1e6, y.acceleration * 1.005) << i;
    }
}

TEST(SensorsInTheLoop, UseOfTheSensorIsRefusedWhereItMakesNoSense) {
    CellRig rig;
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    EXPECT_EQ(rig.set_surface(watch(3)).refusal, static_cast<std::uint16_t>(Refusal::bad_config));
    EXPECT_EQ(rig.set_surface(watch(1, -1.0)).refusal, static_cast<std::uint16_t>(Refusal::bad_config));
    rig.make_ready();
    EXPECT_EQ(rig.set_surface(watch(1)).refusal, static_cast<std::uint16_t>(Refusal::wrong_state));

    CellRig::Options bare;
    bare.machine.sensors = {};
    CellRig without(bare);
    without.connect();
    ASSERT_TRUE(without.until_state(State::disabled, 5000));
    EXPECT_EQ(without.set_surface(watch(1)).refusal, static_cast<std::uint16_t>(Refusal::sensor_not_fitted));
    EXPECT_EQ(without.set_surface(watch(0)).refusal, 0);
    EXPECT_EQ(without.check_seating({.expected = {1, 1, 1}, .tolerance = 1, .tilt = 1, .samples = 1}).refusal,
              static_cast<std::uint16_t>(Refusal::sensor_not_fitted));
    EXPECT_EQ(without.sensors().code[0], static_cast<std::uint16_t>(Refusal::sensor_not_fitted));
}

// --- the seat

class Seating : public testing::Test {
protected:
    explicit Seating(const std::string& script = "") : rig_(in_world({}, script)) {
        rig_.connect();
        EXPECT_TRUE(rig_.until_state(State::disabled, 5000));
        rig_.ticks(3000);
        take_reference();
    }
    void take_reference() {
        for (std::size_t i = 0; i < 3; ++i) {
            truth_.at(i) = rig_.sensors().value.at(i + 1);
        }
    }
    [[nodiscard]] link::CheckSeating wanted(std::array<std::int32_t, 3> off = {}) const {
        link::CheckSeating message;
        for (std::size_t i = 0; i < 3; ++i) {
            message.expected.at(i) = truth_.at(i) + off.at(i);
        }
        message.tolerance = static_cast<std::int32_t>(0.7 * kMm);
        message.tilt = kMm;
        message.samples = 10;
        return message;
    }
    CellRig rig_;
    std::array<std::int32_t, 3> truth_{};
};

TEST_F(Seating, OfAWorkpieceThatSitsAsItsReferenceIsProven) {
    EXPECT_EQ(rig_.check_seating(wanted()).refusal, 0);
    for (const std::int32_t deviation : rig_.sensors().seating) {
        EXPECT_LT(std::abs(deviation), 0.7 * kMm);
    }
}

TEST_F(Seating, ThatIsOffOrTiltedIsRefusedEachByItsOwnCode) {
    const auto off = rig_.check_seating(wanted({3 * kMm, 3 * kMm, 3 * kMm}));
    EXPECT_EQ(off.refusal, static_cast<std::uint16_t>(Refusal::seating_off));
    EXPECT_NEAR(static_cast<double>(off.detail), -3.0 * kMm, 0.3 * kMm);
    const auto tilted = rig_.check_seating(wanted({kMm, -kMm, 0}));
    EXPECT_EQ(tilted.refusal, static_cast<std::uint16_t>(Refusal::seating_tilted));
    EXPECT_NEAR(static_cast<double>(tilted.detail), 2.0 * kMm, 0.5 * kMm);
    auto message = wanted();
    message.tolerance = -1;
    EXPECT_EQ(rig_.check_seating(message).refusal, static_cast<std::uint16_t>(Refusal::bad_config));
}

TEST_F(Seating, ThatFailedForbidsToArmAndToStartUntilOnePasses) {
    rig_.make_ready();
    ASSERT_EQ(rig_.command(link::Verb::disarm).refusal, 0);
    ASSERT_TRUE(rig_.until_state(State::idle, 5000));
    // Homing has turned the table.
    rig_.ticks(1000);
    take_reference();
    EXPECT_NE(rig_.check_seating(wanted({3 * kMm, 3 * kMm, 3 * kMm})).refusal, 0);
    EXPECT_EQ(rig_.command(link::Verb::arm).refusal, static_cast<std::uint16_t>(Refusal::seating_not_proven));
    EXPECT_EQ(rig_.check_seating(wanted()).refusal, 0);
    EXPECT_EQ(rig_.command(link::Verb::arm).refusal, 0);
}

class SeatingFaults : public testing::TestWithParam<std::pair<const char*, SensorCode>> {};

TEST_P(SeatingFaults, EndInTheirOwnCodeAndNeverInAVerdictOnTheWorkpiece) {
    const auto [trouble, code] = GetParam();
    CellRig rig(in_world({}, std::string("at 1.0 sensor 2 ") + trouble));
    rig.connect();
    // A device is asked who it is every five seconds, and three seconds of the same value count as frozen.
    rig.ticks(8000);
    const auto report = rig.sensors();
    EXPECT_EQ(report.code[2], static_cast<std::uint16_t>(code));
    const auto reply = rig.check_seating(
        {.expected = {report.value[1], report.value[2], report.value[3]}, .tolerance = kMm, .tilt = kMm, .samples = 3});
    EXPECT_EQ(reply.refusal, static_cast<std::uint16_t>(Refusal::seating_no_value));
    EXPECT_EQ(reply.detail, 2000 + static_cast<int>(code));
}

INSTANTIATE_TEST_SUITE_P(
    All, SeatingFaults,
    testing::Values(std::pair{"silent", SensorCode::timeout}, std::pair{"crc", SensorCode::bad_crc},
                    std::pair{"wrong_slave", SensorCode::wrong_slave}, std::pair{"exception", SensorCode::exception},
                    std::pair{"chopped", SensorCode::bad_frame}, std::pair{"stale", SensorCode::frozen},
                    std::pair{"foreign", SensorCode::wrong_device}, std::pair{"blind", SensorCode::own_fault}));

TEST(SeatingOrder, SwappedSensorsAreNamedByTheOrderThatFits) {
    // A side that leans, so that the three distances differ.
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "sensors_side";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "side.obj") << "v -35 -660 -460\nv -15 -340 -460\nv 5 -340 -200\nv -15 -660 -200\n"
                                          "f 1 2 3\nf 1 3 4\n";
    std::ofstream(folder / "world.toml") << "base = \"" SC_SOURCE_DIR "/boards/sim/world/default/world.toml\"\n"
                                         << "[[mesh]]\nname = \"side\"\nfile = \"side.obj\"\nunit = \"mm\"\n";
    CellRig rig(in_world(folder / "world.toml", "at 4.0 sensor 1 swapped"));
    rig.connect();
    rig.ticks(3000);
    const auto before = rig.sensors();
    const link::CheckSeating message{
        .expected = {before.value[1], before.value[2], before.value[3]}, .tolerance = kMm, .tilt = kMm, .samples = 10};
    EXPECT_EQ(rig.check_seating(message).refusal, 0);
    rig.ticks(2000);
    const auto reply = rig.check_seating(message);
    EXPECT_EQ(reply.refusal, static_cast<std::uint16_t>(Refusal::seating_swapped));
    EXPECT_EQ(reply.detail, 213);
}

TEST(SeatingOrder, AWrongCountOfCyclesIsFarOff) {
    CellRig rig(in_world({}, "at 3.5 sensor 3 slipped"));
    rig.connect();
    rig.ticks(3000);
    const auto before = rig.sensors();
    rig.ticks(2000);
    const auto reply = rig.check_seating({.expected = {before.value[1], before.value[2], before.value[3]},
                                          .tolerance = 2 * kMm,
                                          .tilt = 2 * kMm,
                                          .samples = 5});
    EXPECT_EQ(reply.refusal, static_cast<std::uint16_t>(Refusal::seating_off));
    EXPECT_NEAR(static_cast<double>(reply.detail), 50.0 * kMm, kMm);
}

TEST(SensorsReport, LasersInTurnAreSwitchedByCommand) {
    CellRig rig;
    rig.connect();
    rig.ticks(2000);
    EXPECT_EQ(rig.command(link::Verb::lasers_in_turn, 2).refusal, static_cast<std::uint16_t>(Refusal::bad_config));
    EXPECT_EQ(rig.command(link::Verb::lasers_in_turn, 1).refusal, 0);
    rig.ticks(3000);
    const auto report = rig.sensors();
    for (std::size_t i = 1; i < 4; ++i) {
        EXPECT_EQ(report.code[i], 0) << i;
    }
}

}  // namespace
