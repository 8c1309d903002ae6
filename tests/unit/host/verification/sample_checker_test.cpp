// SPDX-License-Identifier: Apache-2.0
#include "host/verification/sample_checker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/formats/error.hpp"
#include "shared/codes/state.hpp"

namespace sc::host {
namespace {

constexpr std::array<std::size_t, kAxisCount> kAllAxes{0, 1, 2, 3};
constexpr std::array<double, kAxisCount> kUnits{1e12, 1e12, 1e12, 1e9};
/// Set-points at rest, all within travel and y retracted.
constexpr std::array<double, kAxisCount> kStand{-0.2, -0.1, -0.2, 10.0};

/// Writes ticks as a controller would emit them.
class Samples {
public:
    explicit Samples(const MachineConfig& machine = reference_machine()) : checker_(machine) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            set(i, kStand[i]);
        }
        record.state = static_cast<std::uint8_t>(State::running);
    }
    void set(std::size_t axis, double base_units) {
        record.set_point[axis] = std::llround(base_units * kUnits[axis]);
        record.actual[axis] = record.set_point[axis];
    }
    void tick(std::span<const trace::GalvoSample> frames = {}) {
        checker_.add(record, frames);
        ++record.tick;
    }
    void rest(int ticks) {
        for (int i = 0; i < ticks; ++i) {
            tick();
        }
    }
    [[nodiscard]] const SampleReport& report() const { return checker_.report(); }
    [[nodiscard]] std::size_t count(Breach breach) const {
        return static_cast<std::size_t>(std::ranges::count(report().first, breach, &Violation::breach));
    }

    trace::SampleRecord record;

private:
    SampleChecker checker_;
};

/// Distance covered by time t when the jerk is +j, 0, −j for `ramp`, `hold`, `ramp`: the speed-up half of a move.
double speed_up(double t, double ramp, double hold, double jerk) {
    const auto cube = [jerk](double since) { return since > 0.0 ? jerk * since * since * since / 6.0 : 0.0; };
    return cube(t) - cube(t - ramp) - cube(t - ramp - hold) + cube(t - 2.0 * ramp - hold);
}

struct Shape {
    double ramp;
    double hold;
    double jerk;
};
/// Speed up, cruise for 20 samples, slow down, rest.
template <class Emit>
void run_move(const Shape& shape, double period, Emit emit) {
    const double rise = 2.0 * shape.ramp + shape.hold;
    const double cruise = 20.0 * period;
    const double total = 2.0 * rise + cruise;
    for (double t = 0.0; t < total + 5.0 * period; t += period) {
        // Slowing down is another speed-up taken off.
        emit(speed_up(t, shape.ramp, shape.hold, shape.jerk) -
             speed_up(t - rise - cruise, shape.ramp, shape.hold, shape.jerk));
    }
}

/// A move that reaches just the part given of each limit.
Shape shape_for(double speed, double acceleration, double jerk) {
    const double ramp = acceleration / jerk;
    return {ramp, speed / acceleration - ramp, jerk};
}

struct Limits {
    double speed;
    double acceleration;
    double jerk;
};
Limits limits_of(const AxisConfig& axis) { return {axis.speed, axis.acceleration, axis.jerk}; }
Limits limits_of(const GalvoConfig& galvo) { return {galvo.speed.si(), galvo.acceleration.si(), galvo.jerk.si()}; }
Shape shape_for(const Limits& limits, double speed_factor, double acceleration_factor, double jerk_factor) {
    return shape_for(speed_factor * limits.speed, acceleration_factor * limits.acceleration, jerk_factor * limits.jerk);
}

SampleReport after_axis_move(std::size_t axis, const Shape& shape, std::uint8_t state) {
    Samples samples;
    samples.record.state = state;
    samples.rest(3);
    run_move(shape, 1e-3, [&](double way) {
        samples.set(axis, kStand[axis] - way);
        samples.tick();
    });
    return samples.report();
}
SampleReport after_axis_move(std::size_t axis, const Shape& shape) {
    return after_axis_move(axis, shape, static_cast<std::uint8_t>(State::running));
}

