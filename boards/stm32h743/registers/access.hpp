// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// How drivers reach registers and memory that hardware reads. On the chip: words at their addresses. On a PC: the
/// model that is in force (tests/stm32h743/model/machine.hpp), so that the same driver source runs there.

namespace sc::stm32h743 {

using Address = std::uint32_t;

#if defined(__arm__)

// NOLINTBEGIN(cppcoreguidelines-pro-type-reinterpret-cast,performance-no-int-to-ptr): registers are at addresses.
inline std::uint32_t read32(Address at) noexcept { return *reinterpret_cast<const volatile std::uint32_t*>(at); }
inline void write32(Address at, std::uint32_t value) noexcept {
    *reinterpret_cast<volatile std::uint32_t*>(at) = value;
}
inline void write16(Address at, std::uint16_t value) noexcept {
    *reinterpret_cast<volatile std::uint16_t*>(at) = value;
}
inline void write8(Address at, std::uint8_t value) noexcept { *reinterpret_cast<volatile std::uint8_t*>(at) = value; }
/// Where DMA finds this object.
inline Address address_of(const volatile void* object) noexcept { return reinterpret_cast<Address>(object); }
// NOLINTEND(cppcoreguidelines-pro-type-reinterpret-cast,performance-no-int-to-ptr)
/// All accesses before it have taken effect.
inline void barrier() noexcept { asm volatile("dsb 0xF" ::: "memory"); }
/// What is fetched after it sees what was changed before it.
inline void instruction_barrier() noexcept { asm volatile("isb 0xF" ::: "memory"); }

#else

[[nodiscard]] std::uint32_t read32(Address at) noexcept;
void write32(Address at, std::uint32_t value) noexcept;
void write16(Address at, std::uint16_t value) noexcept;
void write8(Address at, std::uint8_t value) noexcept;
[[nodiscard]] Address address_of(const volatile void* object) noexcept;
void barrier() noexcept;
void instruction_barrier() noexcept;

#endif

inline void set_bits(Address at, std::uint32_t bits) noexcept { write32(at, read32(at) | bits); }
inline void clear_bits(Address at, std::uint32_t bits) noexcept { write32(at, read32(at) & ~bits); }
/// Sets the field under `mask` to `value`, which is already in place.
inline void change_bits(Address at, std::uint32_t mask, std::uint32_t value) noexcept {
    write32(at, (read32(at) & ~mask) | (value & mask));
}
/// Reads until all of `bits` are `set`, `most` times; false when they are not. For bits that hardware raises within a
/// known time: `most` is that time over some 10 ns a read.
[[nodiscard]] inline bool wait_for(Address at, std::uint32_t bits, bool set, std::uint32_t most) noexcept {
    for (std::uint32_t i = 0; i < most; ++i) {
        if ((read32(at) & bits) == (set ? bits : 0U)) {
            return true;
        }
    }
    return false;
}

}  // namespace sc::stm32h743
