// SPDX-License-Identifier: Apache-2.0
// Paths of stage and mirrors together, at the controller's outputs.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "cell_rig.hpp"

namespace sc::test {
namespace {

constexpr double kSpeed = 1.0;     // m/s
constexpr double kPitchMm = 0.05;  // 20 kHz
constexpr double kSpacingMm = 50.0;
constexpr double kY = -319.0;
constexpr double kZ = -390.0;

std::int32_t wire(double mm) { return static_cast<std::int32_t>(std::lround(mm * 1e5)); }

/// Lines along z, 3 mm apart in x, passed to and fro with dark turns between; the stage goes along in x evenly.
struct Comb {
    int lines = 40;
    double half = 20.0;         ///< mm, of a line
    double first_x = -330.0;    ///< mm
    double stage_ahead = 0.0;   ///< mm
    double stage_share = -1.0;  ///< of path distance; what the lines need by default
    double spacing = kSpacingMm;
    int knots_short = 0;
    bool dark = true;
    Actuator actuator = Actuator::split;

    [[nodiscard]] double turn() const { return 2.0; }  // mm of run-out and run-in
    /// Path length of a line and the turn behind it.
    [[nodiscard]] double cycle() const { return 2.0 * half + 2.0 * turn() + 3.0; }
    [[nodiscard]] std::vector<Item> items() const {
        std::vector<Item> items{Turn{0}};
        PathBegin begin;
        begin.actuator = actuator;
        begin.speed_um_s = static_cast<std::uint32_t>(kSpeed * 1e6);
        begin.pitch_nm = static_cast<std::uint32_t>(kPitchMm * 1e6);
        begin.energy_nj = 300'000;
        begin.tolerance_nm = 50;
        items.emplace_back(begin);
        items.emplace_back(StageCurve{static_cast<std::uint32_t>(spacing * 1e3)});
        const double share = stage_share >= 0.0 ? stage_share : 3.0 / cycle();
        int knots = 0;
        double length = 0.0;
        const auto knots_to = [&](double distance) {
            for (; knots < static_cast<int>((distance + 2.0) / spacing + 0.5) + 4 - knots_short; ++knots) {
                const double s = (knots - 1) * spacing;
                items.emplace_back(StageKnot{wire(first_x + stage_ahead + share * s), wire(kY), wire(kZ)});
            }
        };
        const auto point = [&](double x, double z, double step) {
            length += step;
            knots_to(length);
            items.emplace_back(PathPoint{wire(x), wire(kY), wire(kZ + z)});
        };
        for (int i = 0; i < lines; ++i) {
            const double way = i % 2 == 0 ? 1.0 : -1.0;
            const double x = first_x + 3.0 * i;
            if (i > 0) {
                point(x, -way * (half + turn()), 3.0);
                point(x, -way * half, turn());
                if (dark) {
                    items.emplace_back(PathLight{true});
                }
            } else {
                point(x, -half, 0.0);
            }
            point(x, way * half, 2.0 * half);
            if (i + 1 < lines) {
                if (dark) {
                    items.emplace_back(PathLight{false});
                }
                point(x, way * (half + turn()), turn());
            }
        }
        knots_to(length + 2.0);
        items.emplace_back(PathEnd{});
        items.emplace_back(JobEnd{});
        return items;
    }
};

CellRig::Options options_with_rate() {
    CellRig::Options options;
    options.machine.laser.prr_nominal = Frequency::from_si(40e3);
    return options;
}

/// A run of a job, with the greatest differences of what left the controller.
struct JudgedRun {
    CellRig rig{options_with_rate()};
    std::array<double, 3> stage_peak{};   ///< m/s, m/s², m/s³ over X, Y, Z
    std::array<double, 3> mirror_peak{};  ///< … of the mirrors
    double reach = 0.0;                   ///< m
    std::size_t first_point = 0;
    std::vector<std::array<std::int64_t, 2>> frames;