/// The mirror moves out and back, in as many ticks as it takes, ending at zero.
SampleReport after_galvo_move(bool z, const Shape& shape) {
    std::vector<double> way;
    run_move(shape, 1e-5, [&](double w) { way.push_back(w); });
    const double reach = way.back();
    run_move(shape, 1e-5, [&](double w) { way.push_back(reach - w); });
    Samples samples;
    samples.rest(2);
    std::vector<trace::GalvoSample> frames;
    for (std::size_t i = 0; i < way.size() || !frames.empty(); ++i) {
        const std::int64_t place = i < way.size() ? std::llround(way[i] * 1e12) : 0;
        frames.push_back(z ? trace::GalvoSample{0, place} : trace::GalvoSample{place, 0});
        if (frames.size() == 100) {
            samples.tick(frames);
            frames.clear();
        }
    }
    samples.rest(2);
    return samples.report();
}

bool only(const SampleReport& report, Breach breach, std::string_view axis) {
    return report.limit_violations > 0 &&
           std::ranges::all_of(report.first, [&](const Violation& v) { return v.breach == breach && v.axis == axis; });
}

constexpr std::array<std::string_view, kAxisCount> kNames{"x", "y", "z", "c"};

TEST(SampleChecker, AcceptsMovesAtTheLimitsOfEachAxis) {
    for (const std::size_t axis : kAllAxes) {
        const Limits limits = limits_of(reference_machine().axis[axis]);
        const SampleReport report = after_axis_move(axis, shape_for(limits, 1.0, 1.0, 1.0));
        EXPECT_EQ(report.limit_violations, 0U) << kNames[axis];
        EXPECT_NEAR(report.axis_peak[axis].speed, limits.speed, 1e-3 * limits.speed);
        EXPECT_NEAR(report.axis_peak[axis].acceleration, limits.acceleration, 1e-2 * limits.acceleration);
        EXPECT_NEAR(report.axis_peak[axis].jerk, limits.jerk, 1e-2 * limits.jerk);
    }
}

TEST(SampleChecker, AcceptsWhatCompensationAdds) {
    for (const std::size_t axis : kAllAxes) {
        const Limits limits = limits_of(reference_machine().axis[axis]);
        EXPECT_EQ(after_axis_move(axis, shape_for(limits, 1.001, 1.001, 1.001)).limit_violations, 0U);
    }
}

TEST(SampleChecker, RejectsOnePercentMoreSpeedOnEachAxis) {
    for (const std::size_t axis : kAllAxes) {
        const SampleReport report =
            after_axis_move(axis, shape_for(limits_of(reference_machine().axis[axis]), 1.01, 1, 1));
        EXPECT_TRUE(only(report, Breach::speed, kNames[axis])) << kNames[axis];
    }
}

TEST(SampleChecker, RejectsOnePercentMoreAccelerationOnEachAxis) {
    for (const std::size_t axis : kAllAxes) {
        const SampleReport report =
            after_axis_move(axis, shape_for(limits_of(reference_machine().axis[axis]), 1, 1.01, 1));
        EXPECT_TRUE(only(report, Breach::acceleration, kNames[axis])) << kNames[axis];
    }
}

TEST(SampleChecker, RejectsOnePercentMoreJerkOnEachAxis) {
    for (const std::size_t axis : kAllAxes) {
        const SampleReport report =
            after_axis_move(axis, shape_for(limits_of(reference_machine().axis[axis]), 1, 1, 1.01));
        EXPECT_TRUE(only(report, Breach::jerk, kNames[axis])) << kNames[axis];
    }
}

TEST(SampleChecker, AcceptsMirrorsAtTheirLimits) {
    for (const bool z : {false, true}) {
        const SampleReport report = after_galvo_move(z, shape_for(limits_of(reference_machine().galvo), 1, 1, 1));
        EXPECT_EQ(report.limit_violations, 0U);
        EXPECT_GT(report.galvo_frames, 0);
        EXPECT_NEAR(report.galvo_peak[z ? 1 : 0].speed, 2.0, 2e-3);
        EXPECT_EQ(report.galvo_peak[z ? 0 : 1].speed, 0.0);
    }
}

TEST(SampleChecker, RejectsOnePercentMoreOfEachMirror) {
    const Limits limits = limits_of(reference_machine().galvo);
    for (const bool z : {false, true}) {
        const std::string_view name = z ? "galvo z" : "galvo x";
        EXPECT_TRUE(only(after_galvo_move(z, shape_for(limits, 1.01, 1, 1)), Breach::speed, name));
        EXPECT_TRUE(only(after_galvo_move(z, shape_for(limits, 1, 1.01, 1)), Breach::acceleration, name));
        EXPECT_TRUE(only(after_galvo_move(z, shape_for(limits, 1, 1, 1.01)), Breach::jerk, name));
    }
}

