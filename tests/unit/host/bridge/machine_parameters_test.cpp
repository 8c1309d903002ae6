// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/machine_parameters.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "shared/link/config.hpp"

namespace sc::host {
namespace {

TEST(MachineParameters, EachIsReadAndWrittenUnderANameOfItsOwn) {
    const MachineConfig machine = reference_machine();
    std::set<std::string> names;
    for (const MachineParameter& parameter : machine_parameters()) {
        EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
        const double before = parameter.get(machine);
        MachineConfig changed = machine;
        parameter.set(changed, before + 1.0);
        EXPECT_NEAR(parameter.get(changed), before + 1.0, 1e-6 * (std::abs(before) + 1.0)) << parameter.name;
        for (const MachineParameter& other : machine_parameters()) {
            if (other.name != parameter.name) {
                EXPECT_EQ(other.get(changed), other.get(machine)) << parameter.name << " changes " << other.name;
            }
        }
        parameter.set(changed, before);
        EXPECT_NEAR(parameter.get(changed), before, 1e-9 * (std::abs(before) + 1.0)) << parameter.name;
    }
    EXPECT_GT(names.size(), 40U);
}

TEST(MachineParameters, UnitsAreThoseOfTheNames) {
    MachineConfig machine = reference_machine();
    set_parameter(machine, "x.speed_mm_s=400");
    EXPECT_DOUBLE_EQ(machine.axis[0].speed, 0.4);
    set_parameter(machine, "c.speed_deg_s=12.5");
    EXPECT_DOUBLE_EQ(machine.axis[3].speed, 12.5);
    set_parameter(machine, "settle_ms=30");
    EXPECT_EQ(machine.settle_ns, 30'000'000);
    set_parameter(machine, "laser.mark_speed_min_mm_s=2");
    EXPECT_DOUBLE_EQ(machine.laser.mark_speed_min.si(), 2e-3);
}

TEST(MachineParameters, WhatIsNoSettingIsRefusedAndChangesNothing) {
    const auto refused = [](const std::string& setting) {
        MachineConfig machine = reference_machine();
        try {
            set_parameter(machine, setting);
        } catch (const InputError& error) {
            std::array<std::uint8_t, link::kConfigSize> now{};
            std::array<std::uint8_t, link::kConfigSize> before{};
            link::serialise(machine, now);
            link::serialise(reference_machine(), before);
            EXPECT_EQ(now, before);
            return std::string(error.what());
        }
        return std::string("taken");
    };
    EXPECT_NE(refused("x.speed_mm=1").find("is it x.speed_mm_s?"), std::string::npos) << refused("x.speed_mm=1");
    EXPECT_NE(refused("x.speed_mm_s").find("NAME=VALUE"), std::string::npos);
    for (const char* bad :
         {"x.speed_mm_s=", "x.speed_mm_s=fast", "x.speed_mm_s=4x", "x.speed_mm_s=inf", "x.speed_mm_s=1e300"}) {
        EXPECT_NE(refused(bad).find("no number"), std::string::npos) << bad;
    }
    for (const char* bad : {"x.speed_mm_s=0", "x.travel_min_mm=5000", "heartbeat_timeout_ms=5", "y.home_mm=-5000"}) {
        EXPECT_NE(refused(bad).find("no controller can run with this"), std::string::npos) << bad;
    }
}

}  // namespace
}  // namespace sc::host
