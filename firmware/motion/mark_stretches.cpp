// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/mark_stretches.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

using trajectory::Piece;
using trajectory::Quintic;
using trajectory::value;

constexpr std::uint32_t kPiecesBack = 12;  ///< that a boundary is looked for on
constexpr int kSteps = 40;
constexpr double kExact = 1e-13;  ///< m

/// Where q rises through zero: q(0) < 0 ≤ q(duration). Newton, kept inside a shrinking bracket.
double root(const Quintic& q, double duration) noexcept {
    double low = 0.0;
    double high = duration;
    double t = 0.5 * duration;
    for (int i = 0; i < kSteps; ++i) {
        const double error = value(q, t);
        if (absolute(error) < kExact) {
            break;
        }
        (error < 0.0 ? low : high) = t;
        const double slope = trajectory::rate(q, t);
        const double next = slope > 0.0 ? t - error / slope : low;
        t = next > low && next < high ? next : 0.5 * (low + high);
    }
    return t;
}

}  // namespace

void MarkStretches::add(const trajectory::Place& place, const trajectory::Place& direction,
                        std::uint32_t item) noexcept {
    boundaries_[end_ % kCapacity] = {
        {place[0], place[1], place[2]},
        {static_cast<float>(direction[0]), static_cast<float>(direction[1]), static_cast<float>(direction[2])},
        item};
    ++end_;
}

/// On the pieces before number `behind`, the first that begins behind the boundary's point.
double MarkStretches::crossing(const Boundary& boundary, const trajectory::Ring<Piece>& pieces,
                               std::uint32_t behind) noexcept {
    std::uint32_t k = behind;
    for (std::uint32_t n = 0; n < kPiecesBack && k != pieces.first(); ++n) {
        --k;
        const Piece& piece = pieces[k];
        Quintic ahead{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double way = static_cast<double>(boundary.direction[axis]);
            for (std::size_t i = 0; i < ahead.size(); ++i) {
                ahead[i] += way * (piece.axis[axis][i] - (i == 0 ? boundary.place[axis] : 0.0));
            }
        }
        if (ahead[0] < 0.0) {
            const double t = value(ahead, piece.duration) < 0.0 ? piece.duration : root(ahead, piece.duration);
            return value(piece.distance, t);
        }
    }
    return pieces[k].distance[0];
}

void MarkStretches::find(const trajectory::Ring<Piece>& pieces, std::uint32_t end) noexcept {
    if (found_ == end_) {
        scanned_ = end;
        return;
    }
    for (; scanned_ != end; ++scanned_) {
        while (found_ != end_ && pieces[scanned_].item >= boundaries_[found_ % kCapacity].item) {
            Boundary& boundary = boundaries_[found_ % kCapacity];
            double distance = crossing(boundary, pieces, scanned_);
            if (found_ != first_) {
                distance = larger(distance, boundaries_[(found_ - 1) % kCapacity].place[0]);
            }
            boundary.place[0] = distance;
            ++found_;
        }
    }
}

void MarkStretches::forget_before(double distance) noexcept {
    // Of a stretch both ends, so that the first kept is always the beginning of one or the end of the first.
    while (found_ - first_ >= 2) {
        const std::uint32_t next = first_ + 1 + (first_ % 2);
        if (!found(next) || !(boundaries_[next % kCapacity].place[0] <= distance)) {
            return;
        }
        first_ = next;
    }
}

}  // namespace sc::motion
