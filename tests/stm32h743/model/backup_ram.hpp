// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/stm32h743/model/core.hpp"
#include "tests/stm32h743/model/machine.hpp"

/// The RAM with a battery, its clock, its write protection, its regulator and its ECC. Numbers:
/// tests/data/stm32h743/backup_ram.csv.

namespace sc::model {

class BackupRam {
public:
    static constexpr std::uint32_t kRam = 0x38800000;
    static constexpr std::uint32_t kBytes = 4096;
    static constexpr std::uint32_t kClocks = 0x580244E0;
    static constexpr std::uint32_t kPower = 0x58024800;
    static constexpr std::uint32_t kPowerControl1 = 0x00;
    static constexpr std::uint32_t kPowerControl2 = 0x08;
    /// REGISTER.FIELD.
    static const std::map<std::string, std::uint32_t> kMasks;

    BackupRam(Machine& machine, Core& core);

    /// All off and on again: what the RAM holds is lost unless its regulator was ready.
    void power_cycle();
    /// A word whose ECC has more errors than it can put right.
    void spoil(std::uint32_t offset) { lost_.at(offset / 4) = true; }
    /// As the processor's plain loads and stores see it.
    [[nodiscard]] std::array<std::uint8_t, kBytes>& bytes() { return bytes_; }
    [[nodiscard]] bool whole() const;

    std::int64_t regulator_ns = 200'000;  ///< until it is ready; negative: never
    bool access_stuck = false;            ///< the protection cannot be taken off

private:
    struct Clocks final : Peripheral {
        explicit Clocks(BackupRam& ram) : ram_(ram) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
        BackupRam& ram_;
    };
    struct Power final : Peripheral {
        explicit Power(BackupRam& ram) : ram_(ram) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
        BackupRam& ram_;
    };
    struct Cells final : Peripheral {
        explicit Cells(BackupRam& ram) : ram_(ram) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
        BackupRam& ram_;
    };
    [[nodiscard]] bool regulator_ready() const;

    Machine& machine_;
    Core& core_;
    std::array<std::uint8_t, kBytes> bytes_{};
    std::vector<bool> lost_;
    std::uint32_t clocks_ = 0;
    std::uint32_t control1_ = 0;
    bool regulator_ = false;
    std::int64_t regulator_on_ns_ = 0;
    Clocks clocks_registers_{*this};
    Power power_{*this};
    Cells cells_{*this};
};

}  // namespace sc::model
