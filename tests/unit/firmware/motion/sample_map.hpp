// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "shared/machine/axis_map.hpp"

namespace sc::test {

/// A map of the reference machine with something in every table: some 20 to 40 µm, 10 µrad, 5 mdeg, 10 µm of backlash.
inline AxisMap sample_map() {
    const MachineConfig machine = reference_machine();
    AxisMap map;
    const auto wave = [](double amplitude, double turns, double at, double phase) {
        return static_cast<std::int32_t>(std::lround(amplitude * std::sin(2.0 * M_PI * turns * at + phase)));
    };
    for (std::size_t j = 0; j < 3; ++j) {
        const AxisConfig& axis = machine.axis[j];
        map.first[j] = axis.travel_min;
        map.spacing[j] = (axis.travel_max - axis.travel_min) / static_cast<double>(kMapNodes - 1) * (1.0 + 1e-12);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < kMapCoefficients; ++k) {
                const double at = (static_cast<double>(k) - 1.0) / static_cast<double>(kMapNodes - 1);
                map.linear[i][j][k] =
                    wave(20e6, 1.3 + 0.4 * static_cast<double>(i), at, static_cast<double>(i + 2 * j));
            }
        }
        map.backlash[j] = 10'000'000;
        map.take_up[j] = 0.040;
    }
    for (std::size_t t = 0; t < kTurnTables; ++t) {
        for (std::size_t k = 0; k < kTurnNodes; ++k) {
            const double at = static_cast<double>(k) / static_cast<double>(kTurnNodes);
            map.turn[t][k] = wave(t == 0 ? 5e6 : 10e6, t % 2 == 0 ? 2.0 : 1.0, at, 0.7 * static_cast<double>(t));
        }
    }
    map.pivot = {-0.25, -0.47, -0.40};
    map.backlash[index(Axis::c)] = 4'000'000;
    map.take_up[index(Axis::c)] = 0.100;
    return map;
}

}  // namespace sc::test
