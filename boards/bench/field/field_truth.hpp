// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>

#include "boards/sim/world/world_spec.hpp"
#include "shared/machine/galvo_field.hpp"
#include "shared/machine/machine.hpp"

/// What a field correction leaves over in a world: the controller's own map makes words, the world's own rays meet a
/// sheet, and the places are compared. No estimator is in it.

namespace sc::bench {

struct FieldOptions {
    double half = 0.055;  ///< metres: targets from −half to +half in x and z
    double depth = 1e-3;  ///< and from −depth to +depth
    std::size_t side = 45;
    std::size_t depths = 5;
    bool tell_depth = true;  ///< false: the map is asked as if every place were in focus
    Vec3 reading;            ///< where the encoders of the axes stand
    Vec3 anchor;             ///< the place in h that was asked of the axes: targets count from here
};
struct FieldFigures {
    double rms = 0.0;  ///< metres, of the distance in (x, z)
    double max = 0.0;
    std::size_t places = 0;
    std::size_t clamped = 0;  ///< words at the end of their range
};

/// Of the world the head counts, and the axes' errors at the one place where they stand.
[[nodiscard]] FieldFigures field_figures(const GalvoField& field, const sim::WorldSpec& spec,
                                         const MachineConfig& machine, const FieldOptions& options);

/// The numbers of a GalvoField as text, one a line. Throws std::runtime_error.
[[nodiscard]] GalvoField read_field_numbers(const std::filesystem::path& file);

}  // namespace sc::bench