    void start(const std::vector<Item>& items) {
        rig.make_ready();
        first_point = rig.set_points().size();
        rig.watch([this] { take(); });
        ASSERT_EQ(rig.open_job(items).refusal, 0);
        ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    }
    [[nodiscard]] bool until(const std::function<bool()>& predicate, int limit = 60'000) {
        return rig.until(predicate, limit);
    }
    [[nodiscard]] bool finish() {
        return until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; });
    }
    void take() {
        for (const GalvoFrame& frame : rig.cell().latest().galvo) {
            frames.push_back({frame.x_pm, frame.z_pm});
            const std::size_t n = frames.size();
            for (std::size_t k = 0; k < 2 && n > 3; ++k) {
                const auto at = [&](std::size_t back) { return static_cast<double>(frames[n - 1 - back][k]) * 1e-12; };
                reach = std::max(reach, std::abs(at(0)));
                differences(at, 1e-5, mirror_peak);
            }
        }
        const auto& points = rig.set_points();
        if (points.size() < first_point + 4) {
            return;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const auto at = [&](std::size_t back) {
                return static_cast<double>(points[points.size() - 1 - back][k]) * 1e-12;
            };
            differences(at, 1e-3, stage_peak);
        }
    }
    template <class At>
    static void differences(const At& at, double dt, std::array<double, 3>& peak) {
        peak[0] = std::max(peak[0], std::abs(at(0) - at(1)) / dt);
        peak[1] = std::max(peak[1], std::abs(at(0) - 2.0 * at(1) + at(2)) / (dt * dt));
        peak[2] = std::max(peak[2], std::abs(at(0) - 3.0 * at(1) + 3.0 * at(2) - at(3)) / (dt * dt * dt));
    }
    void expect_limits_kept() const {
        const MachineConfig machine = reference_machine();
        EXPECT_LE(stage_peak[0], 1.001 * machine.axis[0].speed);
        EXPECT_LE(stage_peak[1], 1.001 * machine.axis[0].acceleration);
        EXPECT_LE(stage_peak[2], 1.001 * machine.axis[0].jerk);
        EXPECT_LE(mirror_peak[0], 1.001 * machine.galvo.speed.si());
        EXPECT_LE(mirror_peak[1], 1.001 * machine.galvo.acceleration.si());
        EXPECT_LE(mirror_peak[2], 1.001 * machine.galvo.jerk.si() + 8e3);
        EXPECT_LE(reach, machine.galvo.half_field.si());
    }
};

std::size_t pulses_of(const Comb& comb) {
    return static_cast<std::size_t>(comb.lines) *
           (static_cast<std::size_t>(std::lround(2.0 * comb.half / kPitchMm)) + 1);
}

void expect_pulses_on_lines(const Comb& comb, const std::vector<PathPulse>& pulses) {
    ASSERT_EQ(pulses.size(), pulses_of(comb));
    const std::size_t a_line = pulses.size() / static_cast<std::size_t>(comb.lines);
    double worst = 0.0;
    for (std::size_t i = 0; i < pulses.size(); ++i) {
        ASSERT_EQ(pulses[i].number, i);
        const auto line = static_cast<double>(i / a_line);
        const double way = (i / a_line) % 2 == 0 ? 1.0 : -1.0;
        const double along = kPitchMm * static_cast<double>(i % a_line) - comb.half;
        const std::array<double, 3> due{comb.first_x + 3.0 * line, kY, kZ + way * along};
        for (std::size_t k = 0; k < 3; ++k) {
            worst = std::max(worst, std::abs(static_cast<double>(pulses[i].place_pm[k]) * 1e-9 - due[k]));
        }
    }
    EXPECT_LT(worst, 1e-5) << "mm: each line's pulses begin at its first point, whatever the turn before was cut by";
}

