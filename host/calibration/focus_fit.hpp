// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "host/calibration/plate_fit.hpp"

/// Where the focus is, from a ladder: strokes burnt with the axes at different y on a surface that stands still, and
/// how wide each came out. The narrowest or widest stroke alone says little; the whole curve (MarkWidth) says it to a
/// few per cent of the Rayleigh length.

namespace sc::host {

struct Rung {
    int line = 0;
    double y = 0.0;      ///< of the axes, h, metres
    double width = 0.0;  ///< of the stroke, metres
    double sigma = 0.0;  ///< of that, > 0
};
struct FocusFit {
    double y = 0.0;      ///< where the axes must stand for the surface to be in focus: its y in h
    double sigma = 0.0;  ///< 1 sigma
    MarkWidth mark;      ///< curvature 0
    double waist_sigma = 0.0;
    double rayleigh_sigma = 0.0;
    double rms = 0.0;  ///< metres
    std::size_t rungs = 0;
    std::vector<int> wrong;  ///< lines left out
};
/// Maximum likelihood with weak priors on the beam, rungs that fit no noise left out. Throws InputError (with `file`)
/// for fewer than seven rungs, a ladder that does not reach over both sides of the focus, and one that leaves the focus
/// more uncertain than 0.1 mm (its direction, y, is then blind).
[[nodiscard]] FocusFit fit_focus(const std::filesystem::path& file, const std::vector<Rung>& rungs);

}  // namespace sc::host
