// SPDX-License-Identifier: Apache-2.0
#include "shared/machine/galvo_field.hpp"

#include "shared/math/scalar.hpp"

namespace sc {
namespace {

constexpr double kLargestHalf = 0.2;
constexpr double kLargestSlope0 = 0.1;
constexpr double kLargestSlope = 50.0;  // 1/m: an exit pupil of 20 mm
constexpr double kLargestBend = 500.0;  // 1/m²
constexpr double kMostStretch = 0.35;   // a cell of commands against a cell of the field
constexpr double kMostShear = 0.3;

/// Also false for what is not a number.
constexpr bool within(double value, double limit) noexcept { return value >= -limit && value <= limit; }

bool neighbours_are_sound(const GalvoField& field, std::size_t from, std::size_t to, bool along_x) noexcept {
    const double cell = 2.0 * field.half / static_cast<double>(GalvoField::kCells);
    const double dx = field.node[2 * to] - field.node[2 * from];
    const double dz = field.node[2 * to + 1] - field.node[2 * from + 1];
    const double along = along_x ? dx : dz;
    const double across = along_x ? dz : dx;
    return within(along - cell, kMostStretch * cell) && within(across, kMostShear * cell);
}

}  // namespace

bool sound(const GalvoField& field) noexcept {
    if (!(field.half > 0.0 && field.half <= kLargestHalf) || !within(field.slope0[0], kLargestSlope0) ||
        !within(field.slope0[1], kLargestSlope0) || !within(field.bend, kLargestBend)) {
        return false;
    }
    for (const double s : field.slope) {
        if (!within(s, kLargestSlope)) {
            return false;
        }
    }
    constexpr std::size_t kSide = GalvoField::kSide;
    for (std::size_t i = 0; i < GalvoField::kNodes; ++i) {
        if (i % kSide + 1 < kSide && !neighbours_are_sound(field, i, i + 1, true)) {
            return false;
        }
        if (i + kSide < GalvoField::kNodes && !neighbours_are_sound(field, i, i + kSide, false)) {
            return false;
        }
    }
    // With neighbours so, one node's place bounds that of all.
    return within(field.node[0] + field.half, field.half) && within(field.node[1] + field.half, field.half);
}

}  // namespace sc
