// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/sensors/distance_sensor.hpp"

namespace sc::sensors {

/// A phase-shift sensor of the TW10S / L1s family over Modbus RTU, option 0.1 mm. It has no serial number: its stored
/// offset, which is its own, stands for one. Two ways of measuring: for ever with the laser on (register 0x0001), or
/// one measurement at a time with the laser on for it alone (0x000F, answered late), for heads whose spots must not be
/// seen together.
class PhaseSensor final : public DistanceSensor {
public:
    explicit PhaseSensor(const SensorConfig& config) noexcept : DistanceSensor(config) {}
    [[nodiscard]] bool in_turn() const noexcept override {
        return single_ && (step_ == Step::laser_on || step_ == Step::fire || step_ == Step::laser_off);
    }
    /// Lasers in turn from the next measurement on.
    void fire_in_turn(bool on) noexcept { single_ = on; }

private:
    enum class Step : std::uint8_t { identify, laser_on, measure, fire, laser_off, dark };
    [[nodiscard]] bool compose(std::int64_t now_ns, Telegram& telegram) noexcept override;
    void understand(const Reply& reply, std::int64_t now_ns) noexcept override;
    void restart() noexcept override { step_ = Step::identify; }
    void take_value(const Reply& reply) noexcept;

    Step step_ = Step::identify;
    bool single_ = false;
};

}  // namespace sc::sensors