TEST(Split, MarksWithStageAndMirrorsTogetherWithinTheirLimits) {
    const Comb comb;
    JudgedRun run;
    run.start(comb.items());
    ASSERT_TRUE(run.finish()) << "refused: " << (run.rig.refused() ? run.rig.refused()->refusal : 0);
    expect_pulses_on_lines(comb, run.rig.path_pulses());
    run.expect_limits_kept();
    // The comb is 117 mm wide, the field 110 mm: the mirrors alone would not reach, and the stage has gone along.
    const auto& points = run.rig.set_points();
    const auto x = [](const AxisPositions& p) { return static_cast<double>(p[0]) * 1e-9; };
    EXPECT_NEAR(x(points.back()), comb.first_x + 117.0, 3.0);
    EXPECT_GT(run.stage_peak[0], 0.05) << "while it marks";
    EXPECT_LT(run.reach, 0.030);
}

/// Frames less the path's place, plus the stage where it will be: nothing but the lead of the mirrors.
TEST(Split, FramesAndStageTogetherAreThePath) {
    Comb comb;
    comb.lines = 6;
    CellRig::Options options = options_with_rate();
    options.machine.galvo.natural_frequency = {};
    for (const std::int64_t latency_ns : {4'000'000, 4'130'000, 6'600'000}) {
        // Whatever part of a tick the stage is late by.
        for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
            options.machine.axis[index(axis)].latency_ns = latency_ns;
        }
        CellRig rig(options);
        rig.make_ready();
        ASSERT_EQ(rig.open_job(comb.items()).refusal, 0);
        ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
        std::vector<std::array<double, 2>> frames;  // mm; 100 a tick from the first tick kept
        std::vector<double> stage;                  // mm, a tick
        std::vector<PathPulse> pulses;
        std::vector<std::int64_t> first_frame;  // of the tick a pulse was commanded in
        ASSERT_TRUE(rig.until([&] {
            const ServoOutputs& out = rig.cell().latest();
            for (const GalvoFrame& frame : out.galvo) {
                frames.push_back({static_cast<double>(frame.x_pm) * 1e-9, static_cast<double>(frame.z_pm) * 1e-9});
            }
            stage.push_back(static_cast<double>(out.set_point[0]) * 1e-9);
            for (std::size_t i = 0; i < out.pulses_size; ++i) {
                pulses.push_back(out.pulses[i]);
                first_frame.push_back(static_cast<std::int64_t>(frames.size()) - 100);
            }
            return (rig.status().flags & link::kFlagJobDone) != 0;
        }));
        ASSERT_GT(pulses.size(), 1000U);
        // A pulse at path time t is commanded in the tick whose frames begin at t + what the light lags, rounded down.
        const double lag =
            1e-9 * static_cast<double>(options.machine.galvo.latency_ns - options.machine.laser.latency_ns);
        const double late = 1e-6 * static_cast<double>(latency_ns - options.machine.galvo.latency_ns);  // ticks
        double worst = 0.0;
        const double t0 = 1e-9 * static_cast<double>(pulses.front().t_ns);
        const double tick0 = std::floor((t0 + lag) * 1e3);
        const double begin = static_cast<double>(first_frame.front()) - 100.0 * tick0;  // frame at path time 0
        for (const PathPulse& pulse : pulses) {
            const double t = 1e-9 * static_cast<double>(pulse.t_ns);
            const double frame = begin + t * 1e5;
            const auto f = static_cast<std::size_t>(frame);
            const double part = frame - static_cast<double>(f);
            const double share = frames[f][0] + part * (frames[f + 1][0] - frames[f][0]);
            const double tick = frame / 100.0 - late;
            const auto n = static_cast<std::size_t>(tick);
            const double x = tick - static_cast<double>(n);
            const auto& s = stage;
            const double at = s[n] + 0.5 * x *
                                         (s[n + 1] - s[n - 1] +
                                          x * (2.0 * s[n - 1] - 5.0 * s[n] + 4.0 * s[n + 1] - s[n + 2] +
                                               x * (3.0 * (s[n] - s[n + 1]) + s[n + 2] - s[n - 1])));
            worst = std::max(worst, std::abs(share + at - static_cast<double>(pulse.place_pm[0]) * 1e-9));
        }
        EXPECT_LT(worst, 2e-5) << "mm, latency " << latency_ns;
    }
}

