// SPDX-License-Identifier: Apache-2.0
// Parameters that outlive the power, in the loop: when they are written, and what is refused.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "cell_rig.hpp"
#include "shared/codes/codes.hpp"
#include "shared/link/config.hpp"

namespace {

using namespace sc;
using namespace sc::test;

using Bytes = std::vector<std::uint8_t>;

Bytes parameters_of(const MachineConfig& machine) {
    std::array<std::uint8_t, link::kConfigSize> bytes{};
    link::serialise(machine, bytes);
    return {bytes.begin(), bytes.end()};
}

class ParametersInTheLoop : public testing::Test {
protected:
    ParametersInTheLoop() {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) /
                  ("parameters_" + std::to_string(::getpid()) + "_" + test->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    [[nodiscard]] CellRig::Options kept() const {
        CellRig::Options options;
        options.memory = folder_ / "retained";
        return options;
    }
    [[nodiscard]] Bytes file() const {
        std::ifstream in((folder_ / "retained").string() + ".parameters", std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void ready(CellRig& rig) {
        rig.connect();
        ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    }
    static std::uint16_t code(Refusal refusal) { return static_cast<std::uint16_t>(refusal); }

    std::filesystem::path folder_;
};

TEST_F(ParametersInTheLoop, AreToldAndInForceAtTheNextStart) {
    MachineConfig machine = reference_machine();
    machine.settle_ns += 7'000'000;
    const Bytes bytes = parameters_of(machine);
    {
        CellRig rig(kept());
        ready(rig);
        EXPECT_EQ(rig.parameters().fitted, 1);
        EXPECT_EQ(rig.parameters().generation, 0U);
        EXPECT_EQ(rig.store(bytes, link::kConfigVersion).refusal, 0);
        const link::Parameters told = rig.parameters();
        EXPECT_EQ(told.generation, 1U);
        EXPECT_EQ(told.in_force, 0);
        EXPECT_EQ(told.bytes, bytes.size());
        const link::Parameters more = rig.parameters(1000);
        ASSERT_EQ(more.count, bytes.size() - 1000);
        EXPECT_TRUE(std::equal(bytes.begin() + 1000, bytes.end(), more.data.begin()));
    }
    CellRig rig(kept());
    ready(rig);
    EXPECT_EQ(rig.parameters().in_force, 1);
}

TEST_F(ParametersInTheLoop, NothingIsWrittenWhileTheLaserMayComeOn) {
    CellRig rig(kept());
    ready(rig);
    rig.make_ready();
    ASSERT_EQ(rig.command(link::Verb::disarm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle, 5000));
    const std::uint32_t sequence = rig.send_store(parameters_of(reference_machine()), link::kConfigVersion);
    rig.ticks(30);
    ASSERT_FALSE(rig.answered(sequence));
    EXPECT_EQ(rig.command(link::Verb::arm).refusal, code(Refusal::wrong_state)) << "it is being written";
    ASSERT_TRUE(rig.until([&] { return rig.answered(sequence); }, 2000));
    EXPECT_EQ(rig.parameters().generation, 1U);
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::armed, 10'000));
    const Bytes armed = file();
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until([&] { return rig.pulses().size() > 100; }, 60'000));
    EXPECT_EQ(rig.store(parameters_of(reference_machine()), link::kConfigVersion).refusal, code(Refusal::wrong_state));
    ASSERT_TRUE(rig.until_state(State::armed, 60'000));
    EXPECT_EQ(file(), armed);
    EXPECT_EQ(rig.parameters().generation, 1U);
}

TEST_F(ParametersInTheLoop, WhatNoControllerCanRunWithIsRefused) {
    CellRig rig(kept());
    ready(rig);
    MachineConfig bad = reference_machine();
    bad.axis[0].speed = -1.0;
    EXPECT_EQ(rig.store(parameters_of(bad), link::kConfigVersion).refusal, code(Refusal::parameters_bad));
    EXPECT_EQ(rig.store(parameters_of(reference_machine()), link::kConfigVersion + 1).refusal,
              code(Refusal::parameters_bad));
    EXPECT_EQ(rig.store(Bytes(50, 7), link::kConfigVersion).refusal, code(Refusal::parameters_bad));
    EXPECT_EQ(rig.parameters().generation, 0U);

    CellRig without;
    ready(without);
    EXPECT_EQ(without.parameters().fitted, 0);
    EXPECT_EQ(without.store(parameters_of(reference_machine()), link::kConfigVersion).refusal,
              code(Refusal::parameters_not_kept));
}

TEST_F(ParametersInTheLoop, AStartWithAWornOutMemoryRunsWithWhatTheBoardWasBuiltWith) {
    {
        std::ofstream out((folder_ / "retained").string() + ".parameters", std::ios::binary);
        out << std::string(2560, '\x33');
    }
    CellRig rig(kept());
    ready(rig);
    EXPECT_EQ(rig.parameters().generation, 0U);
    EXPECT_EQ(rig.store(parameters_of(reference_machine()), link::kConfigVersion).refusal, 0);
    EXPECT_EQ(rig.parameters().generation, 1U);
}

}  // namespace