TEST(SampleChecker, RejectsMirrorsThatJumpBackToZero) {
    Samples samples;
    std::vector<trace::GalvoSample> frames(100);
    double way = 0.0;
    const Shape shape = shape_for(limits_of(reference_machine().galvo), 0.5, 0.5, 0.5);
    std::size_t i = 0;
    run_move(shape, 1e-5, [&](double w) {
        way = w;
        if (i < frames.size()) {
            frames[i++].x_pm = std::llround(w * 1e12);
        }
    });
    for (; i < frames.size(); ++i) {
        frames[i].x_pm = std::llround(way * 1e12);
    }
    samples.tick(frames);
    EXPECT_EQ(samples.report().limit_violations, 0U);
    samples.tick();
    EXPECT_GT(samples.count(Breach::speed), 0U);
}

TEST(SampleChecker, RejectsAMirrorBeyondItsField) {
    MachineConfig machine = reference_machine();
    machine.galvo.half_field = Length::from_si(0.5e-3);
    Samples samples(machine);
    std::vector<trace::GalvoSample> frames(100);
    samples.tick(frames);
    const Shape shape = shape_for(limits_of(machine.galvo), 1, 1, 1);  // 1.1 mm in 90 frames
    std::size_t i = 0;
    run_move(shape, 1e-5, [&](double w) {
        if (i < frames.size()) {
            frames[i++].z_pm = -std::llround(w * 1e12);
        }
    });
    std::fill(frames.begin() + static_cast<std::ptrdiff_t>(i), frames.end(), frames[i - 1]);
    samples.tick(frames);
    EXPECT_GT(samples.count(Breach::galvo_field), 0U);
    EXPECT_TRUE(only(samples.report(), Breach::galvo_field, "galvo z"));
}

TEST(SampleChecker, RejectsOnePercentOutOfTravelOnEachSide) {
    for (const std::size_t axis : kAllAxes) {
        MachineConfig machine = reference_machine();
        machine.keep_out_count = 0;
        const AxisConfig& a = machine.axis[axis];
        const double beyond = 0.01 * (a.travel_max - a.travel_min);
        for (const auto& [place, inside] :
             {std::pair{a.travel_min - beyond, a.travel_min}, std::pair{a.travel_max + beyond, a.travel_max}}) {
            Samples legal(machine);
            legal.set(axis, inside);
            legal.rest(3);
            EXPECT_EQ(legal.report().limit_violations, 0U) << kNames[axis];
            Samples samples(machine);
            samples.set(axis, place);
            samples.rest(3);
            EXPECT_EQ(samples.report().limit_violations, 3U);
            EXPECT_TRUE(only(samples.report(), Breach::travel, kNames[axis])) << kNames[axis];
            EXPECT_EQ(samples.report().first[0].limit, inside);
        }
    }
}

TEST(SampleChecker, RejectsTheFocusInAKeepOutVolume) {
    Samples samples;
    samples.set(2, -0.4799);
    samples.tick();
    EXPECT_EQ(samples.report().limit_violations, 0U);
    Samples inside;
    inside.set(2, -0.4805);
    inside.tick();
    EXPECT_TRUE(only(inside.report(), Breach::keep_out, ""));
    EXPECT_NEAR(inside.report().first[0].value, 0.5e-3, 1e-9);
}

TEST(SampleChecker, MirrorsCountInTheKeepOutRule) {
    MachineConfig machine = reference_machine();
    machine.galvo.jerk = Jerk::from_si(1e13);
    machine.galvo.acceleration = Acceleration::from_si(1e8);
    machine.galvo.speed = Speed::from_si(1e3);
    Samples samples(machine);
    samples.set(2, -0.4795);
    std::vector<trace::GalvoSample> frames(100);
    frames[50].z_pm = -1'000'000'000;
    samples.tick(frames);
    EXPECT_EQ(samples.report().limit_violations, 1U);
    EXPECT_EQ(samples.report().first[0].frame, 50);
}

TEST(SampleChecker, RejectsATurnWhileNotRetracted) {
    const double up = reference_machine().y_retracted.si();
    const Shape slow = shape_for(limits_of(reference_machine().axis[3]), 0.5, 0.5, 0.5);
    for (const double y : {up, up - 2e-3}) {
        Samples samples;
        samples.set(1, y);
        samples.rest(2);
        run_move(slow, 1e-3, [&](double way) {
            samples.set(3, kStand[3] + way);
            samples.tick();
        });
        EXPECT_EQ(samples.report().limit_violations > 0, y < up);
        EXPECT_EQ(samples.count(Breach::turn_not_retracted) > 0, y < up);
    }
}

