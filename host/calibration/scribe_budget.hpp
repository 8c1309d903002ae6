// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "shared/geometry/frames.hpp"

/// Where the error of a scribed place comes from: the covariances of a calibration set, and the noise of what it does
/// not hold, carried to each place of a job to first order. A place p in c is burnt at
///
///     p_h = R(C) (h_from_c p − a) + a  (+ the beam's landing relative to the axes),
///
/// so δp_h = R(C) [−[q]×, 1] ξ for ξ of a transform that gave q, and central differences for axis, axes and galvo. What
/// cross-covariances of the set say is in the total, as a source "shared". Host only; microseconds a place.

namespace sc::host {

/// 1 sigma of what is no record of the set.
struct BudgetNoise {
    double sensor = 7.5e-6;         ///< metres, each coordinate of a measured marker
    double registration = 0.0;      ///< metres, each coordinate: of stitching the views into c
    double turn = 8.7266e-6;        ///< radians (0.5 mdeg): turntable's positioning
    double axes = 2.5e-6;           ///< metres: positioning of each linear axis
    double pointing = 0.0;          ///< metres: of a person who checks by eye; not an error of scribing
    std::array<double, 2> field{};  ///< metres: where in the galvo's field the place is burnt, x and z
};

/// A place that is burnt, in h, with its face before the laser.
struct BudgetPlace {
    std::string name;
    double face_deg = 0.0;
    Point<frame::H> place;
    bool measured = true;  ///< came through c; a place that was given in h has no error of measurement or transform
};

using PlaceCovariance = std::array<std::array<double, 3>, 3>;  ///< m², in h

struct BudgetSource {
    std::string name;  ///< "sensor", a record's id, "table angle", "axes positioning", "shared"...
    PlaceCovariance covariance{};
};
struct PlaceBudget {
    BudgetPlace at;
    std::vector<BudgetSource> sources;  ///< the same ones, in the same order, for every place
    PlaceCovariance total{};            ///< of scribing
    Vec3 axis_95;                       ///< metres: 95 % of the error along each axis are within
    double distance_95 = 0.0;           ///< metres: 95 % of its length
    double checked_95 = 0.0;            ///< metres: what a check with `pointing` would see, worst axis
};

struct ScribeBudget {
    std::vector<PlaceBudget> places;
    std::vector<std::string> notes;  ///< records that the set lacks, and what that means
};

/// Throws InputError if the set has no way from c to h, or no turntable.
[[nodiscard]] ScribeBudget scribe_budget(const CalibrationSet& set, const std::vector<BudgetPlace>& places,
                                         const BudgetNoise& noise = {});

/// 95 % of the lengths of a normal error of this covariance (Patnaik's approximation by one chi-squared, Wilson and
/// Hilferty's of its quantile; within 3 %).
[[nodiscard]] double distance_95(const PlaceCovariance& covariance) noexcept;

/// One transform of a chain; an inverse one is used from right to left.
struct ChainLink {
    const TransformRecord* record = nullptr;
    bool inverted = false;
};
/// Records that lead from frame `from` to frame `to` (letters), nearest to `to` first; the fewest. Empty if there is no
/// way, or the frames are the same.
[[nodiscard]] std::vector<ChainLink> chain_between(const CalibrationSet& set, const std::string& to,
                                                   const std::string& from);
/// The frames of "h_from_c": {"h", "c"}; none for an id of another shape.
[[nodiscard]] std::optional<std::array<std::string, 2>> frames_of(const std::string& id);

}  // namespace sc::host
