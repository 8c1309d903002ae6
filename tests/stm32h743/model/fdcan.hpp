// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "tests/stm32h743/model/can_wire.hpp"
#include "tests/stm32h743/model/machine.hpp"
#include "tests/stm32h743/model/register_words.hpp"

/// FDCAN: bit timing, message RAM with a receive and a transmit FIFO, protected registers, error counters, bus-off. No
/// filter lists, dedicated buffers or event FIFO: their use is a violation.

namespace sc::model {

/// Offsets from the base of an instance.
namespace fdcan_at {
inline constexpr std::uint32_t endn = 0x04;
inline constexpr std::uint32_t dbtp = 0x0C;
inline constexpr std::uint32_t cccr = 0x18;
inline constexpr std::uint32_t nbtp = 0x1C;
inline constexpr std::uint32_t tscc = 0x20;
inline constexpr std::uint32_t tscv = 0x24;
inline constexpr std::uint32_t ecr = 0x40;
inline constexpr std::uint32_t psr = 0x44;
inline constexpr std::uint32_t tdcr = 0x48;
inline constexpr std::uint32_t ir = 0x50;
inline constexpr std::uint32_t ie = 0x54;
inline constexpr std::uint32_t ils = 0x58;
inline constexpr std::uint32_t ile = 0x5C;
inline constexpr std::uint32_t gfc = 0x80;
inline constexpr std::uint32_t sidfc = 0x84;
inline constexpr std::uint32_t xidfc = 0x88;
inline constexpr std::uint32_t rxf0c = 0xA0;
inline constexpr std::uint32_t rxf0s = 0xA4;
inline constexpr std::uint32_t rxf0a = 0xA8;
inline constexpr std::uint32_t rxesc = 0xBC;
inline constexpr std::uint32_t txbc = 0xC0;
inline constexpr std::uint32_t txfqs = 0xC4;
inline constexpr std::uint32_t txesc = 0xC8;
inline constexpr std::uint32_t txbrp = 0xCC;
inline constexpr std::uint32_t txbar = 0xD0;
}  // namespace fdcan_at

class FdcanModel;

/// The memory that both instances share; words only. Says who reads what holds no frame, and writes what is to be sent.
class FdcanRam : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x4000AC00;
    static constexpr std::uint32_t kBytes = 10240;
    FdcanRam(Machine& machine, const RegisterWords& clocks);
    void add(FdcanModel& user) { users_.push_back(&user); }
    [[nodiscard]] std::uint32_t word(std::uint32_t byte) const { return words_.at(byte / 4); }
    void set_word(std::uint32_t byte, std::uint32_t value) { words_.at(byte / 4) = value; }
    [[nodiscard]] const std::vector<FdcanModel*>& users() const { return users_; }
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;

private:
    Machine& machine_;
    const RegisterWords& clocks_;
    std::array<std::uint32_t, kBytes / 4> words_{};
    std::vector<FdcanModel*> users_;
};

class FdcanModel : public Peripheral, public CanNode {
public:
    static constexpr std::uint32_t kFdcan1 = 0x4000A000;
    static constexpr std::uint32_t kFdcan2 = 0x4000A400;
    static constexpr std::uint32_t kSize = 0x400;
    static constexpr unsigned kFdcan1Line0 = 19;
    static constexpr unsigned kFdcan2Line0 = 20;

    /// `kernel_hz` 0: the kernel clock stands.
    FdcanModel(Machine& machine, const RegisterWords& clocks, FdcanRam& ram, CanWire& wire, std::uint32_t base,
               std::int64_t kernel_hz = 80'000'000);
    /// From its transmit pin through the transceiver to its receive pin.
    void set_loop_delay_ns(std::int64_t ns) { loop_delay_ns_ = ns; }
    void set_kernel_hz(std::int64_t hz) { kernel_hz_ = hz; }
    /// What software sees of a register, without the effects of reading.
    [[nodiscard]] std::uint32_t peek(std::uint32_t offset) const { return words_.at(offset / 4); }

    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;

    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t /*now_ns*/) override { settle(); }

    [[nodiscard]] std::int64_t ready_ns() const override;
    [[nodiscard]] std::optional<WireFrame> wants() const override;
    [[nodiscard]] WireRates rates() const override;
    [[nodiscard]] bool hears_own_fast_bits() const override;
    void sent() override;
    void heard(const WireFrame& frame, std::int64_t began_ns) override;
    void failed(bool sender, WireError error) override;

    struct Part {
        std::uint32_t begin = 0;
        std::uint32_t element = 0;  ///< bytes
        std::uint32_t count = 0;
        [[nodiscard]] std::uint32_t end() const { return begin + element * count; }
        [[nodiscard]] bool holds(std::uint32_t byte) const { return byte >= begin && byte < end(); }
    };
    [[nodiscard]] Part receive_part() const;
    [[nodiscard]] Part send_part() const;
    [[nodiscard]] bool running() const { return !init_; }
    [[nodiscard]] bool has_frame(std::uint32_t index) const;
    [[nodiscard]] bool waits_to_send(std::uint32_t index) const { return (pending_ >> index & 1U) != 0; }

private:
    void note(const std::string& what);
    void settle();
    void write_control(std::uint32_t value);
    void set_init(bool on);
    void check_settings();
    void check_timing();
    void add_requests(std::uint32_t requests);
    void take_back(std::uint32_t index);
    void store(const WireFrame& frame, std::int64_t began_ns);
    void flag(std::uint32_t bit);
    [[nodiscard]] std::uint32_t stamp(std::int64_t ns) const;
    [[nodiscard]] std::int64_t bit_ns() const;
    [[nodiscard]] std::uint32_t& word(std::uint32_t offset) { return words_.at(offset / 4); }

    Machine& machine_;
    const RegisterWords& clocks_;
    FdcanRam& ram_;
    CanWire& wire_;
    std::uint32_t base_;
    std::int64_t kernel_hz_;
    std::int64_t loop_delay_ns_ = 200;
    std::array<std::uint32_t, kSize / 4> words_{};
    bool init_ = true;
    bool init_asked_ = true;
    std::int64_t init_at_ns_ = 0;  ///< when what was asked is in force
    bool change_enable_ = false;
    bool bus_off_ = false;
    std::int64_t ready_ns_ = 0;
    std::int64_t stamp_from_ns_ = 0;
    std::uint32_t rx_get_ = 0;
    std::uint32_t rx_fill_ = 0;
    bool rx_lost_ = false;
    std::uint32_t tx_get_ = 0;
    std::uint32_t tx_fill_ = 0;
    std::uint32_t pending_ = 0;
    std::uint32_t tx_errors_ = 0;
    std::uint32_t rx_errors_ = 0;
    std::uint32_t logged_ = 0;
    std::uint32_t last_error_ = 0;
};

}  // namespace sc::model
