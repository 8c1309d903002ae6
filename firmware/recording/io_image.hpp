// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "shared/wire/bytes.hpp"

/// Inputs and outputs of `Controller::servo_step` as bytes, the same on every core and compiler: little-endian, packed,
/// only what is in use. What a log holds, and what passes between a PC and a board in lock-step. No heap.

namespace sc::recording {

inline constexpr std::size_t kDriveFrameBytes = 2 + 1 + 8;
inline constexpr std::size_t kEncoderBytes = 1 + 4 + 8 * kAxisCount;
inline constexpr std::size_t kSensorByteBytes = 1 + 1 + 2;
inline constexpr std::size_t kInputsImageCapacity =
    8 + 2 + 2 + 1 + 2 + kLinkBytesPerTick + 2 + kDriveFramesPerTick * kDriveFrameBytes + 1 + kSourceBytesPerTick +
    kEncoderBytes + kSensorBuses * (1 + kSensorBytesPerTick * kSensorByteBytes);
inline constexpr std::size_t kLaserRunBytes = 8 + 8 + 4 + 2 + 1 + 1 + 2;
inline constexpr std::size_t kPathPulseBytes = 4 + 1 + 1 + 4 + 8 + 24 + 8;
inline constexpr std::size_t kGalvoFrameBytes = 8 + 8 + 4 + 4;
inline constexpr std::size_t kOutputsImageCapacity =
    2 + kLinkBytesPerTick + 2 + kDriveFramesPerTick * kDriveFrameBytes + 4 * 8 + 1 +
    kGalvoFramesPerTick * kGalvoFrameBytes + 2 + kLaserRunsPerTick * kLaserRunBytes + 2 +
    kPathPulsesPerTick * kPathPulseBytes + 1 + kSourceBytesPerTick + kSensorBuses * (1 + 4 + kSensorTransmissionBytes) +
    1 + 1 + 1 + 8;

/// Digital inputs as they are stored: eight lines from bit 0 on in the order of the structure, then the source's pins.
[[nodiscard]] constexpr std::uint16_t bits_of(const DigitalInputs& d) noexcept {
    return static_cast<std::uint16_t>(
        (d.estop_closed ? 1U : 0U) | (d.interlock_closed ? 2U : 0U) | (d.laser_ready ? 4U : 0U) |
        (d.laser_no_alarm ? 8U : 0U) | (d.shutter_open ? 16U : 0U) | (d.shutter_closed ? 32U : 0U) |
        (d.key_setup ? 64U : 0U) | (d.key_production ? 128U : 0U) | (d.source_status & 0xFU) << 8U);
}
[[nodiscard]] constexpr DigitalInputs digital_inputs(std::uint16_t bits) noexcept {
    const auto bit = [bits](unsigned i) noexcept { return (bits >> i & 1U) != 0; };
    return {
        bit(0), bit(1), bit(2), bit(3), bit(4), bit(5), bit(6), bit(7), static_cast<std::uint8_t>(bits >> 8U & 0xFU)};
}

/// A flag, and the rest when it is 1.
void put(ByteWriter& out, const EncoderInputs& encoders) noexcept;
[[nodiscard]] EncoderInputs get_encoders(ByteReader& in) noexcept;

/// Inputs together with the memory that their spans point into. Not to be copied: the spans point into this object.
struct StoredInputs {
    StoredInputs() = default;
    StoredInputs(const StoredInputs&) = delete;
    StoredInputs& operator=(const StoredInputs&) = delete;

    ServoInputs inputs;
    std::array<std::uint8_t, kLinkBytesPerTick> link_rx{};
    std::array<DriveFrame, kDriveFramesPerTick> drive_rx{};
    std::array<std::uint8_t, kSourceBytesPerTick> source_rx{};
    std::array<std::array<SensorByte, kSensorBytesPerTick>, kSensorBuses> sensor_rx{};
};

/// Bytes written; 0 if `out` is too small (kInputsImageCapacity never is) or the inputs hold more than a tick may.
[[nodiscard]] std::size_t pack(const ServoInputs& inputs, std::span<std::uint8_t> out) noexcept;
/// False, with `stored` unspecified, if the bytes are not exactly one image.
[[nodiscard]] bool unpack(std::span<const std::uint8_t> bytes, StoredInputs& stored) noexcept;

/// Parts of the outputs' image, in its order.
enum class OutputPart : std::uint8_t {
    link,        ///< bytes to the host
    drives,      ///< frames on the drive bus
    set_points,  ///< of the axes
    mirrors,     ///< galvo frames
    laser,       ///< runs of triggers
    pulses,      ///< the same pulses in the path domain
    lines,       ///< bytes to the source and the sensors, digital outputs, gate, state, faults
};
inline constexpr std::size_t kOutputParts = 7;
/// Where in an image each part ends.
using OutputPartEnds = std::array<std::size_t, kOutputParts>;

/// Bytes written; 0 if `out` is too small (kOutputsImageCapacity never is).
[[nodiscard]] std::size_t pack(const ServoOutputs& outputs, std::span<std::uint8_t> out) noexcept;
/// The same, and where the parts end.
[[nodiscard]] std::size_t pack(const ServoOutputs& outputs, std::span<std::uint8_t> out, OutputPartEnds& ends) noexcept;
/// False, with `outputs` unspecified, if the bytes are not exactly one image. What is not in use is left as it was.
[[nodiscard]] bool unpack(std::span<const std::uint8_t> bytes, ServoOutputs& outputs) noexcept;

/// Empties what a tick fills by appending, as servo_step expects it.
void clear(ServoOutputs& outputs) noexcept;

}  // namespace sc::recording
