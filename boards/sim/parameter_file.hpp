// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>

#include "firmware/hal/parameter_memory.hpp"
#include "shared/machine/machine.hpp"

namespace sc::sim {

/// The flash in which a controller keeps its parameters, as a file that is written through at each act. Each act takes
/// some of the controller's ticks, as flash does. Without a path it is forgotten with the process.
class ParameterFile final : public ParameterMemory {
public:
    /// Creates the file when missing. Throws std::system_error.
    explicit ParameterFile(std::filesystem::path path);

    [[nodiscard]] std::span<const std::uint8_t, kSlotBytes> slot(std::size_t slot) const noexcept override {
        return slots_.at(slot);
    }
    [[nodiscard]] bool ready() const noexcept override { return waits_ == 0; }
    void erase(std::size_t slot) noexcept override;
    void write(std::size_t slot, std::size_t unit, const Unit& bytes) noexcept override;
    /// A control period goes by.
    void tick() noexcept { waits_ -= waits_ > 0 ? 1 : 0; }

private:
    void keep(std::size_t offset, std::span<const std::uint8_t> bytes) noexcept;

    std::filesystem::path path_;
    std::array<std::array<std::uint8_t, kSlotBytes>, kSlots> slots_{};
    int waits_ = 0;
};

/// What a controller starts with.
struct StartingMachine {
    MachineConfig machine;
    std::uint32_t generation = 0;  ///< of the stored parameters that it is; 0: it is the board's own
};
/// The parameters that the memory keeps, if they are whole and of this layout and a controller can run with them; else
/// `built_in`.
[[nodiscard]] StartingMachine starting_machine(const ParameterMemory& memory, const MachineConfig& built_in);

}  // namespace sc::sim
