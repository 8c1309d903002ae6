// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "tests/stm32h743/model/clock_fields.hpp"
#include "tests/stm32h743/model/machine.hpp"

/// RCC, PWR, the wait states of the flash and the overdrive: computes the frequencies from the registers, and notes
/// what the chip forbids.

namespace sc::model {

/// What does not work.
struct ClockFaultsOfChip {
    bool no_hse = false;
    bool no_supply = false;  ///< ACTVOSRDY stays low
    bool no_scale1 = false;
    bool no_scale0 = false;
    bool no_pll1 = false;
    bool no_pll2 = false;
    bool no_switch = false;  ///< the core stays on what it has
    bool deaf_flash = false;
    std::uint32_t revision = 0x2003;
};

class ClockTree {
public:
    using Faults = ClockFaultsOfChip;
    explicit ClockTree(Machine& machine, Faults faults = {});

    [[nodiscard]] double core_hz() const { return system_hz() / divider(field(clock_fields::kD1cpre)); }
    [[nodiscard]] double hclk_hz() const { return core_hz() / divider(field(clock_fields::kHpre)); }
    [[nodiscard]] double apb_hz(unsigned number) const;    ///< 1 to 4
    [[nodiscard]] double timer_hz(unsigned number) const;  ///< of APB 1 or 2
    [[nodiscard]] double fdcan_hz() const;                 ///< 0: none
    [[nodiscard]] double usart_hz(bool usart16) const;
    [[nodiscard]] int scale() const;  ///< 0 to 3, in force
    [[nodiscard]] bool on(const Field& one) const { return field(one) != 0; }
    /// Its clock was read back after it was switched on.
    [[nodiscard]] bool settled(const Field& clock) const {
        const auto found = settled_.find(clock.address);
        return found != settled_.end() && (found->second & clock.mask()) != 0;
    }
    /// As a boot loader leaves it.
    void preset(const Field& one, std::uint32_t value) { put(one, value); }
    /// 400 MHz at VOS1 from PLL1 on HSE, with the wait states for that, as a boot loader leaves it.
    void preset_running();
    /// The same at VOS0.
    void preset_overdrive();

private:
    class Face : public Peripheral {
    public:
        Face(ClockTree& tree, std::uint32_t base) : tree_(tree), base_(base) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override { return tree_.read(base_ + offset); }
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override {
            tree_.write(base_ + offset, value, bytes);
        }

    private:
        ClockTree& tree_;
        std::uint32_t base_;
    };

    struct PllFields {
        Field on, ready, m, fraction, medium, range, p_on, q_on, r_on, n, p, q, r;
    };
    static const std::array<PllFields, 2> kPlls;

    [[nodiscard]] std::uint32_t read(std::uint32_t at);
    void write(std::uint32_t at, std::uint32_t value, unsigned bytes);
    void settle();
    void write_cr(std::uint32_t value);
    void write_cfgr(std::uint32_t value);
    void write_scale(std::uint32_t value);
    void write_supply(std::uint32_t value);
    void write_syscfg(std::uint32_t value);
    void write_pll(std::uint32_t at, std::uint32_t value);
    void write_fdcan(std::uint32_t value);
    void start_pll(unsigned number);
    void check_limits(const std::string& after);
    [[nodiscard]] double source_hz() const;
    [[nodiscard]] double vco_hz(unsigned number) const;
    [[nodiscard]] double system_hz() const;
    [[nodiscard]] bool may_set_pll(unsigned number) const;
    [[nodiscard]] static double divider(std::uint32_t prescaler);      ///< of the core and HCLK
    [[nodiscard]] static double apb_divider(std::uint32_t prescaler);  ///< of an APB
    [[nodiscard]] std::uint32_t word(std::uint32_t at) const;
    [[nodiscard]] std::uint32_t field(const Field& one) const { return (word(one.address) & one.mask()) >> one.first; }
    void put(const Field& one, std::uint32_t value);
    void say(const std::string& what) { machine_.violation("clock tree: " + what); }

    Machine& machine_;
    Faults faults_;
    Face rcc_, pwr_, flash_, syscfg_, debug_;
    std::map<std::uint32_t, std::uint32_t> words_;
    std::int64_t hse_at_ = Peripheral::kNever;
    std::int64_t vos_at_ = Peripheral::kNever;
    std::int64_t switch_at_ = Peripheral::kNever;
    std::array<std::int64_t, 2> lock_at_{Peripheral::kNever, Peripheral::kNever};
    std::array<std::int64_t, 2> stop_at_{Peripheral::kNever, Peripheral::kNever};
    int scale_ = 3;
    int next_scale_ = 3;
    std::map<std::uint32_t, std::uint32_t> settled_;  ///< bits of ENR registers
};

}  // namespace sc::model
