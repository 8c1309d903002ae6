// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/formats/part.hpp"
#include "shared/geometry/vec.hpp"

namespace sc::host {

/// A part zero: the frame that one clamping is machined in. Its directions are given, its place is to be found.
struct PartZero {
    std::string name;
    Mat3 axes;   ///< rows: its x, y, z in the blank's frame
    Vec3 place;  ///< metres, in the blank's frame: as published, to compare with
};
/// A machined feature beside its rough counterpart.
struct BlankFeature {
    std::string name;
    FeatureKind kind = FeatureKind::plane;
    std::size_t zero = 0;
    Vec3 machined;  ///< metres, in its part zero
    double machined_radius = 0.0;
    Vec3 rough;  ///< metres, in the blank's frame
    double rough_radius = 0.0;
};
/// A distance between two features along an axis of the blank, from the second to the first.
struct BlankTolerance {
    struct End {
        std::size_t feature = 0;
        bool machined = true;
    };
    std::string id;
    End first;
    End second;
    std::size_t axis = 0;  ///< 0 x, 1 y, 2 z of the blank
    double nominal = 0.0;  ///< metres
    double lower = 0.0;
    double upper = 0.0;
};
/// The blank-localisation problem with several part zeros (Cserteg, Kovács, Váncza 2023).
struct BlankModel {
    double min_allowance = 0.0;        ///< metres
    double max_plane_allowance = 0.0;  ///< metres
    std::vector<PartZero> zeros;
    std::vector<BlankFeature> features;
    std::vector<BlankTolerance> tolerances;
};

/// Reads a file such as tests/data/casting-blank/published.toml. Throws InputError.
[[nodiscard]] BlankModel read_blank_model(const std::filesystem::path& path);

}  // namespace sc::host
