// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/measurement/station.hpp"

namespace sc::host::cli {

/// One more line of readings. Waits up to 100 ms or so: a line without its end, an empty text when none has come,
/// nullopt at the end for good. The first line is the header, as stations files have it.
using LineSource = std::function<std::optional<std::string>()>;
/// A CSV that grows, or with "-" stdin. Throws InputError.
[[nodiscard]] LineSource line_source(const std::string& readings);

struct LiveOptions {
    LineSource source;
    std::string name;  ///< of the source, for messages
    TripleRecord head;
    StationOptions options;
    StationJob job;
    double idle_s = 60.0;
    int port = 0;
    int most = 0;  ///< ends after so many readings; 0: never
};

/// Follows the readings and shows the latest station, of its last ten readings: in the terminal, and as a page on this
/// computer's loopback, whose address is printed on stderr, that refreshes itself. A row that cannot be understood is
/// said and left out; a station that is refused shows why, and no figures. Ends at the end of stdin, after idle_s
/// without a line, after `most` readings, or with Ctrl-C. Returns the exit code: 0, or 1 when the last station was
/// refused.
int measure_live(const LiveOptions& options);

}  // namespace sc::host::cli
