// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "firmware/hal/io.hpp"
#include "shared/machine/sensors.hpp"

struct _modbus;  // NOLINT(bugprone-reserved-identifier): libmodbus's own name

namespace sc::rs485 {

/// A Modbus RTU bus on a serial port of the operating system, by libmodbus. `give` and `take` belong to the control
/// loop: no lock, no allocation, at most one wake-up of a thread. All else happens in the port's own thread.
///
/// The operating system does not say when a byte came. The port hands over a whole answer at once, no earlier than the
/// line could have carried it, its bytes stamped one character apart; so the master's rules on silence hold by
/// construction, and its patience must cover the operating system's delays (SensorConfig::patience_ns).
class ModbusPort {
public:
    /// Opens the port. Throws std::system_error.
    ModbusPort(const std::string& device, const SensorBusConfig& bus);
    ~ModbusPort();
    ModbusPort(const ModbusPort&) = delete;
    ModbusPort& operator=(const ModbusPort&) = delete;

    /// What the controller's tick at `tick_ns` wants sent in the window that begins `period_ns` later. A request given
    /// while one is under way is lost, and counted.
    void give(std::int64_t tick_ns, std::int64_t period_ns, const SensorTransmission& sent);
    /// What has come until the tick at `tick_ns`: nothing, or one answer.
    [[nodiscard]] std::span<const SensorByte> take(std::int64_t tick_ns);
    [[nodiscard]] std::uint64_t lost_requests() const noexcept { return lost_; }

private:
    static constexpr std::size_t kAnswerCapacity = kSensorBytesPerTick;
    enum class Slot : std::uint32_t { empty, asked, answered, end };

    void serve();
    void exchange();

    _modbus* context_ = nullptr;
    std::int64_t character_ns_;
    std::int64_t gap_ns_;

    std::atomic<Slot> slot_{Slot::empty};
    // Of whoever the slot says: the loop when empty or answered, the thread when asked.
    SensorTransmission request_;
    std::array<std::uint8_t, kAnswerCapacity> answer_{};
    std::size_t answer_size_ = 0;

    std::int64_t ready_ns_ = 0;  ///< before then no line could have carried the answer's last byte
    std::array<SensorByte, kAnswerCapacity> heard_{};
    std::uint64_t lost_ = 0;
    std::thread thread_;
};

}  // namespace sc::rs485
