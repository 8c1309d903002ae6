// SPDX-License-Identifier: Apache-2.0
#include "shared/drives/drive_plan.hpp"

namespace sc {

[[gnu::cold]] TargetPair target_pair(const DrivePlan& plan, std::size_t axis) noexcept {
    std::size_t first = axis;
    bool open = false;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        if (!plan.drive[i].paired || plan.drive[i].bus != plan.drive[axis].bus) {
            continue;
        }
        open = !open;
        first = open ? i : first;
        if (!open && (axis == first || axis == i)) {
            return {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(i)};
        }
    }
    return {static_cast<std::uint8_t>(axis), static_cast<std::uint8_t>(axis)};
}

}  // namespace sc
