// SPDX-License-Identifier: Apache-2.0
// The pins of the simulated sources against the controller's tables: written down apart, they must agree.
#include "boards/sim/plant/source_pins.hpp"

#include <set>

#include <gtest/gtest.h>

#include "shared/machine/source_status.hpp"

namespace sc::sim {
namespace {

struct Pair {
    SourceTrouble trouble;
    SourceState state;
    Fault fault;
};
constexpr Pair kPairs[]{{SourceTrouble::none, SourceState::ready, Fault::none},
                        {SourceTrouble::warning, SourceState::warning, Fault::none},
                        {SourceTrouble::starting, SourceState::not_ready, Fault::none},
                        {SourceTrouble::back_reflection, SourceState::back_reflection, Fault::laser_back_reflection},
                        {SourceTrouble::temperature, SourceState::temperature, Fault::laser_temperature},
                        {SourceTrouble::main_supply, SourceState::main_supply, Fault::laser_main_supply},
                        {SourceTrouble::housekeeping, SourceState::housekeeping, Fault::laser_housekeeping},
                        {SourceTrouble::system, SourceState::system, Fault::laser_system},
                        {SourceTrouble::strange, SourceState::unknown, Fault::laser_code_unknown}};
constexpr LaserSource kSources[]{LaserSource::ipg, LaserSource::raycus, LaserSource::jpt};

TEST(SourceStatus, EveryTroubleOfEverySourceIsReadAsWhatItIs) {
    for (const LaserSource source : kSources) {
        for (const Pair& pair : kPairs) {
            const SourceState state = source_state(source, source_pins(source, pair.trouble));
            EXPECT_EQ(state, pair.state) << static_cast<int>(source) << " " << name_of(pair.state);
            EXPECT_EQ(fault_of(state), pair.fault) << name_of(pair.state);
        }
    }
}

TEST(SourceStatus, OneReadingAloneIsReadyAndOneAWarning) {
    for (const LaserSource source : kSources) {
        int ready = 0;
        int warning = 0;
        for (std::uint8_t pins = 0; pins < kSourceReadings; ++pins) {
            const SourceState state = source_state(source, pins);
            ready += state == SourceState::ready ? 1 : 0;
            warning += state == SourceState::warning ? 1 : 0;
            EXPECT_EQ(may_emit(state), state == SourceState::ready || state == SourceState::warning);
        }
        EXPECT_EQ(ready, 1);
        EXPECT_EQ(warning, 1);
        // A broken cable reads as all low or all high.
        EXPECT_FALSE(may_emit(source_state(source, 0x0)));
        EXPECT_FALSE(may_emit(source_state(source, 0xF)));
    }
}

TEST(SourceStatus, TheTablesOfTwoMakersDiffer) {
    std::set<std::uint8_t> warnings;
    for (const LaserSource source : kSources) {
        warnings.insert(source_pins(source, SourceTrouble::warning));
    }
    EXPECT_EQ(warnings.size(), 3U) << "so a wrong maker in the configuration shows";
}

TEST(SourceStatus, EveryStateHasANameAndEveryAlarmACodeOfItsOwn) {
    std::set<std::string_view> names;
    std::set<Fault> faults;
    for (std::size_t i = 0; i < kSourceStateCount; ++i) {
        names.insert(name_of(static_cast<SourceState>(i)));
        const Fault fault = fault_of(static_cast<SourceState>(i));
        if (fault != Fault::none) {
            EXPECT_TRUE(faults.insert(fault).second);
            EXPECT_NE(find_code(fault), nullptr);
        }
    }
    EXPECT_EQ(names.size(), kSourceStateCount);
    EXPECT_FALSE(names.contains("?"));
    EXPECT_EQ(faults.size(), 6U);
}

TEST(SourceStatus, ASourceWithoutPinsIsTakenForReady) {
    for (std::uint8_t pins = 0; pins < kSourceReadings; ++pins) {
        EXPECT_EQ(source_state(LaserSource::none, pins), SourceState::ready);
    }
}

}  // namespace
}  // namespace sc::sim