TEST(SampleChecker, RejectsATurnWhileTheAxisLagsFarBehind) {
    Samples samples;
    samples.rest(2);
    samples.record.actual[1] = -250'000'000'000;
    samples.record.set_point[3] += 10;
    samples.tick();
    EXPECT_TRUE(only(samples.report(), Breach::turn_not_retracted, "y"));
}

TEST(SampleChecker, RejectsPulsesOutsideMarking) {
    for (std::uint8_t state = 0; state < kStateCount; ++state) {
        Samples samples;
        samples.record.state = state;
        samples.record.gate = 1;
        samples.tick();
        const bool marking = state == static_cast<std::uint8_t>(State::marking);
        EXPECT_EQ(samples.count(Breach::gate_outside_marking), marking ? 0U : 1U) << int{state};
    }
}

TEST(SampleChecker, RejectsAGapInTheTicks) {
    Samples samples;
    samples.rest(3);
    ++samples.record.tick;
    samples.set(0, -0.3);  // nothing can be said about the way there
    samples.rest(3);
    EXPECT_EQ(samples.report().limit_violations, 1U);
    EXPECT_EQ(samples.count(Breach::missing_tick), 1U);
}

TEST(SampleChecker, RejectsAJumpBetweenStatesThatMove) {
    Samples samples;
    samples.rest(3);
    samples.record.state = static_cast<std::uint8_t>(State::marking);
    samples.set(0, kStand[0] + 1e-3);
    samples.tick();
    EXPECT_GT(samples.count(Breach::speed), 0U);
}

TEST(SampleChecker, SetPointsMayFollowWhileTheDrivesLead) {
    for (const State state :
         {State::boot, State::disabled, State::enabling, State::homing, State::disabling, State::fault}) {
        Samples samples;
        samples.record.state = static_cast<std::uint8_t>(state);
        samples.rest(2);
        samples.set(0, 0.3);
        samples.rest(2);
        samples.record.state = static_cast<std::uint8_t>(State::idle);
        samples.set(0, -0.1);
        samples.rest(2);
        EXPECT_EQ(samples.report().limit_violations, 0U) << name_of(state);
    }
}

TEST(SampleChecker, AStretchMustBeginAtRest) {
    const Limits limits = limits_of(reference_machine().axis[0]);
    Samples samples;
    samples.record.state = static_cast<std::uint8_t>(State::enabling);
    samples.tick();
    samples.record.state = static_cast<std::uint8_t>(State::idle);
    for (int i = 0; i < 5; ++i) {
        samples.set(0, kStand[0] + 0.5e-3 * limits.speed * i);
        samples.tick();
    }
    EXPECT_GT(samples.count(Breach::acceleration), 0U);
}

TEST(SampleChecker, AStateThatIsNoneHidesNothing) {
    const Shape fast = shape_for(limits_of(reference_machine().axis[0]), 1.2, 1, 1);
    EXPECT_GT(after_axis_move(0, fast, 200).limit_violations, 0U);
}

TEST(SampleChecker, KeepsTheFirstViolationsAndCountsAll) {
    Samples samples;
    samples.set(0, 0.2);
    samples.rest(250);
    EXPECT_EQ(samples.report().limit_violations, 250U);
    EXPECT_EQ(samples.report().first.size(), kKeptViolations);
    EXPECT_EQ(samples.report().first.back().tick, 99);
}

TEST(SampleChecker, CountsTicksAndTime) {
    Samples samples;
    samples.rest(1234);
    EXPECT_EQ(samples.report().ticks, 1234);
    EXPECT_NEAR(samples.report().cell_seconds, 1.234, 1e-12);
}

TEST(SampleChecker, NumbersOfADamagedTraceDoNotOverflow) {
    Samples samples;
    samples.tick();
    samples.record.set_point[0] = std::numeric_limits<std::int64_t>::max();
    samples.tick();
    samples.record.set_point[0] = std::numeric_limits<std::int64_t>::min();
    samples.tick();
    EXPECT_GT(samples.report().limit_violations, 4U);
}

