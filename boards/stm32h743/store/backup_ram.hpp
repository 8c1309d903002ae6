// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>

#include "boards/stm32h743/registers/access.hpp"
#include "firmware/hal/retained.hpp"

/// The 4 KB of RAM that a battery feeds. Its first KB holds how far a job came (RetainedMemory: two copies, each with a
/// check). The rest is free for others. It must not be held back in the data cache: what is in the cache alone goes
/// with the power.

namespace sc::stm32h743 {

inline constexpr Address kBackupRam = 0x38800000;
inline constexpr std::uint32_t kBackupRamBytes = 4096;
inline constexpr std::uint32_t kRetainedBytes = 1024;
static_assert(sizeof(RetainedMemory) <= kRetainedBytes && std::is_trivially_copyable_v<RetainedMemory>);

struct BackupStart {
    enum class Result : std::uint8_t {
        ready,
        read_only,     ///< it cannot be written
        no_regulator,  ///< it can be used, and forgets when the power goes
    };
    Result result = Result::ready;
    std::uint32_t lost_words = 0;  ///< their ECC was broken; they are 0 now, and reading them is no fault
};

/// Before the first use of the RAM. 3 ms at most; some 0.2 ms of it in steps of 0.2 us without interrupts.
[[nodiscard]] BackupStart start_backup_ram() noexcept;

#if defined(__arm__)
/// After start_backup_ram().
inline RetainedMemory& retained_memory() noexcept {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast,performance-no-int-to-ptr): it lies there.
    return *reinterpret_cast<RetainedMemory*>(kBackupRam);
}
#endif

}  // namespace sc::stm32h743
