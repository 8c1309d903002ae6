// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Where everything lies, and what the memory protection allows there. `stm32h743.ld` places sections by the same
/// numbers (a test compares them).

namespace sc::stm32h743 {

struct MemoryRange {
    std::uint32_t base;
    std::uint32_t bytes;
    [[nodiscard]] constexpr std::uint32_t end() const noexcept { return base + bytes; }
    [[nodiscard]] constexpr bool holds(const MemoryRange& other) const noexcept {
        return other.base >= base && other.end() <= end();
    }
};

namespace memory {

inline constexpr std::uint32_t kKb = 1024;
inline constexpr MemoryRange kItcm{0x00000000, 64 * kKb};  ///< code of interrupts; the first 256 bytes stay closed
inline constexpr MemoryRange kNull{0x00000000, 256};
inline constexpr MemoryRange kFlash{0x08000000, 2048 * kKb};
inline constexpr MemoryRange kSlotA{0x08020000, 384 * kKb};  ///< this image, or the one in slot B
inline constexpr MemoryRange kSlotB{0x08100000, 384 * kKb};
inline constexpr MemoryRange kBelowStack{0x1FFF0000, 64 * kKb};  ///< where a full stack would go on
inline constexpr MemoryRange kDtcm{0x20000000, 128 * kKb};       ///< stack, data, interrupt vectors
inline constexpr MemoryRange kAxi{0x24000000, 512 * kKb};        ///< cached: what is large, by the core alone
inline constexpr MemoryRange kSram1{0x30000000, 128 * kKb};      ///< for DMA1, not cached
inline constexpr MemoryRange kSram2{0x30020000, 128 * kKb};      ///< for DMA2, not cached
inline constexpr MemoryRange kSram3{0x30040000, 32 * kKb};       ///< for both, not cached
inline constexpr MemoryRange kSram4{0x38000000, 64 * kKb};       ///< for BDMA, not cached
inline constexpr MemoryRange kBackup{0x38800000, 4 * kKb};       ///< not cached: a reset must find what was written
inline constexpr MemoryRange kFaultRecord{0x38800000, 256};
inline constexpr MemoryRange kRetained{0x38800100, 4 * kKb - 256};

}  // namespace memory

enum class Access : std::uint8_t { none, read_only, read_write };
enum class Caching : std::uint8_t { not_cached, write_through, write_back };

struct ProtectedRange {
    MemoryRange range;  ///< a power of two from 32 on, at a multiple of itself
    Access access;
    Caching caching;
    bool execute;
};

/// Where two overlap, the later one holds. What is in none is as the architecture has it: peripherals, system memory.
inline constexpr std::array kProtection{
    // Nothing is outside; normal memory would be read ahead, and a bus without a memory never answers.
    ProtectedRange{{0x60000000, 512U * 1024 * 1024}, Access::none, Caching::not_cached, false},
    ProtectedRange{{0x80000000, 512U * 1024 * 1024}, Access::none, Caching::not_cached, false},
    ProtectedRange{memory::kFlash, Access::read_only, Caching::write_through, true},
    ProtectedRange{memory::kItcm, Access::read_only, Caching::not_cached, true},
    ProtectedRange{memory::kNull, Access::none, Caching::not_cached, false},
    ProtectedRange{memory::kBelowStack, Access::none, Caching::not_cached, false},
    ProtectedRange{memory::kDtcm, Access::read_write, Caching::not_cached, false},
    ProtectedRange{memory::kAxi, Access::read_write, Caching::write_back, false},
    ProtectedRange{memory::kSram1, Access::read_write, Caching::not_cached, false},
    ProtectedRange{memory::kSram2, Access::read_write, Caching::not_cached, false},
    ProtectedRange{memory::kSram3, Access::read_write, Caching::not_cached, false},
    ProtectedRange{memory::kSram4, Access::read_write, Caching::not_cached, false},
    ProtectedRange{memory::kBackup, Access::read_write, Caching::not_cached, false},
};

[[nodiscard]] constexpr bool protection_is_possible() noexcept {
    for (const ProtectedRange& one : kProtection) {
        const std::uint32_t bytes = one.range.bytes;
        if (bytes < 32 || (bytes & (bytes - 1)) != 0 || one.range.base % bytes != 0) {
            return false;
        }
        if (one.execute && one.access == Access::read_write) {
            return false;  // nothing that can be written can be executed
        }
    }
    return kProtection.size() <= 16;
}
static_assert(protection_is_possible());
static_assert(memory::kFlash.holds(memory::kSlotA) && memory::kFlash.holds(memory::kSlotB));
static_assert(memory::kSlotA.end() <= memory::kSlotB.base);
static_assert(memory::kBackup.holds(memory::kFaultRecord) && memory::kBackup.holds(memory::kRetained) &&
              memory::kFaultRecord.end() <= memory::kRetained.base);
static_assert(memory::kBelowStack.end() == memory::kDtcm.base, "the stack is the lowest in its RAM");

}  // namespace sc::stm32h743
