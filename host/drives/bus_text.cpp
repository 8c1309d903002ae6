// SPDX-License-Identifier: Apache-2.0
#include "host/drives/bus_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

const char* name_of(drives::BusFrame frame) {
    switch (frame) {
        case drives::BusFrame::sync: return "SYNC";
        case drives::BusFrame::target: return "RPDO: controlword, target (6 bytes)";
        case drives::BusFrame::pair_of_targets: return "RPDO: two targets (8 bytes)";
        case drives::BusFrame::status: return "TPDO: status word, place (6 bytes)";
        case drives::BusFrame::controlword: return "RPDO: controlword (2 bytes)";
        case drives::BusFrame::sdo: return "SDO request and answer (8 bytes)";
        case drives::BusFrame::emergency: return "EMCY (8 bytes)";
        case drives::BusFrame::heartbeat: break;
    }
    return "heartbeats (1 byte)";
}

}  // namespace

bool BusSheet::fits() const noexcept {
    return std::ranges::all_of(sums, [](const Sum& sum) { return sum.total() <= 1.0; });
}

BusSheet bus_sheet(const MachineConfig& machine, const DrivePlan& plan) {
    BusSheet sheet;
    for (std::uint8_t bus = 0; bus < kDriveBuses; ++bus) {
        const auto terms = drives::bus_terms(machine, plan, bus);
        if (!terms) {
            throw InputError({.problem = "this is no plan for the drives", .action = "see docs/drives.md"});
        }
        if (terms->size == 0) {
            continue;
        }
        for (const drives::BusTerm& term : terms->all()) {
            sheet.lines.push_back({bus, name_of(term.frame), term.count, term.bits,
                                   static_cast<double>(term.period_ns) * 1e-6, term.share(terms->bitrate),
                                   !term.cyclic});
        }
        const drives::BusBudget sum = drives::sum_of(*terms);
        sheet.sums.push_back({bus, sum.cyclic, sum.reserve});
    }
    return sheet;
}

std::string text_of(const BusSheet& sheet) {
    std::string text;
    std::array<char, 200> line{};
    for (const BusLine& one : sheet.lines) {
        std::snprintf(line.data(), line.size(), "bus %d  %-36s %2u x %3u bits in %4.1f ms  %6.2f %%%s\n", one.bus,
                      one.frames.c_str(), one.count, one.bits, one.period_ms, 100.0 * one.share,
                      one.reserve ? "  reserve" : "");
        text += line.data();
    }
    for (const BusSheet::Sum& sum : sheet.sums) {
        std::snprintf(line.data(), line.size(), "bus %d  cyclic %.2f %% + reserve %.2f %% = %.2f %% of 1 Mbit/s: %s\n",
                      sum.bus, 100.0 * sum.cyclic, 100.0 * sum.reserve, 100.0 * sum.total(),
                      sum.total() <= 1.0 ? "fits" : "does not fit; the controller refuses it (170)");
        text += line.data();
    }
    return text;
}

}  // namespace sc::host
