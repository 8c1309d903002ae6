// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "boards/sim/world/world_error.hpp"
#include "boards/sim/world/world_spec.hpp"
#include "temporary_directory.hpp"

namespace sc::sim {
namespace {

const std::string kDefault = std::string(SC_SOURCE_DIR) + "/boards/sim/world/default/world.toml";

std::string with_base(const std::string& rest) { return "base = \"" + kDefault + "\"\n" + rest; }

std::string default_text() {
    std::ostringstream text;
    text << std::ifstream(kDefault).rdbuf();
    return text.str();
}

TEST(WorldFile, DefaultWorldHoldsTheStatedErrorsInSiUnits) {
    const WorldSpec spec = read_world_spec(kDefault);
    EXPECT_DOUBLE_EQ(spec.axes.squareness_xy, 0.120e-3);
    EXPECT_DOUBLE_EQ(spec.axes.squareness_xz, -0.080e-3);
    EXPECT_DOUBLE_EQ(spec.axes.squareness_yz, 0.150e-3);
    EXPECT_DOUBLE_EQ(spec.axes.scale[1], -8e-6);
    EXPECT_DOUBLE_EQ(spec.turntable.axis_point.y, -0.470027);
    EXPECT_DOUBLE_EQ(spec.turntable.direction.x, 0.00004);
    EXPECT_DOUBLE_EQ(spec.galvo.offset_x, 35e-6);
    EXPECT_DOUBLE_EQ(spec.galvo.gain_z, 0.998);
    EXPECT_DOUBLE_EQ(spec.galvo.tracking, 160e-6);
    EXPECT_EQ(spec.inputs, (DigitalInputs{true, true, true, true, false, false, false, true}));
    ASSERT_EQ(spec.meshes.size(), 1U);
    EXPECT_TRUE(std::filesystem::exists(spec.meshes[0].path));
}

TEST(WorldFile, NoErrorOfTheDefaultWorldIsZero) {
    WorldSpec spec = read_world_spec(kDefault);
    for (const NumberKey& key : number_keys()) {
        if (!key.name.empty() && key.path != "turntable.axis_z_mm") {
            EXPECT_NE(key.field(spec), 0.0) << key.path;
        }
    }
}

TEST(WorldFile, OverridesSingleKeysOfItsBase) {
    const TemporaryDirectory dir;
    const auto file = dir.write("bad_galvo.toml", with_base("[galvo]\noffset_x_um = 85\n[axes.periodic]\n"
                                                            "x_of_y.amplitude_um = 5.0\n[inputs]\nestop_closed = "
                                                            "false\n"));
    const WorldSpec spec = read_world_spec(file);
    EXPECT_DOUBLE_EQ(spec.galvo.offset_x, 85e-6);
    EXPECT_DOUBLE_EQ(spec.galvo.offset_z, -22e-6);
    EXPECT_DOUBLE_EQ(spec.axes.periodic[0][1].amplitude, 5e-6);
    EXPECT_DOUBLE_EQ(spec.axes.periodic[0][1].period, 0.310);
    EXPECT_FALSE(spec.inputs.estop_closed);
    EXPECT_TRUE(spec.inputs.interlock_closed);
    EXPECT_EQ(spec.meshes.size(), 1U);
}

TEST(WorldFile, BasesNestAndPathsAreRelativeToTheirFile) {
    const TemporaryDirectory dir;
    std::filesystem::create_directory(dir.path() / "sub");
    dir.write("middle.toml", with_base("[[mesh]]\nfile = \"m.obj\"\nunit = \"inch\"\n[galvo]\ngain_x = 1.01\n"));
    const auto file = dir.write("sub/top.toml", "base = \"../middle.toml\"\n[galvo]\ngain_z = 1.02\n");
    const WorldSpec spec = read_world_spec(file);
    EXPECT_DOUBLE_EQ(spec.galvo.gain_x, 1.01);
    EXPECT_DOUBLE_EQ(spec.galvo.gain_z, 1.02);
    ASSERT_EQ(spec.meshes.size(), 1U);
    EXPECT_TRUE(spec.meshes[0].path.lexically_normal() == dir.path() / "m.obj") << spec.meshes[0].path;
    EXPECT_DOUBLE_EQ(spec.meshes[0].unit, 0.0254);
}

TEST(WorldFile, EveryKeyIsRequiredWithoutABase) {
    const TemporaryDirectory dir;
    for (const char* key : {"skew_mrad", "squareness_xz_mrad", "laser_ready", "power_time_constant_us"}) {
        std::istringstream lines(default_text());
        std::string text;
        for (std::string line; std::getline(lines, line);) {
            text += line.starts_with(key) ? "" : line + "\n";
        }
        try {
            (void)read_world_spec(dir.write("short.toml", text));
            ADD_FAILURE() << "accepted without " << key;
        } catch (const WorldError& error) {
            EXPECT_NE(error.detail().value.find(key), std::string::npos) << error.what();
        }
    }
}

struct BadWorld {
    const char* text;  ///< after the line that names the base
    std::size_t line;
    const char* value;
};
class WorldFileRefuses : public testing::TestWithParam<BadWorld> {};

TEST_P(WorldFileRefuses, WithFileLineAndValue) {
    const TemporaryDirectory dir;
    const auto file = dir.write("bad.toml", with_base(GetParam().text));
    try {
        (void)read_world_spec(file);
        FAIL() << "was accepted";
    } catch (const WorldError& error) {
        EXPECT_EQ(error.detail().file, file.string());
        EXPECT_EQ(error.detail().line, GetParam().line);
        EXPECT_EQ(error.detail().value, GetParam().value);
        EXPECT_FALSE(error.detail().action.empty());
    }
}
INSTANTIATE_TEST_SUITE_P(
    Files, WorldFileRefuses,
    testing::Values(BadWorld{"[galvo]\noffset_x_mm = 1\n", 3, "galvo.offset_x_mm"},
                    BadWorld{"\nlaser = 3\n", 3, "laser"}, BadWorld{"[nonsense]\na = 1\n", 3, "nonsense.a"},
                    BadWorld{"[galvo]\n\ngain_x = \"1.0\"\n", 4, "galvo.gain_x"},
                    BadWorld{"[galvo]\ngain_x = nan\n", 3, "galvo.gain_x"},
                    BadWorld{"[galvo]\ngain_x = 7.0\n", 3, "galvo.gain_x = 7"},
                    BadWorld{"[axes]\nsquareness_xy_mrad = 1,5\n", 3, ""},
                    BadWorld{"[inputs]\nestop_closed = 1\n", 3, "inputs.estop_closed"},
                    BadWorld{"version = 2\n", 2, "version"}, BadWorld{"mesh = 1\n", 2, "mesh"},
                    BadWorld{"[[mesh]]\nfile = \"a.obj\"\nunit = \"feet\"\n", 4, "feet"},
                    BadWorld{"[[mesh]]\nfile = \"a.obj\"\nunit = \"mm\"\ncolour = 1\n", 5, "mesh.colour"},
                    BadWorld{"[[mesh]]\nunit = \"mm\"\n", 2, "mesh"}));

TEST(WorldFile, MissingFileAndCircleOfBasesAreRefused) {
    const TemporaryDirectory dir;
    EXPECT_THROW((void)read_world_spec(dir.path() / "none.toml"), WorldError);
    const auto loop = dir.write("loop.toml", "base = \"loop.toml\"\n");
    EXPECT_THROW((void)read_world_spec(loop), WorldError);
}

}  // namespace
}  // namespace sc::sim
