// SPDX-License-Identifier: Apache-2.0
#include "shared/drives/bus_budget.hpp"

namespace sc::drives {
namespace {

/// Shares of one bus; none without a drive.
[[gnu::cold]] BusBudget share_of(const MachineConfig& machine, const DrivePlan& plan, std::uint8_t bus,
                                 double cycle_bits, double heartbeat_bits) noexcept {
    double cyclic = worst_frame_bits(0);
    double nodes = 1.0;
    std::uint32_t pairs = 0;
    for (const DriveOptions& drive : plan.drive) {
        if (drive.bus == bus) {
            nodes += 1.0;
            pairs += drive.paired ? 1 : 0;
            cyclic += drive.paired ? 0U : worst_frame_bits(kPdoBytes);
            cyclic += static_cast<double>(worst_frame_bits(kPdoBytes)) / static_cast<double>(drive.status_every);
        }
    }
    if (nodes == 1.0) {
        return {};
    }
    const auto shared_frames = static_cast<double>((pairs + 1) >> 1U);  // two targets a frame
    cyclic += shared_frames * worst_frame_bits(8);
    const double service = machine.drive_cycle_ticks == 1 ? kServiceTicks : 1;
    const double controlword = pairs > 0 ? worst_frame_bits(2) : 0;
    return {cyclic / cycle_bits, (3 * worst_frame_bits(8) / service + controlword) / cycle_bits +
                                     nodes * worst_frame_bits(1) / heartbeat_bits};
}

}  // namespace

[[gnu::cold]] std::expected<BusBudget, Refusal> bus_budget(const MachineConfig& machine,
                                                           const DrivePlan& plan) noexcept {
    constexpr double kBitsPerNs = static_cast<double>(kDriveBusBitrate) * 1e-9;
    const std::int64_t cycle_ns = machine.control_period_ns * static_cast<std::int64_t>(machine.drive_cycle_ticks);
    bool sound = cycle_ns > 0;
    for (const DriveOptions& drive : plan.drive) {
        sound = sound && drive.bus < kDriveBuses && drive.status_every > 0 && drive.status_every <= kMostStatusEvery;
    }
    if (!sound) {
        return std::unexpected(Refusal::bad_config);
    }
    const double cycle_bits = kBitsPerNs * static_cast<double>(cycle_ns);
    const double heartbeat_bits = kBitsPerNs * static_cast<double>(kHeartbeatPeriodNs);
    BusBudget fuller;
    for (std::uint8_t bus = 0; bus < kDriveBuses; ++bus) {
        const BusBudget budget = share_of(machine, plan, bus, cycle_bits, heartbeat_bits);
        fuller = budget.total() > fuller.total() ? budget : fuller;
    }
    if (!(fuller.total() <= 1.0)) {
        return std::unexpected(Refusal::drive_bus_full);
    }
    return fuller;
}

}  // namespace sc::drives
