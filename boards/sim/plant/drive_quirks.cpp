// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_quirks.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace sc::sim {
namespace {

struct Named {
    std::string_view name;
    void (*put)(DriveQuirks&);
};

constexpr std::array kNamed{
    Named{"lenze-931e",
          [](DriveQuirks& q) {
              q.pdo_gap_ns = 4'000'000;
              q.pdo_delay_ns = 800'000;
          }},
    Named{"lenze-9400", [](DriveQuirks& q) { q.pdo_delay_ns = 150'000; }},
    Named{"infranor", [](DriveQuirks& q) { q.period_step_us = 500; }},
    Named{"delta", [](DriveQuirks& q) { q.lost_syncs = 2; }},
    Named{"no-period", [](DriveQuirks& q) { q.no_period = true; }},
    Named{"no-6007", [](DriveQuirks& q) { q.no_6007 = true; }},
    Named{"event-driven", [](DriveQuirks& q) { q.event_driven = true; }},
    Named{"bit-30", [](DriveQuirks& q) { q.bit_30 = true; }},
    Named{"no-dummy", [](DriveQuirks& q) { q.no_dummy = true; }},
};

}  // namespace

std::vector<std::string> drive_quirk_names() {
    std::vector<std::string> names;
    for (const Named& named : kNamed) {
        names.emplace_back(named.name);
    }
    return names;
}

DriveQuirks drive_quirks(std::string_view names) {
    DriveQuirks quirks;
    while (!names.empty()) {
        const std::size_t comma = std::min(names.find(','), names.size());
        const std::string_view name = names.substr(0, comma);
        const auto* const found = std::ranges::find(kNamed, name, &Named::name);
        if (found == kNamed.end()) {
            std::string all;
            for (const Named& named : kNamed) {
                all += (all.empty() ? "" : ", ") + std::string(named.name);
            }
            throw std::invalid_argument("no drive quirk is called '" + std::string(name) + "'; there are: " + all);
        }
        found->put(quirks);
        names.remove_prefix(std::min(comma + 1, names.size()));
    }
    return quirks;
}

}  // namespace sc::sim
