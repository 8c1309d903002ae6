// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "image_path.hpp"

namespace sc::mps2_an500 {
namespace {

TEST(InstructionCounter, CountsLoopsOfKnownLengthToTheInstruction) {
    M7Controller core(image_under_test(), reference_machine(), 1);
    const std::vector<std::uint32_t> counted = core.count_loops();
    ASSERT_EQ(counted.size(), kLoops);
    EXPECT_EQ(loop_instructions_of(0), 4U);
    EXPECT_GT(loop_instructions_of(kLoops - 1), 2'000'000U);
    for (std::size_t i = 0; i < kLoops; ++i) {
        EXPECT_EQ(counted[i], loop_instructions_of(i)) << i;
    }
}

TEST(InstructionCounter, CountsTheSameForTheSameTicks) {
    const auto costs = [] {
        M7Controller core(image_under_test(), reference_machine(), 1);
        ServoOutputs outputs;
        std::vector<std::uint32_t> all;
        for (ServoInputs inputs; inputs.tick < 50; ++inputs.tick) {
            core.tick(inputs, outputs);
            all.push_back(core.last_cost().servo);
            all.push_back(core.last_cost().plan);
        }
        return all;
    };
    const std::vector<std::uint32_t> first = costs();
    EXPECT_EQ(costs(), first);
    EXPECT_GT(first[0], 1000U);
}

}  // namespace
}  // namespace sc::mps2_an500
