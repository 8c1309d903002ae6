// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <variant>

#include "firmware/hal/io.hpp"
#include "firmware/sensors/ascii_sensor.hpp"
#include "firmware/sensors/bus_master.hpp"
#include "firmware/sensors/phase_sensor.hpp"
#include "firmware/sensors/triangulation_sensor.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::sensors {

/// All distance sensors of a cell on their buses, each bus going round its sensors for ever. Servo context, once a
/// tick: some 150 instructions, 40 more for each byte that has come, 300 more where an answer ends.
class SensorHub {
public:
    SensorHub(const SensorsConfig& config, std::int64_t period_ns) noexcept;

    void step(const ServoInputs& in, ServoOutputs& out) noexcept;

    [[nodiscard]] bool fitted(std::size_t sensor) const noexcept { return sensors_[sensor].index() != 0; }
    /// As at the last step.
    [[nodiscard]] Sample sample(std::size_t sensor) const noexcept;
    /// The lasers of the triple head one at a time, or all on.
    void fire_in_turn(bool on) noexcept;

private:
    using Slot = std::variant<std::monostate, TriangulationSensor, PhaseSensor, AsciiSensor>;
    struct Bus {
        BusMaster master;
        std::uint8_t cursor = 0;       ///< whose turn it is
        bool held = false;             ///< who has the bus needs it longer than one telegram
        std::int64_t latched_ns = -1;  ///< instant of the last latch, −1: none
    };
    static constexpr std::uint8_t kLatchTag = kSensorCount;

    [[nodiscard]] DistanceSensor* sensor(std::size_t i) noexcept;
    void ask(std::size_t bus, SensorTransmission& out) noexcept;

    SensorsConfig config_;
    std::array<Slot, kSensorCount> sensors_;
    std::array<Bus, kSensorBuses> buses_;
    std::int64_t period_ns_;
    std::int64_t now_ns_ = 0;
};

}  // namespace sc::sensors
