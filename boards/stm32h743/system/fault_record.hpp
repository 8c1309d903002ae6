// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

/// What a fault leaves behind, in backup RAM, for the next start. The chip's exceptions enter through
/// boards/stm32h743/image/fault_entry.cpp.

namespace sc::stm32h743 {

struct FaultRecord {
    std::uint32_t exception =
        0;                   ///< number of the vector: 2 NMI, 3 hard, 4 memory, 5 bus, 6 usage, 16 watchdog; 0 panic
    std::uint32_t tick = 0;  ///< of note_tick()
    std::uint32_t sp = 0;
    std::uint32_t pc = 0;  ///< these three: 0 when the stack could not be read
    std::uint32_t lr = 0;
    std::uint32_t xpsr = 0;
    std::uint32_t cfsr = 0;
    std::uint32_t hfsr = 0;
    std::uint32_t memory_address = 0;  ///< 0: not known
    std::uint32_t bus_address = 0;     ///< 0: not known, as with a write that was buffered
    std::uint32_t abfsr = 0;           ///< which bus gave the fault that was not precise
    std::uint32_t clock_flags = 0;     ///< RCC_CIFR; bit 10: HSE has stopped
    std::uint32_t flash_bank1 = 0;     ///< FLASH_SR; bit 26: two bits of a word were wrong
    std::uint32_t flash_bank2 = 0;
    bool operator==(const FaultRecord&) const noexcept = default;
};

inline constexpr std::size_t kFaultRecordWords = 14;
/// The words, their check word, and a word without meaning, at memory::kFaultRecord.
inline constexpr std::uint32_t kFaultRecordBytes = 64;

/// Gate, trigger, power byte, master oscillator, guide laser and shutter low, by direct writes, whatever drove their
/// pins before. Any context; some 20 register accesses, less than 1 us at 480 MHz and 3 us on HSI.
void make_outputs_safe() noexcept;

/// Lets memory, bus and usage faults have handlers of their own, and opens backup RAM. At the start.
[[nodiscard]] bool start_fault_records() noexcept;

/// For the record; once a control cycle.
void note_tick(std::uint32_t tick) noexcept;

/// What the core tells of the exception that stacked its frame at `sp`.
[[nodiscard]] FaultRecord gather_fault(std::uint32_t exception, std::uint32_t sp) noexcept;

/// Into backup RAM. A reset at any time leaves this record, the one before or none, but no mixture.
void leave_fault_record(const FaultRecord& record) noexcept;

/// The record of the last fault, once.
[[nodiscard]] std::optional<FaultRecord> take_fault_record() noexcept;

}  // namespace sc::stm32h743
