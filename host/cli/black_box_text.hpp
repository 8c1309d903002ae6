// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/bridge/black_box.hpp"
#include "host/bridge/clock_fit.hpp"

namespace sc::host::cli {

/// For a person: what froze the box, then samples and events in order of time, relative to the newest sample. `last_s`:
/// of the time before it; all without. `clock` adds the host's time of the newest sample.
[[nodiscard]] std::string black_box_text(const BlackBoxContent& content, double last_s, const ClockFit& clock);
/// One row a sample, events in rows of their own; the first line names the columns.
[[nodiscard]] std::string black_box_csv(const BlackBoxContent& content, const ClockFit& clock);
[[nodiscard]] nlohmann::ordered_json black_box_json(const BlackBoxContent& content, const ClockFit& clock);
/// "enable", "refused: 103 wrong_state" ...: what an event says.
[[nodiscard]] std::string describe(const link::BlackboxEvent& event);

/// The clock of the cell against the host's, as `scribecell monitor` shows it. Null, or one line, before there is any.
[[nodiscard]] std::string clock_text(const ClockFit& clock, HostTime now);
[[nodiscard]] nlohmann::ordered_json clock_json(const ClockFit& clock, HostTime now);

}  // namespace sc::host::cli
