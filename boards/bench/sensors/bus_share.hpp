// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "boards/sim/world/world.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::bench {

/// Readings on one bus beside what the line could carry.
struct BusShare {
    double readings_per_s = 0.0;  ///< valid answers with a value, new or repeated
    double new_per_s = 0.0;       ///< measurements among them
    double limit_per_s = 0.0;     ///< by the line alone
    [[nodiscard]] double share() const { return limit_per_s > 0.0 ? readings_per_s / limit_per_s : 0.0; }
};
struct BusShares {
    BusShare y;
    BusShare triple;
};

/// Most readings a line can carry: one request, silence of t3.5, the sensor's own turn-round, its answer, silence of
/// t3.5. Computed here from the Modbus standard, not taken from the master.
[[nodiscard]] double readings_per_s(const SensorBusConfig& bus, int request_bytes, int answer_bytes,
                                    double turn_round_s);

/// Runs hub and simulated sensors for `seconds` of the cell's time. `whole_telegrams`: the board hands bytes
/// over only once the silence behind a telegram has passed, as a serial driver that frames by idle time does (the
/// ablation).
[[nodiscard]] BusShares measure_bus_shares(const sim::World& world, const SensorsConfig& config, double seconds,
                                           bool whole_telegrams);

}  // namespace sc::bench
