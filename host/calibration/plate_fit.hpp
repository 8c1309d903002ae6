// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "host/calibration/galvo_fit.hpp"
#include "host/formats/calibration_set.hpp"

/// Where the 3-D sensor measures (h_from_c) and how the galvo bends its field, both from one set of burnt crosses that
/// the sensor has measured: no eye and no target in between.
///
/// A cross at m in c lies at p = h_from_c·m in h. It was burnt with the axes at a and the command g, so
///     p_x − a_x = land_x(g, p_y − a_y),   p_z − a_z = land_z(g, p_y − a_y)          (galvo_model.hpp)
/// and its strokes are as wide as the beam leaves a mark at d = p_y − a_y − curvature·|land(g, 0)|²:
///     w² = waist²·(1 + (d / rayleigh)²),  width = 2·√(w²/2 · ln(reach² / w²))
/// where reach² = 2·energy / (π·fluence that leaves a mark). h's y is where the focus is, and only the widths show it:
/// without them a shift along y looks like another gain of the galvo. Nothing tells the galvo's offset from a shift of
/// h along x and z: h is where the beam is with the galvo's offset at a value that the caller chooses.

namespace sc::host {

struct PlateSight {
    int number = 0;
    FieldPlace command{};      ///< of the galvo
    Vec3 anchor;               ///< where the focus of the axes stood, h
    Vec3 place;                ///< as the sensor saw it, c
    Vec3 sigma;                ///< of that, > 0
    double width = 0.0;        ///< of its strokes; 0: not measured
    double width_sigma = 0.0;  ///< > 0 with a width
};
struct PlateFitOptions {
    bool residual_grid = true;
    bool find_wrong = true;
    FieldPlace offset{};  ///< metres: of the galvo, by definition
    double angle_scale = 0.160;
    double residual_half = 0.060;
    std::size_t residual_side = 10;
    double most_turn = 2e-4;    ///< radians: more uncertainty than that is refused
    double most_place = 30e-6;  ///< metres, at the middle of the crosses
};
/// The mark that the beam leaves.
struct MarkWidth {
    double waist = 20e-6;      ///< metres, 1/e² radius in focus
    double rayleigh = 0.8e-3;  ///< metres
    double reach = 3e-4;       ///< metres
    double curvature = 0.0;    ///< 1/m: the best focus lies so much · r² nearer to the head
    static constexpr std::size_t kParameters = 4;
    /// Of a stroke on a surface `depth` metres nearer to the head than the best focus.
    [[nodiscard]] double at(double depth) const;
};
struct PlateCrossFit {
    int number = 0;
    bool used = true;
    FieldPlace residual{};   ///< metres, x and z, with the residual grid
    double width_off = 0.0;  ///< metres; 0 without a width
    double surprise = 0.0;   ///< chi-squared of the residual, 2 degrees of freedom
};
struct PlateFit {
    static constexpr std::size_t kParameters = 6 + GalvoModel::kParameters + MarkWidth::kParameters;
    Mat3 rotation;  ///< h_from_c
    Vec3 translation;
    GalvoModel galvo;
    MarkWidth mark;                                ///< as assumed where there are no widths
    Covariance<kParameters> joint;                 ///< ξ of h_from_c (left), galvo, then the mark's four
    Covariance<6> of_transform;                    ///< its first block
    Covariance<GalvoModel::kParameters> of_galvo;  ///< and its second
    std::vector<PlateCrossFit> crosses;
    std::size_t widths = 0;
    double ray_rms = 0.0;  ///< metres, each coordinate, before the residual grid
    double rms = 0.0;      ///< after it
    double grid_freedom = 0.0;
    double field_sigma = 0.0;  ///< as GalvoFit's
    double chi_squared = 0.0;  ///< of rays and widths
    double freedom = 0.0;
    double raised = 1.0;       ///< the sigmas were raised by this: the data scatter more
    Vec3 middle;               ///< of the crosses, h
    double turn_sigma = 0.0;   ///< radians, in the least certain direction
    double place_sigma = 0.0;  ///< metres, the same at `middle`
    double focus_sigma = 0.0;  ///< metres, along y at `middle`

    [[nodiscard]] std::vector<int> wrong() const;  ///< numbers of the crosses left out
    /// As `calibrate galvo-field` has it.
    [[nodiscard]] GalvoFit galvo_fit() const;
};

/// Robust maximum likelihood over all unknowns at once, priors as in fit_galvo; then the smoothed residual grid. Host
/// only; some 0.3 s for 800 crosses. Throws InputError (with `file`) for fewer than 60 crosses, commands over less than
/// half of ±residual_half in x or z, depths over less than 0.5 mm, crosses of which most do not match, and crosses that
/// leave a direction of h_from_c uncertain: it is named.
[[nodiscard]] PlateFit fit_plate_crosses(const std::filesystem::path& file, const std::vector<PlateSight>& sights,
                                         const PlateFitOptions& options = {});

}  // namespace sc::host
