// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "boards/event_device/event_packets.hpp"
#include "boards/sim/plant/laser.hpp"
#include "boards/sim/plant/mopa_source.hpp"
#include "boards/sim/plant/output_hashes.hpp"
#include "boards/sim/plant/shutter.hpp"

namespace sc::sim {

/// What was played.
struct EventReport {
    std::uint64_t windows = 0;
    std::uint64_t gaps = 0;  ///< windows that did not follow the one before
    std::uint64_t pulses = 0;
    std::uint64_t shuttered = 0;  ///< pulses that the shutter kept back
    std::uint64_t vetoes = 0;
    std::int64_t last_pulse_ns = -1;
    LaserCounters laser{};
    std::string command_trace_sha256;  ///< pulses in the path domain, as every board has it
    std::string set_point_sha256;      ///< changes of the axes' set-points while marking
    std::string laser_sha256;          ///< runs of triggers, each by its time after the one before
};

/// Laser, source and shutter playing a controller's windows in the controller's time. What happens is told to `sink` as
/// lines: time, what, value.
class EventPlayer {
public:
    using Sink = std::function<void(std::int64_t t_ns, std::string_view what, std::int64_t value)>;
    EventPlayer(const MachineConfig& machine, Sink sink);

    /// Plays [t_tick, t_tick+1) with the window before this one, and takes this one. Ticks that are missing are played
    /// dark.
    void window(std::int64_t tick, const ServoOutputs& outputs);
    /// The guard's word, at once.
    void veto(std::uint8_t causes);
    /// The controller has gone or fallen silent: everything off.
    void shut();
    /// How all stands after the last window.
    [[nodiscard]] event_device::Status status();
    /// A trouble of the source from now on, for tests: alarm and not ready as pins.
    void alarm(bool on) noexcept { alarm_ = on; }

    [[nodiscard]] EventReport report() const;

private:
    void play(std::int64_t begin_ns, const ServoOutputs* acting);
    void level(std::int64_t t_ns, std::string_view what, bool& last, bool now);

    MachineConfig machine_;
    Sink sink_;
    LaserPlant laser_;
    ShutterPlant shutter_;
    MopaSource source_;
    std::unique_ptr<ServoOutputs> acting_;
    bool has_acting_ = false;
    std::int64_t tick_ = -1;
    std::uint8_t causes_ = 0;
    bool alarm_ = false;
    bool gate_ = false;
    bool oscillator_ = false;
    bool open_ = false;
    bool guide_ = false;
    std::vector<std::uint8_t> source_bytes_;
    EventReport report_;
    OutputHashes hashes_;
};

[[nodiscard]] std::string to_json(const EventReport& report);

}  // namespace sc::sim
