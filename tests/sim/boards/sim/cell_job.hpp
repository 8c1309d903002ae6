// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <vector>

#include "boards/sim/cell.hpp"
#include "shared/path/item.hpp"

namespace sc::sim {

inline CellOptions default_cell(const std::string& script = "") {
    CellOptions options;
    options.world = std::filesystem::path(SC_SOURCE_DIR) / "boards/sim/world/default/world.toml";
    options.script = parse_fault_script(script, "script");
    return options;
}

/// One straight line on face 0 at z = -390 mm, from x = -300 mm on, 1000 pulses of 0.1 mJ a millimetre apart by 1/50.
struct LineJob {
    static constexpr double kX0 = -0.300;
    static constexpr double kY = -0.319;
    static constexpr double kZ = -0.390;
    static constexpr double kPitch = 20e-6;
    double length = 0.020;
    double speed = 0.050;

    [[nodiscard]] std::vector<Item> items() const {
        const auto wire = [](double metres) {
            return static_cast<std::int32_t>(std::lround(metres * kWireUnitsPerMetre));
        };
        PathBegin begin;
        begin.path = 1;
        begin.speed_um_s = static_cast<std::uint32_t>(std::lround(speed * 1e6));
        begin.pitch_nm = static_cast<std::uint32_t>(std::lround(kPitch * 1e9));
        begin.energy_nj = 100'000;
        begin.tolerance_nm = 5000;
        return {Turn{0},
                begin,
                PathPoint{wire(kX0), wire(kY), wire(kZ)},
                PathPoint{wire(kX0 + length), wire(kY), wire(kZ)},
                PathEnd{},
                JobEnd{}};
    }
    [[nodiscard]] std::size_t pulses() const { return static_cast<std::size_t>(std::lround(length / kPitch)) + 1; }
};

}  // namespace sc::sim
