// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/client.hpp"

#include <string>

#include <gtest/gtest.h>

#include "shared/link/config.hpp"
#include "tests/unit/host/bridge/fake_cell.hpp"

namespace sc::host {
namespace {

using test::FakeCell;
using test::Trouble;

constexpr Nanoseconds kSecond{1'000'000'000};

ClientOptions options() {
    ClientOptions o;
    o.session = 4711;
    return o;
}

TEST(CellClient, OpensASessionAndReadsTheMachine) {
    FakeCell cell;
    cell.machine.axis[2].travel_min = -0.123;
    CellClient client(cell, options());
    client.connect();
    EXPECT_EQ(client.hello().session, 4711U);
    const MachineConfig machine = client.read_config();
    EXPECT_EQ(machine.axis[2].travel_min, -0.123);
    EXPECT_EQ(machine.keep_out_count, cell.machine.keep_out_count);
}

TEST(CellClient, RefusesAnotherSchemaAndNamesBoth) {
    FakeCell cell;
    cell.schema ^= 1U;
    CellClient client(cell, options());
    try {
        client.connect();
        FAIL() << "connected";
    } catch (const CellRefused& refused) {
        EXPECT_EQ(refused.refusal, Refusal::schema_mismatch);
        EXPECT_NE(std::string(refused.what()).find("100 schema_mismatch"), std::string::npos) << refused.what();
        EXPECT_NE(std::string(refused.what()).find("same version"), std::string::npos) << refused.what();
    }
}

TEST(CellClient, SaysWhenNobodyAnswers) {
    FakeCell cell;
    cell.mute = true;
    CellClient client(cell, options());
    EXPECT_THROW(client.connect(), LinkError);
    EXPECT_EQ(cell.hellos, options().attempts);
}

TEST(CellClient, SaysWhenTheLinkCloses) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    cell.unplugged = true;
    EXPECT_THROW(client.pump(client.now() + kSecond), LinkError);
}

TEST(CellClient, CountsALongSilenceAsALostLink) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    cell.mute = true;
    EXPECT_NO_THROW(client.pump_until([] { return false; }, 9 * kSecond));
    EXPECT_THROW(client.pump_until([] { return false; }, 2 * kSecond), LinkError);
}

TEST(CellClient, BeatsAtLeastThreeTimesWithinTheTimeout) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    client.pump_until([] { return false; }, 2 * kSecond);
    ASSERT_GT(cell.heartbeats.size(), 60U);
    for (std::size_t i = 1; i < cell.heartbeats.size(); ++i) {
        EXPECT_LE((cell.heartbeats[i] - cell.heartbeats[i - 1]).count(), options().heartbeat_timeout.count() / 3);
    }
}

TEST(CellClient, DoesEachCommandOnceOverABadLink) {
    FakeCell cell({.drop = 0.3, .repeat = 0.2, .corrupt = 0.1, .seed = 5});
    CellClient client(cell, options());
    client.connect();
    client.command(link::Verb::enable);
    for (int i = 0; i < 40; ++i) {
        client.command(link::Verb::jog, 0, i, 1000);
    }
    client.command(link::Verb::disable);
    EXPECT_EQ(cell.done[link::Verb::enable], 1);
    EXPECT_EQ(cell.done[link::Verb::jog], 40);
    EXPECT_EQ(cell.done[link::Verb::disable], 1);
    EXPECT_GT(client.repeats(), 0U);
    const WireCounters counters = client.counters();
    EXPECT_GT(counters.frames_bad, 0U);
    EXPECT_GT(counters.messages_lost, 0U);
    EXPECT_GT(counters.messages_repeated, 0U);
}

TEST(CellClient, ReadsTheMachineOverABadLink) {
    FakeCell cell({.drop = 0.3, .repeat = 0.2, .corrupt = 0.1, .seed = 9});
    CellClient client(cell, options());
    client.connect();
    EXPECT_EQ(client.read_config().axis[0].travel_max, cell.machine.axis[0].travel_max);
}

TEST(CellClient, HandsOnARefusalWithItsNumberAndText) {
    FakeCell cell;
    cell.refuse[link::Verb::arm] = Refusal::interlock_open;
    CellClient client(cell, options());
    client.connect();
    try {
        client.command(link::Verb::arm);
        FAIL() << "accepted";
    } catch (const CellRefused& refused) {
        EXPECT_EQ(refused.refusal, Refusal::interlock_open);
        EXPECT_NE(std::string(refused.what()).find("106"), std::string::npos);
        EXPECT_NE(std::string(refused.what()).find("arm"), std::string::npos);
    }
}

TEST(CellClient, ConnectsAgainWhenTheSessionHasGone) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    cell.hellos = 0;
    EXPECT_NO_THROW(client.command(link::Verb::enable));
    EXPECT_EQ(cell.hellos, 1);
}

TEST(CellClient, SendsTheCompensationAsItIs) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    Compensation compensation;
    compensation.axis_from_h.row[0] = {1.0, -1e-4, 2e-5};
    compensation.axis_from_h.row[2] = {0.0, 0.0, 1.0001};
    compensation.axis_offset = {1e-5, 2e-5, 3e-5};
    compensation.galvo_from_field = {1.001, 2e-4, -3e-4, 0.999};
    compensation.galvo_offset = {5e-5, -6e-5};
    client.set_compensation(compensation);
    EXPECT_EQ(cell.compensation.axis_matrix,
              (std::array<double, 9>{1.0, -1e-4, 2e-5, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0001}));
    EXPECT_EQ(cell.compensation.axis_offset, (std::array<double, 3>{1e-5, 2e-5, 3e-5}));
    EXPECT_EQ(cell.compensation.galvo_matrix, compensation.galvo_from_field);
    EXPECT_EQ(cell.compensation.galvo_offset, compensation.galvo_offset);
}

