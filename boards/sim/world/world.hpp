// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "boards/sim/world/bvh.hpp"
#include "boards/sim/world/machine_errors.hpp"
#include "boards/sim/world/world_spec.hpp"

namespace sc::sim {

/// One error that the world really has, for the report.
struct KnownError {
    std::string name;
    double value = 0.0;
    std::string unit;
    std::string compensated_by;  ///< "calibration: axes", "calibration: galvo field", ...
};

/// Where light met the workpiece.
struct Spot {
    Vec3 place;            ///< metres, h
    Vec3 table_place;      ///< the same spot in t
    Vec3 normal;           ///< unit, outward, h
    double defocus = 0.0;  ///< metres: best focus minus surface along +y, positive = focus nearer to the head
};

/// The true cell: surfaces, and every error of the machine. Immutable; what it answers depends on its arguments alone.
class World {
public:
    /// Throws WorldError as read_world_spec and read_obj do, and for a table axis that is not within 30° of +z.
    explicit World(const std::filesystem::path& file);
    explicit World(WorldSpec spec);
    /// With this surface (metres, t) instead of the spec's files.
    World(WorldSpec spec, Mesh surface);

    /// First surface that a ray in h meets with the table at reading `c_deg`. For laser, Y sensor, triple head and 3-D
    /// sensor alike. Some 1 µs.
    [[nodiscard]] std::optional<Hit> hit(const Ray& ray, double c_deg) const;

    /// A pulse: axis readings (metres), galvo command (metres), table reading (degrees). The beam starts at the lens,
    /// one focal length before its focus. nullopt when it meets nothing.
    [[nodiscard]] std::optional<Spot> shine(const Vec3& reading, double command_x, double command_z,
                                            double c_deg) const;

    /// The table's true axis line, and its true angle at a reading (degrees).
    [[nodiscard]] AxisLine axis() const { return true_axis(spec_.turntable); }
    [[nodiscard]] double table_angle(double c_deg) const { return true_angle(spec_.turntable, c_deg); }
    [[nodiscard]] Rigid<frame::H, frame::T> h_from_t(double c_deg) const;
    /// Every error, with its true value, zero ones too, in the order of the file format.
    [[nodiscard]] std::vector<KnownError> errors() const;
    [[nodiscard]] const WorldSpec& spec() const noexcept { return spec_; }
    [[nodiscard]] const Mesh& mesh() const noexcept { return surface_.mesh(); }

private:
    [[nodiscard]] std::optional<Hit> hit_in_table(const Ray& ray, const Rigid<frame::T, frame::H>& table_from_h) const;

    WorldSpec spec_;
    Bvh surface_;
};

}  // namespace sc::sim
