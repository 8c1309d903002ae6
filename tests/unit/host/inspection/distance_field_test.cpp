// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/distance_field.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "host/inspection/space_order.hpp"
#include "tests/bench/allowance_workload.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host {
namespace {

using test::box_mesh;

constexpr double kExact = 1e-12;  // metres: 1e-9 mm

/// In closed form.
double to_box(const Vec3& p, const Vec3& low, const Vec3& high) {
    const Vec3 q{std::max(low.x - p.x, p.x - high.x), std::max(low.y - p.y, p.y - high.y),
                 std::max(low.z - p.z, p.z - high.z)};
    const double inside = std::min(std::max({q.x, q.y, q.z}), 0.0);
    return inside + norm(Vec3{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)});
}

std::vector<Vec3> places_in(const Vec3& low, const Vec3& high, std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < count; ++i) {
        out.push_back({low.x + share(random) * (high.x - low.x), low.y + share(random) * (high.y - low.y),
                       low.z + share(random) * (high.z - low.z)});
    }
    return out;
}

std::vector<Simd> kinds() {
    std::vector<Simd> out;
    for (const Simd simd : {Simd::baseline, Simd::avx2, Simd::avx512}) {
        if (available(simd)) {
            out.push_back(simd);
        }
    }
    return out;
}

void expect_as_brute(const TriangleMesh& mesh, const std::vector<Vec3>& places, const char* what) {
    const DistanceField field(mesh);
    const std::vector<double> brute = test::brute_distances(mesh, places);
    for (const Simd simd : kinds()) {
        std::vector<Distance> out(places.size());
        field.measure(places, out, {.simd = simd});
        double worst = 0.0;
        for (std::size_t i = 0; i < places.size(); ++i) {
            worst = std::max(worst, std::abs(std::abs(out[i].value) - brute[i]));
        }
        EXPECT_LE(worst, kExact) << what << ", " << name_of(simd);
    }
}

TEST(DistanceField, IsThatOfABoxWithItsSign) {
    const Vec3 low{0.1, -0.2, 0.3};
    const Vec3 high{0.2, -0.1, 0.301};  // a thin wall: 1 mm
    const DistanceField field(box_mesh(low, high));
    ASSERT_TRUE(field.topology().closed());
    const auto places = places_in(low - Vec3{0.05, 0.05, 0.002}, high + Vec3{0.05, 0.05, 0.002}, 20000, 1);
    std::vector<Distance> out(places.size());
    field.measure(places, out);
    for (std::size_t i = 0; i < places.size(); ++i) {
        ASSERT_NEAR(out[i].value, to_box(places[i], low, high), kExact) << i;
    }
}

TEST(DistanceField, IsExactOnTheNeedlesOfARealPart) {
    const TriangleMesh mesh = read_mesh(test::casting("finished.stl")).mesh;
    expect_as_brute(mesh, test::places_off(mesh, 4000, -4e-3, 4e-3, 2e-5, 2), "off the surface");
    expect_as_brute(mesh, test::places_at_edges(mesh, 4000, 5e-5, 3), "at edges and corners");
    expect_as_brute(mesh, places_in({-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}, 500, 4), "far away");
    expect_as_brute(mesh, mesh.vertices, "the corners themselves");
}

TEST(DistanceField, SplittingEdgesChangesNothing) {
    const TriangleMesh mesh = read_mesh(test::casting("finished.stl")).mesh;
    const TriangleMesh split = test::split_to(mesh, 30000);
    ASSERT_TRUE(topology_of(split).closed());
    const auto places = test::places_off(mesh, 20000, -2e-3, 4e-3, 2e-5, 5);
    std::vector<Distance> one(places.size());
    std::vector<Distance> two(places.size());
    DistanceField(mesh).measure(places, one);
    DistanceField(split).measure(places, two);
    for (std::size_t i = 0; i < places.size(); ++i) {
        ASSERT_NEAR(one[i].value, two[i].value, kExact) << i;
    }
}

TEST(DistanceField, AllKindsAndThreadsAndOrdersAgree) {
    const TriangleMesh mesh = read_mesh(test::casting("finished.stl")).mesh;
    const DistanceField field(mesh);
    const auto places = test::places_off(mesh, 30000, -1e-3, 4e-3, 2e-5, 6);
    std::vector<Distance> first(places.size());
    field.measure(places, first, {.threads = 1, .simd = Simd::baseline, .sorted = true});
    for (const Simd simd : kinds()) {
        for (const unsigned threads : {1U, 2U, 5U}) {
            std::vector<Distance> out(places.size());
            field.measure(places, out, {.threads = threads, .simd = simd});
            for (std::size_t i = 0; i < places.size(); ++i) {
                ASSERT_NEAR(out[i].value, first[i].value, 1e-15) << i << " " << name_of(simd);
            }
        }
    }
}

