// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "host/vision/circle_fit.hpp"
#include "host/vision/grey_image.hpp"

/// Centres of laser spots and of dots in pictures, to a fraction of a pixel.

namespace sc::host {

/// Why a picture gives no centre.
enum class SpotProblem : std::uint8_t {
    flat,        ///< nothing stands out of the noise
    no_split,    ///< Otsu's threshold does not part the picture into spot and background
    small,       ///< too few pixels
    large,       ///< fills too much of the picture
    cut,         ///< reaches the picture's edge
    several,     ///< more than one spot of like size
    not_round,   ///< the outline is no circle
    wrong_count  ///< dots: not as many as there should be
};
[[nodiscard]] const char* name_of(SpotProblem problem) noexcept;

struct SpotRefusal {
    SpotProblem problem = SpotProblem::flat;
    std::string text;  ///< a sentence for a person, with values and what to do
};

/// Pixels; (0, 0) is the middle of the first pixel, y down.
struct Spot {
    double x = 0.0;
    double y = 0.0;
    double radius = 0.0;      ///< of the half-height outline
    double sigma = 0.0;       ///< of the centre, each way, as the outline's scatter says
    double roundness = 0.0;   ///< rms distance of the outline from its circle, over the radius
    double contrast = 0.0;    ///< height over noise
    double saturated = 0.0;   ///< share of the spot's pixels at full scale
    double misfit = 1.0;      ///< rms of the light off a Gaussian surface, over the light
    bool by_surface = false;  ///< the centre is the surface's, not the outlines'
    Circle edge;              ///< circle through Canny's edge of Otsu's region, as the paper has it
    std::size_t edge_points = 0;
};

/// The one laser spot of a picture. Otsu's threshold and the largest region say where it is, a circle through Canny's
/// edge of that region how large. Then, on the picture smoothed to a third of that radius (speckle), outlines at five
/// heights between local background and top are found to a fraction of a pixel; the mean of their circles' centres is
/// the result, or the start of a fit of the light's surface where the spot is one. None of these depends on what else
/// is in the picture. Some 30 ms for a million pixels.
[[nodiscard]] std::expected<Spot, SpotRefusal> find_spot(const GreyImage& image);

/// All dots of a pattern, `count` of them, dark on bright or bright on dark, in no particular order.
[[nodiscard]] std::expected<std::vector<Spot>, SpotRefusal> find_dots(const GreyImage& image, std::size_t count);

}  // namespace sc::host
