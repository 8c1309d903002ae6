// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "tests/stm32h743/model/byte_dma.hpp"
#include "tests/stm32h743/model/machine.hpp"
#include "tests/stm32h743/model/register_words.hpp"

/// A USART, asynchronous, 8 data bits, without its FIFOs: bit times, driver enable, receiver timeout, idle line,
/// errors.

namespace sc::model {

/// Offsets from the base of an instance.
namespace usart_at {
inline constexpr std::uint32_t cr1 = 0x00;
inline constexpr std::uint32_t cr2 = 0x04;
inline constexpr std::uint32_t cr3 = 0x08;
inline constexpr std::uint32_t brr = 0x0C;
inline constexpr std::uint32_t rtor = 0x14;
inline constexpr std::uint32_t isr = 0x1C;
inline constexpr std::uint32_t icr = 0x20;
inline constexpr std::uint32_t rdr = 0x24;
inline constexpr std::uint32_t tdr = 0x28;
}  // namespace usart_at

class UsartModel : public Peripheral {
public:
    static constexpr std::uint32_t kSize = 0x400;
    struct Instance {
        std::uint32_t base;
        std::uint32_t clock_at;  ///< in RCC
        std::uint32_t clock;
        unsigned interrupt;
        std::uint32_t rx_request;
        std::uint32_t tx_request;
    };
    static constexpr Instance kUsart2{0x40004400, rcc::kApb1l, rcc::kUsart2, 38, 43, 44};
    static constexpr Instance kUsart3{0x40004800, rcc::kApb1l, rcc::kUsart3, 39, 45, 46};
    static constexpr Instance kUsart6{0x40011400, rcc::kApb2, rcc::kUsart6, 71, 71, 72};

    /// What was seen on the line that it drives.
    struct Sent {
        std::uint8_t byte = 0;
        std::int64_t begin_ns = 0;  ///< of the start bit
        std::int64_t end_ns = 0;    ///< of the stop bit
    };
    struct Window {
        std::int64_t begin_ns = 0;
        std::int64_t end_ns = kNever;
    };
    enum Wrong : std::uint32_t { parity = 1, framing = 2, noise = 4 };

    /// `dma` may be null. `kernel_hz` 0: the kernel clock stands.
    UsartModel(Machine& machine, const RegisterWords& clocks, ByteDma* dma, const Instance& instance,
               std::int64_t kernel_hz = 120'000'000);
    void set_kernel_hz(std::int64_t hz) { kernel_hz_ = hz; }

    /// Its transceiver hears what it sends.
    void set_echo(bool on) { echo_ = on; }
    /// A byte comes on the line, its start bit at `begin_ns`, not before the end of the last one. `wrong`: Wrong bits.
    void arrives(std::uint8_t byte, std::int64_t begin_ns, std::uint32_t wrong = 0);
    /// One after the other from now on, at the rate that the registers have.
    void arrive_from(std::int64_t begin_ns, const std::vector<std::uint8_t>& bytes);
    [[nodiscard]] std::int64_t bit_ns() const;
    [[nodiscard]] std::int64_t character_ns() const;
    [[nodiscard]] const std::vector<Sent>& sent() const { return sent_; }
    /// When the driver of the line was on.
    [[nodiscard]] const std::vector<Window>& driven() const { return driven_; }
    /// Bytes that came while it drove the line itself.
    [[nodiscard]] unsigned collisions() const { return collisions_; }

    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t now_ns) override;

private:
    struct Coming {
        std::uint8_t byte = 0;
        std::uint32_t wrong = 0;
        std::int64_t begin_ns = 0;
        std::int64_t end_ns = 0;
        bool heard = true;  ///< the receiver was on at the start bit
        bool begun = false;
        bool own = false;  ///< what it sends itself
    };
    void comes(const Coming& coming);
    void note(const std::string& what);
    [[nodiscard]] bool on(std::uint32_t bits) const { return (words_.at(0) & (bits | 1U)) == (bits | 1U); }
    [[nodiscard]] std::int64_t sixteenths(std::uint32_t first) const;
    void write_protected(std::uint32_t offset, std::uint32_t value, std::uint32_t frozen);
    void transmit(std::uint32_t value);
    void load();
    void sent_one(std::int64_t now_ns);
    void receive_one(const Coming& coming);
    void pump();
    void signal();

    Machine& machine_;
    const RegisterWords& clocks_;
    ByteDma* dma_;
    Instance instance_;
    std::int64_t kernel_hz_;
    std::array<std::uint32_t, 16> words_{};
    std::uint32_t flags_ = 0xC0;  ///< TXE, TC
    bool holding_ = false;        ///< TDR
    std::uint8_t held_ = 0;
    bool shifting_ = false;
    Sent shift_;
    std::int64_t release_ns_ = kNever;
    std::vector<Sent> sent_;
    std::vector<Window> driven_;
    std::deque<Coming> coming_;
    std::int64_t idle_ns_ = kNever;
    std::int64_t timeout_ns_ = kNever;
    unsigned collisions_ = 0;
    bool echo_ = false;
    std::int64_t last_signal_ns_ = -1;
    unsigned signals_ = 0;
};

}  // namespace sc::model
