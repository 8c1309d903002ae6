// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/drives/canopen.hpp"
#include "shared/drives/drive_plan.hpp"
#include "shared/machine/machine.hpp"

/// The objects that the master writes and checks in a drive between its boot-up and NMT start. docs/drives.md lists
/// them with their reasons.

namespace sc::drives {

/// The drives' own following-error check is the second line behind FollowingWatch. A drive compares with its present
/// demand, so its window holds the way made in the latency at full speed besides, and it trips later by this time.
inline constexpr std::uint32_t kDriveWindowTimeMs = 20;

struct SetupStep {
    enum class Kind : std::uint8_t {
        write,           ///< an abort fails the set-up
        write_optional,  ///< the object may be absent
        write_checked,   ///< written, read back and compared
        expect_bits,     ///< read; all bits of `value` must be set
        expect_value,    ///< read; must be `value`
    };
    canopen::ObjectKey key{};
    std::uint32_t value = 0;
    Kind kind = Kind::write;
};

/// The steps of one drive, in order: a table in constant memory, filled with the axis' few numbers.
class DriveSetup {
public:
    /// An empty list: nothing to write.
    DriveSetup() noexcept = default;
    /// For one axis of the machine. O(steps).
    DriveSetup(const MachineConfig& machine, std::size_t axis, const DrivePlan& plan = kPlainDrives) noexcept;

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    /// O(steps). Beyond the end: the first one.
    [[nodiscard]] SetupStep operator[](std::size_t i) const noexcept;

    /// Numbers that differ from axis to axis.
    enum class Number : std::uint8_t {
        none,
        master_watch,
        own_rpdo,
        target_rpdo,
        tpdo,
        first_target,
        second_target,
        status_every,
        cycle_us,
        cycle_ms,
        window,
        ramp,
        homing_method,
        search,
        creep,
        home,
        vendor,
        product,
        count
    };

private:
    void set(Number number, std::uint32_t value) noexcept { number_[static_cast<std::size_t>(number)] = value; }
    [[nodiscard]] bool holds(std::uint16_t when) const noexcept { return (when & ~present_) == 0; }

    std::array<std::uint32_t, static_cast<std::size_t>(Number::count)> number_{};
    std::uint16_t present_ = 0;  ///< conditions that hold
    std::uint8_t size_ = 0;
};

/// `value` rounded half away from zero and clamped to an int32; a value that is no number becomes 0.
[[nodiscard]] std::int32_t round_to_i32(double value) noexcept;
/// The same, clamped to an unsigned 32-bit number.
[[nodiscard]] std::uint32_t round_to_u32(double value) noexcept;

}  // namespace sc::drives
