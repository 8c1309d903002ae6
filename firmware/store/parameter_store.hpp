// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/hal/parameter_memory.hpp"

namespace sc::store {

/// What a slot holds: parameters as bytes, of some layout, the newer the higher the generation.
struct Stored {
    std::size_t slot = 0;
    std::uint32_t generation = 0;  ///< from 1
    std::uint16_t layout = 0;
    std::uint32_t crc = 0;  ///< CRC-32 of the bytes
    std::span<const std::uint8_t> bytes;
};

/// Largest content: a slot less its head.
inline constexpr std::size_t kMostBytes = ParameterMemory::kSlotBytes - ParameterMemory::kUnit;

/// The newest whole slot, or none. A slot is a head of one unit (magic, generation, layout, size, CRC-32 of these and
/// of the content) and the content; the head is written last, so a slot whose writing was cut anywhere is not whole,
/// and the other one, which was not touched, counts. Two passes over the content. Any context.
[[nodiscard]] std::optional<Stored> newest(const ParameterMemory& memory) noexcept;

/// Writes parameters into the slot that does not hold the newest: erase, then a unit a tick, the head last, then a look
/// whether it is whole. Servo context; a tick costs some 200 instructions, the last one a pass over the content.
class ParameterStore {
public:
    enum class Progress : std::uint8_t { idle, writing, done, failed };

    /// Null: nothing can be kept. Before the first step.
    void keep_in(ParameterMemory* memory) noexcept;
    [[nodiscard]] bool fitted() const noexcept { return memory_ != nullptr; }
    [[nodiscard]] bool busy() const noexcept { return phase_ != Phase::idle; }
    /// As it was found at the start, or written since.
    [[nodiscard]] const std::optional<Stored>& stored() const noexcept { return stored_; }

    /// Only while fitted and not busy. The bytes must stay as they are until it is done; at most kMostBytes. None: both
    /// slots are erased, and what the board was built with counts again.
    void begin(std::span<const std::uint8_t> bytes, std::uint16_t layout) noexcept;
    /// Once a tick. `allowed` false (the laser may come on): nothing is begun in this tick. `done`
    /// or `failed` is told once.
    Progress step(bool allowed) noexcept;

private:
    enum class Phase : std::uint8_t { idle, erase, erase_other, content, head, look };

    ParameterMemory* memory_ = nullptr;
    std::optional<Stored> stored_;
    Phase phase_ = Phase::idle;
    std::span<const std::uint8_t> bytes_;
    std::uint16_t layout_ = 0;
    std::size_t slot_ = 0;
    std::uint32_t generation_ = 0;
    std::size_t unit_ = 0;
};

}  // namespace sc::store
