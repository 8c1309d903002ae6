// SPDX-License-Identifier: Apache-2.0
#include "host/formats/length_unit.hpp"

#include <array>

namespace sc::host {

namespace {

constexpr std::array<LengthUnit, 6> kUnits{
    {{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"inch", 0.0254}, {"foot", 0.3048}}};

}  // namespace

std::optional<LengthUnit> length_unit(std::string_view name) noexcept {
    const std::string_view full = name == "in" ? "inch" : (name == "ft" ? "foot" : name);
    for (const LengthUnit& unit : kUnits) {
        if (unit.name == full) {
            return unit;
        }
    }
    return std::nullopt;
}

std::string length_unit_names() {
    std::string out;
    for (const LengthUnit& unit : kUnits) {
        out += (out.empty() ? "" : ", ") + std::string(unit.name);
    }
    return out;
}

}  // namespace sc::host
