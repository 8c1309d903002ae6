// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh.hpp"

#include <cstring>
#include <set>

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

constexpr const char* kTetrahedron = R"(solid t
facet normal 0 0 0
 outer loop
  vertex 0 0 0
  vertex 0 1 0
  vertex 1 0 0
 endloop
endfacet
facet normal 0 0 0
 outer loop
  vertex 0 0 0
  vertex 1 0 0
  vertex 0 0 1
 endloop
endfacet
facet normal 0 0 0
 outer loop
  vertex 0 0 0
  vertex 0 0 1
  vertex -0.0 1 0
 endloop
endfacet
facet normal 0 0 0
 outer loop
  vertex 1 0 0
  vertex 0 1 0
  vertex 0 0 1
 endloop
endfacet
endsolid t
)";

double volume(const TriangleMesh& mesh) {
    double six = 0.0;
    for (const auto& t : mesh.triangles) {
        six += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]]));
    }
    return six / 6.0;
}

TEST(MeshFile, ReadsAnAsciiStlAndJoinsItsCorners) {
    const TempDir dir;
    const MeshFile file = read_mesh(dir.write("t.stl", kTetrahedron));
    EXPECT_EQ(file.mesh.vertices.size(), 4U);
    EXPECT_EQ(file.mesh.triangles.size(), 4U);
    EXPECT_EQ(file.dropped, 0U);
    EXPECT_NEAR(volume(file.mesh), 1e-9 / 6.0, 1e-18);  // 1 mm in metres
}

TEST(MeshFile, TakesTheUnitThatItIsTold) {
    const TempDir dir;
    const MeshFile file = read_mesh(dir.write("t.stl", kTetrahedron), *length_unit("in"));
    EXPECT_NEAR(volume(file.mesh), 0.0254 * 0.0254 * 0.0254 / 6.0, 1e-15);
}

TEST(MeshFile, BinaryStlComesBackAsItWasWritten) {
    const TempDir dir;
    const MeshFile ascii = read_mesh(dir.write("t.stl", kTetrahedron));
    write_stl(dir / "b.stl", ascii.mesh);
    const MeshFile binary = read_mesh(dir / "b.stl");
    EXPECT_EQ(binary.mesh.triangles, ascii.mesh.triangles);
    EXPECT_EQ(binary.mesh.vertices, ascii.mesh.vertices);
}

TEST(MeshFile, AnAsciiNameInABinaryHeaderDoesNotMislead) {
    const TempDir dir;
    write_stl(dir / "b.stl", read_mesh(dir.write("t.stl", kTetrahedron)).mesh);
    std::string bytes = test::slurp(dir / "b.stl");
    std::memcpy(bytes.data(), "solid x", 7);
    EXPECT_EQ(read_mesh(dir.write("c.stl", bytes)).mesh.triangles.size(), 4U);
}

TEST(MeshFile, ReadsPlyInAllThreeForms) {
    const TempDir dir;
    const auto header = [](const char* format) {
        return std::string("ply\nformat ") + format +
               " 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n"
               "element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n";
    };
    const std::string text = header("ascii") + "0 0 0\n1 0 0\n1 1 0.5\n0 1 0\n7 4 0 1 2 3\n7 3 0 3 1\n";
    const MeshFile ascii = read_mesh(dir.write("a.ply", text));
    EXPECT_EQ(ascii.mesh.triangles.size(), 3U) << "the square becomes two";
    EXPECT_DOUBLE_EQ(ascii.mesh.vertices[2].z, 0.5e-3);

    for (const bool big : {false, true}) {
        std::string bytes = header(big ? "binary_big_endian" : "binary_little_endian");
        const auto put = [&](const auto& value) {
            std::string raw(sizeof(value), '\0');
            std::memcpy(raw.data(), &value, sizeof(value));
            bytes.append(big ? std::string(raw.rbegin(), raw.rend()) : raw);
        };
        const double places[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}};
        for (const auto& p : places) {
            put(static_cast<float>(p[0]));
            put(static_cast<float>(p[1]));
            put(p[2]);
        }
        for (const std::vector<int>& face : {std::vector<int>{0, 1, 2, 3}, std::vector<int>{0, 3, 1}}) {
            put(static_cast<unsigned char>(7));
            put(static_cast<unsigned char>(face.size()));
            for (const int corner : face) {
                put(corner);
            }
        }
        const MeshFile binary = read_mesh(dir.write("b.ply", bytes));
        EXPECT_EQ(binary.mesh.vertices, ascii.mesh.vertices) << big;
        EXPECT_EQ(binary.mesh.triangles, ascii.mesh.triangles) << big;
        const auto cut = dir.write("c.ply", bytes.substr(0, bytes.size() - 3));
        EXPECT_THROW(static_cast<void>(read_mesh(cut)), InputError);
    }
}

