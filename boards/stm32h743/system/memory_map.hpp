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
inline constexpr MemoryRange kBank1{0x08000000, 1024 * kKb};
inline constexpr MemoryRange kBank2{0x08100000, 1024 * kKb};
inline constexpr MemoryRange kSlotA{0x08020000, 384 * kKb};  ///< this image, or the one in slot B
inline constexpr MemoryRange kSlotB{0x08100000, 384 * kKb};
inline constexpr MemoryRange kRecords{0x08180000, 512 * kKb};    ///< slot states and parameters, written by any image
inline constexpr MemoryRange kBelowStack{0x1FFF0000, 64 * kKb};  ///< where a full stack would go on
inline constexpr MemoryRange kDtcm{0x20000000, 128 * kKb};       ///< stack, data, interrupt vectors
inline constexpr MemoryRange kAxi{0x24000000, 512 * kKb};        ///< cached: what is large, by the core alone
inline constexpr MemoryRange kSram1{0x30000000, 128 * kKb};      ///< for DMA1, not cached
inline constexpr MemoryRange kSram2{0x30020000, 128 * kKb};      ///< for DMA2, not cached
inline constexpr MemoryRange kSram3{0x30040000, 32 * kKb};       ///< for both, not cached
inline constexpr MemoryRange kSram4{0x38000000, 64 * kKb};       ///< for BDMA, not cached
inline constexpr MemoryRange kBackup{0x38800000, 4 * kKb};       ///< not cached: a reset must find what was written
inline constexpr MemoryRange kRetained{0x38800000, 1 * kKb};     ///< how far a job came
inline constexpr MemoryRange kBackupFree{0x38800400, 3 * kKb - 256};
inline constexpr MemoryRange kFaultRecord{0x38800F00, 256};

}  // namespace memory

enum class Access : std::uint8_t { none, read_only, read_write };
enum class Caching : std::uint8_t { not_cached, write_through, write_back };

struct ProtectedRange {
    MemoryRange range;  ///< a power of two from 32 on, at a multiple of itself
    Access access;
    Caching caching;
    bool execute;
};

/// Of an image that runs from this bank. Where two overlap, the later one holds. What is in none is as the architecture
/// has it: peripherals, system memory. The other bank and the records can be written (an update, a store), so nothing
/// there is cached or executed.
[[nodiscard]] constexpr auto protection(unsigned bank) noexcept {
    const MemoryRange own = bank == 2 ? memory::kBank2 : memory::kBank1;
    const MemoryRange other = bank == 2 ? memory::kBank1 : memory::kBank2;
    return std::array{
        // Nothing is outside; normal memory would be read ahead, and a bus without a memory never answers.
        ProtectedRange{{0x60000000, 512U * 1024 * 1024}, Access::none, Caching::not_cached, false},
        ProtectedRange{{0x80000000, 512U * 1024 * 1024}, Access::none, Caching::not_cached, false},
        ProtectedRange{own, Access::read_only, Caching::write_through, true},
        ProtectedRange{other, Access::read_write, Caching::not_cached, false},
        ProtectedRange{memory::kRecords, Access::read_write, Caching::not_cached, false},
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
}

[[nodiscard]] constexpr bool protection_is_possible(unsigned bank) noexcept {
    for (const ProtectedRange& one : protection(bank)) {
        const std::uint32_t bytes = one.range.bytes;
        if (bytes < 32 || (bytes & (bytes - 1)) != 0 || one.range.base % bytes != 0) {
            return false;
        }
        if (one.execute && one.access == Access::read_write) {
            return false;  // nothing that can be written can be executed
        }
    }
    return protection(bank).size() <= 16;
}
static_assert(protection_is_possible(1) && protection_is_possible(2));
static_assert(memory::kBank1.holds(memory::kSlotA) && memory::kBank2.holds(memory::kSlotB));
static_assert(memory::kBank2.holds(memory::kRecords) && memory::kSlotB.end() <= memory::kRecords.base);
static_assert(memory::kRetained.base == memory::kBackup.base && memory::kRetained.end() == memory::kBackupFree.base &&
              memory::kBackupFree.end() == memory::kFaultRecord.base &&
              memory::kFaultRecord.end() == memory::kBackup.end());
static_assert(memory::kBelowStack.end() == memory::kDtcm.base, "the stack is the lowest in its RAM");

}  // namespace sc::stm32h743
