// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/sensors/distance_sensor.hpp"

namespace sc::sensors {

/// A triangulation sensor of the RF602 / AR100 family over Modbus RTU. It must have been set to that protocol (holding
/// register 39 = 2). Its serial number, base and range are read first, again after each loss of contact, and every
/// kIdentifyNs; then its laser is switched on; then register 6 is read for ever.
class TriangulationSensor final : public DistanceSensor {
public:
    explicit TriangulationSensor(const SensorConfig& config) noexcept : DistanceSensor(config) {}

    /// Broadcast that makes all sensors of the family on a bus hold the value of one instant.
    [[nodiscard]] static Telegram latch(std::int64_t patience_ns) noexcept;

private:
    enum class Step : std::uint8_t { identify, laser_on, measure };
    [[nodiscard]] bool compose(std::int64_t now_ns, Telegram& telegram) noexcept override;
    void understand(const Reply& reply, std::int64_t now_ns) noexcept override;
    void restart() noexcept override { step_ = Step::identify; }

    Step step_ = Step::identify;
    std::uint16_t base_mm_ = 0;
    std::uint16_t range_mm_ = 0;
};

}  // namespace sc::sensors