TEST(Split, HoldAndResumeLoseAndRepeatNoPulse) {
    const Comb comb;
    JudgedRun run;
    run.start(comb.items());
    for (const std::size_t at : {500U, 7'000U, 7'900U, 20'123U, 31'000U}) {
        ASSERT_TRUE(run.until([&] { return run.rig.path_pulses().size() >= at; })) << at;
        ASSERT_EQ(run.rig.command(link::Verb::hold).refusal, 0);
        ASSERT_TRUE(run.until([&] { return run.rig.state() == State::held; }, 2000));
        const auto stood = run.rig.set_points().back();
        const std::size_t pulses = run.rig.path_pulses().size();
        run.rig.ticks(50);
        EXPECT_EQ(run.rig.set_points().back(), stood) << "held is at rest";
        EXPECT_EQ(run.rig.path_pulses().size(), pulses);
        ASSERT_EQ(run.rig.command(link::Verb::resume).refusal, 0);
    }
    ASSERT_TRUE(run.finish());
    expect_pulses_on_lines(comb, run.rig.path_pulses());
    run.expect_limits_kept();
}

TEST(Split, TheSameCommandsWhateverTheOverrideHoldsAndBlocksAreAndNoneAboveWhatThePathWasPlannedFor) {
    const Comb comb{.lines = 12};
    std::vector<std::string> places;
    std::vector<std::int64_t> ticks;
    for (const std::int32_t percent : {100, 40, 200}) {
        JudgedRun run;
        ASSERT_NO_FATAL_FAILURE(run.start(comb.items()));
        ASSERT_EQ(run.rig.command(link::Verb::set_override, percent).refusal, 0);
        ASSERT_TRUE(run.finish()) << percent;
        expect_pulses_on_lines(comb, run.rig.path_pulses());
        run.expect_limits_kept();
        ticks.push_back(run.rig.path_pulses().back().t_ns - run.rig.path_pulses().front().t_ns);
    }
    EXPECT_NEAR(static_cast<double>(ticks[1]) / static_cast<double>(ticks[0]), 2.5, 0.3);
    EXPECT_NEAR(static_cast<double>(ticks[2]) / static_cast<double>(ticks[0]), 1.0, 0.02);
}

TEST(Split, TheCommandsDependOnThePathAloneNotOnHowItCame) {
    const Comb comb{.lines = 12};
    std::vector<std::string> hashes;
    for (const std::size_t items : {std::size_t{255}, std::size_t{1}, std::size_t{7}}) {
        CellRig::Options options = options_with_rate();
        options.items_per_block = items;
        CellRig rig(options);
        rig.make_ready();
        ASSERT_EQ(rig.open_job(comb.items()).refusal, 0);
        ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
        ASSERT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }, 60'000));
        EXPECT_EQ(rig.path_pulses().size(), pulses_of(comb));
        hashes.push_back(rig.command_hash());
    }
    EXPECT_EQ(hashes[1], hashes[0]);
    EXPECT_EQ(hashes[2], hashes[0]);
}

TEST(Split, GoesOnAfterStarvation) {
    const Comb comb;
    JudgedRun run;
    run.rig.limit_items(60);
    run.start(comb.items());
    ASSERT_TRUE(run.until([&] { return run.rig.status().starvations > 0; }));
    run.rig.ticks(300);
    EXPECT_LT(run.rig.path_pulses().size(), pulses_of(comb));
    run.rig.limit_items(0xFFFFFFFF);
    ASSERT_TRUE(run.finish());
    expect_pulses_on_lines(comb, run.rig.path_pulses());
    run.expect_limits_kept();
}

