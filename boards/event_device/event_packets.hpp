// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/hal/io.hpp"
#include "firmware/recording/io_image.hpp"
#include "shared/link/config.hpp"
#include "shared/machine/machine.hpp"

/// Packets between a controller and its event device. Each begins with a byte that says what it is; numbers are
/// little-endian.
///
///     controller: begin  (version u16, MachineConfig as shared/link/config.hpp)   once, first
///                 window (tick i64, ServoOutputs as firmware/recording/io_image.hpp)   each tick, in order
///                 veto   (GuardCause bits u8)   the guard's word between ticks: not 0 shuts the gate at once, 0 opens
///                 it
///     device:     status (tick i64, lines u16 as recording::bits_of, count u8, bytes of the source's serial port)
///                 after each window
///
/// The window of tick n acts in [t_n+1, t_n+2), its cancel_laser at once. No heap, any context.

namespace sc::event_device {

inline constexpr std::uint16_t kVersion = 1;
enum class Packet : std::uint8_t { begin = 1, window = 2, veto = 3, status = 64 };

inline constexpr std::size_t kBeginSize = 1 + 2 + link::kConfigSize;
inline constexpr std::size_t kWindowHead = 1 + 8;
inline constexpr std::size_t kPacketCapacity = kWindowHead + recording::kOutputsImageCapacity;
inline constexpr std::size_t kStatusCapacity = 1 + 8 + 2 + 1 + kSourceBytesPerTick;

/// How laser, source and shutter stand at t_tick+1, once the window before has been played.
struct Status {
    std::int64_t tick = -1;
    DigitalInputs lines{};  ///< laser_ready, laser_no_alarm, shutter_open, shutter_closed, source_status
    std::array<std::uint8_t, kSourceBytesPerTick> source{};
    std::size_t source_size = 0;
};

/// Bytes written; `out` has room for kBeginSize, kPacketCapacity, 2 and kStatusCapacity.
[[nodiscard]] std::size_t put_begin(const MachineConfig& machine, std::span<std::uint8_t> out) noexcept;
[[nodiscard]] std::size_t put_window(std::int64_t tick, const ServoOutputs& outputs,
                                     std::span<std::uint8_t> out) noexcept;
[[nodiscard]] std::size_t put_veto(std::uint8_t causes, std::span<std::uint8_t> out) noexcept;
[[nodiscard]] std::size_t put_status(const Status& status, std::span<std::uint8_t> out) noexcept;

/// What a packet is; nullopt if it is none.
[[nodiscard]] std::optional<Packet> kind_of(std::span<const std::uint8_t> bytes) noexcept;
/// False if the packet is not whole, of another version, or no controller can run with the machine.
[[nodiscard]] bool get_begin(std::span<const std::uint8_t> bytes, MachineConfig& machine) noexcept;
[[nodiscard]] bool get_window(std::span<const std::uint8_t> bytes, std::int64_t& tick, ServoOutputs& outputs) noexcept;
[[nodiscard]] bool get_veto(std::span<const std::uint8_t> bytes, std::uint8_t& causes) noexcept;
[[nodiscard]] bool get_status(std::span<const std::uint8_t> bytes, Status& status) noexcept;

}  // namespace sc::event_device
