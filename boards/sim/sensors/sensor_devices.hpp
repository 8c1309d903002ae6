// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "boards/sim/sensors/distance_models.hpp"
#include "boards/sim/sensors/rs485_line.hpp"
#include "boards/sim/world/world_spec.hpp"
#include "firmware/hal/io.hpp"

namespace sc::sim {

/// What is wrong with a sensor.
enum class SensorTrouble : std::uint8_t {
    none,
    silent,       ///< hears and says nothing
    crc,          ///< its checksum (or block check) is wrong
    wrong_slave,  ///< it answers in another's name
    exception,    ///< it refuses every request
    chopped,      ///< a pause in the middle of each answer
    stale,        ///< answers for ever with the value of now
    foreign,      ///< another device of the same address: another number
    blind,        ///< no light comes back
    slipped,      ///< counts one cycle too many (phase sensors)
};

/// A distance sensor as a device on the line: it measures by itself every period, and answers when it is asked.
class SensorDevice : public LineDevice {
public:
    /// Measures at `t_ns` what its beam meets.
    virtual void measure(std::int64_t t_ns, const std::optional<Target>& target) = 0;
    [[nodiscard]] std::int64_t next_measurement_ns() const noexcept { return next_ns_; }
    void trouble(SensorTrouble what) { trouble_ = what; }

protected:
    explicit SensorDevice(double update_s);
    /// The period is over.
    void measured(std::int64_t t_ns) { next_ns_ = t_ns + update_ns_; }

    SensorTrouble trouble_ = SensorTrouble::none;

private:
    std::int64_t update_ns_;
    std::int64_t next_ns_ = 0;
};

/// Modbus RTU of a slave as the standard has it (its own code, not the master's): telegrams are told apart by silence
/// of t3.5, broken ones are dropped, and the answer comes after that silence and the device's own turn-round.
class ModbusDevice : public SensorDevice {
public:
    void hear(std::uint8_t byte, bool garbled, std::int64_t end_ns) override;
    [[nodiscard]] std::optional<std::int64_t> due_ns() const override;
    [[nodiscard]] std::optional<SlaveAnswer> act(std::int64_t now_ns) override;
    /// A whole request without its silence, for a carrier that keeps telegrams apart by itself; empty: no answer.
    [[nodiscard]] std::vector<std::uint8_t> serve(const std::vector<std::uint8_t>& request, std::int64_t now_ns);

protected:
    ModbusDevice(const SensorBusConfig& bus, std::uint8_t address, double update_s, std::int64_t turn_round_ns);

    /// Register `first` + `i` of a read that began at `first`; nullopt where there is none.
    [[nodiscard]] virtual std::optional<std::uint16_t> read(std::uint8_t function, std::uint16_t first, unsigned i,
                                                            std::int64_t now_ns) = 0;
    [[nodiscard]] virtual bool write(std::uint16_t reg, std::uint16_t value, std::int64_t now_ns) = 0;
    /// How much later than at once this is answered.
    [[nodiscard]] virtual std::int64_t takes_ns(std::uint16_t first) const = 0;

private:
    std::uint8_t address_;
    std::int64_t character_ns_;
    std::int64_t inner_ns_;
    std::int64_t gap_ns_;
    std::int64_t turn_round_ns_;
    std::vector<std::uint8_t> frame_;
    bool broken_ = false;
    std::int64_t last_ns_ = 0;
    std::vector<std::uint8_t> slow_request_;
    std::int64_t slow_at_ns_ = 0;
};

class TriangulationDevice final : public ModbusDevice {
public:
    TriangulationDevice(const SensorBusConfig& bus, const SensorConfig& config, const YSensorTruth& truth,
                        std::uint64_t seed, std::uint64_t stream);
    void measure(std::int64_t t_ns, const std::optional<Target>& target) override;

private:
    std::optional<std::uint16_t> read(std::uint8_t function, std::uint16_t first, unsigned i,
                                      std::int64_t now_ns) override;
    bool write(std::uint16_t reg, std::uint16_t value, std::int64_t now_ns) override;
    [[nodiscard]] std::int64_t takes_ns(std::uint16_t first) const override;
    [[nodiscard]] std::uint16_t value_at(std::int64_t now_ns);

    struct Value {
        std::int64_t from_ns;
        std::uint16_t value;
    };
    YSensorTruth truth_;
    TriangulationModel model_;
    std::int64_t delay_ns_;
    std::deque<Value> coming_;
    std::uint16_t value_ = 0;
    std::optional<std::uint16_t> latched_;
    bool laser_ = false;
};

class PhaseDevice final : public ModbusDevice {
public:
    /// `beam`: which of the head's it is by its gain, zero and number.
    PhaseDevice(const SensorBusConfig& bus, const SensorConfig& config, const TripleTruth& truth, std::size_t beam,
                std::uint64_t seed, std::uint64_t stream);
    void measure(std::int64_t t_ns, const std::optional<Target>& target) override;
    [[nodiscard]] bool laser() const noexcept { return laser_; }

private:
    std::optional<std::uint16_t> read(std::uint8_t function, std::uint16_t first, unsigned i,
                                      std::int64_t now_ns) override;
    bool write(std::uint16_t reg, std::uint16_t value, std::int64_t now_ns) override;
    [[nodiscard]] std::int64_t takes_ns(std::uint16_t first) const override;
    [[nodiscard]] std::uint32_t value_at(std::int64_t now_ns);

    struct Value {
        std::int64_t from_ns;
        std::uint32_t value;
    };
    TripleTruth truth_;
    std::size_t beam_;
    std::uint8_t own_address_;
    PhaseModel model_;
    std::int64_t delay_ns_;
    std::deque<Value> coming_;
    std::uint32_t value_ = PhaseModel::kNoSignal;
    bool laser_ = false;
};

/// A sensor that speaks lines of text (firmware/sensors/ascii_sensor.hpp has the grammar), with the triangulation
/// model behind it.
class AsciiDevice final : public SensorDevice {
public:
    AsciiDevice(const SensorBusConfig& bus, const SensorConfig& config, const YSensorTruth& truth, std::uint64_t seed,
                std::uint64_t stream);
    void measure(std::int64_t t_ns, const std::optional<Target>& target) override;
    void hear(std::uint8_t byte, bool garbled, std::int64_t end_ns) override;
    [[nodiscard]] std::optional<std::int64_t> due_ns() const override { return answer_at_; }
    [[nodiscard]] std::optional<SlaveAnswer> act(std::int64_t now_ns) override;

private:
    [[nodiscard]] std::string value_text() const;

    YSensorTruth truth_;
    unsigned address_;
    std::int64_t gap_ns_;
    TriangulationModel model_;
    std::uint16_t value_ = 0;
    std::string line_;
    std::string question_;
    std::optional<std::int64_t> answer_at_;
};

}  // namespace sc::sim
