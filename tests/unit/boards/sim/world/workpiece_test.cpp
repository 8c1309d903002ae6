// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "boards/sim/world/world.hpp"
#include "shared/machine/machine.hpp"
#include "temporary_directory.hpp"

namespace sc::sim {
namespace {

const std::filesystem::path kRoot = SC_SOURCE_DIR;
const std::filesystem::path kFolder = kRoot / "boards/sim/world/default";
const std::filesystem::path kTable = kRoot / "examples/ras3dm/table1.csv";

struct Marker {
    int face = 0;
    Vec3 place;  ///< metres, h at C = -face
};

std::vector<Marker> true_markers() {
    std::ifstream stream(kTable);
    std::string line;
    std::getline(stream, line);
    std::vector<Marker> markers;
    while (std::getline(stream, line)) {
        std::vector<double> row;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) {
            row.push_back(std::stod(cell));
        }
        if (row.size() >= 8) {
            markers.push_back({static_cast<int>(row[0]), 1e-3 * Vec3{row[5], row[6], row[7]}});
        }
    }
    return markers;
}

const World& default_world() {
    static const World world(kFolder / "world.toml");
    return world;
}

/// The table's turn about its true axis without runout, wobble and pitch error: what the markers are defined by.
Rigid<frame::H, frame::T> pure_turn(double degrees) {
    const double angle = degrees * kPi / 180.0;
    return turned(default_world().axis(), std::sin(angle), std::cos(angle));
}

TEST(Workpiece, AllMarkersLieOnTheSurfaceWhereTheirFaceMeetsTheBeam) {
    const Bvh surface(default_world().mesh());
    const auto markers = true_markers();
    ASSERT_EQ(markers.size(), 36U);
    for (const Marker& m : markers) {
        const auto table_from_h = pure_turn(-m.face).inverse();
        const Ray ray{(table_from_h * Point<frame::H>{m.place + Vec3{0.0, 0.2, 0.0}}).v,
                      (table_from_h * Direction<frame::H>{{0.0, -1.0, 0.0}}).v};
        const auto hit = surface.hit(ray);
        ASSERT_TRUE(hit);
        EXPECT_LT(norm((pure_turn(-m.face) * Point<frame::T>{hit->point}).v - m.place), 1e-9);
    }
}

TEST(Workpiece, SurfaceIsSmoothRoundEachMarker) {
    for (const Marker& m : true_markers()) {
        const auto at = [&](double dx, double dz) {
            const auto hit = default_world().hit({m.place + Vec3{dx, 0.1, dz}, {0, -1, 0}}, -m.face);
            return hit ? hit->point.y : std::numeric_limits<double>::quiet_NaN();
        };
        for (const double r : {0.001, 0.003, 0.005}) {
            EXPECT_NEAR(at(r, 0) + at(-r, 0), 2.0 * at(0, 0), 1e-8);
            EXPECT_NEAR(at(0, r) + at(0, -r), 2.0 * at(0, 0), 1e-8);
        }
    }
}

TEST(Workpiece, MeshIsClosedAndOriented) {
    const Mesh& mesh = default_world().mesh();
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    double volume = 0.0;
    for (const auto& t : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            ++edges[{t[i], t[(i + 1) % 3]}];
        }
        volume += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]])) / 6.0;
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    // Some 0.4 m by 0.35 m by 0.23 m with cut corners.
    EXPECT_GT(volume, 0.02);
    EXPECT_LT(volume, 0.04);
}

TEST(Workpiece, SwingsFreeOfTheRetractedFocusAndStandsAboveTheTable) {
    const MachineConfig machine = reference_machine();
    const Vec3 axis = default_world().axis().point.v;
    for (const Vec3& v : default_world().mesh().vertices) {
        const double radius = std::hypot(v.x - axis.x, v.y - axis.y);
        EXPECT_LT(axis.y + radius, machine.y_retracted.si() - 0.02);
        EXPECT_GT(v.z, machine.keep_out[0].max.z);
    }
}

TEST(Workpiece, ScriptMakesTheCommittedMeshAgain) {
    const TemporaryDirectory dir;
    const std::filesystem::path made = dir.path() / "made.obj";
    const std::string command = "python3 '" + (kRoot / "boards/sim/world/make_workpiece.py").string() + "' --table '" +
                                kTable.string() + "' --out '" + made.string() + "' > /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const auto text = [](const std::filesystem::path& path) {
        std::ostringstream out;
        out << std::ifstream(path).rdbuf();
        return out.str();
    };
    EXPECT_EQ(text(made), text(kFolder / "workpiece.obj"));
}

}  // namespace
}  // namespace sc::sim
