// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <random>
#include <vector>

#include "shared/geometry/vec.hpp"

/// What a camera without distortion sees of circles. Camera frame: x right, y down, z along the view, millimetres.
/// Pixel (column, row) has its centre at (column, row).

namespace sc::sim {

using Random = std::mt19937_64;

struct Camera {
    double focal = 2232.0;  ///< px
    double middle_x = 0.0;
    double middle_y = 0.0;
    int width = 0;
    int height = 0;
};

struct Circle {
    Vec3 centre;
    Vec3 normal;
    double radius = 3.0;
};

struct Look {
    double dark = 40.0;         ///< grey values, inside
    double contrast = 160.0;    ///< grey values
    double blur = 1.0;          ///< px: of the lens, standard deviation
    double noise = 3.0;         ///< grey values, standard deviation
    double rise = 0.0;          ///< grey values of light over 100 px
    double rise_heading = 0.0;  ///< rad
};

/// Grey values before noise and rounding, row by row.
using Light = std::vector<double>;

/// Where the middle of a circle is seen.
[[nodiscard]] std::array<double, 2> seen_at(const Vec3& place, const Camera& camera);

/// Light of the circles on a bright plane, integrated over pixels on a grid eight times as fine.
[[nodiscard]] Light light_of(const Camera& camera, const std::vector<Circle>& circles, const Look& look);

/// Adds noise, rounds, writes an 8 bit PNG. Throws std::runtime_error.
void write_picture(const std::filesystem::path& file, const Camera& camera, const Light& light, double noise,
                   Random& random);

}  // namespace sc::sim
