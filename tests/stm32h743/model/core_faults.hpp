// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "tests/stm32h743/model/clock_tree.hpp"

/// What a fault handler meets: the core's fault status, ports whose pins somebody drives, the main output of TIM1, and
/// backup RAM with its clock, its lock and its buffer. Numbers: tests/data/stm32h743/fault.csv.

namespace sc::model {

namespace fault_fields {

inline constexpr std::uint32_t kScb = 0xE000ED00;
inline constexpr std::uint32_t kPortE = 0x58021000;
inline constexpr std::uint32_t kPortF = 0x58021400;
inline constexpr std::uint32_t kTim1 = 0x40010000;
inline constexpr Field kResetRequest{"SCB_AIRCR", "SYSRESETREQ", kScb + 0x0C, 2, 1};
inline constexpr Field kVectKey{"SCB_AIRCR", "VECTKEY", kScb + 0x0C, 16, 16};
inline constexpr Field kMemFaultEna{"SCB_SHCSR", "MEMFAULTENA", kScb + 0x24, 16, 1};
inline constexpr Field kBusFaultEna{"SCB_SHCSR", "BUSFAULTENA", kScb + 0x24, 17, 1};
inline constexpr Field kUsgFaultEna{"SCB_SHCSR", "USGFAULTENA", kScb + 0x24, 18, 1};
inline constexpr Field kMmarValid{"SCB_CFSR", "MMARVALID", kScb + 0x28, 7, 1};
inline constexpr Field kBfarValid{"SCB_CFSR", "BFARVALID", kScb + 0x28, 15, 1};
inline constexpr Field kForced{"SCB_HFSR", "FORCED", kScb + 0x2C, 30, 1};
inline constexpr Field kMmfar{"SCB_MMFAR", "ADDRESS", kScb + 0x34, 0, 32};
inline constexpr Field kBfar{"SCB_BFAR", "ADDRESS", kScb + 0x38, 0, 32};
inline constexpr Field kAbfsr{"SCB_ABFSR", "AXIM", kScb + 0x2A8, 3, 1};
inline constexpr Field kModerE{"GPIOE_MODER", "MODE15", kPortE + 0x00, 30, 2};
inline constexpr Field kResetE{"GPIOE_BSRR", "BR0", kPortE + 0x18, 16, 1};
inline constexpr Field kModerF{"GPIOF_MODER", "MODE15", kPortF + 0x00, 30, 2};
inline constexpr Field kResetF{"GPIOF_BSRR", "BR0", kPortF + 0x18, 16, 1};
inline constexpr Field kMainOutput{"TIM1_BDTR", "MOE", kTim1 + 0x44, 15, 1};
inline constexpr std::array kAll{kResetRequest, kVectKey, kMemFaultEna, kBusFaultEna, kUsgFaultEna, kMmarValid,
                                 kBfarValid,    kForced,  kMmfar,       kBfar,        kAbfsr,       kModerE,
                                 kResetE,       kModerF,  kResetF,      kMainOutput};
inline constexpr std::uint32_t kBackupRam = 0x38800000;
inline constexpr std::uint32_t kBackupBytes = 4096;

}  // namespace fault_fields

/// 4 KB, kept through resets. A write waits in a buffer until the next one; a reset loses it.
class BackupRam : public Peripheral {
public:
    BackupRam(Machine& machine, ClockTree& tree);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    void reset();
    /// Power goes after so many further writes.
    void cut_after(std::uint32_t writes) { left_ = writes; }
    void flip(std::uint32_t offset, unsigned bit) { words_.at(offset / 4) ^= 1U << bit; }
    void fill(std::uint32_t value) { words_.fill(value); }

private:
    void flush();
    Machine& machine_;
    ClockTree& tree_;
    std::array<std::uint32_t, fault_fields::kBackupBytes / 4> words_{};
    std::optional<std::uint32_t> waiting_at_;
    std::uint32_t waiting_ = 0;
    std::uint32_t left_ = ~0U;
};

/// One port: what its pins are at.
class OutputPort : public Peripheral {
public:
    OutputPort(Machine& machine, ClockTree& tree, std::uint32_t base, const Field& clock);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    /// What a timer or DMA drives on pins in alternate function.
    void drive(std::uint32_t pins) { driven_ = pins; }
    void preset(std::uint32_t modes, std::uint32_t outputs);
    /// Levels; a pin that is let go of is low, by its resistor.
    [[nodiscard]] std::uint32_t levels() const;
    [[nodiscard]] std::uint32_t modes() const { return modes_; }
    /// It is a violation when one of these rises from now on.
    void watch(std::uint32_t pins) { watched_ = pins; }

private:
    Machine& machine_;
    ClockTree& tree_;
    Field clock_;
    std::uint32_t modes_ = ~0U;
    std::uint32_t outputs_ = 0;
    std::uint32_t driven_ = 0;
    std::uint32_t watched_ = 0;
};

/// Registers that hold what is written, each write checked against what may change.
class CoreStatus : public Peripheral {
public:
    explicit CoreStatus(Machine& machine);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    void preset(std::uint32_t address, std::uint32_t value) { words_[address - fault_fields::kScb] = value; }
    [[nodiscard]] bool reset_requested() const { return reset_requested_; }
    [[nodiscard]] std::uint32_t word(std::uint32_t address) { return words_[address - fault_fields::kScb]; }

private:
    Machine& machine_;
    std::map<std::uint32_t, std::uint32_t> words_;
    bool reset_requested_ = false;
};

/// TIM1 as far as its outputs can be let go of: BDTR.
class MainOutput : public Peripheral {
public:
    MainOutput(Machine& machine, ClockTree& tree);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    void preset(std::uint32_t value) { bdtr_ = value; }

private:
    void check();
    Machine& machine_;
    ClockTree& tree_;
    std::uint32_t bdtr_ = 0;
};

}  // namespace sc::model
