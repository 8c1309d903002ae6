// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/machine_keys.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

TEST(MachineKeys, SetWhatTheControllerIsTold) {
    MachineConfig machine = reference_machine();
    set_machine(machine, {"galvo.natural_frequency_hz=0", "galvo.latency_us=12.5", "galvo.word=18", "galvo.damping=0.6",
                          "laser.power_byte=energy"});
    EXPECT_EQ(machine.galvo.natural_frequency.si(), 0.0);
    EXPECT_EQ(machine.galvo.latency_ns, 12'500);
    EXPECT_EQ(machine.galvo.word, GalvoWord::bits18);
    EXPECT_EQ(machine.galvo.damping, 0.6);
    EXPECT_EQ(machine.laser.power_byte, PowerByte::pulse_energy);
}

TEST(MachineKeys, RefuseWhatTheyDoNotKnow) {
    for (const char* bad : {"", "galvo.word", "galvo.word=17", "galvo.latency_us=", "galvo.latency_us=-1",
                            "galvo.latency_us=1e9", "galvo.latency_us=nan", "galvo.latency_us=5 us", "axis.speed=1",
                            "laser.power_byte=watts", "galvo.latency_us=100"}) {
        MachineConfig machine = reference_machine();
        EXPECT_THROW(set_machine(machine, {bad}), std::invalid_argument) << bad;
    }
}

}  // namespace
}  // namespace sc::sim
