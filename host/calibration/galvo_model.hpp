// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "shared/machine/galvo_field.hpp"

/// Where the beam of a two-mirror head behind an f-theta lens lands, and the correction that the controller needs for
/// it. Host only (libm). Lengths in metres, angles in radians.
///
///     mirrors a = gain_x c_x / angle_scale, b = gain_z c_z / angle_scale, for the command c; x mirror first
///     lens    (u, w) = r(t) / sin t · (sin a, cos a sin b), cos t = cos a cos b, r(t) = f1 t + f2 t² + f3 t³ + f4 t⁴
///     focus   p = offset + R (u, w) + residual(c), R = [cos ρ, −sin(ρ + σ); sin ρ, cos(ρ + σ)]
///     lean    l = tilt + R (u · exit_x, w · exit_z) · (1 + bend (u² + w²)), per metre that the beam travels
///     lands at p − depth · l on a surface that lies depth nearer to the head than the focal plane.

namespace sc::host {

using FieldPlace = std::array<double, 2>;  ///< (x, z)

struct GalvoModel {
    /// In the order of `value`, of covariances and of the calibration file.
    enum Parameter : std::size_t {
        kOffsetX,
        kOffsetZ,
        kGainX,
        kGainZ,
        kRotation,
        kSkew,
        kF1,
        kF2,
        kF3,
        kF4,
        kExitX,
        kExitZ,
        kBend,
        kTiltX,
        kTiltZ
    };
    static constexpr std::size_t kParameters = 15;

    double angle_scale = 0.160;  ///< metres of command per radian of optical angle
    std::array<double, kParameters> value{0.0, 0.0, 1.0,  1.0,  0.0, 0.0, 0.160, 0.0,
                                          0.0, 0.0, 6.25, 6.25, 0.0, 0.0, 0.0};
    /// What the ray model leaves over, as a bicubic B-spline of the command over the square ± residual_half: side ·
    /// side coefficients (side ≥ 4), x runs fastest. Empty: nothing is left.
    double residual_half = 0.0;
    std::size_t residual_side = 0;
    std::vector<FieldPlace> residual;

    /// Where command (c_x, c_z) lands at a depth, relative to the place of the axes.
    [[nodiscard]] FieldPlace land(const FieldPlace& command, double depth) const;
    /// The command whose beam passes `place` in focus; the inverse of land(…, 0) to 1 nm. Throws std::domain_error
    /// where the model has none.
    [[nodiscard]] FieldPlace command_for(const FieldPlace& place) const;
    /// What the controller is sent, over the square ± half. Throws as command_for.
    [[nodiscard]] GalvoField field(double half = 0.060) const;
    [[nodiscard]] static GalvoModel from(const GalvoFieldRecord& record);
    /// Model, but for covariance and provenance.
    [[nodiscard]] GalvoFieldRecord record() const;
    bool operator==(const GalvoModel&) const = default;
};

/// Weights of the coefficients `first` … `first` + 3 along one edge of a residual grid, at a command.
struct ResidualWeights {
    std::size_t first = 0;
    std::array<double, 4> weight{};
};
[[nodiscard]] ResidualWeights residual_weights(double command, double half, std::size_t side);

/// The correction of a set's galvo field, empty if it has none. Throws InputError for a record that has no inverse over
/// the field, or that the controller would refuse.
[[nodiscard]] GalvoField galvo_field_of(const CalibrationSet& set);

}  // namespace sc::host
