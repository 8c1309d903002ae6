// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "host/bridge/open_transport.hpp"
#include "host/cli/measure_live.hpp"

namespace sc::host::cli {

/// The triple head of a cell as a source of readings: a row whenever all three sensors have measured anew; where one
/// says what ails it, or the three do not measure for half a second, a row with that as its fault. The station is
/// called "cell". The first call opens the link; throws what open_transport and CellClient throw, Interrupted on
/// Ctrl-C.
[[nodiscard]] LineSource link_source(const std::string& url, const LinkOptions& options);

}  // namespace sc::host::cli
