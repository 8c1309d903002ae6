// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/bus_budget.hpp"

namespace sc::drives {
namespace {

constexpr double kNsPerSecond = 1e9;

bool is_sound(const BusPlan& plan) noexcept {
    return plan.axes > 0 && plan.axes < 127 && plan.bitrate > 0 && plan.cycle_ns > 0 && plan.heartbeat_ns > 0 &&
           plan.rpdo_bytes <= 8 && plan.tpdo_bytes <= 8;
}

}  // namespace

std::expected<BusBudget, Refusal> bus_budget(const BusPlan& plan) noexcept {
    if (!is_sound(plan)) {
        return std::unexpected(Refusal::bad_config);
    }
    const double capacity_per_ns = static_cast<double>(plan.bitrate) / kNsPerSecond;
    const double cycle_capacity = capacity_per_ns * static_cast<double>(plan.cycle_ns);
    const double heartbeat_capacity = capacity_per_ns * static_cast<double>(plan.heartbeat_ns);
    const std::uint32_t per_axis = worst_frame_bits(plan.rpdo_bytes) + worst_frame_bits(plan.tpdo_bytes);
    const std::uint32_t cyclic_bits = worst_frame_bits(0) + plan.axes * per_axis;
    const std::uint32_t spare_bits = 3 * worst_frame_bits(8);
    const std::uint32_t heartbeat_bits = (plan.axes + 1) * worst_frame_bits(1);

    BusBudget budget;
    budget.cyclic = static_cast<double>(cyclic_bits) / cycle_capacity;
    budget.reserve =
        static_cast<double>(spare_bits) / cycle_capacity + static_cast<double>(heartbeat_bits) / heartbeat_capacity;
    if (!(budget.total() <= 1.0)) {
        return std::unexpected(Refusal::bad_config);
    }
    return budget;
}

std::expected<BusBudget, Refusal> bus_budget(const MachineConfig& machine) noexcept {
    BusPlan plan;
    plan.cycle_ns = machine.control_period_ns * static_cast<std::int64_t>(machine.drive_cycle_ticks);
    return bus_budget(plan);
}

}  // namespace sc::drives
