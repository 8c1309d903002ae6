// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "boards/mps2_an500/shared_ram.hpp"

namespace sc::mps2_an500 {

/// The structure at the start of the PSRAM, as the core sees it.
inline SharedRam& shared_ram() noexcept { return *reinterpret_cast<SharedRam*>(kSharedRamAddress); }

inline void set_core_state(CoreState state) noexcept {
    std::atomic_ref(shared_ram().core_state).store(static_cast<std::uint32_t>(state), std::memory_order_release);
}

}  // namespace sc::mps2_an500
