// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/cell.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "cell_job.hpp"
#include "test_host.hpp"

namespace sc::sim {
namespace {

TEST(SimCell, ComesUpDisabledAndHealthyWithoutAHost) {
    SimCell cell(default_cell());
    for (int i = 0; i < 2000; ++i) {
        cell.tick();
    }
    EXPECT_EQ(cell.state(), State::disabled);
    EXPECT_EQ(cell.faults(), 0U);
    EXPECT_EQ(cell.now_ns(), 2'000'000'000);
    EXPECT_EQ(cell.plant().galvo_words_dropped(), 0U);
}

class SimCellJob : public testing::Test {
protected:
    struct Outcome {
        std::vector<trace::PulseRecord> pulses;
        CellReport report;
    };
    static Outcome burn(const LineJob& job, std::size_t block, std::uint32_t baud) {
        Outcome outcome;
        CellOptions options = default_cell();
        options.baud = baud;
        options.on_pulse = [&](const trace::PulseRecord& r) { outcome.pulses.push_back(r); };
        SimCell cell(options);
        TestHost host(cell);
        EXPECT_TRUE(host.prepare());
        EXPECT_TRUE(host.run(job.items(), 20'000, block));
        outcome.report = cell.report();
        return outcome;
    }
};

TEST_F(SimCellJob, BurnsALineWhereTheWorldsErrorsPutIt) {
    const LineJob job;
    const Outcome outcome = burn(job, 40, 921'600);
    ASSERT_EQ(outcome.pulses.size(), job.pulses());
    EXPECT_EQ(outcome.report.pulses, job.pulses());
    EXPECT_EQ(outcome.report.laser.unlit, 0U);
    EXPECT_EQ(outcome.report.laser.not_allowed, 0U);
    EXPECT_EQ(outcome.report.laser.cancelled, 0U);
    EXPECT_EQ(outcome.report.laser.out_of_rate, 0U);
    EXPECT_EQ(outcome.report.laser.disordered, 0U);
    EXPECT_EQ(outcome.report.first_fault, Fault::none);
    const WorldSpec spec = read_world_spec(default_cell().world);
    for (std::size_t k = 0; k < outcome.pulses.size(); ++k) {
        const trace::PulseRecord& r = outcome.pulses[k];
        const Vec3 command{LineJob::kX0 + static_cast<double>(k) * LineJob::kPitch, LineJob::kY, LineJob::kZ};
        const Vec3 expected = true_focus(spec.axes, command) + Vec3{spec.galvo.offset_x, 0.0, spec.galvo.offset_z};
        ASSERT_EQ(r.hit, 1);
        EXPECT_NEAR(static_cast<double>(r.place_pm[0]) * 1e-12, expected.x, 3e-6) << k;
        EXPECT_NEAR(static_cast<double>(r.place_pm[2]) * 1e-12, expected.z, 2e-6) << k;
        EXPECT_NEAR(static_cast<double>(r.place_pm[1] + r.defocus_pm) * 1e-12, expected.y, 2e-6) << k;
        // The first pulses after a pause are stronger, as this world has it.
        const double left = std::pow(1.0 - 1.0 / spec.laser.first_pulses, static_cast<double>(k));
        EXPECT_NEAR(r.energy_nj / (1.0 + spec.laser.first_pulse_excess * left), 100'000.0, 2'000.0) << k;
    }
}

TEST_F(SimCellJob, CommandHashDependsOnNeitherBlocksNorBaud) {
    const LineJob job;
    const std::string hash = burn(job, 40, 921'600).report.command_trace_sha256;
    EXPECT_EQ(burn(job, 1, 921'600).report.command_trace_sha256, hash);
    EXPECT_EQ(burn(job, 3, 57'600).report.command_trace_sha256, hash);
    EXPECT_NE(burn({0.0201, 0.050}, 40, 921'600).report.command_trace_sha256, hash);
}

TEST_F(SimCellJob, SameCallsGiveTheSamePulses) {
    const LineJob job{0.004, 0.030};
    const Outcome a = burn(job, 40, 921'600);
    const Outcome b = burn(job, 40, 921'600);
    ASSERT_EQ(a.pulses.size(), b.pulses.size());
    EXPECT_TRUE(std::ranges::equal(a.pulses, b.pulses, [](const auto& p, const auto& q) {
        return p.t_ns == q.t_ns && p.place_pm == q.place_pm && p.energy_nj == q.energy_nj;
    }));
}

}  // namespace
}  // namespace sc::sim
