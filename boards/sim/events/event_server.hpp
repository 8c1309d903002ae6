// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "boards/sim/events/event_player.hpp"

namespace sc::sim {

struct EventServerOptions {
    std::filesystem::path out;       ///< the trace; empty: none
    std::int64_t watchdog_ms = 100;  ///< without a window for so long all is shut; 0: it waits for ever
};

/// One controller from its first packet to its end, on an open socket. Returns what was played when the controller goes
/// or `*stop` becomes true; the socket stays open. Throws std::runtime_error when the first packet is no beginning,
/// std::system_error when the disk refuses.
[[nodiscard]] EventReport serve_events(int socket, const EventServerOptions& options, const volatile bool* stop);

}  // namespace sc::sim
