// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/faces.hpp"

#include <gtest/gtest.h>

#include "host/formats/part.hpp"
#include "host/inspection/distance_field.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host {
namespace {

TEST(Faces, OfABoxAreSixPlanes) {
    const TriangleMesh mesh = test::box_mesh({0.0, 0.0, 0.0}, {0.1, 0.2, 0.3});
    const FaceMap map = segmented(mesh, topology_of(mesh));
    ASSERT_EQ(map.faces.size(), 6U);
    for (const CadFace& face : map.faces) {
        EXPECT_EQ(face.kind, FaceKind::plane);
        EXPECT_EQ(face.triangles.size(), 2U);
    }
}

TEST(Faces, OfABoredBlockAreSixPlanesAndABore) {
    const TriangleMesh mesh = test::bored_block(0.1, 0.05, 0.02, 48);
    const FaceMap map = segmented(mesh, topology_of(mesh));
    std::size_t planes = 0;
    for (const CadFace& face : map.faces) {
        planes += face.kind == FaceKind::plane ? 1U : 0U;
        if (face.kind == FaceKind::cylinder) {
            EXPECT_TRUE(face.hollow);
            EXPECT_NEAR(face.radius, 0.02, 1e-9);
            EXPECT_NEAR(std::abs(face.direction.z), 1.0, 1e-12);
            EXPECT_EQ(face.triangles.size(), 96U);
        }
    }
    EXPECT_EQ(planes, 6U);
    EXPECT_EQ(map.faces.size(), 7U);
}

TEST(Faces, OfTheCastingAreThoseThatItsPlanNames) {
    const DistanceField field(read_mesh(test::casting("finished.stl")).mesh);
    const FaceMap map = segmented(field.mesh(), field.topology());
    for (const MachinedFeature& feature : read_part(test::casting("part.toml")).machined) {
        const Distance at = field.at(feature.point.v);
        EXPECT_LT(std::abs(at.value), 2e-6) << feature.id;
        const CadFace& face = map.faces[map.face_of[at.triangle]];
        if (feature.kind == FeatureKind::plane) {
            EXPECT_EQ(face.kind, FaceKind::plane) << feature.id;
            EXPECT_GT(dot(face.direction, feature.direction.v), 0.999999) << feature.id;
        } else {
            ASSERT_EQ(face.kind, FaceKind::cylinder) << feature.id;
            EXPECT_TRUE(face.hollow) << feature.id;
            EXPECT_NEAR(2.0 * face.radius, feature.diameter, 5e-6) << feature.id;
            EXPECT_GT(std::abs(dot(face.direction, feature.direction.v)), 0.99999) << feature.id;
        }
    }
    EXPECT_LT(map.faces.size(), 400U);
}

TEST(Faces, AreThoseOfTheFileWhereItNamesThem) {
    TriangleMesh mesh = test::bored_block(0.1, 0.05, 0.02, 48);
    const FaceMap found = segmented(mesh, topology_of(mesh));
    mesh.face = found.face_of;
    const FaceMap named = segmented(mesh, topology_of(mesh));
    EXPECT_EQ(named.faces.size(), found.faces.size());
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        EXPECT_EQ(named.faces[named.face_of[i]].kind, found.faces[found.face_of[i]].kind);
    }
}

}  // namespace
}  // namespace sc::host
