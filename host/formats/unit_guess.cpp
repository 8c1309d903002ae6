// SPDX-License-Identifier: Apache-2.0
#include "host/formats/unit_guess.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sc::host {

namespace {

constexpr UnitGuess kMetres{"metres", 1000.0};
constexpr UnitGuess kInches{"inches", 25.4};

bool all_fit_in(const UnitGuess& unit, std::span<const Vec3> places, const std::function<bool(const Vec3&)>& fits) {
    return std::ranges::all_of(places, [&](const Vec3& v) { return fits((unit.millimetres * 1e-3) * v); });
}

bool within(std::span<const Vec3> places, double limit) {
    return std::ranges::all_of(places, [limit](const Vec3& v) {
        return std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit;
    });
}

}  // namespace

std::optional<UnitGuess> guess_unit(std::span<const Vec3> millimetres, double small_mm,
                                    const std::function<bool(const Vec3&)>& fits) {
    if (millimetres.empty()) {
        return std::nullopt;
    }
    if (within(millimetres, small_mm)) {
        for (const UnitGuess& unit : {kMetres, kInches}) {
            if (all_fit_in(unit, millimetres, fits)) {
                return unit;
            }
        }
    }
    if (std::ranges::any_of(millimetres, [&](const Vec3& v) { return fits(1e-3 * v); })) {
        return std::nullopt;
    }
    for (const UnitGuess& unit : {kMetres, kInches}) {
        if (all_fit_in(unit, millimetres, fits)) {
            return unit;
        }
    }
    return std::nullopt;
}

std::optional<UnitGuess> guess_unit_in_h(std::span<const Vec3> millimetres, const MachineConfig& machine) {
    double longest = 0.0;
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
        const AxisConfig& a = machine.axis[index(axis)];
        longest = std::max(longest, a.travel_max - a.travel_min);
    }
    const auto fits = [&machine](const Vec3& v) {
        for (std::size_t i = 0; i < 3; ++i) {
            if (v[i] < machine.axis[i].travel_min || v[i] > machine.axis[i].travel_max) {
                return false;
            }
        }
        return true;
    };
    return guess_unit(millimetres, 1000.0 * longest / kInches.millimetres, fits);
}

}  // namespace sc::host
