// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/sensors/reading.hpp"
#include "firmware/sensors/telegram.hpp"

namespace sc::sensors {

/// What every kind of sensor must offer: a telegram when it is its turn, and what an answer means. Neither waits. The
/// next reading may be asked for before the last has been handed over; any other step waits for its answer. Servo
/// context; one telegram or answer a tick.
class DistanceSensor {
public:
    /// After so long a lost sensor is tried again, so that the others keep the bus.
    static constexpr std::int64_t kRetryNs = 250'000'000;
    /// So often a sensor is asked again who it is.
    static constexpr std::int64_t kIdentifyNs = 5'000'000'000;

    /// What is to be sent now; false: nothing at present. Its tag is the caller's.
    [[nodiscard]] bool next(std::int64_t now_ns, Telegram& telegram) noexcept;
    /// The answer to a telegram, or why there is none; each gets one.
    void take(const Reply& reply, std::int64_t now_ns) noexcept;
    /// It needs the bus until this is false again (its laser must be out before the next one is lit).
    [[nodiscard]] virtual bool in_turn() const noexcept { return false; }

    [[nodiscard]] const SensorConfig& config() const noexcept { return config_; }
    [[nodiscard]] Sample sample(std::int64_t now_ns) const noexcept { return reading_.at(now_ns); }

protected:
    explicit DistanceSensor(const SensorConfig& config) noexcept : config_(config), reading_(config) {}
    ~DistanceSensor() = default;
    DistanceSensor(const DistanceSensor&) = default;
    DistanceSensor& operator=(const DistanceSensor&) = default;

    // Each kind has its own of these three. They are not pure, since that would pull in the C++ run-time library.
    /// The telegram of the present step. True if it is a reading.
    [[nodiscard]] virtual bool compose(std::int64_t now_ns, Telegram& telegram) noexcept;
    /// A checked answer; its step is that of its telegram.
    virtual void understand(const Reply& reply, std::int64_t now_ns) noexcept;
    /// Contact is lost: begin anew.
    virtual void restart() noexcept;
    /// It is time to ask who it is; and it has said so.
    [[nodiscard]] bool due(std::int64_t now_ns) const noexcept { return now_ns >= identify_at_; }
    void identified(bool right, std::int64_t now_ns) noexcept;
    /// Its laser has been switched on: what it says is of before, until it has measured.
    void lit(std::int64_t now_ns) noexcept;
    [[nodiscard]] bool warm(std::int64_t now_ns) const noexcept { return now_ns >= warm_at_; }
    SensorConfig config_;
    Reading reading_;
    bool lit_ = false;  ///< its laser, as far as is known

private:
    bool waits_ = false;  ///< for the answer to a step that is no reading
    std::int64_t retry_at_ = 0;
    std::int64_t warm_at_ = 0;
    std::int64_t identify_at_ = 0;
};

}  // namespace sc::sensors
