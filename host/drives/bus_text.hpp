// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "shared/drives/bus_terms.hpp"

/// The bus budget of a machine's drives for people and programs. Host only.

namespace sc::host {

struct BusLine {
    int bus = 0;
    std::string frames;  ///< which
    std::uint32_t count = 0;
    std::uint32_t bits = 0;  ///< of one, at worst
    double period_ms = 0.0;
    double share = 0.0;
    bool reserve = false;
};
struct BusSheet {
    std::vector<BusLine> lines;
    struct Sum {
        int bus = 0;
        double cyclic = 0.0;
        double reserve = 0.0;
        [[nodiscard]] double total() const noexcept { return cyclic + reserve; }
    };
    std::vector<Sum> sums;  ///< of each bus that has a drive
    [[nodiscard]] bool fits() const noexcept;
};
/// Throws InputError for a plan that is none.
[[nodiscard]] BusSheet bus_sheet(const MachineConfig& machine, const DrivePlan& plan);
[[nodiscard]] std::string text_of(const BusSheet& sheet);

}  // namespace sc::host
