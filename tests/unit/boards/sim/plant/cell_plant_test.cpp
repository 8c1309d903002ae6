// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/cell_plant.hpp"

#include <array>
#include <bitset>
#include <cmath>
#include <memory>
#include <stdexcept>

#include <gtest/gtest.h>

#include "firmware/safety/frame_guard.hpp"

namespace sc::sim {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A cell without errors and without a workpiece.
WorldSpec empty_cell() {
    WorldSpec spec;
    spec.inputs = {true, true, true, true, false, false, false, true};
    return spec;
}

/// The same with a sheet across it at y = -20 mm in t.
World cell_with_sheet() {
    return {empty_cell(),
            Mesh{{{-1, -0.02, -1}, {1, -0.02, -1}, {1, -0.02, 1}, {-1, -0.02, 1}}, {{0, 2, 1}, {0, 3, 2}}}};
}

std::uint32_t word_at(const MachineConfig& machine, double metres) {
    const auto position = static_cast<std::uint32_t>(0x8000 + std::lround(metres * machine.galvo.counts_per_metre));
    const std::uint32_t body = 0x20000U | (position << 1U);
    return body | static_cast<std::uint32_t>(std::bitset<20>(body).count() % 2);
}

/// A controller's outputs by hand, ticked as the cell does it.
class Bench {
public:
    explicit Bench(const char* script = "", const MachineConfig& machine = reference_machine())
        : machine_(machine),
          world_(empty_cell()),
          plant_(machine_, world_, parse_fault_script(script, "s.txt"), safety::frame_guard) {
        plant_.shutter().put(1.0);
    }

    /// One tick: `shape` fills in its outputs. Returns the inputs that it began with.
    template <class Shape>
    ServoInputs tick(Shape shape) {
        ServoInputs inputs;
        plant_.sample(inputs);
        newest_ = 1 - newest_;
        ServoOutputs& out = *outputs_[newest_];
        out = {};
        for (GalvoFrame& frame : out.galvo) {
            frame.word_x = frame.word_z = word_at(machine_, 0.0);
        }
        out.digital.master_oscillator = out.digital.shutter_open = true;
        out.gate_allowed = true;
        shape(out, (tick_ + 1) * kMs);
        plant_.accept(tick_, out);
        plant_.play(tick_, tick_ == 0 ? nullptr : outputs_[1 - newest_].get(),
                    [this](const trace::PulseRecord& r) { pulses_.push_back(r); });
        ++tick_;
        return inputs;
    }
    /// Ticks with 80 kHz of pulses until `ticks` have passed in all.
    void mark_until(std::int64_t ticks) {
        while (tick_ < ticks) {
            tick(mark);
        }
    }
    static void mark(ServoOutputs& out, std::int64_t window_ns) {
        out.laser[0] = {window_ns, 12'500 * 256, 0, 80, 1, 255, 5'000};
        out.laser_size = 1;
    }
    static void dark(ServoOutputs& out, std::int64_t) { out.gate_allowed = false; }

