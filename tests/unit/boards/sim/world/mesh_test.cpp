// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/mesh.hpp"

#include <gtest/gtest.h>

#include "boards/sim/world/world_error.hpp"
#include "temporary_directory.hpp"

namespace sc::sim {
namespace {

TEST(Mesh, ReadsFacesInEveryFormOfObj) {
    const TemporaryDirectory dir;
    const auto file = dir.write("a.obj",
                                "# comment\n\nmtllib x.mtl\no thing\nv 0 0 0\nv 10 0 0 # at the end\r\nv 10 10 0\n"
                                "v 0 1e1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3\nf -4 -2 -1\nf 1 2 3 4\n");
    const Mesh mesh = read_obj(file, 1e-3);
    ASSERT_EQ(mesh.vertices.size(), 4U);
    EXPECT_DOUBLE_EQ(mesh.vertices[2].x, 0.01);
    const std::vector<std::array<std::uint32_t, 3>> expected{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}};
    EXPECT_EQ(mesh.triangles, expected);
}

TEST(Mesh, AppendShiftsIndices) {
    Mesh a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    append(a, a);
    ASSERT_EQ(a.triangles.size(), 2U);
    EXPECT_EQ(a.triangles[1], (std::array<std::uint32_t, 3>{3, 4, 5}));
}

struct BadObj {
    const char* text;
    std::size_t line;
    const char* value;
};
class MeshRefuses : public testing::TestWithParam<BadObj> {};

TEST_P(MeshRefuses, WithLineAndValue) {
    const TemporaryDirectory dir;
    try {
        (void)read_obj(dir.write("bad.obj", GetParam().text), 1.0);
        FAIL() << "was accepted";
    } catch (const WorldError& error) {
        EXPECT_EQ(error.detail().line, GetParam().line);
        EXPECT_EQ(error.detail().value, GetParam().value);
        EXPECT_FALSE(error.detail().action.empty());
    }
}
INSTANTIATE_TEST_SUITE_P(Files, MeshRefuses,
                         testing::Values(BadObj{"v 0 0\n", 1, "v"}, BadObj{"v 0 0 1,5\n", 1, "1,5"},
                                         BadObj{"v 0 nan 0\n", 1, "nan"}, BadObj{"v 0 0 0\nf 1 2 3\n", 2, "2"},
                                         BadObj{"v 0 0 0\nf 0 1 1\n", 2, "0"},
                                         BadObj{"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", 4, "f"},
                                         BadObj{"solid x\n", 1, "solid"}, BadObj{"v 0 0 0\n", 0, ""},
                                         BadObj{"v 0 0 0\nf 1 1\n", 2, "f"}));

TEST(Mesh, MissingFileIsNamed) {
    try {
        (void)read_obj("/nowhere/part.obj", 1.0);
        FAIL();
    } catch (const WorldError& error) {
        EXPECT_NE(std::string(error.what()).find("/nowhere/part.obj"), std::string::npos);
    }
}

}  // namespace
}  // namespace sc::sim
