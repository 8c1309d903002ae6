// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_configuration.hpp"

#include <bit>

#include "firmware/drives/axis402.hpp"
#include "firmware/drives/bus_budget.hpp"

namespace sc::drives {
namespace {

using Kind = SetupStep::Kind;

constexpr std::uint32_t kPdoOff = 0x8000'0000U;
constexpr std::uint32_t kPdoNoRemoteRequest = 0x4000'0000U;
constexpr std::uint32_t kEverySync = 1;
constexpr std::uint32_t kQuickStopRampThenDisabled = 2;
constexpr std::uint32_t kConnectionLossQuickStop = 3;
constexpr std::uint32_t kCspAndHoming = 0xA0;  ///< bits of 6502: mode − 1
constexpr double kHomingSearchShare = 0.5;
constexpr double kHomingCreepShare = 0.05;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kNsPerUs = 1'000;

/// Truncates within ±4.3e9, then puts the half away from zero. Exact: |value| < 2^53.
double rounded(double value) noexcept {
    const auto whole = static_cast<std::int64_t>(value);
    const double part = value - static_cast<double>(whole);
    if (part >= 0.5) {
        return static_cast<double>(whole + 1);
    }
    return static_cast<double>(part <= -0.5 ? whole - 1 : whole);
}

std::uint32_t i8_bits(int value) noexcept { return static_cast<std::uint32_t>(value) & 0xFFU; }

}  // namespace

std::int32_t round_to_i32(double value) noexcept {
    if (value >= 2147483647.0) {
        return INT32_MAX;
    }
    if (value <= -2147483648.0) {
        return INT32_MIN;
    }
    return value == value ? static_cast<std::int32_t>(rounded(value)) : 0;
}

std::uint32_t round_to_u32(double value) noexcept {
    if (value >= 4294967295.0) {
        return UINT32_MAX;
    }
    return value > 0.0 ? static_cast<std::uint32_t>(rounded(value)) : 0;
}

DriveSetup::DriveSetup(const MachineConfig& machine, std::size_t axis) noexcept {
    const AxisConfig& config = machine.axis[axis < kAxisCount ? axis : 0];
    add(Kind::expect_bits, 0x6502, 0, 4, kCspAndHoming);
    add_liveness(machine);
    add_pdos(config.drive_node);
    add_motion(machine, config);
    add_homing(config);
}

void DriveSetup::add(Kind kind, std::uint16_t index, std::uint8_t sub, std::uint8_t size,
                     std::uint32_t value) noexcept {
    if (size_ < kCapacity) {
        steps_[size_++] = {.key = {.index = index, .sub = sub, .size = size}, .value = value, .kind = kind};
    }
}

void DriveSetup::add_liveness(const MachineConfig& machine) noexcept {
    const auto timeout_ms = static_cast<std::uint32_t>((machine.heartbeat_timeout_ns / kNsPerMs) & 0xFFFF);
    add(Kind::write, 0x1017, 0, 2, static_cast<std::uint32_t>(kHeartbeatPeriodNs / kNsPerMs));
    add(Kind::write, 0x1016, 1, 4, (std::uint32_t{canopen::kMasterNode} << 16U) | timeout_ms);
    add(Kind::write_optional, 0x6007, 0, 2, kConnectionLossQuickStop);
}

void DriveSetup::add_pdos(std::uint8_t node) noexcept {
    // A mapping may change only while the PDO is off (bit 31 of its COB-ID) and its number of entries is 0.
    const std::uint32_t rpdo_id = canopen::kRpdo1Base + std::uint32_t{node};
    const std::uint32_t tpdo_id = (canopen::kTpdo1Base + std::uint32_t{node}) | kPdoNoRemoteRequest;
    add(Kind::write, 0x1400, 1, 4, rpdo_id | kPdoOff);
    add(Kind::write, 0x1400, 2, 1, kEverySync);
    add(Kind::write, 0x1600, 0, 1, 0);
    add(Kind::write, 0x1600, 1, 4, 0x6040'0010U);
    add(Kind::write, 0x1600, 2, 4, 0x607A'0020U);
    add(Kind::write, 0x1600, 0, 1, 2);
    add(Kind::write, 0x1400, 1, 4, rpdo_id);
    add(Kind::write, 0x1800, 1, 4, tpdo_id | kPdoOff);
    add(Kind::write, 0x1800, 2, 1, kEverySync);
    add(Kind::write, 0x1A00, 0, 1, 0);
    add(Kind::write, 0x1A00, 1, 4, 0x6041'0010U);
    add(Kind::write, 0x1A00, 2, 4, 0x6064'0020U);
    add(Kind::write, 0x1A00, 0, 1, 2);
    add(Kind::write, 0x1800, 1, 4, tpdo_id);
    // What a maker has set up besides would eat the bus.
    for (std::uint16_t further = 1; further <= 3; ++further) {
        const std::uint32_t shift = std::uint32_t{further} * 0x100U;
        add(Kind::write_optional, static_cast<std::uint16_t>(0x1400 + further), 1, 4, (rpdo_id + shift) | kPdoOff);
        add(Kind::write_optional, static_cast<std::uint16_t>(0x1800 + further), 1, 4, (tpdo_id + shift) | kPdoOff);
    }
}

void DriveSetup::add_motion(const MachineConfig& machine, const AxisConfig& axis) noexcept {
    const std::int64_t cycle_ns = machine.control_period_ns * static_cast<std::int64_t>(machine.drive_cycle_ticks);
    const auto cycle_ms = static_cast<std::uint32_t>((cycle_ns / kNsPerMs) & 0xFF);
    add(Kind::write_optional, 0x1006, 0, 4, static_cast<std::uint32_t>((cycle_ns / kNsPerUs) & 0xFFFF'FFFF));
    add(Kind::write_checked, 0x60C2, 1, 1, cycle_ms);
    add(Kind::write_checked, 0x60C2, 2, 1, i8_bits(-3));
    const double lag_at_speed = axis.speed * static_cast<double>(axis.latency_ns) * 1e-9;
    add(Kind::write_optional, 0x6065, 0, 4,
        round_to_u32((axis.following_window + lag_at_speed) * axis.counts_per_unit));
    add(Kind::write_optional, 0x6066, 0, 2, kDriveWindowTimeMs);
    add(Kind::write, 0x605A, 0, 2, kQuickStopRampThenDisabled);
    add(Kind::write_optional, 0x6085, 0, 4, round_to_u32(axis.acceleration * axis.counts_per_unit));
    add(Kind::write, 0x6060, 0, 1, i8_bits(static_cast<int>(axis402::Mode::csp)));
}

void DriveSetup::add_homing(const AxisConfig& axis) noexcept {
    const double counts_per_s = axis.speed * axis.counts_per_unit;
    add(Kind::write, 0x6098, 0, 1, kHomingMethod);
    add(Kind::write, 0x6099, 1, 4, round_to_u32(counts_per_s * kHomingSearchShare));
    add(Kind::write, 0x6099, 2, 4, round_to_u32(counts_per_s * kHomingCreepShare));
    add(Kind::write_optional, 0x609A, 0, 4, round_to_u32(axis.acceleration * axis.counts_per_unit));
    add(Kind::write, 0x607C, 0, 4,
        std::bit_cast<std::uint32_t>(round_to_i32(axis.home_position * axis.counts_per_unit)));
}

}  // namespace sc::drives
