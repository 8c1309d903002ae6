// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// Where a board keeps the parameters that outlive its power: two slots of flash; a file in the simulated cell. Reading
/// is by address. Erasing and writing take their time: they are begun here, and `ready` tells when they are done.

namespace sc {

class ParameterMemory {
public:
    /// What is written at once: a flash word with its ECC bits.
    static constexpr std::size_t kUnit = 32;
    static constexpr std::size_t kSlots = 2;
    static constexpr std::size_t kSlotBytes = 40 * kUnit;
    using Unit = std::array<std::uint8_t, kUnit>;

    ParameterMemory(const ParameterMemory&) = delete;
    ParameterMemory& operator=(const ParameterMemory&) = delete;

    [[nodiscard]] virtual std::span<const std::uint8_t, kSlotBytes> slot(std::size_t slot) const noexcept = 0;
    /// Nothing is under way.
    [[nodiscard]] virtual bool ready() const noexcept = 0;
    /// Only while ready. An erased slot is no whole one.
    virtual void erase(std::size_t slot) noexcept = 0;
    /// Only while ready, each unit once after its slot was erased.
    virtual void write(std::size_t slot, std::size_t unit, const Unit& bytes) noexcept = 0;

protected:
    ParameterMemory() = default;
    ~ParameterMemory() = default;
};

}  // namespace sc
