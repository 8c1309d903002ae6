// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/world.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "boards/sim/world/world_error.hpp"
#include "temporary_directory.hpp"

namespace sc::sim {
namespace {

/// A wall at y = -300 mm (200 mm wide and high, 2 mm thick in no way: a sheet) round the axis at (-250, -470).
WorldSpec wall_world(const TemporaryDirectory& dir) {
    WorldSpec spec;
    spec.turntable.axis_point = {-0.250, -0.470, 0.0};
    spec.meshes = {{"wall",
                    dir.write("wall.obj",
                              "v -350 -300 -500\nv -150 -300 -500\nv -150 -300 -300\nv -350 -300 -300\n"
                              "f 1 3 2\nf 1 4 3\n"),
                    1e-3}};
    return spec;
}

TEST(World, StraightBeamMeetsTheWallUnderTheFocus) {
    const TemporaryDirectory dir;
    const World world(wall_world(dir));
    const auto spot = world.shine({-0.2, -0.299, -0.4}, 0.0, 0.0, 0.0);
    ASSERT_TRUE(spot);
    EXPECT_NEAR(spot->place.x, -0.2, 1e-12);
    EXPECT_NEAR(spot->place.y, -0.3, 1e-12);
    EXPECT_NEAR(spot->place.z, -0.4, 1e-12);
    EXPECT_NEAR(spot->defocus, 0.001, 1e-12);
    EXPECT_LT(norm(spot->normal - Vec3{0, 1, 0}), 1e-12);
    EXPECT_LT(norm(spot->table_place - spot->place), 1e-12);
}

TEST(World, DefocusMovesADeflectedBeamByItsLean) {
    const TemporaryDirectory dir;
    const World world(wall_world(dir));
    // Focus 1 mm before the wall, deflection 8 mm: leans by 0.05, so it lands 50 um further out.
    const auto spot = world.shine({-0.25, -0.299, -0.4}, 0.008, 0.0, 0.0);
    ASSERT_TRUE(spot);
    EXPECT_NEAR(spot->place.x, -0.25 + 0.008 + 50e-6, 1e-12);
    EXPECT_NEAR(spot->defocus, 0.001, 1e-12);
    // Focus 1 mm behind the surface: 50 um further in, and the defocus is negative.
    const auto behind = world.shine({-0.25, -0.301, -0.4}, 0.008, 0.0, 0.0);
    ASSERT_TRUE(behind);
    EXPECT_NEAR(behind->place.x, -0.25 + 0.008 - 50e-6, 1e-12);
    EXPECT_NEAR(behind->defocus, -0.001, 1e-12);
}

TEST(World, WallTurnsWithTheTable) {
    const TemporaryDirectory dir;
    const World world(wall_world(dir));
    // 170 mm before the axis: a quarter turn takes the wall away, a half turn to behind the axis (y = -640 mm).
    EXPECT_FALSE(world.shine({-0.2, -0.3, -0.4}, 0.0, 0.0, 90.0));
    const auto half = world.shine({-0.2, -0.5, -0.4}, 0.0, 0.0, 180.0);
    ASSERT_TRUE(half);
    EXPECT_NEAR(half->place.y, -0.640, 1e-12);
    EXPECT_NEAR(half->table_place.x, -0.300, 1e-12);
    EXPECT_NEAR(half->table_place.y, -0.300, 1e-12);
    EXPECT_NEAR(half->normal.y, -1.0, 1e-12);
}

TEST(World, MissesBesideTheWall) {
    const TemporaryDirectory dir;
    const World world(wall_world(dir));
    EXPECT_FALSE(world.shine({-0.149, -0.3, -0.4}, 0.0, 0.0, 0.0));
}

TEST(World, HitAndShineAgree) {
    const World world(std::filesystem::path(SC_SOURCE_DIR) / "boards/sim/world/default/world.toml");
    const Vec3 reading{-0.25, -0.318, -0.39};
    const auto spot = world.shine(reading, 0.002, -0.003, 0.123);
    ASSERT_TRUE(spot);
    const Beam beam = true_beam(world.spec().galvo, true_focus(world.spec().axes, reading), 0.002, -0.003);
    const auto hit = world.hit({beam.focus - 0.1 * beam.direction, beam.direction}, 0.123);
    ASSERT_TRUE(hit);
    EXPECT_LT(norm(hit->point - spot->place), 1e-12);
    EXPECT_LT(norm((world.h_from_t(0.123) * Point<frame::T>{spot->table_place}).v - spot->place), 1e-12);
}

TEST(World, ListsItsErrorsInFileUnits) {
    const World world(std::filesystem::path(SC_SOURCE_DIR) / "boards/sim/world/default/world.toml");
    const auto errors = world.errors();
    const auto find = [&](const std::string& name) {
        const auto found = std::ranges::find(errors, name, &KnownError::name);
        return found == errors.end() ? KnownError{} : *found;
    };
    const KnownError galvo = find("galvo.offset_x");
    EXPECT_NEAR(galvo.value, 35.0, 1e-9);
    EXPECT_EQ(galvo.unit, "um");
    EXPECT_EQ(galvo.compensated_by, "calibration: galvo field");
    EXPECT_NEAR(find("axes.squareness_xz").value, -0.080, 1e-12);
    EXPECT_EQ(find("axes.squareness_xz").compensated_by, "calibration: axes");
    EXPECT_EQ(find("turntable.axis_y").compensated_by, "calibration: turntable axis");
    EXPECT_EQ(find("turntable.runout").compensated_by, "calibration: axis map");
    EXPECT_EQ(find("galvo.beam_tilt_x").compensated_by, "calibration: galvo field");
    EXPECT_NEAR(find("axes.periodic.z_of_x").value, 0.9, 1e-9);
}

TEST(World, LyingTableAxisIsRefused) {
    const TemporaryDirectory dir;
    const auto file = dir.write("world.toml", "base = \"" + std::string(SC_SOURCE_DIR) +
                                                  "/boards/sim/world/default/world.toml\"\n[turntable]\n"
                                                  "direction_x = 1.0\n");
    EXPECT_THROW(World{file}, WorldError);
}

}  // namespace
}  // namespace sc::sim
