// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "tests/stm32h743/model/clock_fields.hpp"
#include "tests/stm32h743/model/machine.hpp"

/// The core's interrupt controller with 150 interrupts and four bits of priority. Numbers:
/// tests/data/stm32h743/nvic.csv.

namespace sc::model {

namespace nvic_fields {

inline constexpr std::uint32_t kNvic = 0xE000E100;
inline constexpr std::uint32_t kScb = 0xE000ED00;
inline constexpr Field kEnable{"NVIC_ISER0", "SETENA", kNvic + 0x000, 0, 32};
inline constexpr Field kDisable{"NVIC_ICER0", "CLRENA", kNvic + 0x080, 0, 32};
inline constexpr Field kForget{"NVIC_ICPR0", "CLRPEND", kNvic + 0x180, 0, 32};
inline constexpr Field kPriority{"NVIC_IPR0", "PRI_N0", kNvic + 0x300, 4, 4};
inline constexpr Field kPend{"SCB_ICSR", "PENDSVSET", kScb + 0x04, 28, 1};
inline constexpr Field kGroup{"SCB_AIRCR", "PRIGROUP", kScb + 0x0C, 8, 3};
inline constexpr Field kKey{"SCB_AIRCR", "VECTKEY", kScb + 0x0C, 16, 16};
inline constexpr Field kMemory{"SCB_SHPR1", "PRI_4", kScb + 0x18, 4, 4};
inline constexpr Field kPendSv{"SCB_SHPR3", "PRI_14", kScb + 0x20, 20, 4};
inline constexpr std::array kAll{kEnable, kDisable, kForget, kPriority, kPend, kGroup, kKey, kMemory, kPendSv};

}  // namespace nvic_fields

class InterruptControl {
public:
    static constexpr unsigned kInterrupts = 150;

    explicit InterruptControl(Machine& machine);
    [[nodiscard]] bool enabled(unsigned number) const { return enabled_.at(number); }
    [[nodiscard]] bool pending(unsigned number) const { return pending_.at(number); }
    [[nodiscard]] bool servo_asked() const { return servo_asked_; }
    /// Larger waits.
    [[nodiscard]] unsigned priority(unsigned number) const { return priority_.at(number) >> 4U; }
    [[nodiscard]] unsigned servo_priority() const { return servo_priority_ >> 4U; }
    [[nodiscard]] std::uint32_t fault_priorities() const { return fault_priorities_; }
    [[nodiscard]] bool all_bits_preempt() const { return group_ <= 3; }
    /// As a boot loader leaves it.
    void preset(unsigned number, bool enabled, bool pending, std::uint8_t priority);

private:
    class Face : public Peripheral {
    public:
        Face(InterruptControl& control, std::uint32_t base) : control_(control), base_(base) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t /*offset*/) override { return 0; }
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override {
            control_.write(base_ + offset, value, bytes);
        }

    private:
        InterruptControl& control_;
        std::uint32_t base_;
    };
    void write(std::uint32_t at, std::uint32_t value, unsigned bytes);
    void write_bits(std::uint32_t at, std::uint32_t value);
    void say(const std::string& what) { machine_.violation("interrupts: " + what); }

    Machine& machine_;
    Face nvic_, scb_;
    std::array<bool, kInterrupts> enabled_{};
    std::array<bool, kInterrupts> pending_{};
    std::array<bool, kInterrupts> set_{};  ///< its priority was given
    std::array<std::uint8_t, kInterrupts> priority_{};
    std::uint32_t group_ = 7;
    std::uint32_t fault_priorities_ = 0x00F0'F0F0;
    std::uint8_t servo_priority_ = 0;
    bool servo_asked_ = false;
};

}  // namespace sc::model
