// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_configuration.hpp"

#include <bit>

#include "firmware/drives/axis402.hpp"
#include "shared/drives/bus_budget.hpp"

namespace sc::drives {
namespace {

using Kind = SetupStep::Kind;
using Number = DriveSetup::Number;

constexpr std::uint32_t kPdoOff = 0x8000'0000U;
constexpr std::uint32_t kPdoNoRemoteRequest = 0x4000'0000U;
constexpr std::uint32_t kEverySync = 1;
constexpr std::uint32_t kControlword = 0x6040'0010U;
constexpr std::uint32_t kTarget = 0x607A'0020U;
constexpr std::uint32_t kNothing = 0x0007'0020U;  ///< 32 bits that the drive skips (dummy mapping)
constexpr std::uint32_t kQuickStopRampThenDisabled = 2;
constexpr std::uint32_t kConnectionLossQuickStop = 3;
constexpr std::uint32_t kCspAndHoming = 0xA0;  ///< bits of 6502: mode − 1
constexpr double kHomingSearchShare = 0.5;
constexpr double kHomingCreepShare = 0.05;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kNsPerUs = 1'000;

// Conditions of a row: drive_object bits, and these.
constexpr std::uint16_t kAlways = 0;
constexpr std::uint16_t kPaired = 0x0100;
constexpr std::uint16_t kUnpaired = 0x0200;
constexpr std::uint16_t kVendor = 0x0400;
constexpr std::uint16_t kProduct = 0x0800;
constexpr std::uint16_t kBrake = 0x1000;

struct Row {
    std::uint16_t index;
    std::uint8_t sub;
    std::uint8_t size;
    Kind kind;
    Number number;
    std::uint16_t when;
    std::uint32_t value;  ///< added to the number
};

// A mapping may change only while the PDO is off (bit 31 of its COB-ID) and its number of entries is 0. What a maker
// has set up besides would eat the bus.
using enum Number;
constexpr Row kRows[] = {
    {0x1018, 1, 4, Kind::expect_value, vendor, kVendor, 0},
    {0x1018, 2, 4, Kind::expect_value, product, kProduct, 0},
    {0x6502, 0, 4, Kind::expect_bits, none, kAlways, kCspAndHoming},
    {0x1017, 0, 2, Kind::write, none, kAlways, static_cast<std::uint32_t>(kHeartbeatPeriodNs / kNsPerMs)},
    {0x1016, 1, 4, Kind::write, master_watch, kAlways, 0},
    {0x6007, 0, 2, Kind::write_optional, none, drive_object::k6007, kConnectionLossQuickStop},
    {0x1400, 1, 4, Kind::write, target_rpdo, kAlways, kPdoOff},
    {0x1400, 2, 1, Kind::write, none, kAlways, kEverySync},
    {0x1600, 0, 1, Kind::write, none, kAlways, 0},
    {0x1600, 1, 4, Kind::write, first_target, kAlways, 0},
    {0x1600, 2, 4, Kind::write, second_target, kAlways, 0},
    {0x1600, 0, 1, Kind::write, none, kAlways, 2},
    {0x1400, 1, 4, Kind::write, target_rpdo, kAlways, 0},
    {0x1800, 1, 4, Kind::write, tpdo, kAlways, kPdoOff},
    {0x1800, 2, 1, Kind::write, status_every, kAlways, 0},
    {0x1A00, 0, 1, Kind::write, none, kAlways, 0},
    {0x1A00, 1, 4, Kind::write, none, kAlways, 0x6041'0010U},
    {0x1A00, 2, 4, Kind::write, none, kAlways, 0x6064'0020U},
    {0x1A00, 0, 1, Kind::write, none, kAlways, 2},
    {0x1800, 1, 4, Kind::write, tpdo, kAlways, 0},
    {0x1401, 1, 4, Kind::write, own_rpdo, kPaired, 0x100 + kPdoOff},
    {0x1401, 2, 1, Kind::write, none, kPaired, kEverySync},
    {0x1601, 0, 1, Kind::write, none, kPaired, 0},
    {0x1601, 1, 4, Kind::write, none, kPaired, kControlword},
    {0x1601, 0, 1, Kind::write, none, kPaired, 1},
    {0x1401, 1, 4, Kind::write, own_rpdo, kPaired, 0x100},
    {0x1401, 1, 4, Kind::write_optional, own_rpdo, kUnpaired | drive_object::kRpdos, 0x100 + kPdoOff},
    {0x1801, 1, 4, Kind::write_optional, tpdo, drive_object::kTpdos, 0x100 + kPdoOff},
    {0x1402, 1, 4, Kind::write_optional, own_rpdo, drive_object::kRpdos, 0x200 + kPdoOff},
    {0x1802, 1, 4, Kind::write_optional, tpdo, drive_object::kTpdos, 0x200 + kPdoOff},
    {0x1403, 1, 4, Kind::write_optional, own_rpdo, drive_object::kRpdos, 0x300 + kPdoOff},
    {0x1803, 1, 4, Kind::write_optional, tpdo, drive_object::kTpdos, 0x300 + kPdoOff},
    {0x1006, 0, 4, Kind::write_optional, cycle_us, drive_object::k1006, 0},
    {0x60C2, 1, 1, Kind::write_checked, cycle_ms, kAlways, 0},
    {0x60C2, 2, 1, Kind::write_checked, none, kAlways, 0xFD},
    {0x6065, 0, 4, Kind::write_optional, window, drive_object::k6065, 0},
    {0x6066, 0, 2, Kind::write_optional, none, drive_object::k6066, kDriveWindowTimeMs},
    {0x605A, 0, 2, Kind::write, none, kAlways, kQuickStopRampThenDisabled},
    {0x6085, 0, 4, Kind::write_optional, ramp, drive_object::k6085, 0},
    {0x6060, 0, 1, Kind::write, none, kAlways, static_cast<std::uint32_t>(axis402::Mode::csp)},
    {0x6098, 0, 1, Kind::write, homing_method, kAlways, 0},
    {0x6099, 1, 4, Kind::write, search, kAlways, 0},
    {0x6099, 2, 4, Kind::write, creep, kAlways, 0},
    {0x609A, 0, 4, Kind::write_optional, ramp, drive_object::k609A, 0},
    {0x607C, 0, 4, Kind::write, home, kAlways, 0},
    {0x60FE, 2, 4, Kind::write, none, kBrake, 1},
    {0x60FE, 1, 4, Kind::write, none, kBrake, 1},
};

}  // namespace

[[gnu::noinline]] std::int32_t round_to_i32(double value) noexcept {
    if (value >= 2147483647.0) {
        return INT32_MAX;
    }
    if (value <= -2147483648.0) {
        return INT32_MIN;
    }
    if (value != value) {
        return 0;
    }
    const auto whole = static_cast<std::int32_t>(value);
    const double part = value - static_cast<double>(whole);
    return whole + (part >= 0.5 ? 1 : 0) - (part <= -0.5 ? 1 : 0);
}

[[gnu::noinline]] std::uint32_t round_to_u32(double value) noexcept {
    if (value >= 4294967295.0) {
        return UINT32_MAX;
    }
    const auto whole = value > 0.0 ? static_cast<std::uint32_t>(value) : 0U;
    return whole + (value - static_cast<double>(whole) >= 0.5 ? 1U : 0U);
}

[[gnu::cold]] DriveSetup::DriveSetup(const MachineConfig& machine, std::size_t axis, const DrivePlan& plan) noexcept {
    const std::size_t at = axis < kAxisCount ? axis : 0;
    const AxisConfig& config = machine.axis[at];
    const DriveOptions& options = plan.drive[at];
    const bool paired = options.paired;
    const unsigned lacking = options.absent;
    present_ = static_cast<std::uint16_t>(
        (~lacking & drive_object::kAll) | (paired ? kPaired : kUnpaired) | (options.vendor != 0 ? kVendor : 0U) |
        (options.product != 0 ? kProduct : 0U) | (options.brake_apply_ms != 0 ? kBrake : 0U));

    set(master_watch, (std::uint32_t{canopen::kMasterNode} << 16U) |
                          static_cast<std::uint32_t>((machine.heartbeat_timeout_ns / kNsPerMs) & 0xFFFF));
    const TargetPair pair = paired ? target_pair(plan, at) : TargetPair{};
    const bool second = paired && pair.second == at && pair.first != at;
    set(own_rpdo, canopen::kRpdo1Base + std::uint32_t{config.drive_node});
    set(target_rpdo, canopen::kRpdo1Base + std::uint32_t{(paired ? machine.axis[pair.first] : config).drive_node});
    set(first_target, second ? kNothing : (paired ? kTarget : kControlword));
    set(second_target, paired && !second ? kNothing : kTarget);
    set(tpdo, (canopen::kTpdo1Base + std::uint32_t{config.drive_node}) | kPdoNoRemoteRequest);
    set(Number::status_every, options.status_every);

    const std::int64_t cycle_ns = machine.control_period_ns * static_cast<std::int64_t>(machine.drive_cycle_ticks);
    set(cycle_us, static_cast<std::uint32_t>((cycle_ns / kNsPerUs) & 0xFFFF'FFFF));
    set(cycle_ms, static_cast<std::uint32_t>((cycle_ns / kNsPerMs) & 0xFF));
    const double lag_at_speed = config.speed * static_cast<double>(config.latency_ns) * 1e-9;
    set(window, round_to_u32((config.following_window + lag_at_speed) * config.counts_per_unit));
    set(ramp, round_to_u32(config.acceleration * config.counts_per_unit));

    const double counts_per_s = config.speed * config.counts_per_unit;
    set(Number::homing_method, static_cast<std::uint8_t>(options.homing_method));
    set(search, round_to_u32(counts_per_s * kHomingSearchShare));
    set(creep, round_to_u32(counts_per_s * kHomingCreepShare));
    set(home, std::bit_cast<std::uint32_t>(round_to_i32(config.home_position * config.counts_per_unit)));
    set(Number::vendor, options.vendor);
    set(Number::product, options.product);
    for (const Row& row : kRows) {
        size_ = static_cast<std::uint8_t>(size_ + (holds(row.when) ? 1 : 0));
    }
}

SetupStep DriveSetup::operator[](std::size_t i) const noexcept {
    std::size_t left = i < size_ ? i : 0;
    for (const Row& row : kRows) {
        if (holds(row.when) && left-- == 0) {
            return {.key = {.index = row.index, .sub = row.sub, .size = row.size},
                    .value = row.value + number_[static_cast<std::size_t>(row.number)],
                    .kind = row.kind};
        }
    }
    return {};
}

}  // namespace sc::drives
