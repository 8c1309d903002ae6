// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "host/inspection/distance_field.hpp"
#include "host/inspection/faces.hpp"

namespace sc::host {

/// Height of a place over one face: metres, positive outside the metal.
struct Reading {
    double value = 0.0;
    Vec3 direction;      ///< unit; the height grows fastest this way
    bool strip = false;  ///< of a flat strip of a bore: the height over the bore is the least over all its strips
};

/// Measures allowance over a given face. The signed distance to the whole mesh is the same where the face is nearest;
/// but where metal is missing near a face's rim, another face is nearest and says nothing about this one.
///   plane            the height over it
///   bore             the least height over its flat strips (exact on the mesh), the radius where it has none
///   other cylinders  the distance to the mesh where this face is nearest, else the radius
///   other faces      the distance to the mesh
class FaceGauge {
public:
    FaceGauge(const DistanceField& field, const FaceMap& map);
    /// Some 20 ns over planes and bores, else that of a distance query. May run from several threads.
    [[nodiscard]] Reading at(const Vec3& place, std::uint32_t face) const;

private:
    struct Strip {
        double angle = 0.0;  ///< as angle_of has it
        Vec3 on;
        Vec3 normal;
        double area = 0.0;
    };
    /// normal · place − offset is the height over a strip.
    struct Flat {
        Vec3 normal;
        double offset = 0.0;
    };
    struct Bore {
        Vec3 u;
        Vec3 v;
        std::vector<double> angles;        ///< of the strips, rising, about the axis; empty: too few
        std::vector<Flat> flats;           ///< two of the last, all, two of the first: a circle without an end
        std::vector<std::uint32_t> first;  ///< of equal parts of the circle: the first strip at or beyond its start
    };
    [[nodiscard]] Bore bore_of(const CadFace& face) const;
    [[nodiscard]] Reading over_bore(const Vec3& place, const CadFace& face, const Bore& bore) const;

    const DistanceField* field_;
    const FaceMap* map_;
    std::vector<Bore> bores_;  ///< one a face, empty for what is none
};

}  // namespace sc::host
