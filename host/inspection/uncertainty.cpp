// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace sc::host {

namespace {

/// In any one direction, of a place in h that a transform's error ξ (rotation, translation) moves by ω × p + v.
double carried_to(const Vec3& p, const Covariance<6>& covariance) {
    Eigen::Matrix<double, 6, 6> sigma;
    for (Eigen::Index i = 0; i < 6; ++i) {
        for (Eigen::Index k = 0; k < 6; ++k) {
            sigma(i, k) = covariance.at[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
        }
    }
    Eigen::Matrix<double, 3, 6> moved;
    moved << 0.0, p.z, -p.y, 1.0, 0.0, 0.0,  //
        -p.z, 0.0, p.x, 0.0, 1.0, 0.0,       //
        p.y, -p.x, 0.0, 0.0, 0.0, 1.0;
    return std::sqrt(std::max(0.0, (moved * sigma * moved.transpose()).trace() / 3.0));
}

}  // namespace

Uncertainty uncertainty_of(const Inspection& inspection, const DistanceField& field,
                           const CalibrationSet* calibration) {
    Uncertainty out;
    const Fit& fit = inspection.fit;
    if (fit.used > 0 && fit.stiffness > 0.0) {
        const double held = fit.sigma / std::sqrt(static_cast<double>(fit.used) * fit.stiffness);
        const UncertaintySource placement{"placement", held,
                                          "spread of the points used, and the motion they hold least"};
        out.allowance = {{"one point", fit.sigma, "spread of the points used by the fit"}, placement};
        out.lines = {placement};
    }
    double squares = 0.0;
    std::size_t count = 0;
    for (const DatumLine& line : inspection.lines) {
        for (const LineRun& run : line.cut.runs) {
            for (const LinePlace& at : run.places) {
                squares += at.sigma * at.sigma;
                ++count;
            }
        }
    }
    if (count > 0) {
        out.lines.push_back({"surface at the line", std::sqrt(squares / static_cast<double>(count)),
                             "scatter of the points about the surface fitted there"});
    }
    if (calibration == nullptr) {
        return out;
    }
    const auto record = std::ranges::find(calibration->transforms, "h_from_c", &TransformRecord::id);
    if (record != calibration->transforms.end()) {
        const Vec3 middle =
            (inspection.final_w_from_c().inverse() * Point<frame::W>{0.5 * (field.low() + field.high())}).v;
        out.lines.push_back({"h_from_c",
                             carried_to(record->rotation * middle + record->translation, record->covariance),
                             "covariance in calibration " + calibration->id + ", at the middle of the part"});
    }
    return out;
}

double expanded(std::span<const UncertaintySource> sources) {
    double squares = 0.0;
    for (const UncertaintySource& source : sources) {
        squares += source.sigma * source.sigma;
    }
    return 2.0 * std::sqrt(squares);
}

}  // namespace sc::host
