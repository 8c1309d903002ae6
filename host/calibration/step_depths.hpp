// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "host/formats/target.hpp"

/// Depths (y in h) of markers on a stepped target, from the differences of a distance sensor beside the head and the
/// certified heights of the steps.

namespace sc::host {

struct DepthReading {
    int marker = 0;
    Vec3 place;             ///< where the focus stood, h; y is what y1 + a1 − a2 starts from
    double distance = 0.0;  ///< what the sensor read there, metres
    double sigma = 0.0;     ///< of that
};
struct StepDepths {
    struct Depth {
        int marker = 0;
        double y = 0.0;
        double sigma = 0.0;  ///< less what all have in common: the focus
        double off = 0.0;    ///< what the reading is off the fit
    };
    std::vector<Depth> depths;
    double gain = 0.0;  ///< of the sensor over the steps, less one
    double gain_sigma = 0.0;
    double tilt_x = 0.0;  ///< of the target: dy/dx, dy/dz
    double tilt_z = 0.0;
    double rms = 0.0;  ///< metres, of the readings
};

/// y + (1 + gain)·(a1 − a) = plane(x, z) + height of the marker's step, least squares over plane and gain; `focus_y` is
/// where the first marker was in focus (y1, with its reading a1). A target without steps of different heights leaves
/// the gain at 0. Throws InputError (with `file`) for fewer than four readings, a marker that is on no step, markers on
/// a line.
[[nodiscard]] StepDepths fit_step_depths(const std::filesystem::path& file, const Target& target,
                                         const std::vector<DepthReading>& readings, double focus_y);

}  // namespace sc::host
