// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/drives/canopen.hpp"
#include "shared/machine/machine.hpp"

/// The objects that the master writes and checks in a drive between its boot-up and NMT start. docs/drives.md lists
/// them with their reasons.

namespace sc::drives {

/// Homing by the home switch, first motion towards positive travel.
inline constexpr std::uint32_t kHomingMethod = 19;
/// The drives' own following-error check is the second line behind FollowingWatch. A drive compares with its present
/// demand, so its window holds the way made in the latency at full speed besides, and it trips later by this time.
inline constexpr std::uint32_t kDriveWindowTimeMs = 20;

struct SetupStep {
    enum class Kind : std::uint8_t {
        write,           ///< an abort fails the set-up
        write_optional,  ///< the object may be absent
        write_checked,   ///< written, read back and compared
        expect_bits,     ///< read; all bits of `value` must be set
    };
    canopen::ObjectKey key{};
    std::uint32_t value = 0;
    Kind kind = Kind::write;
};

/// A list of steps of fixed capacity.
class DriveSetup {
public:
    static constexpr std::size_t kCapacity = 48;
    /// An empty list: nothing to write.
    DriveSetup() noexcept = default;
    /// For one axis of the machine. O(steps).
    DriveSetup(const MachineConfig& machine, std::size_t axis) noexcept;

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] const SetupStep& operator[](std::size_t i) const noexcept { return steps_[i < size_ ? i : 0]; }

private:
    void add(SetupStep::Kind kind, std::uint16_t index, std::uint8_t sub, std::uint8_t size,
             std::uint32_t value) noexcept;
    void add_liveness(const MachineConfig& machine) noexcept;
    void add_pdos(std::uint8_t node) noexcept;
    void add_motion(const MachineConfig& machine, const AxisConfig& axis) noexcept;
    void add_homing(const AxisConfig& axis) noexcept;

    std::array<SetupStep, kCapacity> steps_{};
    std::size_t size_ = 0;
};

/// `value` rounded half away from zero and clamped to an int32; a value that is no number becomes 0.
[[nodiscard]] std::int32_t round_to_i32(double value) noexcept;
/// The same, clamped to an unsigned 32-bit number.
[[nodiscard]] std::uint32_t round_to_u32(double value) noexcept;

}  // namespace sc::drives
