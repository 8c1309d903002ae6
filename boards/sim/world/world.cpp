// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/world.hpp"

#include <utility>

#include "boards/sim/world/mesh.hpp"
#include "boards/sim/world/world_error.hpp"

namespace sc::sim {
namespace {

Mesh all_meshes(const WorldSpec& spec) {
    Mesh mesh;
    for (const MeshFile& file : spec.meshes) {
        append(mesh, read_obj(file.path, file.unit));
    }
    return mesh;
}

WorldSpec checked(WorldSpec spec, const std::filesystem::path& file) {
    const Vec3& d = spec.turntable.direction;
    if (!(d.z > 0.85 * norm(d))) {
        throw WorldError({file.string(), 0, "turntable.direction", "the table's axis leans by more than 30 degrees",
                          "give a direction near (0, 0, 1)"});
    }
    return spec;
}

}  // namespace

World::World(const std::filesystem::path& file) : World(checked(read_world_spec(file), file)) {}

World::World(WorldSpec spec) : spec_(std::move(spec)), surface_(all_meshes(spec_)) {}

World::World(WorldSpec spec, Mesh surface) : spec_(std::move(spec)), surface_(std::move(surface)) {}

Rigid<frame::H, frame::T> World::h_from_t(double c_deg) const { return true_h_from_t(spec_.turntable, c_deg); }

std::optional<Hit> World::hit_in_table(const Ray& ray, const Rigid<frame::T, frame::H>& table_from_h) const {
    const Point<frame::T> origin = table_from_h * Point<frame::H>{ray.origin};
    const Direction<frame::T> direction = table_from_h * Direction<frame::H>{ray.direction};
    return surface_.hit({origin.v, direction.v});
}

std::optional<Hit> World::hit(const Ray& ray, double c_deg) const {
    const Rigid<frame::H, frame::T> h_from_table = h_from_t(c_deg);
    std::optional<Hit> found = hit_in_table(ray, h_from_table.inverse());
    if (found) {
        found->point = (h_from_table * Point<frame::T>{found->point}).v;
        found->normal = (h_from_table * Direction<frame::T>{found->normal}).v;
    }
    return found;
}

std::optional<Spot> World::shine(const Vec3& reading, double command_x, double command_z, double c_deg) const {
    const Beam beam = true_beam(spec_.galvo, true_focus(spec_.axes, reading), command_x, command_z);
    const double to_lens = spec_.galvo.focal_length / -beam.direction.y;
    const Rigid<frame::H, frame::T> h_from_table = h_from_t(c_deg);
    const std::optional<Hit> found =
        hit_in_table({beam.focus - to_lens * beam.direction, beam.direction}, h_from_table.inverse());
    if (!found) {
        return std::nullopt;
    }
    const Vec3 place = (h_from_table * Point<frame::T>{found->point}).v;
    const Vec3 normal = (h_from_table * Direction<frame::T>{found->normal}).v;
    return Spot{place, found->point, normal, beam.focus.y - place.y};
}

std::vector<KnownError> World::errors() const {
    std::vector<KnownError> list;
    WorldSpec copy = spec_;
    for (const NumberKey& key : number_keys()) {
        if (!key.name.empty()) {
            list.push_back({key.name, key.field(copy) / key.si, key.unit, key.compensated_by});
        }
    }
    return list;
}

}  // namespace sc::sim
