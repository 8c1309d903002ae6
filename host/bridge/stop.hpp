// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sc::host {

/// Exit code of a program that a person or the system has ended.
inline constexpr int kExitInterrupted = 130;

/// From now on the first SIGINT, SIGTERM or SIGHUP only sets a flag, so that the cell is brought to rest in good order;
/// the second one ends the program as usual (the cell then stops by itself, as the link has gone silent). SIGPIPE is
/// ignored. Call once, before threads start.
void install_stop_signals();
/// One of these signals has come.
[[nodiscard]] bool stop_requested() noexcept;

}  // namespace sc::host
