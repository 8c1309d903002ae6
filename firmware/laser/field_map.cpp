// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/field_map.hpp"

namespace sc::laser {
namespace {

/// One component of the spline: its value and its two derivatives per cell.
struct Look {
    double value = 0.0;
    double dx = 0.0;
    double dz = 0.0;
};

/// `node`: the first of the sixteen, of one component.
Look look(const double* node, const SplineWeights& x, const SplineWeights& z) noexcept {
    Look sum;
    for (std::size_t row = 0; row < 4; ++row) {
        const double* n = node + 2 * GalvoField::kSide * row;
        const double value = x.value[0] * n[0] + x.value[1] * n[2] + (x.value[2] * n[4] + x.value[3] * n[6]);
        const double slope = x.slope[0] * n[0] + x.slope[1] * n[2] + (x.slope[2] * n[4] + x.slope[3] * n[6]);
        sum.value += z.value[row] * value;
        sum.dx += z.value[row] * slope;
        sum.dz += z.slope[row] * value;
    }
    return sum;
}

/// Cell and place in it.
struct Cell {
    std::uint32_t index = 0;
    double u = 0.0;
};
Cell cell_of(double place, double half, double cells_per_metre) noexcept {
    constexpr double kMost = static_cast<double>(GalvoField::kCells);
    const double at = clamped((place + half) * cells_per_metre, 0.0, kMost);
    auto index = static_cast<std::uint32_t>(at);
    index = index < GalvoField::kCells ? index : static_cast<std::uint32_t>(GalvoField::kCells - 1);
    return {index, at - static_cast<double>(index)};
}

}  // namespace

FieldMap::FieldMap(const GalvoConfig& galvo) noexcept {
    linear_.format = WordFormat(galvo.word, galvo.convention);
    counts_per_metre_ = galvo.counts_per_metre * linear_.format.scale();
    set(Compensation{});
}

void FieldMap::set(const Compensation& compensation) noexcept {
    for (std::size_t i = 0; i < 2; ++i) {
        linear_.m[i] = {compensation.galvo_from_field[2 * i] * counts_per_metre_,
                        compensation.galvo_from_field[2 * i + 1] * counts_per_metre_, 0.0};
        linear_.offset[i] = compensation.galvo_offset[i] * counts_per_metre_;
    }
}

void FieldMap::set(const GalvoField& field) noexcept {
    field_ = field;
    if (!field.empty()) {
        cell_ = 2.0 * field.half / static_cast<double>(GalvoField::kCells);
        cells_per_metre_ = static_cast<double>(GalvoField::kCells) / (2.0 * field.half);
    }
}

std::array<double, 2> FieldMap::slope_at(double x, double z) const noexcept {
    const double bend = 1.0 + field_.bend * (x * x + z * z);
    return {field_.slope0[0] + (field_.slope[0] * x + field_.slope[1] * z) * bend,
            field_.slope0[1] + (field_.slope[2] * x + field_.slope[3] * z) * bend};
}

FieldPatch FieldMap::patch(double x, double z, double depth) const noexcept {
    if (field_.empty()) {
        return linear_;
    }
    // s = p − depth · slope(p), solved by putting p in again; each time the error shrinks by depth · |slope'| < 0.1.
    double px = x;
    double pz = z;
    std::array<double, 2> lean = slope_at(px, pz);
    for (int i = 0; i < 3; ++i) {
        px = x + depth * lean[0];
        pz = z + depth * lean[1];
        lean = slope_at(px, pz);
    }
    // dp/ds = (1 − depth · T)⁻¹ with T = d slope/dp, by the same series; dp/d depth = dp/ds · slope.
    const double bend = 1.0 + field_.bend * (px * px + pz * pz);
    const double rx = field_.slope[0] * px + field_.slope[1] * pz;
    const double rz = field_.slope[2] * px + field_.slope[3] * pz;
    const double twice = 2.0 * field_.bend;
    const double txx = depth * (field_.slope[0] * bend + rx * twice * px);
    const double txz = depth * (field_.slope[1] * bend + rx * twice * pz);
    const double tzx = depth * (field_.slope[2] * bend + rz * twice * px);
    const double tzz = depth * (field_.slope[3] * bend + rz * twice * pz);
    double gxx = 1.0 + txx;
    double gxz = txz;
    double gzx = tzx;
    double gzz = 1.0 + tzz;
    for (int i = 0; i < 2; ++i) {
        const double nxx = 1.0 + (txx * gxx + txz * gzx);
        const double nxz = txx * gxz + txz * gzz;
        const double nzx = tzx * gxx + tzz * gzx;
        const double nzz = 1.0 + (tzx * gxz + tzz * gzz);
        gxx = nxx;
        gxz = nxz;
        gzx = nzx;
        gzz = nzz;
    }
    const Cell cx = cell_of(px, field_.half, cells_per_metre_);
    const Cell cz = cell_of(pz, field_.half, cells_per_metre_);
    const SplineWeights wx = spline_weights(cx.u);
    const SplineWeights wz = spline_weights(cz.u);
    const double* node = field_.node.data() + 2 * (GalvoField::kSide * cz.index + cx.index);

    const double per_cell = cells_per_metre_ * counts_per_metre_;
    // Beyond the square, the tangent at its edge goes on.
    const double beyond_x = px - (static_cast<double>(cx.index) + cx.u) * cell_ + field_.half;
    const double beyond_z = pz - (static_cast<double>(cz.index) + cz.u) * cell_ + field_.half;
    struct Row {
        std::array<double, 3> m;
        double offset;
    };
    const auto row = [&](std::size_t i) noexcept -> Row {
        const Look at = look(node + i, wx, wz);
        const double jx = at.dx * per_cell;
        const double jz = at.dz * per_cell;
        const double value = at.value * counts_per_metre_ + (jx * beyond_x + jz * beyond_z);
        const double mx = jx * gxx + jz * gzx;
        const double mz = jx * gxz + jz * gzz;
        const double md = mx * lean[0] + mz * lean[1];
        return {{mx, mz, md}, value - (mx * x + mz * z + md * depth)};
    };
    const Row first = row(0);
    const Row second = row(1);
    return {{first.m, second.m}, {first.offset, second.offset}, linear_.format};
}

}  // namespace sc::laser
