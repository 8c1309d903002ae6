// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/stm32h743/model/optics.hpp"
#include "tests/stm32h743/model/slow_lines.hpp"

/// SPI3 as a receiving slave on PC10 (clock) and PC12 (data), with DMA for each word. Numbers:
/// tests/data/stm32h743/status.csv.

namespace sc::model {

class StatusSpi : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40003C00;
    static constexpr std::uint32_t kRequest = 61;
    /// Attaches itself; port C is looked at for its pins.
    StatusSpi(Machine& machine, const ClockGates& clocks, DmaModel& dma, const SlowPort& port_c);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;

    /// A rising edge of the clock pin, with the level of the data pin.
    void clock(bool data);

private:
    void note(const std::string& what) { machine_.violation("SPI3: " + what); }
    [[nodiscard]] bool enabled() const { return (words_[0] & 1U) != 0; }
    Machine& machine_;
    const ClockGates& clocks_;
    DmaModel& dma_;
    const SlowPort& port_;
    std::array<std::uint32_t, 24> words_{};
    std::uint32_t shift_ = 0;
    unsigned bits_ = 0;
    std::uint32_t received_ = 0;
    bool waits_ = false;  ///< a word has come and was not read
};

/// A head's status line: 20 bits with the galvo's clock, the status word between three bits and a parity bit.
class StatusLine {
public:
    explicit StatusLine(StatusSpi& spi) : spi_(spi) {}
    void set(std::uint16_t status) { next_ = status; }
    /// The line hangs at one level.
    void hang(bool on, bool level = false) {
        hangs_ = on;
        level_ = level;
    }
    /// A clock that the head did not see.
    void slip() { ++bit_; }
    /// A rising edge of the galvo's clock.
    void clock();

private:
    StatusSpi& spi_;
    std::uint16_t next_ = 0;
    std::uint32_t frame_ = 0;
    unsigned bit_ = 0;
    bool hangs_ = false;
    bool level_ = false;
};

}  // namespace sc::model
