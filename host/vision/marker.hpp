// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/vision/drawing.hpp"
#include "host/vision/ellipse.hpp"
#include "host/vision/grey_image.hpp"

/// Circular markers in pictures: their ellipses, to a few thousandths of a pixel.

namespace sc::host {

/// Why an outline that looks like a marker gives no centre.
enum class MarkerProblem : std::uint8_t {
    cut,          ///< reaches the picture's edge
    small,        ///< its minor semi-axis is too short
    oblique,      ///< seen at too flat an angle
    faint,        ///< its edge hardly stands out of the noise
    saturated,    ///< the edge is clipped at full scale
    occluded,     ///< a part of the outline is missing or covered
    not_ellipse,  ///< the outline is no ellipse
};
[[nodiscard]] const char* name_of(MarkerProblem problem) noexcept;

struct Marker {
    Ellipse ellipse;
    std::array<double, 3> covariance{};  ///< of the centre by the pixels' noise: xx, xy, yy; px²
    double sigma = 0.0;                  ///< px: of the centre, 1 sigma, the larger of x and y
    double misfit = 0.0;                 ///< px: rms of the edge off the ellipse, over parts of the outline
    double contrast = 0.0;               ///< step of the light at the edge over the noise of a pixel
    double saturated = 0.0;              ///< share of the edge's pixels at full scale
    bool dark = false;                   ///< darker than what is around it
};

struct MarkerRefusal {
    MarkerProblem problem = MarkerProblem::not_ellipse;
    Ellipse where;     ///< roughly
    std::string text;  ///< a sentence for a person, with values and what to do
};

struct MarkerSettings {
    double smoothing_px = 1.0;    ///< of the gradients; 0: differences of neighbours
    double weight_power = 2.0;    ///< weight of a tangent: gradient to this power; 0: all alike
    double least_minor_px = 2.5;  ///< semi-axis
    double least_ratio = 0.2;     ///< of the axes: a circle tilted by 78°
};

struct MarkersFound {
    std::vector<Marker> markers;         ///< from the top left on, by rows of their centres
    std::vector<MarkerRefusal> refused;  ///< only what looks like a marker
};

/// All markers of a picture, dark on bright or bright on dark. Closed outlines at 40 levels of the light that are near
/// an ellipse say where they are; then each is fitted as a dual conic to the tangents that smoothed gradients are,
/// weighted by their strength, three pixels and more either side of the edge. The centre is the ellipse's: see
/// circle_pose.hpp for the circle's. Some 0.3 s for a million pixels.
[[nodiscard]] MarkersFound find_markers(const GreyImage& image, const MarkerSettings& settings = {});

/// The picture with ellipses, centres (20 times their 1 sigma as a disc, at least 1.5 px) and what was refused.
[[nodiscard]] Drawing overlay_of(const GreyImage& image, const MarkersFound& found);

}  // namespace sc::host
