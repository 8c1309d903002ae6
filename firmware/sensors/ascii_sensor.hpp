// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/sensors/distance_sensor.hpp"

namespace sc::sensors {

/// A sensor that speaks lines of text on RS485, as the HL-G1 does: `%AA#RMDbb\r` asks for the measured value, and
/// `%AA$RMD±ddd.ddddbb\r` has it in mm (`%AA!eebb\r`: an error), with AA the unit number and bb the exclusive or of all
/// bytes before it, both two digits (hexadecimal). 10 nm exactly to the last digit. ±950.0000 and beyond: no target.
class AsciiSensor final : public DistanceSensor {
public:
    explicit AsciiSensor(const SensorConfig& config) noexcept : DistanceSensor(config) {}

private:
    [[nodiscard]] bool compose(std::int64_t now_ns, Telegram& telegram) noexcept override;
    void understand(const Reply& reply, std::int64_t now_ns) noexcept override;
    void restart() noexcept override {}
};

}  // namespace sc::sensors
