// SPDX-License-Identifier: Apache-2.0
#include "shared/drives/bus_terms.hpp"

namespace sc::drives {
namespace {

constexpr std::uint32_t kMostAxes = 126;
constexpr std::uint32_t kPairBytes = 8;
constexpr std::uint32_t kControlwordBytes = 2;

void add(BusTerms& terms, const BusTerm& term) noexcept {
    for (std::size_t i = 0; i < terms.size; ++i) {
        BusTerm& old = terms.term[i];
        if (old.frame == term.frame && old.bits == term.bits && old.period_ns == term.period_ns) {
            old.count += term.count;
            return;
        }
    }
    if (terms.size < terms.term.size()) {
        terms.term[terms.size++] = term;
    }
}

/// What does not depend on the single drive: SYNC, heartbeats, SDO, EMCY.
void add_common(BusTerms& terms, const BusPlan& plan, bool paired) noexcept {
    const std::int64_t service = plan.service_ns > 0 ? plan.service_ns : plan.cycle_ns;
    add(terms, {BusFrame::sync, true, 1, worst_frame_bits(0), plan.cycle_ns});
    add(terms, {BusFrame::sdo, false, 2, worst_frame_bits(8), service});
    add(terms, {BusFrame::emergency, false, 1, worst_frame_bits(8), service});
    if (paired) {
        add(terms, {BusFrame::controlword, false, 1, worst_frame_bits(kControlwordBytes), plan.cycle_ns});
    }
    add(terms, {BusFrame::heartbeat, false, plan.axes + 1, worst_frame_bits(1), plan.heartbeat_ns});
}

bool is_sound(const BusPlan& plan) noexcept {
    return plan.axes > 0 && plan.axes <= kMostAxes && plan.bitrate > 0 && plan.cycle_ns > 0 && plan.heartbeat_ns > 0 &&
           plan.service_ns >= 0 && plan.status_every > 0 && plan.status_every <= kMostStatusEvery &&
           plan.rpdo_bytes <= 8 && plan.tpdo_bytes <= 8;
}

std::expected<BusBudget, Refusal> checked(const BusTerms& terms) noexcept {
    const BusBudget budget = sum_of(terms);
    if (!(budget.total() <= 1.0)) {
        return std::unexpected(Refusal::drive_bus_full);
    }
    return budget;
}

}  // namespace

BusBudget sum_of(const BusTerms& terms) noexcept {
    BusBudget budget;
    for (const BusTerm& term : terms.all()) {
        (term.cyclic ? budget.cyclic : budget.reserve) += term.share(terms.bitrate);
    }
    return budget;
}

std::expected<BusTerms, Refusal> bus_terms(const BusPlan& plan) noexcept {
    if (!is_sound(plan)) {
        return std::unexpected(Refusal::bad_config);
    }
    BusTerms terms;
    terms.bitrate = plan.bitrate;
    add_common(terms, plan, plan.paired);
    if (plan.paired) {
        add(terms, {BusFrame::pair_of_targets, true, (plan.axes + 1) / 2, worst_frame_bits(kPairBytes), plan.cycle_ns});
    } else {
        add(terms, {BusFrame::target, true, plan.axes, worst_frame_bits(plan.rpdo_bytes), plan.cycle_ns});
    }
    add(terms, {BusFrame::status, true, plan.axes, worst_frame_bits(plan.tpdo_bytes),
                plan.cycle_ns * static_cast<std::int64_t>(plan.status_every)});
    return terms;
}

std::expected<BusTerms, Refusal> bus_terms(const MachineConfig& machine, const DrivePlan& plan,
                                           std::uint8_t bus) noexcept {
    BusPlan common;
    common.cycle_ns = machine.control_period_ns * static_cast<std::int64_t>(machine.drive_cycle_ticks);
    common.service_ns =
        machine.drive_cycle_ticks == 1 ? machine.control_period_ns * static_cast<std::int64_t>(kServiceTicks) : 0;
    common.axes = 0;
    bool paired = false;
    for (const DriveOptions& drive : plan.drive) {
        if (drive.bus >= kDriveBuses || drive.status_every == 0 || drive.status_every > kMostStatusEvery) {
            return std::unexpected(Refusal::bad_config);
        }
        common.axes += drive.bus == bus ? 1 : 0;
        paired = paired || (drive.bus == bus && drive.paired);
    }
    BusTerms terms;
    if (common.axes == 0) {
        return terms;
    }
    if (!is_sound(common)) {
        return std::unexpected(Refusal::bad_config);
    }
    add_common(terms, common, paired);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const DriveOptions& drive = plan.drive[axis];
        if (drive.bus != bus) {
            continue;
        }
        if (!drive.paired) {
            add(terms, {BusFrame::target, true, 1, worst_frame_bits(common.rpdo_bytes), common.cycle_ns});
        } else if (target_pair(plan, axis).first == axis) {
            add(terms, {BusFrame::pair_of_targets, true, 1, worst_frame_bits(kPairBytes), common.cycle_ns});
        }
        add(terms, {BusFrame::status, true, 1, worst_frame_bits(common.tpdo_bytes),
                    common.cycle_ns * static_cast<std::int64_t>(drive.status_every)});
    }
    return terms;
}

std::expected<BusBudget, Refusal> bus_budget(const BusPlan& plan) noexcept {
    const auto terms = bus_terms(plan);
    return terms ? checked(*terms) : std::unexpected(terms.error());
}

}  // namespace sc::drives
