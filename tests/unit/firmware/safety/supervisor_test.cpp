// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/supervisor.hpp"

#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sc::safety {
namespace {

Supervisor driven(std::initializer_list<Event> events) {
    Supervisor supervisor;
    for (const Event event : events) {
        EXPECT_TRUE(supervisor.post(event)) << name_of(event);
    }
    return supervisor;
}

Supervisor marking() {
    return driven({Event::drives_present, Event::enable, Event::enabled, Event::arm, Event::mo_ready, Event::start,
                   Event::path_begin});
}

std::string diagram() {
    std::ostringstream out;
    out << "stateDiagram-v2\n    [*] --> boot\n";
    for (const Transition& row : kTransitions) {
        out << "    " << sc::name_of(row.from) << " --> " << sc::name_of(row.to) << ": " << name_of(row.event) << "\n";
    }
    return out.str();
}

std::string documented_diagram() {
    std::ifstream file(SC_SOURCE_DIR "/docs/states.md");
    std::string line;
    std::string block;
    bool inside = false;
    while (std::getline(file, line)) {
        if (line == "```mermaid") {
            inside = true;
        } else if (inside && line == "```") {
            return block;
        } else if (inside) {
            block += line + "\n";
        }
    }
    return block;
}

TEST(Supervisor, TableIsTheDiagramOfTheDocument) { EXPECT_EQ(documented_diagram(), diagram()) << diagram(); }

TEST(Supervisor, EveryNameIsItsOwn) {
    std::set<std::string_view> names;
    for (std::size_t i = 0; i < kEventCount; ++i) {
        names.insert(name_of(static_cast<Event>(i)));
    }
    EXPECT_EQ(names.size(), kEventCount);
    EXPECT_FALSE(names.contains("?"));
    EXPECT_EQ(name_of(static_cast<Event>(kEventCount)), "?") << "kEventCount is the number of events";
}

TEST(Supervisor, RunsAJobFromPowerUpToTheEnd) {
    Supervisor s = marking();
    EXPECT_EQ(s.state(), State::marking);
    EXPECT_TRUE(s.post(Event::path_end));
    EXPECT_TRUE(s.post(Event::job_done));
    EXPECT_TRUE(s.post(Event::disarm));
    EXPECT_TRUE(s.post(Event::disable));
    EXPECT_TRUE(s.post(Event::disabled));
    EXPECT_EQ(s.state(), State::disabled);
    EXPECT_EQ(s.faults(), 0U);
}

TEST(Supervisor, RefusedEventChangesNothing) {
    Supervisor s;
    EXPECT_FALSE(s.allowed(Event::start));
    EXPECT_FALSE(s.post(Event::start));
    EXPECT_EQ(s.state(), State::boot);
}

TEST(Supervisor, HoldResumesAndAbortEndsTheJob) {
    Supervisor s = marking();
    EXPECT_TRUE(s.post(Event::hold));
    EXPECT_FALSE(s.post(Event::resume)) << "still stopping";
    EXPECT_TRUE(s.post(Event::stopped_held));
    EXPECT_TRUE(s.post(Event::resume));
    EXPECT_EQ(s.state(), State::running);
    EXPECT_TRUE(s.post(Event::starved));
    EXPECT_TRUE(s.post(Event::stopped_held));
    EXPECT_TRUE(s.post(Event::abort));
    EXPECT_EQ(s.state(), State::armed);
}

TEST(Supervisor, SilentLinkHoldsAndTheSameSessionGoesOn) {
    Supervisor s = marking();
    EXPECT_TRUE(s.post(Event::link_silent));
    EXPECT_EQ(s.state(), State::stopping);
    EXPECT_TRUE(s.post(Event::stopped_link));
    EXPECT_EQ(s.state(), State::held_link);
    EXPECT_FALSE(s.post(Event::resume)) << "only the host's return leads on";
    EXPECT_TRUE(s.post(Event::link_back));
    EXPECT_EQ(s.state(), State::running);
    EXPECT_EQ(s.faults(), 0U);
}

TEST(Supervisor, TripLatchesTheFirstFaultWithItsContext) {
    Supervisor s = marking();
    s.trip(Fault::interlock_open, kNoAxis, 1234);
    s.trip(Fault::drive_lost, 2, 1240);
    EXPECT_EQ(s.state(), State::fault);
    EXPECT_EQ(s.faults(), fault_bit(Fault::interlock_open) | fault_bit(Fault::drive_lost));
    EXPECT_EQ(s.first_fault().fault, Fault::interlock_open);
    EXPECT_EQ(s.first_fault().axis, kNoAxis);
    EXPECT_EQ(s.first_fault().state, State::marking);
    EXPECT_EQ(s.first_fault().tick, 1234);
}

TEST(Supervisor, TripWithoutAFaultIsIgnored) {
    Supervisor s = marking();
    s.trip(Fault::none, kNoAxis, 1);
    EXPECT_EQ(s.state(), State::marking);
    EXPECT_EQ(s.faults(), 0U);
}

TEST(Supervisor, TripAndResetCannotBePosted) {
    Supervisor s = marking();
    EXPECT_FALSE(s.post(Event::trip));
    EXPECT_EQ(s.state(), State::marking);
    s.trip(Fault::estop_open, kNoAxis, 1);
    EXPECT_FALSE(s.post(Event::reset));
    EXPECT_EQ(s.state(), State::fault);
}

TEST(Supervisor, ResetNeedsTheCauseGoneAndRearmsNothing) {
    Supervisor s = marking();
    EXPECT_EQ(s.reset(0), Refusal::wrong_state);
    s.trip(Fault::estop_open, kNoAxis, 1);
    EXPECT_EQ(s.reset(fault_bit(Fault::estop_open)), Refusal::fault_present);
    EXPECT_EQ(s.reset(fault_bit(Fault::laser_alarm)), Refusal::fault_present) << "a new cause counts too";
    EXPECT_EQ(s.state(), State::fault);
    EXPECT_EQ(s.reset(0), Refusal::none);
    EXPECT_EQ(s.state(), State::disabled);
    EXPECT_EQ(s.faults(), 0U);
    EXPECT_EQ(s.first_fault().fault, Fault::none);
}

TEST(Supervisor, NoWayToMarkingAvoidsArmingAndEnabling) {
    // 200 000 random events: whenever the state is marking, all of these were passed since the last loss of power or
    // MO.
    std::mt19937 random(20240601);
    std::uniform_int_distribution<int> pick(0, static_cast<int>(kEventCount) - 1);
    Supervisor s;
    bool enabled = false;
    bool mo_waited = false;
    int marked = 0;
    for (int i = 0; i < 200'000; ++i) {
        const auto event = static_cast<Event>(pick(random));
        if (event == Event::trip && i % 7 == 0) {
            s.trip(Fault::drive_fault, 0, i);
        } else if (event == Event::reset) {
            static_cast<void>(s.reset(0));
        } else if (s.post(event)) {
            enabled = enabled || event == Event::enabled;
            mo_waited = mo_waited || event == Event::mo_ready;
        }
        enabled = enabled && powered_state(s.state()) && s.state() != State::enabling;
        mo_waited = mo_waited && mo_state(s.state()) && s.state() != State::arming;
        if (gate_state(s.state())) {
            ++marked;
            ASSERT_TRUE(enabled && mo_waited) << "event " << i;
        }
        ASSERT_EQ(s.state() == State::fault, s.faults() != 0);
    }
    EXPECT_GT(marked, 100);
}

}  // namespace
}  // namespace sc::safety