TEST(CellClient, SendsTheGalvoFieldInOrderAndEndsIt) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    GalvoField field;
    for (std::size_t i = 0; i < GalvoField::kNumbers; ++i) {
        field.set_number(i, static_cast<double>(i) + 0.5);
    }
    client.set_galvo_field(field);
    ASSERT_EQ(cell.galvo_field.size(), GalvoField::kNumbers);
    for (std::size_t i = 0; i < GalvoField::kNumbers; ++i) {
        EXPECT_EQ(cell.galvo_field[i], static_cast<double>(i) + 0.5);
    }
    EXPECT_TRUE(cell.galvo_field_ended);
    cell.galvo_field.clear();
    client.set_galvo_field({});
    EXPECT_TRUE(cell.galvo_field.empty());
    EXPECT_TRUE(cell.galvo_field_ended);
    PowerCurve curve;
    curve.count = 2;
    curve.byte[1] = 255;
    curve.watts[1] = 75.0;
    client.set_power_curve(curve);
    EXPECT_EQ(cell.power_curve.count, 2);
    EXPECT_EQ(cell.power_curve.bytes[1], 255);
    EXPECT_EQ(cell.power_curve.watts[1], 75.0);
    client.set_galvo_lag({163'500, Frequency::from_si(1812.5), 0.71});
    EXPECT_EQ(cell.galvo_lag.latency_ns, 163'500U);
    EXPECT_EQ(cell.galvo_lag.natural_frequency_hz, 1812.5);
    EXPECT_EQ(cell.galvo_lag.damping, 0.71);
}

TEST(CellClient, AsksTheSensorsAndSaysWhyASeatIsRefused) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    client.set_surface({.mode = 2, .zero = 0.12, .window = 1e-3, .bound = 5e-4});
    EXPECT_EQ(cell.surface.mode, 2);
    EXPECT_EQ(cell.surface.zero, 0.12);
    cell.sensors.value = {7, 8, 9, -10};
    EXPECT_EQ(client.read_sensors().value, cell.sensors.value);
    client.check_seating({.expected = {1, 2, 3}, .tolerance = 4, .samples = 2});
    EXPECT_EQ(cell.seating.expected[2], 3);
    cell.seating_answer = {.refusal = static_cast<std::uint16_t>(Refusal::seating_off), .detail = 84'000};
    try {
        client.check_seating({.expected = {1, 2, 3}, .tolerance = 4, .samples = 2});
        ADD_FAILURE() << "nothing was thrown";
    } catch (const CellRefused& refused) {
        EXPECT_EQ(refused.refusal, Refusal::seating_off);
        EXPECT_NE(std::string(refused.what()).find("+0.840 mm"), std::string::npos) << refused.what();
    }
}

TEST(CellClient, RefusesWhatVersion10OfTheLinkLacks) {
    FakeCell cell;
    cell.minor = 0;
    cell.schema = link::kSchemaHashes[0];
    CellClient client(cell, options());
    client.connect();
    client.set_galvo_lag({});
    client.set_surface({});
    EXPECT_THROW(client.set_galvo_lag({163'500, Frequency::from_si(1812.5), 0.71}), CellRefused);
    EXPECT_THROW(client.set_surface({.mode = 1}), CellRefused);
    EXPECT_THROW(client.check_seating({}), CellRefused);
    EXPECT_THROW((void)client.read_sensors(), CellRefused);
    EXPECT_EQ(cell.surface.mode, 0);
}

TEST(CellClient, TellsEachChangeOfStateOnce) {
    FakeCell cell;
    CellClient client(cell, options());
    std::vector<State> seen;
    client.on_state([&](State /*from*/, State to) { seen.push_back(to); });
    client.connect();
    client.command(link::Verb::enable);
    client.wait_for({State::idle}, kSecond, "enable");
    client.command(link::Verb::arm);
    client.wait_for({State::armed}, kSecond, "arm");
    client.pump_until([] { return false; }, kSecond);
    EXPECT_EQ(seen.back(), State::armed);
    EXPECT_EQ(std::count(seen.begin(), seen.end(), State::idle), 1);
    EXPECT_EQ(std::count(seen.begin(), seen.end(), State::armed), 1);
}

TEST(CellClient, WaitingEndsWithTheFaultOrInTime) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    EXPECT_THROW(client.wait_for({State::marking}, kSecond, "marking"), CellError);
    cell.state = State::fault;
    try {
        client.wait_for({State::idle}, kSecond, "enable");
        FAIL() << "no fault";
    } catch (const CellFault& fault) {
        EXPECT_EQ(fault.fault, Fault::none);
    }
}

TEST(CellClient, StoresParametersAndReadsThemBack) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    EXPECT_EQ(client.read_parameters().generation, 0U);
    MachineConfig machine = reference_machine();
    machine.settle_ns = 31'000'000;
    client.store_parameters(machine);
    const StoredParameters stored = client.read_parameters();
    EXPECT_TRUE(stored.fitted);
    EXPECT_EQ(stored.generation, 1U);
    const auto read = link::deserialise(stored.bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->settle_ns, 31'000'000);
    client.store_parameters(std::nullopt);
    EXPECT_TRUE(client.read_parameters().bytes.empty());
}

TEST(CellClient, StopCheckEndsAnyWait) {
    FakeCell cell;
    CellClient client(cell, options());
    client.connect();
    bool stop = false;
    client.set_stop_check([&] { return stop; });
    EXPECT_NO_THROW(client.pump(client.now() + kSecond));
    stop = true;
    EXPECT_THROW(client.pump(client.now() + kSecond), Interrupted);
}

}  // namespace
}  // namespace sc::host