TEST(CheckSamples, ReadsATraceFile) {
    const std::filesystem::path path =
        std::filesystem::path(testing::TempDir()) / ("samples_" + std::to_string(getpid()) + ".trace");
    std::ofstream file(path, std::ios::binary);
    const auto put = [&file](std::span<const std::uint8_t> bytes) {
        for (const std::uint8_t byte : bytes) {
            file.put(static_cast<char>(byte));
        }
    };
    file.write(trace::kSampleMagic.data(), trace::kSampleMagic.size());
    put(std::array<std::uint8_t, 6>{2, 0, 0, 0, '{', '}'});
    for (std::int64_t tick = 0; tick < 3; ++tick) {
        trace::SampleRecord record;
        record.tick = tick;
        record.set_point = {-200'000'000'000 + tick, -100'000'000'000, -200'000'000'000, 0};
        record.actual = record.set_point;
        record.state = static_cast<std::uint8_t>(State::running);
        record.gate = tick == 1 ? 1 : 0;
        record.galvo_frames = tick == 2 ? 100 : 0;
        std::array<std::uint8_t, trace::kSampleRecordSize> bytes{};
        trace::pack(record, bytes);
        put(bytes);
    }
    for (int frame = 0; frame < 100; ++frame) {
        std::array<std::uint8_t, trace::kGalvoSampleSize> bytes{};
        trace::pack(trace::GalvoSample{frame, 0}, bytes);
        put(bytes);
    }
    file.close();
    const SampleReport report = check_samples(path, reference_machine());
    std::filesystem::remove(path);
    EXPECT_EQ(report.ticks, 3);
    EXPECT_EQ(report.galvo_frames, 100);
    EXPECT_EQ(report.limit_violations, 1U);
    EXPECT_EQ(report.first[0].breach, Breach::gate_outside_marking);
    EXPECT_EQ(report.first[0].tick, 1);
}

TEST(SampleChecker, ATraceThatIsWholeEndsAtRest) {
    const MachineConfig machine = reference_machine();
    for (const std::size_t axis : kAllAxes) {
        const Shape shape = shape_for(limits_of(machine.axis[axis]), 1.0, 1.0, 1.0);
        std::vector<double> way;
        run_move(shape, 1e-3, [&](double w) { way.push_back(w); });
        for (const std::size_t ticks : {way.size(), way.size() / 2}) {
            SampleChecker checker(machine);
            trace::SampleRecord record;
            record.state = static_cast<std::uint8_t>(State::running);
            for (std::size_t i = 0; i < kAxisCount; ++i) {
                record.set_point[i] = std::llround(kStand[i] * kUnits[i]);
            }
            record.actual = record.set_point;
            for (std::size_t n = 0; n < ticks; ++n) {
                record.set_point[axis] = std::llround((kStand[axis] - way[n]) * kUnits[axis]);
                record.actual = record.set_point;
                checker.add(record, {});
                ++record.tick;
            }
            EXPECT_EQ(checker.report().limit_violations, 0U);
            checker.end();
            EXPECT_EQ(checker.report().limit_violations, ticks == way.size() ? 0U : 1U) << axis;
            if (ticks < way.size()) {
                EXPECT_EQ(checker.report().first.front().breach, Breach::not_at_rest);
                EXPECT_EQ(checker.report().first.front().tick, static_cast<std::int64_t>(ticks) - 1);
            }
        }
    }
}

TEST(SampleChecker, KeepsTheTickOfEachPeakAndTheFactorThatItIsGiven) {
    SampleChecker strict(reference_machine());
    SampleChecker lenient(reference_machine(), 1.02);
    const Shape shape = shape_for(limits_of(reference_machine().axis[0]), 0.9, 0.9, 1.01);
    trace::SampleRecord record;
    record.state = static_cast<std::uint8_t>(State::running);
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        record.set_point[i] = std::llround(kStand[i] * kUnits[i]);
    }
    const std::int64_t stand = record.set_point[0];
    run_move(shape, 1e-3, [&](double way) {
        record.set_point[0] = stand - std::llround(way * kUnits[0]);
        record.actual = record.set_point;
        strict.add(record, {});
        lenient.add(record, {});
        ++record.tick;
    });
    EXPECT_GT(strict.report().limit_violations, 0U);
    EXPECT_EQ(lenient.report().limit_violations, 0U);
    const std::array<std::int64_t, 3> tick = lenient.report().axis_peak[0].tick;
    EXPECT_LT(tick[2], tick[1]) << "jerk comes before acceleration";
    EXPECT_LT(tick[1], tick[0]) << "and acceleration before speed";
}

TEST(CheckSamples, RefusesAMissingFile) {
    EXPECT_THROW((void)check_samples("not/there.trace", reference_machine()), InputError);
}

}  // namespace
}  // namespace sc::host