TEST(MeshFile, ReadsObjWithItsKindsOfIndices) {
    const TempDir dir;
    const MeshFile file = read_mesh(
        dir.write("t.obj", "# x\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1/1/1 2//1 3\nf -4 -2 -1\n"));
    ASSERT_EQ(file.mesh.triangles.size(), 2U);
    EXPECT_EQ(file.mesh.vertices.size(), 4U);
}

TEST(MeshFile, DropsTrianglesThatAreNone) {
    const TempDir dir;
    const MeshFile file = read_mesh(dir.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 1 2 4\n"));
    EXPECT_EQ(file.read, 2U);
    EXPECT_EQ(file.dropped, 1U);
}

TEST(MeshFile, RefusesWithFileLineAndValue) {
    const TempDir dir;
    const auto bad_number = dir.write("a.stl", test::replaced(kTetrahedron, "vertex 0 1 0", "vertex 0 1,5 0"));
    expect_refusal([&] { static_cast<void>(read_mesh(bad_number)); },
                   {bad_number.string(), 5, "1,5", "y is not a finite number"});
    const auto nan = dir.write("n.stl", test::replaced(kTetrahedron, "vertex 0 1 0", "vertex 0 nan 0"));
    expect_refusal([&] { static_cast<void>(read_mesh(nan)); }, {nan.string(), 5, "nan", "not a finite number"});
    const auto torn = dir.write("t.stl", std::string(kTetrahedron).substr(0, 300));
    EXPECT_THROW(static_cast<void>(read_mesh(torn)), InputError);
    const auto index = dir.write("i.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n");
    expect_refusal([&] { static_cast<void>(read_mesh(index)); }, {index.string(), 3, "9", "not there"});
    const auto empty = dir.write("e.stl", "");
    expect_refusal([&] { static_cast<void>(read_mesh(empty)); }, {empty.string(), 0, "", "is empty"});
    const auto none = dir.write("none.stl", "solid x\nendsolid x\n");
    expect_refusal([&] { static_cast<void>(read_mesh(none)); },
                   {none.string(), 0, "0 triangles in the file", "no triangle with an area"});
    std::string wrong_count(84 + 50, '\0');
    wrong_count[80] = 3;
    const auto short_file = dir.write("s.stl", wrong_count);
    expect_refusal([&] { static_cast<void>(read_mesh(short_file)); },
                   {short_file.string(), 0, "3 triangles, 134 bytes", "at byte 80"});
    const auto cloud =
        dir.write("p.ply",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                  "end_header\n0 0 0\n");
    expect_refusal([&] { static_cast<void>(read_mesh(cloud)); }, {cloud.string(), 0, "1 vertices", "no triangles"});
    EXPECT_THROW(static_cast<void>(read_mesh(dir / "missing.stl")), InputError);
    EXPECT_THROW(static_cast<void>(read_mesh(dir.path())), InputError);
}

TEST(MeshFile, ReadsTheCasting) {
    const std::filesystem::path data = std::filesystem::path(SC_TEST_DATA) / "casting-blank";
    const MeshFile finished = read_mesh(data / "finished.stl");
    EXPECT_EQ(finished.mesh.triangles.size(), 6296U);
    EXPECT_GT(volume(finished.mesh), 0.0);
    EXPECT_EQ(read_mesh(data / "rough.stl").mesh.triangles.size(), 6152U);
}

}  // namespace
}  // namespace sc::host