TEST(DistanceField, SignsAreRightNearEdgesCornersAndThinWalls) {
    // The part's own normals are not used: a place moved by the distance along the foot's direction is on the surface,
    // and the winding of the triangles about it is that of a solid.
    const TriangleMesh mesh = read_mesh(test::casting("finished.stl")).mesh;
    const DistanceField field(mesh);
    auto places = test::places_at_edges(mesh, 300, 5e-5, 7);
    const auto deep = test::places_at_edges(mesh, 300, 3e-3, 8);
    places.insert(places.end(), deep.begin(), deep.end());
    for (const Vec3& p : places) {
        double angle = 0.0;
        for (const auto& t : mesh.triangles) {
            const Vec3 a = mesh.vertices[t[0]] - p;
            const Vec3 b = mesh.vertices[t[1]] - p;
            const Vec3 c = mesh.vertices[t[2]] - p;
            angle += 2.0 * std::atan2(dot(a, cross(b, c)), norm(a) * norm(b) * norm(c) + dot(a, b) * norm(c) +
                                                               dot(b, c) * norm(a) + dot(c, a) * norm(b));
        }
        const bool inside = angle > 2.0 * std::numbers::pi;
        const Distance distance = field.at(p);
        if (std::abs(distance.value) > 1e-12) {
            EXPECT_EQ(distance.value < 0.0, inside) << p.x << " " << p.y << " " << p.z;
        }
    }
}

TEST(DistanceField, SliversWithoutNormalDoNotTurnASign) {
    // A box with a corner in the middle of an edge that only one side knows of: a triangle without area closes the gap.
    TriangleMesh mesh = box_mesh({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1});
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::uint32_t a = mesh.triangles[0][0];
    const std::uint32_t b = mesh.triangles[0][1];
    const std::uint32_t c = mesh.triangles[0][2];
    mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
    mesh.triangles[0] = {a, middle, c};
    mesh.triangles.push_back({middle, b, c});
    mesh.triangles.push_back({middle, a, b});
    const DistanceField field(mesh);
    ASSERT_TRUE(field.topology().closed());
    for (const Vec3& p : places_in({-0.02, -0.02, -0.02}, {0.12, 0.12, 0.12}, 5000, 9)) {
        ASSERT_NEAR(field.at(p).value, to_box(p, {0.0, 0.0, 0.0}, {0.1, 0.1, 0.1}), kExact);
    }
    const Vec3 m = mesh.vertices[middle];
    for (const Vec3& way : places_in({-1e-3, -1e-3, -1e-3}, {1e-3, 1e-3, 1e-3}, 2000, 10)) {
        ASSERT_NEAR(field.at(m + way).value, to_box(m + way, {0.0, 0.0, 0.0}, {0.1, 0.1, 0.1}), kExact);
    }
}

TEST(DistanceField, TurnsOverAMeshThatFacesInwards) {
    TriangleMesh mesh = box_mesh({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1});
    turn_over(mesh);
    const DistanceField field(mesh);
    EXPECT_TRUE(field.turned());
    EXPECT_NEAR(field.at({0.05, 0.05, 0.05}).value, -0.05, kExact);
}

TEST(DistanceField, FootIsOnTheMeshAtThatDistance) {
    const TriangleMesh mesh = read_mesh(test::casting("finished.stl")).mesh;
    const DistanceField field(mesh);
    for (const Vec3& p : test::places_off(mesh, 500, -2e-3, 2e-3, 0.0, 11)) {
        const Distance d = field.at(p);
        const Foot foot = field.foot(p, d);
        EXPECT_LT(norm(foot.place + d.value * foot.direction - p), 1e-10);
        // The direction is that of growth.
        EXPECT_NEAR(field.at(p + 1e-8 * foot.direction).value - d.value, 1e-8, 1e-12);
    }
}

TEST(Topology, NamesOpenCrowdedAndTurnedEdges) {
    TriangleMesh open = box_mesh({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1});
    open.triangles.pop_back();
    const Topology one = topology_of(open);
    EXPECT_EQ(one.open_edges, 3U);
    EXPECT_FALSE(one.closed());
    EXPECT_NE(open_text(one).find("3 open edges"), std::string::npos);
    EXPECT_NE(open_text(one).find("100.000"), std::string::npos) << "says where, in mm";

    TriangleMesh turned = box_mesh({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1});
    std::swap(turned.triangles[0][0], turned.triangles[0][1]);
    EXPECT_EQ(topology_of(turned).turned_edges, 3U);

    TriangleMesh crowded = box_mesh({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1});
    crowded.triangles.push_back(crowded.triangles[0]);
    EXPECT_EQ(topology_of(crowded).crowded_edges, 3U);

    const Topology whole = topology_of(box_mesh({0.0, 0.0, 0.0}, {0.1, 0.2, 0.3}));
    EXPECT_TRUE(whole.closed());
    EXPECT_EQ(whole.shells, 1U);
    EXPECT_NEAR(whole.volume, 0.006, 1e-15);
    EXPECT_TRUE(topology_of(test::bored_block(0.1, 0.05, 0.02, 64)).closed());
    EXPECT_GT(topology_of(test::bored_block(0.1, 0.05, 0.02, 64)).volume, 0.0);
}

TEST(SpaceOrder, HoldsEveryIndexOnceAndKeepsNeighboursTogether) {
    const auto places = places_in({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 50000, 12);
    const auto order = space_order(places, 2);
    std::vector<std::uint32_t> sorted = order;
    std::ranges::sort(sorted);
    for (std::uint32_t i = 0; i < sorted.size(); ++i) {
        ASSERT_EQ(sorted[i], i);
    }
    double step = 0.0;
    for (std::size_t i = 1; i < order.size(); ++i) {
        step += norm(places[order[i]] - places[order[i - 1]]);
    }
    EXPECT_LT(step / static_cast<double>(order.size()), 0.06) << "random order has 0.66";
    EXPECT_EQ(space_order(places, 5), order) << "whatever the number of threads";
}

}  // namespace
}  // namespace sc::host
