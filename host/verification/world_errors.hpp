// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/path/job_plan.hpp"

/// The errors that the traced world lists in its header, against what the calibration takes out. They serve to foretell
/// where a cross must have been burnt; they are never used to find it.

namespace sc::host {

/// One listed error, and what of it is left.
struct ErrorBalance {
    KnownError error;
    std::optional<double> calibrated;  ///< the calibration's estimate in the error's unit, if it has one
    double left = 0.0;                 ///< error minus estimate; the error itself where there is none
    bool foretold = false;             ///< part of `foretell` below
};

/// True errors of axes and galvo in SI units, as far as the header lists them; absent ones are zero.
struct MachineTruth {
    std::array<double, 3> squareness{};                      ///< xy, xz, yz: rad
    std::array<double, 3> scale{};                           ///< x, y, z
    std::array<double, 2> galvo_offset{};                    ///< x, z: metres
    std::array<double, 4> galvo_matrix{1.0, 0.0, 0.0, 1.0};  ///< row-major
};

[[nodiscard]] std::vector<ErrorBalance> balance(std::span<const KnownError> errors, const CalibrationSet& set);
[[nodiscard]] MachineTruth machine_truth(std::span<const KnownError> errors);

/// Where the focus truly goes when the cell is told `place` for a path of this actuator and centre (anchor): the
/// set-points after compensation, then the true errors of axes and galvo. The turntable's errors, periodic shifts, lag
/// and encoder grid are left out.
[[nodiscard]] Vec3 foretell(const MachineTruth& truth, const Compensation& compensation, const Vec3& place,
                            Actuator actuator, const Vec3& anchor);

}  // namespace sc::host