Refusal refusal_of(const std::vector<Item>& items) {
    CellRig rig(options_with_rate());
    rig.make_ready();
    EXPECT_EQ(rig.open_job(items).refusal, 0);
    EXPECT_EQ(rig.command(link::Verb::start).refusal, 0);
    EXPECT_TRUE(
        rig.until([&] { return rig.refused().has_value() || (rig.status().flags & link::kFlagJobDone) != 0; }, 60'000));
    return rig.refused() ? static_cast<Refusal>(rig.refused()->refusal) : Refusal::none;
}

Refusal refusal_of(const Comb& comb) { return refusal_of(comb.items()); }

TEST(Split, RefusesAStageCurveThatIsNone) {
    EXPECT_EQ(refusal_of(Comb{.lines = 4, .spacing = 0.5}), Refusal::bad_stage_curve) << "knots too close";
    EXPECT_EQ(refusal_of(Comb{.lines = 4, .spacing = 10.0}), Refusal::bad_stage_curve)
        << "a line over more than two knots";
    EXPECT_EQ(refusal_of(Comb{.lines = 4, .knots_short = 2}), Refusal::bad_stage_curve) << "the curve ends too early";
    EXPECT_EQ(refusal_of(Comb{.lines = 4, .actuator = Actuator::galvo}), Refusal::item_out_of_order);
}

TEST(Split, RefusesAStageThatIsTooFastForItsShare) {
    EXPECT_EQ(refusal_of(Comb{.stage_share = 0.105}), Refusal::stage_too_fast) << "0.105 m/s, more than half of 0.2";
    std::vector<Item> bent = Comb{.lines = 20}.items();
    std::vector<StageKnot*> knots;
    for (Item& item : bent) {
        if (auto* knot = std::get_if<StageKnot>(&item)) {
            knots.push_back(knot);
        }
    }
    ASSERT_EQ(refusal_of(bent), Refusal::none);
    knots[10]->z += wire(4.0);  // 8 mm of second difference over 50 mm at 1 m/s: 3.2 m/s²
    EXPECT_EQ(refusal_of(bent), Refusal::stage_too_fast);
}

TEST(Split, LightEndsAndBeginsInTurnsAndIsOnAtTheEnd) {
    const std::vector<Item> items = Comb{.lines = 3}.items();
    const auto light = [](const Item& item) { return std::holds_alternative<PathLight>(item); };
    std::vector<Item> without = items;
    without.erase(std::ranges::find_if(without, light));
    EXPECT_EQ(refusal_of(without), Refusal::item_out_of_order) << "on while it is on";
    std::vector<Item> ends_dark = items;
    ends_dark.insert(ends_dark.end() - 2, PathLight{false});
    EXPECT_EQ(refusal_of(ends_dark), Refusal::item_out_of_order);
}

TEST(Split, AGalvoPathCanBeDarkBetweenItsPointsToo) {
    std::vector<Item> items;
    PathBegin begin;
    for (const Item& item : Comb{.lines = 10}.items()) {
        if (const auto* was = std::get_if<PathBegin>(&item)) {
            begin = *was;
            begin.actuator = Actuator::galvo;
            begin.anchor_x = wire(-315.0);
            begin.anchor_y = wire(kY);
            begin.anchor_z = wire(kZ);
            items.emplace_back(begin);
        } else if (!std::holds_alternative<StageCurve>(item) && !std::holds_alternative<StageKnot>(item)) {
            items.push_back(item);
        }
    }
    JudgedRun run;
    run.start(items);
    ASSERT_TRUE(run.finish());
    expect_pulses_on_lines({.lines = 10}, run.rig.path_pulses());
}

TEST(Split, RefusesWhatTheMirrorsCannotReachFromTheStage) {
    EXPECT_EQ(refusal_of(Comb{.lines = 4, .stage_ahead = 80.0}), Refusal::galvo_out_of_field);
    EXPECT_EQ(refusal_of(Comb{.lines = 40, .stage_share = 0.0}), Refusal::galvo_out_of_field);
}

}  // namespace
}  // namespace sc::test
