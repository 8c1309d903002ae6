// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "tests/bench/peers.hpp"

#if defined(SC_WITH_EMBREE)

#include <embree3/rtcore.h>
#include <xmmintrin.h>

#include "host/inspection/topology.hpp"

namespace sc::host::test {

namespace {

struct Model {
    TriangleMesh mesh;
    Topology topology;
    std::vector<Vec3> normal;
    std::vector<Vec3> corner_normal;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    ~Model() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
};

struct Answer {
    const Model* model = nullptr;
    Vec3 place;
    double squared = 1e300;
    Vec3 nearest;
    std::uint32_t triangle = 0;
    int feature = 0;
};

/// Ericson's regions: 0 face, 1..3 edge, 4..6 corner.
Vec3 nearest_on(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& feature) {
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const double d1 = dot(ab, p - a);
    const double d2 = dot(ac, p - a);
    if (d1 <= 0.0 && d2 <= 0.0) {
        feature = 4;
        return a;
    }
    const double d3 = dot(ab, p - b);
    const double d4 = dot(ac, p - b);
    if (d3 >= 0.0 && d4 <= d3) {
        feature = 5;
        return b;
    }
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        feature = 1;
        return a + (d1 / (d1 - d3)) * ab;
    }
    const double d5 = dot(ab, p - c);
    const double d6 = dot(ac, p - c);
    if (d6 >= 0.0 && d5 <= d6) {
        feature = 6;
        return c;
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        feature = 3;
        return a + (d2 / (d2 - d6)) * ac;
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        feature = 2;
        return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
    }
    feature = 0;
    const double all = 1.0 / (va + vb + vc);
    return a + (vb * all) * ab + (vc * all) * ac;
}

bool look(RTCPointQueryFunctionArguments* args) {
    auto& answer = *static_cast<Answer*>(args->userPtr);
    const TriangleMesh& mesh = answer.model->mesh;
    const auto& t = mesh.triangles[args->primID];
    int feature = 0;
    const Vec3 q = nearest_on(answer.place, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], feature);
    const Vec3 r = answer.place - q;
    const double squared = dot(r, r);
    if (squared < answer.squared) {
        answer.squared = squared;
        answer.nearest = q;
        answer.triangle = args->primID;
        answer.feature = feature;
        // In millimetres, as its boxes are.
        args->query->radius = static_cast<float>(1e3 * std::sqrt(squared)) * 1.000001F;
        return true;
    }
    return false;
}

double signed_distance(const Answer& answer) {
    const Model& m = *answer.model;
    Vec3 side = m.normal[answer.triangle];
    if (answer.feature >= 4) {
        side = m.corner_normal[m.mesh.triangles[answer.triangle][static_cast<std::size_t>(answer.feature - 4)]];
    } else if (answer.feature > 0) {
        side = side + m.normal[m.topology.neighbour[answer.triangle][static_cast<std::size_t>(answer.feature - 1)]];
    }
    return std::copysign(std::sqrt(answer.squared), dot(side, answer.place - answer.nearest));
}

}  // namespace

Distances make_embree(const TriangleMesh& mesh) {
    const auto model = std::make_shared<Model>();
    model->mesh = mesh;
    model->topology = topology_of(mesh);
    model->corner_normal.assign(mesh.vertices.size(), {});
    for (const auto& t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t[0]];
        const Vec3 n = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
        model->normal.push_back((1.0 / norm(n)) * n);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 u = mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]];
            const Vec3 v = mesh.vertices[t[(k + 2) % 3]] - mesh.vertices[t[k]];
            const double angle = std::atan2(norm(cross(u, v)), dot(u, v));
            model->corner_normal[t[k]] = model->corner_normal[t[k]] + angle * model->normal.back();
        }
    }
    model->device = rtcNewDevice("threads=1");
    model->scene = rtcNewScene(model->device);
    rtcSetSceneBuildQuality(model->scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(model->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            vertices[3 * i + axis] = static_cast<float>(1e3 * mesh.vertices[i][axis]);
        }
    }
    void* index =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size());
    std::memcpy(index, mesh.triangles.data(), 12 * mesh.triangles.size());
    rtcSetGeometryPointQueryFunction(geometry, look);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(model->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(model->scene);
    return [model](const std::vector<Vec3>& places, std::vector<double>& out) {
        const unsigned saved = _mm_getcsr();
        _mm_setcsr(saved | 0x8040U);  // no denormals, as Embree recommends
        for (std::size_t i = 0; i < places.size(); ++i) {
            Answer answer;
            answer.model = model.get();
            answer.place = places[i];
            RTCPointQuery query{};
            query.x = static_cast<float>(1e3 * places[i].x);
            query.y = static_cast<float>(1e3 * places[i].y);
            query.z = static_cast<float>(1e3 * places[i].z);
            query.radius = std::numeric_limits<float>::infinity();
            RTCPointQueryContext context;
            rtcInitPointQueryContext(&context);
            rtcPointQuery(model->scene, &query, &context, nullptr, &answer);
            out[i] = signed_distance(answer);
        }
        _mm_setcsr(saved);
    };
}

}  // namespace sc::host::test

#else

namespace sc::host::test {
Distances make_embree(const TriangleMesh&) { return {}; }
}  // namespace sc::host::test

#endif
