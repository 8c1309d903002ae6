// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "boards/sim/world/world_spec.hpp"
#include "firmware/hal/io.hpp"
#include "shared/machine/machine.hpp"

namespace sc::sim {

/// Light of one trigger.
struct LaserPulse {
    std::int64_t t_ns = 0;  ///< when the light leaves: trigger + latency
    std::uint32_t energy_nj = 0;
    bool lit = false;  ///< false: the master oscillator was off or had not waited; no light came
};

/// What did not become light, and what a real source would complain about. All monotonic.
struct LaserCounters {
    std::uint64_t unlit = 0;        ///< triggers before the master oscillator's wait was over
    std::uint64_t not_allowed = 0;  ///< in runs of a tick that did not allow the gate
    std::uint64_t cancelled = 0;    ///< dropped by cancel_laser or the guard
    std::uint64_t cut = 0;          ///< stopped by the hard line
    std::uint64_t out_of_rate = 0;  ///< source rate outside [prr_min, prr_nominal]
    std::uint64_t disordered = 0;   ///< triggers earlier than the one before
    std::uint64_t strobes = 0;      ///< of the power byte's latch, as they should be
    std::uint64_t bad_strobes = 0;  ///< too short a setup or width, or lines that change meanwhile: no byte is taken
    std::uint64_t wrong_power = 0;  ///< pulses made with another power byte than their run names
};

/// What a type-D source asks of its power port.
inline constexpr std::int64_t kLatchSetupNs = 1'000;
inline constexpr std::int64_t kLatchWidthNs = 2'000;

/// Pulsed fibre laser with its gate. It takes runs of triggers with absolute times and gives pulses in order of time.
/// Energy of a pulse = average power at its byte / source rate, source rate = pick / period, but for the first ones
/// after a pause: the gain that has built up makes them stronger (or, with a first-pulse killer, weaker). The byte is
/// what the source has taken at the last good edge of its latch, whatever the run says. Four things
/// can stop a trigger: the run was not allowed, it was cancelled, the gate is shut, or the hard line cuts the light
/// itself. One thread; some 10 ns a pulse.
class LaserPlant {
public:
    LaserPlant(const LaserConfig& config, const LaserTruth& truth);

    void set_master_oscillator(bool on, std::int64_t t_ns) noexcept;
    /// Adds a run. `allowed`: the tick that made it opened the gate; if not, its pulses only count.
    void queue(const LaserRun& run, bool allowed);
    /// Drops every queued trigger from `from_ns` on. Runs queued later are not touched.
    void cancel(std::int64_t from_ns);
    /// Gate shut for triggers from `from_ns` on, until `open_gate`.
    void shut_gate(std::int64_t from_ns) noexcept;
    /// The byte 0 is laid on the port and latched, unless it is in force.
    void clear_power(std::int64_t t_ns);
    void open_gate() noexcept { gate_shut_ns_ = kNever; }
    /// Hard line: no light from `from_ns` on, whatever firmware says, until `restore_light`.
    void cut_light(std::int64_t from_ns) noexcept;
    void restore_light() noexcept { light_cut_ns_ = kNever; }

    /// Told of each trigger that passes the gate, whether or not it makes light: control time, ns.
    void watch_triggers(std::function<void(std::int64_t)> sink) { triggers_ = std::move(sink); }

    /// Next pulse whose light leaves before `limit_ns`. Call until it gives none, with limits that grow.
    [[nodiscard]] std::optional<LaserPulse> next(std::int64_t limit_ns);
    [[nodiscard]] const LaserCounters& counters() const noexcept { return counters_; }

private:
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
    struct Queued {
        LaserRun run;
        std::int64_t done = 0;         ///< pulses given
        std::int64_t end_ns = kNever;  ///< triggers from here on are cancelled
    };
    /// What the board does with the port: the byte stands from `laid`, the latch is up from `rise` to `fall`.
    struct Strobe {
        std::int64_t laid_ns = 0;
        std::int64_t rise_ns = 0;
        std::int64_t fall_ns = 0;
        std::uint8_t byte = 0;
    };
    void strobe(std::int64_t rise_ns, std::uint8_t byte);
    void take_strobes(std::int64_t until_ns);
    [[nodiscard]] double target() const {
        const double share = byte_ / 255.0;
        return config_.power.si() * byte_ / 255.0 * (1.0 + truth_.power_bend * (1.0 - share));
    }
    void relax(std::int64_t t_ns);
    [[nodiscard]] double power_at(std::int64_t t_ns);
    [[nodiscard]] double gain_at(std::int64_t t_ns, double period_ns);
    [[nodiscard]] bool stopped(const Queued& queued, std::int64_t trigger_ns, std::int64_t light_ns);
    [[nodiscard]] LaserPulse shoot(const Queued& queued, std::int64_t trigger_ns, std::int64_t light_ns);

    LaserConfig config_;
    LaserTruth truth_;
    std::deque<Queued> runs_;
    std::int64_t gate_shut_ns_ = kNever;
    std::int64_t light_cut_ns_ = kNever;
    std::int64_t oscillator_on_ns_ = kNever;
    std::int64_t last_trigger_ns256_ = std::numeric_limits<std::int64_t>::min();
    std::deque<Strobe> strobes_;
    std::int64_t last_fall_ns_ = std::numeric_limits<std::int64_t>::min();
    double power_ = 0.0;     ///< W, at power_ns_; used with a time constant only
    std::uint8_t byte_ = 0;  ///< that the source has taken
    std::int64_t power_ns_ = 0;
    double excess_ = 0.0;  ///< of the gain, at the last pulse
    std::optional<std::int64_t> gain_ns_;
    LaserCounters counters_;
    std::function<void(std::int64_t)> triggers_;
};

}  // namespace sc::sim
