// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/lag_plate.hpp"
#include "shared/machine/machine.hpp"

/// How the mirrors follow, from burnt and measured lines.
///
/// A mirror that is a delay and a second-order servo, driven by frames that lead by the inverse of the servo that the
/// controller was told (a0, b0, and the latency T0), stands a place c(t) of the path at
///
///     y(t) = c(t + δ) + e(t + δ),   e + a e' + b e'' = (a0 − a) c' + (b0 − b) c'',   δ = (T0 − a0) − (T − a)
///
/// with a = 2 damping / ω, b = 1 / ω², T the latency at constant speed: half a frame, delay and a. (Holding a command
/// for a frame costs half of it, which T holds, and a curvature of period² / 24, which the controller's lead has taken
/// out.) A mark at distance s of a line burnt at speed v belongs to t = s / v. What is measured is an affine image of
/// y, since where plate and axes stand is not the mirrors' matter.

namespace sc::host {

struct LagFit {
    GalvoLag lag;
    Covariance<3> covariance;  ///< of latency, frequency, damping: s, Hz, 1
    std::size_t marks = 0;     ///< that were used
    std::size_t outliers = 0;  ///< of them, not believed
    double rms = 0.0;          ///< metres, of each coordinate
    double sigma = 0.0;        ///< metres: noise of a coordinate that the data show
    /// Metres: 1 σ of a pulse's place at the mirrors' greatest speed and acceleration, for latency, frequency and
    /// damping as they are here.
    double placement_sigma = 0.0;
};

/// Robust maximum likelihood of latency, frequency, damping and the affine image: Levenberg-Marquardt with weights
/// after Cauchy. No prior: what the marks do not show is refused.
///
/// Throws std::domain_error with what is missing and what to do: fewer than 200 marks; marks that are in no line of the
/// plan, or beyond its end; a predicted 1 σ of placement above 2.5 µm; a lag that no controller of this machine takes;
/// a noise that is more than five times the stated one and 20 µm.
[[nodiscard]] LagFit fit_lag(const LagPlan& plan, const std::vector<LagMark>& marks, const MachineConfig& machine);

}  // namespace sc::host
