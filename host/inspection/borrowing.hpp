// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "host/formats/part.hpp"
#include "host/inspection/alignment.hpp"
#include "host/inspection/distance_field.hpp"
#include "host/inspection/face_gauge.hpp"

namespace sc::host {

/// Points of the scan that ask something of the placement. All lengths in metres.
struct BorrowPoint {
    Vec3 place;               ///< in w, as aligned
    std::uint32_t group = 0;  ///< the face that it lies over
};
/// What a face asks for: at least `least` metal, and at most `most` (as-cast faces: a band about zero).
struct BorrowGroup {
    std::string id;
    std::uint32_t face = 0;  ///< of the FaceMap
    double least = 0.0;
    double most = std::numeric_limits<double>::infinity();
    bool evened = true;  ///< whether its variance counts
};

struct BorrowOptions {
    unsigned threads = 0;
    /// Motions that are free: along x, y, z of w, and about them (through the CAD model's middle).
    std::array<bool, 6> free{true, true, true, true, true, true};
    std::array<double, 6> bound{5e-3, 5e-3, 5e-3, 0.02, 0.02, 0.02};  ///< metres, radians; either way
    std::vector<DatumPlane> locked = {};                              ///< planes that must stay where they are
};

/// A point that stops the smallest margin from growing.
struct ActivePoint {
    std::uint32_t point = 0;
    std::uint32_t group = 0;
    bool upper = false;       ///< it is the group's `most` that stops
    double multiplier = 0.0;  ///< all of them sum to 1
    double margin = 0.0;      ///< metres
    Vec3 place;               ///< in w, after the motion
    Vec3 direction;           ///< in which its allowance grows
};
/// A bound on a motion that stops it, likewise.
struct ActiveBound {
    std::size_t motion = 0;  ///< 0..5
    bool upper = false;
    double multiplier = 0.0;
};

struct Borrowing {
    Rigid<frame::W, frame::W> motion;  ///< of the scanned part, from where it was aligned
    std::array<double, 6> along{};     ///< the same: shift of the middle (metres), turn vector (radians)
    double margin_before = 0.0;        ///< smallest of allowance less requirement
    double margin = 0.0;
    double variance_before = 0.0;  ///< mean over the faces that count, square metres
    double variance = 0.0;
    std::vector<ActivePoint> active;
    std::vector<ActiveBound> bounds;
    /// Of the proof at the final place, lengths in mm, motions scaled to the part's half diagonal: nothing larger is
    /// left of stationarity, feasibility, complementarity.
    double kkt_residual = 0.0;
    int rounds = 0;  ///< linearisations
};

/// Moves a part inside its blank: the largest smallest margin; at that, the least variance of the allowance in each
/// face; at both, the least motion. Sequential linear programs on the heights over the faces (FaceGauge); the answer is
/// the best of all motions near the start, with multipliers as a proof. A million points: some 0.3 s on two cores.
/// Throws InputError if no motion is free, InspectionError if no point asks for anything.
[[nodiscard]] Borrowing borrow(const DistanceField& field, const FaceGauge& gauge, std::span<const BorrowPoint> points,
                               std::span<const BorrowGroup> groups, const BorrowOptions& options = {});

/// The paper's: one axis, two opposite sides. The shift towards the side with more that makes both equal.
struct Equalised {
    double shift = 0.0;
    double left = 0.0;
    double right = 0.0;
};
[[nodiscard]] Equalised equalise(double left, double right) noexcept;

}  // namespace sc::host
