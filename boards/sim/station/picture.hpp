// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "boards/sim/station/triple_head.hpp"

/// Pictures that a camera would take of laser spots and of dots: light first, then exposure.

namespace sc::sim {

/// Light, 1 is where the camera saturates. Pixel (column, row) has its centre at (column, row).
class Picture {
public:
    Picture(int width, int height, double light) : width_(width), height_(height), light_(size(), light) {}
    [[nodiscard]] int width() const noexcept { return width_; }
    [[nodiscard]] int height() const noexcept { return height_; }
    [[nodiscard]] double& at(int column, int row) { return light_[index(column, row)]; }
    [[nodiscard]] double at(int column, int row) const { return light_[index(column, row)]; }

private:
    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    }
    [[nodiscard]] std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    }
    int width_;
    int height_;
    std::vector<double> light_;
};

/// A Gaussian beam on a rough surface.
struct SpotLook {
    std::array<double, 2> centre{};  ///< px: of the beam's axis
    double waist = 20.0;             ///< px: where the light is 1/e² of the peak, across the tilt
    double stretch = 1.0;            ///< 1/cos of the surface's tilt
    double heading = 0.0;            ///< rad: direction of the stretch
    double peak = 0.8;
    double speckle = 0.2;  ///< contrast: standard deviation over mean
    double grain = 1.5;    ///< px: size of a speckle, standard deviation of its field
};

void add_spot(Picture& picture, const SpotLook& look, Random& random);
/// Light that rises over the picture by `rise`, in direction `heading`; none is added in the middle.
void add_gradient(Picture& picture, double rise, double heading);
/// A dark disc with soft edges, drawn as the ellipse with this centre and these half axes (px, columns first: two
/// conjugate half diameters).
void add_disc(Picture& picture, const std::array<double, 2>& centre, const std::array<double, 2>& half_a,
              const std::array<double, 2>& half_b, double light);

/// Exposes with noise of `sigma` (1 = full scale) and shot noise that doubles its variance at full scale, to 8 bits,
/// and writes a PGM. Throws std::runtime_error.
void write_picture(const std::filesystem::path& file, const Picture& picture, double sigma, Random& random);

}  // namespace sc::sim