    MachineConfig machine_;
    World world_;
    CellPlant plant_;
    std::array<std::unique_ptr<ServoOutputs>, 2> outputs_{std::make_unique<ServoOutputs>(),
                                                          std::make_unique<ServoOutputs>()};
    std::size_t newest_ = 0;
    std::int64_t tick_ = 0;
    std::vector<trace::PulseRecord> pulses_;
};

TEST(CellPlant, PlaysTheOutputsOfATickInTheNextWindow) {
    Bench bench;
    for (int i = 0; i < 20; ++i) {
        bench.tick(Bench::dark);
    }
    bench.tick(Bench::mark);
    bench.tick(Bench::dark);
    bench.tick(Bench::dark);
    ASSERT_EQ(bench.pulses_.size(), 80U);
    EXPECT_EQ(bench.pulses_.front().t_ns, 21 * kMs + 1000);
    EXPECT_EQ(bench.pulses_.back().t_ns, 21 * kMs + 79 * 12'500 + 1000);
    EXPECT_EQ(bench.pulses_.front().energy_nj, 1'000'000U);
    EXPECT_EQ(bench.plant_.laser_counters().cancelled, 0U);
}

TEST(CellPlant, NoLightBeforeTheMasterOscillatorHasWaited) {
    Bench bench;
    bench.mark_until(20);
    // MO is on from 1 ms, its wait is 8 ms: light from 9 ms on. 8 ms of 80 kHz stayed dark.
    EXPECT_EQ(bench.plant_.laser_counters().unlit, 640U);
    EXPECT_EQ(bench.pulses_.front().t_ns, 9 * kMs + 1000);
}

TEST(CellPlant, NothingPassesWhenTheTickDidNotAllowTheGate) {
    Bench bench;
    bench.mark_until(15);
    const std::size_t before = bench.pulses_.size();
    bench.tick([](ServoOutputs& out, std::int64_t t) {
        Bench::mark(out, t);
        out.gate_allowed = false;
    });
    bench.tick(Bench::dark);
    bench.tick(Bench::dark);
    EXPECT_EQ(bench.pulses_.size(), before + 80);
    EXPECT_EQ(bench.plant_.laser_counters().not_allowed, 80U);
}

struct Edge {
    const char* event;
    std::int64_t most_ns;  ///< from the edge to the last light
    std::uint8_t cause;
};
class CellPlantEdge : public testing::TestWithParam<Edge> {};

TEST_P(CellPlantEdge, LaserIsOffInTimeWhateverThePhase) {
    for (const std::int64_t phase_ns : {0, 1, 400, 11'500, 50'000, 99'999, 100'000, 100'001, 733'333, 999'999}) {
        const std::int64_t edge = 20 * kMs + phase_ns;
        const std::string script = "at " + std::to_string(static_cast<double>(edge) * 1e-9).substr(0, 1) + "." +
                                   std::to_string(1'000'000'000 + edge).substr(1) + " " + GetParam().event;
        Bench bench(script.c_str());
        bench.mark_until(25);
        ASSERT_EQ(bench.plant_.fault_records().size(), 1U);
        ASSERT_EQ(bench.plant_.fault_records()[0].t_ns, edge);
        EXPECT_LE(bench.pulses_.back().t_ns - edge, GetParam().most_ns) << script;
        EXPECT_GE(bench.pulses_.back().t_ns, edge - 12'500) << script;
        EXPECT_EQ(bench.plant_.last_pulse_ns(), bench.pulses_.back().t_ns);
        ServoInputs inputs = bench.tick(Bench::dark);
        // The hard line has shut the shutter too, and this controller still allows the gate.
        const unsigned shutter = GetParam().cause <= 2 ? static_cast<unsigned>(GuardCause::shutter) : 0U;
        EXPECT_EQ(inputs.guard_causes & ~shutter, GetParam().cause);
    }
}
INSTANTIATE_TEST_SUITE_P(Events, CellPlantEdge,
                         testing::Values(Edge{"estop open", 1'000, 1}, Edge{"interlock open", 1'000, 2},
                                         Edge{"laser alarm", 110'000, 4}, Edge{"galvo fail", 110'000, 8},
                                         Edge{"laser temperature", 110'000, 4}, Edge{"shutter unplugged", 110'000, 16},
                                         Edge{"key setup", 110'000, 32}));

TEST(CellPlant, HardLineNeedsNoFirmware) {
    const GuardFunction blind = [](const GuardInputs&) noexcept { return GuardVeto{false, 0}; };
    const World world(empty_cell());
    const MachineConfig machine = reference_machine();
    CellPlant plant(machine, world, parse_fault_script("at 0.02 estop open", "s"), blind);
    plant.shutter().put(1.0);
    std::vector<trace::PulseRecord> pulses;
    std::array<std::unique_ptr<ServoOutputs>, 2> outputs{std::make_unique<ServoOutputs>(),
                                                         std::make_unique<ServoOutputs>()};
    for (std::int64_t tick = 0; tick < 30; ++tick) {
        ServoOutputs& out = *outputs[static_cast<std::size_t>(tick % 2)];
        out = {};
        out.digital.master_oscillator = out.digital.shutter_open = out.gate_allowed = true;
        Bench::mark(out, (tick + 1) * kMs);
        plant.accept(tick, out);
        plant.play(tick, tick == 0 ? nullptr : outputs[static_cast<std::size_t>((tick + 1) % 2)].get(),
                   [&](const trace::PulseRecord& r) { pulses.push_back(r); });
    }
    ASSERT_FALSE(pulses.empty());
    EXPECT_LE(pulses.back().t_ns, 20 * kMs + 1000);
    EXPECT_GT(plant.laser_counters().cut, 0U);
}

TEST(CellPlant, CancelActsAtOnceAndDropsWhatIsQueued) {
    Bench bench;
    bench.mark_until(20);
    bench.tick([](ServoOutputs& out, std::int64_t t) {
        Bench::mark(out, t);
        out.cancel_laser = true;
    });
    bench.tick(Bench::dark);
    bench.tick(Bench::dark);
    EXPECT_LE(bench.pulses_.back().t_ns, 20 * kMs + 10'000 + 1'000);
    EXPECT_GE(bench.pulses_.back().t_ns, 20 * kMs);
    bench.mark_until(30);
    EXPECT_EQ(bench.pulses_.back().t_ns, 29 * kMs + 79 * 12'500 + 1000) << "a cancel is no lasting veto";
}

TEST(CellPlant, EventAfterAPulseIsAnEdgeAtThatPulse) {
    Bench bench("pulse 100 interlock open");
    bench.mark_until(15);
    EXPECT_EQ(bench.pulses_.size(), 100U);
    EXPECT_EQ(bench.plant_.pulses(), 100U);
    ASSERT_EQ(bench.plant_.fault_records().size(), 1U);
    EXPECT_EQ(bench.plant_.fault_records()[0].t_ns, bench.pulses_.back().t_ns);
    EXPECT_FALSE(bench.plant_.fault_records()[0].last_pulse_ns);
}

TEST(CellPlant, LinesReachTheInputsAndComeBack) {
    Bench bench(
        "at 0.005 estop open\nat 0.006 laser alarm\nat 0.007 laser not_ready\nat 0.010 laser ok\n"
        "at 0.010 estop close\nat 0.012 link cut\nat 0.014 link restore\n");
    const auto at = [&](std::int64_t tick) {
        while (bench.tick_ < tick) {
            bench.tick(Bench::dark);
        }
        const DigitalInputs in = bench.tick(Bench::dark).digital;
        return std::array{in.estop_closed, in.interlock_closed, in.laser_ready, in.laser_no_alarm};
    };
    EXPECT_EQ(at(4), (std::array{true, true, true, true}));
    EXPECT_EQ(at(6), (std::array{false, true, true, true}));
    EXPECT_EQ(at(9), (std::array{false, true, false, false}));
    EXPECT_EQ(at(11), (std::array{true, true, true, true}));
    EXPECT_TRUE(bench.plant_.link_connected());
    (void)at(13);
    EXPECT_FALSE(bench.plant_.link_connected());
    (void)at(15);
    EXPECT_TRUE(bench.plant_.link_connected());
}

TEST(CellPlant, TheShutterKeepsTheLightBackUntilItIsOpen) {
    Bench bench;
    bench.plant_.shutter().put(0.0);
    bench.mark_until(80);
    // Commanded from 1 ms on; light passes when 95 % of 60 ms are over. The guard, which sees it, lets none through
    // before.
    ASSERT_FALSE(bench.pulses_.empty());
    EXPECT_GE(bench.pulses_.front().t_ns, 58 * kMs);
    EXPECT_LE(bench.pulses_.front().t_ns, 62 * kMs);
}

TEST(CellPlant, TheHardLineShutsTheShutterToo) {
    Bench bench("at 0.02 interlock open\n");
    bench.mark_until(100);
    EXPECT_TRUE(bench.plant_.shutter().reads_closed()) << "the command still says open";
}

TEST(CellPlant, KeyAndShutterReachTheInputs) {
    Bench bench("at 0.005 key setup\nat 0.010 key off\nat 0.015 key production\nat 0.02 shutter unplugged\n");
    const auto at = [&](std::int64_t tick) {
        while (bench.tick_ < tick) {
            bench.tick(Bench::dark);
        }
        return bench.tick(Bench::dark).digital;
    };
    EXPECT_EQ(key_mode(at(4)), KeyMode::production);
    EXPECT_EQ(key_mode(at(7)), KeyMode::setup);
    EXPECT_EQ(key_mode(at(12)), KeyMode::off);
    EXPECT_EQ(key_mode(at(17)), KeyMode::production);
    EXPECT_TRUE(shutter_reads_open(at(18)));
    EXPECT_FALSE(shutter_reads_open(at(22)));
}

TEST(CellPlant, BadGalvoWordsAreCounted) {
    Bench bench;
    bench.tick([](ServoOutputs& out, std::int64_t) { out.galvo[7].word_x ^= 1U; });
    bench.tick(Bench::dark);
    EXPECT_EQ(bench.plant_.galvo_words_dropped(), 1U);
}

TEST(CellPlant, PulseLandsWhereMirrorsWereATrackingTimeAgo) {
    MachineConfig machine = reference_machine();
    machine.galvo.counts_per_metre = 4e6;  // 8 mm either side, a grid of 0.25 um
    const World world = cell_with_sheet();
    CellPlant plant(machine, world, {}, safety::frame_guard);
    plant.shutter().put(1.0);
    std::vector<trace::PulseRecord> pulses;
    std::array<std::unique_ptr<ServoOutputs>, 2> outputs{std::make_unique<ServoOutputs>(),
                                                         std::make_unique<ServoOutputs>()};
    const double speed = 0.2;
    const auto command = [&](std::int64_t t_ns) { return speed * (static_cast<double>(t_ns) * 1e-9 - 0.020); };
    for (std::int64_t tick = 0; tick < 30; ++tick) {
        ServoOutputs& out = *outputs[static_cast<std::size_t>(tick % 2)];
        out = {};
        out.digital.master_oscillator = out.digital.shutter_open = out.gate_allowed = true;
        const std::int64_t window = (tick + 1) * kMs;
        for (std::size_t k = 0; k < kGalvoFramesPerTick; ++k) {
            const double x = command(window + static_cast<std::int64_t>(k) * 10'000);
            out.galvo[k].word_x = word_at(machine, x);
            out.galvo[k].word_z = word_at(machine, 0.0);
        }
        out.laser[0] = {window + 3'217, 47'000 * 256, 0, 20, 1, 255, 5'000};
        out.laser_size = 1;
        plant.accept(tick, out);
        plant.play(tick, tick == 0 ? nullptr : outputs[static_cast<std::size_t>((tick + 1) % 2)].get(),
                   [&](const trace::PulseRecord& r) { pulses.push_back(r); });
    }
    ASSERT_GT(pulses.size(), 300U);
    const double x = plant.drive(Axis::x).true_position();
    const double y = plant.drive(Axis::y).true_position();
    for (const trace::PulseRecord& r : pulses) {
        ASSERT_EQ(r.hit, 1);
        const double mirrors = command(r.t_ns - 160'000);
        const double focus_x = x + mirrors;
        // The beam goes on along its lean to the sheet, which stands turned by C.
        const double defocus = static_cast<double>(r.defocus_pm) * 1e-12;
        EXPECT_NEAR(static_cast<double>(r.place_pm[0]) * 1e-12, focus_x + mirrors / 0.160 * defocus, 0.4e-6);
        EXPECT_NEAR(static_cast<double>(r.place_pm[1]) * 1e-12, y - defocus, 1e-11);
        EXPECT_NEAR(static_cast<double>(r.table_pm[1]) * 1e-12, -0.02, 2e-12);
        EXPECT_NEAR(static_cast<double>(r.c_ndeg) * 1e-9, plant.drive(Axis::c).true_position(), 1e-8);
    }
}

TEST(CellPlant, BeamThatMeetsNothingIsAPulseWithoutAHit) {
    Bench bench;
    bench.mark_until(12);
    ASSERT_FALSE(bench.pulses_.empty());
    EXPECT_EQ(bench.pulses_.front().hit, 0);
    EXPECT_EQ(bench.pulses_.front().place_pm, (std::array<std::int64_t, 3>{}));
}

TEST(CellPlant, EncodersLieOnTheirGrids) {
    Bench bench;
    const AxisPositions encoders = bench.plant_.encoders();
    EXPECT_EQ(encoders[0] % 1'000'000, 0);  // 1 um
    EXPECT_EQ(encoders[3] % 1'000'000, 0);  // 0.001 degree
    EXPECT_NEAR(static_cast<double>(encoders[0]) * 1e-12, bench.plant_.drive(Axis::x).true_position(), 0.5e-6);
}

TEST(CellPlant, PeriodsThatDoNotDivideAreRefused) {
    const World world(empty_cell());
    MachineConfig machine = reference_machine();
    machine.guard_period_ns = 300'000;
    EXPECT_THROW(CellPlant(machine, world, {}, safety::frame_guard), std::invalid_argument);
    machine = reference_machine();
    machine.control_period_ns = 2 * kMs;
    EXPECT_THROW(CellPlant(machine, world, {}, safety::frame_guard), std::invalid_argument);
}

}  // namespace
}  // namespace sc::sim
