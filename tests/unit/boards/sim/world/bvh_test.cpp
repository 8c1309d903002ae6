// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/bvh.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

Mesh random_soup(std::size_t triangles, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    std::uniform_real_distribution<double> size(-0.2, 0.2);
    Mesh mesh;
    for (std::uint32_t i = 0; i < triangles; ++i) {
        const Vec3 a{place(random), place(random), place(random)};
        mesh.vertices.push_back(a);
        mesh.vertices.push_back(a + Vec3{size(random), size(random), size(random)});
        mesh.vertices.push_back(a + Vec3{size(random), size(random), size(random)});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

/// Signed volume test of each edge: shares no formula with the code under test.
double distance_by_volumes(const Mesh& mesh, std::size_t triangle, const Ray& ray) {
    const Vec3 far = ray.origin + 10.0 * ray.direction;
    const Vec3& a = mesh.vertices[mesh.triangles[triangle][0]];
    const Vec3& b = mesh.vertices[mesh.triangles[triangle][1]];
    const Vec3& c = mesh.vertices[mesh.triangles[triangle][2]];
    const auto volume = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
        return dot(q - p, cross(r - p, s - p));
    };
    const double u = volume(ray.origin, far, b, c);
    const double v = volume(ray.origin, far, c, a);
    const double w = volume(ray.origin, far, a, b);
    const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    const double side = volume(ray.origin, a, b, c);
    const double other = volume(far, a, b, c);
    if (!inside || (side > 0) == (other > 0)) {
        return std::numeric_limits<double>::infinity();
    }
    return 10.0 * side / (side - other);
}

class BvhAgainstBruteForce : public testing::TestWithParam<std::size_t> {};

TEST_P(BvhAgainstBruteForce, FindsTheSameFirstHit) {
    const Bvh bvh(random_soup(GetParam(), 7));
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(-2.0, 2.0);
    std::size_t hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 origin{place(random), place(random), place(random)};
        const Vec3 aim = 0.4 * Vec3{place(random), place(random), place(random)} - origin;
        const Ray ray{origin, (1.0 / norm(aim)) * aim};
        double nearest = std::numeric_limits<double>::infinity();
        std::size_t triangle = 0;
        for (std::size_t t = 0; t < bvh.mesh().triangles.size(); ++t) {
            const double distance = distance_by_volumes(bvh.mesh(), t, ray);
            if (distance < nearest) {
                nearest = distance;
                triangle = t;
            }
        }
        const auto hit = bvh.hit(ray);
        ASSERT_EQ(hit.has_value(), std::isfinite(nearest)) << "ray " << i;
        if (hit) {
            ++hits;
            EXPECT_EQ(hit->triangle, triangle);
            EXPECT_NEAR(norm(hit->point - origin), nearest, 1e-9);
            EXPECT_NEAR(norm(hit->normal), 1.0, 1e-12);
        }
    }
    EXPECT_GT(hits, GetParam() < 10 ? 0U : 50U);
}
INSTANTIATE_TEST_SUITE_P(Sizes, BvhAgainstBruteForce, testing::Values(1, 2, 5, 64, 600));

Mesh unit_square() { return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}}; }

TEST(Bvh, HitsOnSharedEdgesAndCorners) {
    const Bvh bvh(unit_square());
    for (int i = 0; i <= 100; ++i) {
        const double s = i / 100.0;
        EXPECT_TRUE(bvh.hit({{s, s, 1.0}, {0, 0, -1}})) << "on the diagonal at " << s;
        EXPECT_TRUE(bvh.hit({{s, s, 1.0}, {0.3 - s, 0.3 - s, -1}})) << "askew towards the diagonal from " << s;
    }
    EXPECT_TRUE(bvh.hit({{0, 0, 1}, {0, 0, -1}}));
    EXPECT_TRUE(bvh.hit({{1, 0, 1}, {0, 0, -1}}));
}

TEST(Bvh, MissesBesideBehindAndAlong) {
    const Bvh bvh(unit_square());
    EXPECT_FALSE(bvh.hit({{1.000001, 0.5, 1}, {0, 0, -1}}));
    EXPECT_FALSE(bvh.hit({{0.5, 0.5, 1}, {0, 0, 1}}));
    EXPECT_FALSE(bvh.hit({{-1, 0.5, 0}, {1, 0, 0}}));
}

TEST(Bvh, HitsFromBothSidesWithTheOutwardNormal) {
    const Bvh bvh(unit_square());
    for (const double side : {1.0, -1.0}) {
        const auto hit = bvh.hit({{0.25, 0.5, side}, {0, 0, -side}});
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->normal, (Vec3{0, 0, 1}));
        EXPECT_EQ(hit->point, (Vec3{0.25, 0.5, 0}));
    }
}

TEST(Bvh, EmptyMeshIsNeverHit) { EXPECT_FALSE(Bvh().hit({{0, 0, 1}, {0, 0, -1}})); }

TEST(Bvh, ServesTwoHundredThousandTriangles) {
    // A bumpy sheet; every ray from above must hit exactly at its own place.
    constexpr std::uint32_t kSide = 317;
    Mesh mesh;
    const auto height = [](std::uint32_t i, std::uint32_t j) { return 0.01 * std::sin(0.3 * i) * std::cos(0.2 * j); };
    for (std::uint32_t j = 0; j < kSide; ++j) {
        for (std::uint32_t i = 0; i < kSide; ++i) {
            mesh.vertices.push_back({1e-3 * i, 1e-3 * j, height(i, j)});
        }
    }
    for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
        for (std::uint32_t i = 0; i + 1 < kSide; ++i) {
            const std::uint32_t a = j * kSide + i;
            mesh.triangles.push_back({a, a + 1, a + kSide});
            mesh.triangles.push_back({a + 1, a + kSide + 1, a + kSide});
        }
    }
    ASSERT_GT(mesh.triangles.size(), 199'000U);
    const Bvh bvh(std::move(mesh));
    for (std::uint32_t k = 0; k < kSide * kSide; k += 97) {
        const std::uint32_t i = k % kSide;
        const std::uint32_t j = k / kSide;
        const auto hit = bvh.hit({{1e-3 * i, 1e-3 * j, 1.0}, {0, 0, -1}});
        ASSERT_TRUE(hit) << i << ' ' << j;
        EXPECT_NEAR(hit->point.z, height(i, j), 1e-14);
    }
}

}  // namespace
}  // namespace sc::sim
