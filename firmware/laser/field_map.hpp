// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/laser/xy2_100.hpp"
#include "shared/machine/galvo_field.hpp"
#include "shared/machine/machine.hpp"
#include "shared/math/scalar.hpp"

/// Places in the field to counts and words, through the calibrated field correction. (x, z) in metres about the field's
/// centre, depth in metres: how much nearer to the head than the focal plane the surface lies. |x|, |z|, |depth| < 1 m.

namespace sc::laser {

/// The map about one place: affine in (x, z, depth). 100 kHz context: no division, no root.
struct FieldPatch {
    using Place = std::array<double, 3>;  ///< x, z, depth

    std::array<std::array<double, 3>, 2> m{};  ///< counts per metre
    std::array<double, 2> offset{};            ///< counts
    WordFormat format{GalvoWord::bits16, GalvoConvention::unset};

    [[nodiscard]] std::array<double, 2> exact_counts(const Place& p) const noexcept {
        return {m[0][0] * p[0] + m[0][1] * p[1] + (m[0][2] * p[2] + offset[0]),
                m[1][0] * p[0] + m[1][1] * p[1] + (m[1][2] * p[2] + offset[1])};
    }
    [[nodiscard]] std::array<std::int32_t, 2> counts(const Place& p) const noexcept {
        const std::array<double, 2> c = exact_counts(p);
        return {format.within(nearest32_within(c[0])), format.within(nearest32_within(c[1]))};
    }
    [[nodiscard]] std::array<std::uint32_t, 2> words(const Place& p) const noexcept {
        const std::array<std::int32_t, 2> c = counts(p);
        return {format.word(c[0]), format.word(c[1])};
    }
};

/// The whole map. Without a GalvoField it is the affine one of Compensation, the same everywhere.
class FieldMap {
public:
    explicit FieldMap(const GalvoConfig& galvo) noexcept;
    void set(const Compensation& compensation) noexcept;
    /// From now on this correction in place of Compensation's matrix; an empty one, or drop, takes it away.
    void set(const GalvoField& field) noexcept;
    void drop() noexcept { field_.half = 0.0; }

    /// It is not affine: a patch serves for the frames near its place only.
    [[nodiscard]] bool curved() const noexcept { return !field_.empty(); }
    /// The map of Compensation: that of every place while it is not curved.
    [[nodiscard]] const FieldPatch& flat() const noexcept { return linear_; }
    /// The map about a place: exact there, and at the surface within 0.2 µm up to 0.25 mm away, 0.33 µm up to 0.32 mm,
    /// for a lens of f 160 mm on a surface that slopes by 1 : 10 or less
    /// (tests/unit/firmware/laser/field_map_test.cpp). Some 450 instructions, without a field 30.
    [[nodiscard]] FieldPatch patch(double x, double z, double depth) const noexcept;

private:
    [[nodiscard]] std::array<double, 2> slope_at(double x, double z) const noexcept;

    GalvoField field_;
    FieldPatch linear_;
    double counts_per_metre_ = 0.0;
    double cell_ = 0.0;  ///< metres
    double cells_per_metre_ = 0.0;
};

}  // namespace sc::laser
