// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"

/// Inputs and outputs of `Controller::servo_step` as bytes, the same on every core and compiler: little-endian, packed,
/// only what is in use. What a log holds, and what passes between a PC and a board in lock-step. No heap.

namespace sc::recording {

inline constexpr std::size_t kDriveFrameBytes = 2 + 1 + 8;
inline constexpr std::size_t kInputsImageCapacity =
    8 + 1 + 2 + 1 + 2 + kLinkBytesPerTick + 2 + kDriveFramesPerTick * kDriveFrameBytes;
inline constexpr std::size_t kLaserRunBytes = 8 + 8 + 4 + 2 + 1 + 1;
inline constexpr std::size_t kPathPulseBytes = 4 + 1 + 1 + 4 + 8 + 24 + 8;
inline constexpr std::size_t kGalvoFrameBytes = 8 + 8 + 4 + 4;
inline constexpr std::size_t kOutputsImageCapacity =
    2 + kLinkBytesPerTick + 2 + kDriveFramesPerTick * kDriveFrameBytes + 4 * 8 + 1 +
    kGalvoFramesPerTick * kGalvoFrameBytes + 2 + kLaserRunsPerTick * kLaserRunBytes + 2 +
    kPathPulsesPerTick * kPathPulseBytes + 1 + 1 + 1 + 8;

/// Inputs together with the memory that their spans point into. Not to be copied: the spans point into this object.
struct StoredInputs {
    StoredInputs() = default;
    StoredInputs(const StoredInputs&) = delete;
    StoredInputs& operator=(const StoredInputs&) = delete;

    ServoInputs inputs;
    std::array<std::uint8_t, kLinkBytesPerTick> link_rx{};
    std::array<DriveFrame, kDriveFramesPerTick> drive_rx{};
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
    lines,       ///< digital outputs, gate, state, faults
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
