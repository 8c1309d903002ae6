// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "boards/stm32h743/link/can_frame.hpp"
#include "boards/stm32h743/registers/fdcan.hpp"

namespace sc::stm32h743 {

/// Times in quanta of the kernel clock / prescaler: one quantum, then `before`, the sample point, then `after`.
struct BitTiming {
    std::uint32_t prescaler = 1;
    std::uint32_t before = 0;
    std::uint32_t after = 0;
    std::uint32_t jump = 0;
    [[nodiscard]] constexpr std::uint32_t rate(std::uint32_t kernel_hz) const noexcept {
        return kernel_hz / (prescaler * (1 + before + after));
    }
};

struct FdcanSettings {
    Address base = 0;
    std::uint32_t ram = 0;       ///< byte in the message RAM where its part begins
    std::uint32_t rx_count = 0;  ///< frames in receive FIFO 0, up to 64
    std::uint32_t tx_count = 0;  ///< frames in the transmit FIFO, up to 32
    bool fd = false;             ///< FD frames with rate switch, elements of 64 bytes; else classic, 8 bytes
    BitTiming nominal;
    BitTiming data;
    [[nodiscard]] constexpr std::uint32_t element_bytes() const noexcept { return 8U + (fd ? 64U : 8U); }
    [[nodiscard]] constexpr std::uint32_t tx_ram() const noexcept { return ram + rx_count * element_bytes(); }
    [[nodiscard]] constexpr std::uint32_t end() const noexcept { return tx_ram() + tx_count * element_bytes(); }
};

inline constexpr std::uint32_t kFdcanKernelHz = 80'000'000;
/// Sample points 80 % of a nominal bit, 75 % of a fast one.
inline constexpr BitTiming kNominal1M{1, 63, 16, 16};
inline constexpr BitTiming kData5M{1, 11, 4, 4};
inline constexpr FdcanSettings kHostCan{fdcan::kFdcan1, 0, 64, 32, true, kNominal1M, kData5M};
inline constexpr FdcanSettings kDriveCan{fdcan::kFdcan2, kHostCan.end(), 64, 32, false, kNominal1M, {}};

static_assert(kNominal1M.rate(kFdcanKernelHz) == 1'000'000 && kData5M.rate(kFdcanKernelHz) == 5'000'000);
static_assert(kHostCan.end() == kDriveCan.ram && kDriveCan.end() <= fdcan::kMessageRamBytes);

/// An FDCAN as a port. Filters let all frames into receive FIFO 0, which holds 64: at 1 Mbit/s more than two ticks of
/// 1 ms of the shortest frames. Frames leave in the order in which they were given. One context at a time. Wants the
/// kernel clock (80 MHz) selected and the pins set before start.
class Fdcan {
public:
    using Frame = CanFrame;
    enum class Start : std::uint8_t {
        ok,
        absent,       ///< the register of known content reads otherwise
        no_init,      ///< did not stop for configuration: no kernel clock
        not_entered,  ///< did not leave initialisation: no kernel clock
        refused,      ///< a setting did not stay
    };
    /// Bus-off lasts at least so long, so that a broken bus is not disturbed all the time; then 129 times 11 recessive
    /// bits follow, which the hardware counts.
    static constexpr std::int64_t kBusOffNs = 100'000'000;

    explicit Fdcan(const FdcanSettings& settings) noexcept : settings_(settings) {}

    /// At most some 100 us; may be called again.
    [[nodiscard]] Start start() noexcept;
    /// Some 20 register accesses with 64 bytes.
    [[nodiscard]] CanSent send(const CanFrame& frame) noexcept;
    /// The oldest frame; false when none waits.
    [[nodiscard]] bool receive(CanFrame& out) noexcept;
    /// Once a tick: counters, state, and the way back from bus-off. Frames that waited for the bus when it went off
    /// are dropped, for they are stale.
    void service(std::int64_t now_ns) noexcept;
    /// Asks for an interrupt on line 0 for each frame received, and for each change of bus-off.
    void use_interrupt() noexcept;
    /// To be called by the handler of line 0: takes back what has been signalled. True: frames are there.
    [[nodiscard]] bool acknowledge() noexcept;

    [[nodiscard]] BusState state() const noexcept { return state_; }
    [[nodiscard]] const CanCounters& counters() const noexcept { return counters_; }

private:
    [[nodiscard]] Address at(Address offset) const noexcept { return settings_.base + offset; }
    [[nodiscard]] bool configure() noexcept;
    [[nodiscard]] bool fits(const CanFrame& frame) const noexcept;
    void note_lost(std::uint32_t flags) noexcept;
    void restart() noexcept;

    FdcanSettings settings_;
    BusState state_ = BusState::down;
    CanCounters counters_;
    std::int64_t off_since_ns_ = 0;
    bool off_ = false;         ///< bus-off has been seen
    bool recovering_ = false;  ///< started again; the hardware counts recessive bits
};

}  // namespace sc::stm32h743
