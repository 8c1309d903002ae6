// SPDX-License-Identifier: Apache-2.0
#include "boards/bench/bus/bus_load.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "boards/bench/bus/drive_line.hpp"
#include "shared/drives/bus_terms.hpp"

namespace sc::bench {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
constexpr std::int64_t kReadyTicks = 20'000;
constexpr std::int64_t kSettleTicks = 200;

drives::BusPlan plan_of(const BusCase& which) {
    drives::BusPlan plan;
    plan.axes = (which.axes + which.buses - 1) / which.buses;
    plan.cycle_ns = kTickNs * static_cast<std::int64_t>(which.cycle_ticks);
    plan.service_ns = which.cycle_ticks == 1 ? kTickNs * static_cast<std::int64_t>(drives::kServiceTicks) : 0;
    plan.status_every = which.status_every;
    plan.paired = which.paired;
    return plan;
}

}  // namespace

double BusResult::error_pct() const noexcept { return 100.0 * std::abs(counted - computed) / computed; }

std::vector<BusCase> bus_cases() {
    std::vector<BusCase> cases;
    for (const std::uint32_t axes : {3U, 4U, 6U}) {
        const std::string begin = "axes" + std::to_string(axes);
        cases.push_back({.name = begin + "_1khz", .axes = axes});
        cases.push_back({.name = begin + "_status_every_2nd", .axes = axes, .status_every = 2});
        cases.push_back({.name = begin + "_paired", .axes = axes, .paired = true});
        cases.push_back({.name = begin + "_500hz", .axes = axes, .cycle_ticks = 2});
        cases.push_back({.name = begin + "_two_buses", .axes = axes, .buses = 2});
    }
    return cases;
}

BusResult measure_bus(const BusCase& which, bool by_master, double seconds) {
    BusResult result;
    result.of = which;
    const drives::BusTerms terms = drives::bus_terms(plan_of(which)).value();
    const drives::BusBudget budget = drives::sum_of(terms);
    result.cyclic = budget.cyclic;
    result.total = budget.total();
    result.by_master = by_master;
    result.carried = budget.cyclic < 1.0;
    result.computed = budget.cyclic;
    for (const drives::BusTerm& term : terms.all()) {
        result.computed += term.frame == drives::BusFrame::heartbeat ? term.share(terms.bitrate) : 0.0;
    }

    DriveLine line(which, by_master, result.carried);
    std::int64_t tick = 0;
    while (tick < kReadyTicks && !line.ready()) {
        line.step(tick++);
    }
    if (!line.ready()) {
        throw std::runtime_error(which.name + ": the drives do not get ready");
    }
    for (const std::int64_t end = tick + kSettleTicks; tick < end;) {
        line.step(tick++);
    }
    line.count_from_now();
    // Whole numbers of every period: 20 ms holds all cycles and the heartbeats.
    const auto ticks = static_cast<std::int64_t>(std::round(seconds * 50.0)) * 20;
    for (const std::int64_t end = tick + ticks; tick < end;) {
        line.step(tick++);
    }
    result.frames = line.counts();
    result.seconds = static_cast<double>(ticks) * 1e-3;
    const double capacity = result.seconds * static_cast<double>(drives::kDriveBusBitrate);
    result.counted = static_cast<double>(result.frames.worst_bits) / capacity;
    result.wire = static_cast<double>(result.frames.wire_bits) / capacity;
    return result;
}

}  // namespace sc::bench
