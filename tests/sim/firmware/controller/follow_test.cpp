// SPDX-License-Identifier: Apache-2.0
// Mirrors that take up what the axes are off their path.
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "cell_rig.hpp"

namespace sc::test {
namespace {

struct Line {
    double off_z = 0.0;  ///< metres, rms of the pulses about their mean, on the workpiece
    double off_x = 0.0;
    std::string hash;
};

/// A line of 20 mm along x by the axes, in a world that pushes them.
Line burn(const char* world, FollowAxes follow) {
    CellRig::Options options;
    options.world = std::filesystem::path(SC_SOURCE_DIR) / "boards/sim/world/beam" / world;
    options.machine.galvo.follow = follow;
    options.machine.axis[index(Axis::x)].encoder_counts_per_unit = 1e7;
    options.machine.axis[index(Axis::z)].encoder_counts_per_unit = 1e7;
    options.machine.axis[index(Axis::c)].encoder_counts_per_unit = 4e4;
    CellRig rig(options);
    rig.make_ready();
    PathBegin begin;
    begin.speed_um_s = 20'000;
    begin.pitch_nm = 50'000;
    begin.energy_nj = 300'000;
    begin.tolerance_nm = 10'000;
    const auto point = [](double x_mm) {
        return PathPoint{static_cast<std::int32_t>(std::lround(x_mm * 1e5)), -21'000'000, -25'000'000};
    };
    EXPECT_EQ(rig.open_job({Turn{0}, begin, point(-235.0), point(-215.0), PathEnd{}, JobEnd{}}).refusal, 0);
    EXPECT_EQ(rig.command(link::Verb::start).refusal, 0);
    EXPECT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }, 60'000));
    EXPECT_EQ(rig.pulses().size(), 401U);
    Line line;
    line.hash = rig.command_hash();
    const auto count = static_cast<double>(rig.pulses().size());
    std::array<double, 2> mean{};
    std::array<double, 2> square{};
    for (const bool second : {false, true}) {
        for (std::size_t i = 0; i < rig.pulses().size(); ++i) {
            const auto& p = rig.pulses()[i].table_pm;
            const std::array<double, 2> off{static_cast<double>(p[0]) * 1e-12 - 50e-6 * static_cast<double>(i),
                                            static_cast<double>(p[2]) * 1e-12};
            for (std::size_t k = 0; k < 2; ++k) {
                if (second) {
                    square[k] += (off[k] - mean[k]) * (off[k] - mean[k]) / count;
                } else {
                    mean[k] += off[k] / count;
                }
            }
        }
    }
    line.off_x = std::sqrt(square[0]);
    line.off_z = std::sqrt(square[1]);
    return line;
}

TEST(FollowAxes, TheBeamStaysOnTheLineThatTheAxesLeaveAndTheJobIsTheSame) {
    const Line off = burn("pushed_axes.toml", FollowAxes::off);
    EXPECT_GT(off.off_z, 25e-6);
    EXPECT_GT(off.off_x, 25e-6);
    const Line drives = burn("pushed_axes.toml", FollowAxes::drives);
    EXPECT_LT(drives.off_z, 0.15 * off.off_z);
    EXPECT_LT(drives.off_x, 0.15 * off.off_x);
    const Line encoders = burn("pushed_axes.toml", FollowAxes::encoders);
    EXPECT_LT(encoders.off_z, 0.05 * off.off_z);
    EXPECT_LT(encoders.off_x, 0.05 * off.off_x);
    EXPECT_EQ(off.hash, drives.hash);
    EXPECT_EQ(off.hash, encoders.hash);
}

TEST(FollowAxes, ATableThatSwingsIsFollowedByTheSurfacesDistanceFromItsAxis) {
    const Line off = burn("pushed_table.toml", FollowAxes::off);
    EXPECT_GT(off.off_x, 25e-6);
    EXPECT_LT(burn("pushed_table.toml", FollowAxes::drives).off_x, 0.15 * off.off_x);
    EXPECT_LT(burn("pushed_table.toml", FollowAxes::encoders).off_x, 0.05 * off.off_x);
}

TEST(FollowAxes, AxesThatNothingPushesAreFollowedWithinTheDrivesGrid) {
    const Line off = burn("world.toml", FollowAxes::off);
    const Line drives = burn("world.toml", FollowAxes::drives);
    EXPECT_LT(drives.off_z, off.off_z + 1.0e-6);
    EXPECT_LT(drives.off_x, off.off_x + 1.0e-6);
}

}  // namespace
}  // namespace sc::test
