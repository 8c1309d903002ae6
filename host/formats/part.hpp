// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/geometry/frames.hpp"

namespace sc::host {

enum class FeatureKind : std::uint8_t { plane, bore };

/// A surface that will be machined, and how much metal it must have over the finished part.
struct MachinedFeature {
    std::string id;
    FeatureKind kind = FeatureKind::plane;
    Point<frame::W> point;          ///< on the machined surface
    Direction<frame::W> direction;  ///< unit, out of the material; a bore's points out of its mouth
    Point<frame::W> axis_point;     ///< bores: the axis at the mouth
    double diameter = 0.0;          ///< bores: metres
    double depth = 0.0;             ///< bores: metres, 0 = not stated
    double min_allowance = 0.0;     ///< metres
    bool operator==(const MachinedFeature&) const = default;
};
/// A datum plane: its line is scribed where it meets the rough surface.
struct DatumPlane {
    std::string id;
    Point<frame::W> point;
    Direction<frame::W> normal;  ///< unit
    std::string note;
    bool operator==(const DatumPlane&) const = default;
};
/// A reference point of a 3-2-1 alignment, on an as-cast surface.
struct ReferencePoint {
    std::string id;
    int level = 1;  ///< 1 primary (three points), 2 secondary (two), 3 tertiary (one)
    Point<frame::W> point;
    Direction<frame::W> normal;  ///< unit, out of the material
    bool operator==(const ReferencePoint&) const = default;
};
/// Surfaces that stay as cast: how far they may lie inside or outside the finished part.
struct AsCastBand {
    double inside = 0.0;   ///< metres, ≥ 0
    double outside = 0.0;  ///< metres, ≥ 0
    bool operator==(const AsCastBand&) const = default;
};
/// What a process plan says of a part. File: format = "scribecell-part", version = 1.
struct Part {
    std::string id;
    std::string note;
    std::vector<MachinedFeature> machined;  ///< ids are unique among all three lists
    std::vector<DatumPlane> datums;
    std::vector<ReferencePoint> reference_points;
    std::optional<AsCastBand> as_cast;
    bool operator==(const Part&) const = default;
};

/// Both throw InputError (file, line, value, what to do). Also read is a plain machining description, which has `units`
/// in place of `format` (docs/formats.md); it is written as a part.
[[nodiscard]] Part read_part(const std::filesystem::path& path);
void write_part(const std::filesystem::path& path, const Part& part);

}  // namespace sc::host
