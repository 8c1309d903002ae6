// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/measurement/station.hpp"

namespace sc::host::cli {

struct LiveOptions {
    std::string readings;  ///< a CSV that grows; "-": stdin
    TripleRecord head;
    StationOptions options;
    StationJob job;
    double idle_s = 60.0;
    int port = 0;
};

/// One more line of readings. Waits up to 100 ms: a line without its end, an empty text when none has come, nullopt at
/// the end for good. A source of sensors over the link is one more function of this kind: it gives the header first
/// (station,d1_mm,d2_mm,d3_mm,age_ms,fault), then a row a sample.
using LineSource = std::function<std::optional<std::string>()>;
[[nodiscard]] LineSource line_source(const std::string& readings);

/// Follows the readings and shows the latest station, of its last ten readings: in the terminal, and as a page on this
/// computer's loopback, whose address is printed on stderr, that refreshes itself. A row that cannot be understood is
/// said and left out; a station that is refused shows why, and no figures. Ends at the end of stdin, after idle_s
/// without a line, or with Ctrl-C. Returns the exit code: 0, or 1 when the last station was refused.
int measure_live(const LiveOptions& options);

}  // namespace sc::host::cli
