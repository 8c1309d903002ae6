// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "boards/sim/board_figures.hpp"
#include "boards/sim/plant/cell_plant.hpp"
#include "boards/sim/plant/fault_player.hpp"
#include "boards/sim/plant/laser.hpp"
#include "boards/sim/world/world.hpp"
#include "shared/codes/codes.hpp"
#include "shared/codes/state.hpp"

namespace sc::sim {

/// How a cell ended: the contents of cell.json.
struct CellReport {
    State state = State::boot;
    std::uint64_t faults = 0;  ///< bits by Fault
    Fault first_fault = Fault::none;
    std::int64_t now_ns = 0;
    std::uint64_t pulses = 0;
    std::int64_t last_pulse_ns = -1;
    LaserCounters laser;
    BeamCounters beam;
    unsigned pulse_width_ns = 0;
    std::uint64_t galvo_words_dropped = 0;
    std::string command_trace_sha256;
    std::string set_point_sha256;  ///< changes of the axes' set-points while marking
    std::string laser_sha256;      ///< runs of triggers, each by its time after the one before
    std::string board;             ///< where the controller ran
    std::optional<BoardFigures> figures;
    std::vector<FaultRecord> script_events;
    std::vector<KnownError> errors;
};

/// One JSON object. Faults are named as in shared/codes; `last_pulse_after_ns` of a script event is the time from its
/// edge to the last light before the cell came to rest, null when there was no light.
[[nodiscard]] std::string to_json(const CellReport& report);

}  // namespace sc::sim
