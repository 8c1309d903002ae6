// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "boards/sim/plant/fault_script.hpp"

namespace sc::sim {

/// What came of one event of a script.
struct FaultRecord {
    std::int64_t t_ns = 0;  ///< the edge
    std::string what;
    std::optional<std::int64_t> last_pulse_ns;  ///< last light after the edge and before the cell came to rest
    bool open = true;                           ///< the cell has not come to rest since
};

/// Hands out the events of a script as they fall due, and keeps what came of each.
class FaultPlayer {
public:
    explicit FaultPlayer(std::vector<FaultEvent> events);

    /// One more event, with a time of its own; one that has passed falls due at once.
    void add(FaultEvent event);

    /// Time of the next timed event, or the largest integer.
    [[nodiscard]] std::int64_t next_time() const noexcept;
    /// The next timed event if it is due at `t_ns`; it is then recorded with its own time.
    [[nodiscard]] std::optional<FaultEvent> take_at(std::int64_t t_ns);
    /// An event that waits for `pulses` lit pulses or fewer; it is recorded at `t_ns`.
    [[nodiscard]] std::optional<FaultEvent> take_after(std::uint64_t pulses, std::int64_t t_ns);

    /// Light left at `t_ns`.
    void saw_pulse(std::int64_t t_ns) noexcept;
    /// The cell is at rest: what fires later is no consequence of the events so far.
    void came_to_rest() noexcept;
    [[nodiscard]] const std::vector<FaultRecord>& records() const noexcept { return records_; }

private:
    void sort();

    std::vector<FaultEvent> timed_;    ///< latest first
    std::vector<FaultEvent> counted_;  ///< largest count first
    std::vector<FaultRecord> records_;
    std::size_t first_open_ = 0;
};

}  // namespace sc::sim
