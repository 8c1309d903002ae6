// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "boards/sim/sensors/rs485_line.hpp"
#include "boards/sim/sensors/sensor_devices.hpp"
#include "boards/sim/world/world.hpp"
#include "firmware/hal/io.hpp"

namespace sc::sim {

/// All distance sensors of the simulated cell on their lines. One thread.
class SensorPlant {
public:
    /// `world` must outlive this.
    SensorPlant(const SensorsConfig& config, const World& world);

    /// What the controller sends in the window that begins at `window_ns`.
    void transmit(std::int64_t window_ns, const std::array<SensorTransmission, kSensorBuses>& sent);
    /// Lives until `t_ns` with the axes and the table at these readings (metres, degrees).
    void step_to(std::int64_t t_ns, const Vec3& reading, double c_deg);
    /// What has been heard since the last call, into `out` (cleared first).
    void take(std::int64_t t_ns, std::array<std::vector<SensorByte>, kSensorBuses>& out);

    void trouble(std::size_t sensor, SensorTrouble what);
    /// A sensor of the triple head and the next one change places on the head.
    void swap_with_next(std::size_t sensor);
    /// What a sensor's beam truly meets now.
    [[nodiscard]] std::optional<Target> target(std::size_t sensor, const Vec3& reading, double c_deg) const;
    [[nodiscard]] Rs485Line& line(std::size_t bus) { return lines_.at(bus); }
    [[nodiscard]] SensorDevice* device(std::size_t sensor) { return devices_.at(sensor).get(); }

private:
    [[nodiscard]] Ray ray(std::size_t place, const Vec3& reading) const;

    const World* world_;
    std::array<Rs485Line, kSensorBuses> lines_;
    std::array<std::unique_ptr<SensorDevice>, kSensorCount> devices_;
    std::array<std::size_t, kSensorCount> mount_{};  ///< which place a sensor looks from
};

}  // namespace sc::sim
