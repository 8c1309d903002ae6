// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

/// Rules of the firmware that a bench can do without. Only copies of the firmware's sources that mutate.py makes ask
/// for them; what is flashed, simulated and tested elsewhere has nothing to switch.

namespace sc::faults {

struct RemovedRule {
    unsigned number = 0;
    std::string_view rule;
};

/// The rules that this program can do without; none, in a program with the firmware as it is.
[[nodiscard]] const std::vector<RemovedRule>& removable_rules();
/// From now on the firmware goes without this rule; 0: with all of them.
void take_out(unsigned rule) noexcept;
/// Asked by the mutated sources.
[[nodiscard]] bool taken_out(unsigned rule) noexcept;

}  // namespace sc::faults
