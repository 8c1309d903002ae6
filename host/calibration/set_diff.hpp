// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"

/// What changed from one calibration set to another, in terms of what both say of their own uncertainty, and how far it
/// moves a place at the workpiece. The two are taken to be independent estimates: a set that was derived from the other
/// changes by less than its sigmas where it shares data. Host only.

namespace sc::host {

enum class RecordChange : std::uint8_t { same, changed, added, removed };
[[nodiscard]] std::string_view name_of(RecordChange change) noexcept;

struct RecordDiff {
    std::string id;
    RecordChange change = RecordChange::same;
    std::optional<double> turn{};    ///< radians: angle of a transform, lean of an axis
    std::optional<double> place{};   ///< metres: of a transform about the place below, of an axis, of the galvo's zero
    std::optional<double> sigmas{};  ///< √(δᵀ (Σ_a + Σ_b)⁻¹ δ / k): near 1 if both are right
    std::optional<double> chance{};  ///< that it is as large, if nothing has changed (chi-squared)
    std::optional<Vec3> moves{};  ///< metres, in h: where the place is burnt by b, less by a; the worst of four faces
};

struct SetDiff {
    Vec3 at;  ///< metres, in h at face 0
    std::vector<RecordDiff> records;
};

/// A place in front of the turntable's axis, or the middle of a reference cell's travel for a set without one.
[[nodiscard]] Vec3 default_place(const CalibrationSet& set);
[[nodiscard]] SetDiff diff_sets(const CalibrationSet& a, const CalibrationSet& b, const Vec3& at);

}  // namespace sc::host
