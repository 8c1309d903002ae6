// SPDX-License-Identifier: Apache-2.0
// A job traced with the guide laser: all of it, slowly, and without a way for the beam.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cell_rig.hpp"
#include "undisturbed.hpp"

namespace sc::test {
namespace {

Refusal refusal(const link::CommandReply& reply) { return static_cast<Refusal>(reply.refusal); }

class Preview : public testing::Test {
protected:
    void make_idle(const std::string& script = "") {
        CellRig::Options options;
        options.script = script;
        rig_ = std::make_unique<CellRig>(options);
        rig_->cell().plant().watch_guide([this](const trace::PulseRecord& spot) { spots_.push_back(spot); });
        rig_->connect();
        ASSERT_TRUE(rig_->until_state(State::disabled, 5000));
        ASSERT_EQ(rig_->command(link::Verb::enable).refusal, 0);
        ASSERT_TRUE(rig_->until_state(State::idle, 5000));
        ASSERT_EQ(rig_->command(link::Verb::home).refusal, 0);
        ASSERT_TRUE(rig_->until_state(State::homing, 100));
        ASSERT_TRUE(rig_->until_state(State::idle, 120'000));
    }
    Refusal begin() {
        EXPECT_EQ(rig_->open_job(short_job()).refusal, 0);
        return refusal(rig_->command(link::Verb::preview));
    }
    bool to_its_end() {
        return rig_->until([&] { return rig_->state() == State::idle && rig_->status().flags & link::kFlagJobDone; },
                           60'000);
    }
    /// Nothing that makes light has been switched on since the cell was.
    void expect_dark() const {
        const sim::BeamCounters& beam = rig_->cell().plant().beam_counters();
        EXPECT_EQ(beam.master_oscillator_ns, 0);
        EXPECT_EQ(beam.gate_ns, 0);
        EXPECT_EQ(beam.shutter_ns, 0);
        EXPECT_EQ(beam.shuttered, 0U);
        const sim::LaserCounters& laser = rig_->cell().plant().laser_counters();
        EXPECT_EQ(laser.unlit + laser.not_allowed + laser.cancelled + laser.cut, 0U) << "triggers that were sent";
        EXPECT_TRUE(rig_->pulses().empty());
        EXPECT_TRUE(rig_->path_pulses().empty());
    }

    std::unique_ptr<CellRig> rig_;
    std::vector<trace::PulseRecord> spots_;
};

double apart(const trace::PulseRecord& a, const trace::PulseRecord& b) {
    return std::hypot(static_cast<double>(a.place_pm[0] - b.place_pm[0]),
                      static_cast<double>(a.place_pm[2] - b.place_pm[2]));
}

/// Largest way from a record of the one list to the nearest of the other, pm.
double strays(const std::vector<trace::PulseRecord>& from, const std::vector<trace::PulseRecord>& to) {
    double most = 0.0;
    for (const trace::PulseRecord& a : from) {
        double nearest = 1e30;
        for (const trace::PulseRecord& b : to) {
            nearest = std::min(nearest, apart(a, b));
        }
        most = std::max(most, nearest);
    }
    return most;
}

TEST_F(Preview, TracesTheWholeJobAndNothingElseWithoutAnyLight) {
    make_idle();
    ASSERT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(to_its_end());
    expect_dark();
    ASSERT_GT(spots_.size(), 2000U);
    // A spot each 10 um; it is switched by ticks, 0.1 mm at its speed, and sees the same errors as the beam.
    EXPECT_LT(strays(undisturbed().pulses(), spots_), 150e6) << "a line was left out";
    EXPECT_LT(strays(spots_, undisturbed().pulses()), 150e6) << "it shines off the lines";
}

TEST_F(Preview, IsNoFasterThanAnEyeCanFollowWhateverTheOverride) {
    make_idle();
    ASSERT_EQ(rig_->command(link::Verb::set_override, 200).refusal, 0);
    ASSERT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(to_its_end());
    double fastest = 0.0;
    for (std::size_t i = 1; i < spots_.size(); ++i) {
        const auto dt = static_cast<double>(spots_[i].t_ns - spots_[i - 1].t_ns);
        if (dt == 100'000.0) {
            fastest = std::max(fastest, apart(spots_[i], spots_[i - 1]) / dt * 1e-3);  // m/s
        }
    }
    // The galvo's paths are programmed at 250 mm/s, twice that by the override. Gains and noise leave 2 %.
    EXPECT_LT(fastest, 0.102);
    EXPECT_GT(fastest, 0.095);
}

TEST_F(Preview, RepeatsStopsWhenToldAndLeavesTheCellFitToMark) {
    make_idle();
    ASSERT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(to_its_end());
    const std::size_t once = spots_.size();
    ASSERT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(to_its_end());
    EXPECT_EQ(spots_.size(), 2 * once);
    ASSERT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(rig_->until([&] { return spots_.size() > 2 * once + 100; }, 20'000));
    EXPECT_EQ(refusal(rig_->command(link::Verb::hold)), Refusal::wrong_state);
    ASSERT_EQ(rig_->command(link::Verb::abort).refusal, 0);
    EXPECT_FALSE(rig_->cell().latest().digital.guide_laser) << "off while it comes to rest";
    ASSERT_TRUE(rig_->until_state(State::idle, 3000));
    expect_dark();
    ASSERT_EQ(rig_->command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig_->until_state(State::armed, 1000));
    ASSERT_EQ(rig_->open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig_->command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig_->until([&] { return (rig_->status().flags & link::kFlagJobDone) != 0; }, 60'000));
    EXPECT_EQ(rig_->command_hash(), undisturbed().command_hash());
}

TEST_F(Preview, StopsWhenTheHostFallsSilent) {
    make_idle();
    ASSERT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(rig_->until([&] { return spots_.size() > 100; }, 20'000));
    rig_->speak(false);
    ASSERT_TRUE(rig_->until_state(State::idle, 2000));
    EXPECT_FALSE(rig_->cell().latest().digital.guide_laser);
    EXPECT_EQ(rig_->cell().faults(), 0U);
}

TEST_F(Preview, WaitsForPointsWithoutLosingItsPlace) {
    make_idle();
    std::vector<Item> items = short_job();
    std::vector<Item> line;
    for (const Item& item : items) {
        if (std::holds_alternative<PathEnd>(item) && line.size() > 10) {
            for (int i = 1; i <= 3000; ++i) {
                line.emplace_back(PathPoint{-24'000'000 + i * 2'000, -31'900'000, -39'000'000 + (i % 40) * 20});
            }
        }
        line.push_back(item);
    }
    rig_->limit_items(1200);
    ASSERT_EQ(rig_->open_job(line).refusal, 0);
    ASSERT_EQ(rig_->command(link::Verb::preview).refusal, 0);
    ASSERT_TRUE(rig_->until([&] { return rig_->ack().planned > 1000; }, 60'000));
    rig_->ticks(3000);
    EXPECT_EQ(rig_->state(), State::previewing);
    const std::size_t waiting = spots_.size();
    rig_->limit_items(0xFFFFFFFF);
    ASSERT_TRUE(to_its_end());
    EXPECT_EQ(rig_->status().faults, 0U);
    // 60 mm of line in steps of 10 um: it went on from where it had come to, and did not begin the path again.
    EXPECT_GT(spots_.size(), waiting + 1000);
    const auto end = *std::max_element(spots_.begin(), spots_.end(),
                                       [](const auto& a, const auto& b) { return a.place_pm[0] < b.place_pm[0]; });
    EXPECT_NEAR(static_cast<double>(end.place_pm[0]), -180e9, 0.3e9);
    std::int64_t back = 0;
    for (std::size_t i = waiting + 1; i < spots_.size(); ++i) {
        back = std::max(back, spots_[i - 1].place_pm[0] - spots_[i].place_pm[0]);
    }
    EXPECT_LT(back, 1'000'000'000) << "no way back of a millimetre between two spots";
    expect_dark();
}

TEST_F(Preview, NeedsTheKeyAndAClosedEnclosureUnlessTheKeyIsAtSetup) {
    make_idle("at 0.1 key off\n");
    EXPECT_EQ(begin(), Refusal::key_off);
    make_idle("at 0.1 interlock open\n");
    EXPECT_EQ(begin(), Refusal::interlock_open);
    make_idle("at 0.1 interlock open\nat 0.1 key setup\n");
    EXPECT_EQ(begin(), Refusal::none);
    ASSERT_TRUE(to_its_end());
    expect_dark();
    EXPECT_GT(spots_.size(), 2000U);
}

TEST_F(Preview, EndsAtOnceWhenTheKeyOrTheEnclosureSaysSo) {
    for (const auto& [script, state] : {std::pair{"key off", State::idle}, std::pair{"interlock open", State::fault},
                                        std::pair{"estop open", State::fault}}) {
        make_idle("at 40 " + std::string(script) + "\n");
        ASSERT_LT(rig_->cell().now_ns(), 40'000'000'000);
        int round = 0;
        while (rig_->cell().now_ns() < 40'000'000'000) {
            ASSERT_LT(++round, 100);
            ASSERT_EQ(begin(), Refusal::none);
            rig_->until([&] { return rig_->cell().now_ns() >= 40'000'000'000 || rig_->state() == State::idle; });
        }
        rig_->ticks(2);
        EXPECT_FALSE(rig_->cell().latest().digital.guide_laser) << script;
        ASSERT_TRUE(rig_->until_state(state, 3000)) << script;
        expect_dark();
    }
}

TEST_F(Preview, AKeyAtSetupMarksNothingWhateverTheHostAsksFor) {
    make_idle("at 0.1 key setup\n");
    EXPECT_EQ(refusal(rig_->command(link::Verb::arm)), Refusal::key_not_production);
    std::mt19937 random(7);
    std::uniform_int_distribution<int> verb(1, 14);
    int previews = 0;
    for (int i = 0; i < 400; ++i) {
        if (rig_->state() == State::idle || rig_->state() == State::armed) {
            rig_->open_job(short_job());
        }
        const auto asked = static_cast<link::Verb>(verb(random));
        const bool took = rig_->command(asked, 0, 1000, 10'000).refusal == 0;
        previews += took && asked == link::Verb::preview ? 1 : 0;
        rig_->ticks(20);
    }
    EXPECT_GT(previews, 0);
    expect_dark();
}

TEST_F(Preview, TheGuideLaserCanBeHadToPointByAndGoesWithAnythingElse) {
    make_idle();
    CellRig& rig = *rig_;
    const auto shines = [&rig] { return rig.cell().latest().digital.guide_laser; };
    rig.ticks(5);
    EXPECT_FALSE(shines()) << "nobody has asked";
    ASSERT_EQ(refusal(rig.command(link::Verb::guide, 1)), Refusal::none);
    rig.ticks(2);
    EXPECT_TRUE(shines());
    EXPECT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagGuideLaser) != 0; }, 100));
    ASSERT_EQ(rig.command(link::Verb::jog, 0, -1'000'000, 50'000).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::jogging, 5));
    EXPECT_TRUE(shines());
    ASSERT_TRUE(rig.until_state(State::idle, 5000));
    EXPECT_TRUE(shines());
    ASSERT_EQ(refusal(rig.command(link::Verb::guide, 0)), Refusal::none);
    rig.ticks(2);
    EXPECT_FALSE(shines());
    ASSERT_EQ(refusal(rig.command(link::Verb::guide, 1)), Refusal::none);
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    EXPECT_TRUE(rig.until([&] { return rig.state() == State::arming && !shines(); }, 3));
    EXPECT_EQ(refusal(rig.command(link::Verb::guide, 1)), Refusal::wrong_state);
    ASSERT_TRUE(rig.until_state(State::armed, 5000));
    ASSERT_EQ(rig.command(link::Verb::disarm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle, 5000));
    rig.ticks(5);
    EXPECT_FALSE(shines()) << "it must be asked for again";
}

TEST_F(Preview, TheGuideLaserGoesWithKeyEnclosureAndHost) {
    for (const char* script : {"key off", "interlock open", "drop"}) {
        SCOPED_TRACE(script);
        const bool silent = std::string(script) == "drop";
        make_idle(silent ? "" : "at 40 " + std::string(script) + "\n");
        CellRig& rig = *rig_;
        ASSERT_TRUE(rig.until([&] { return rig.cell().now_ns() >= 39'900'000'000; }, 40'000));
        ASSERT_EQ(refusal(rig.command(link::Verb::guide, 1)), Refusal::none);
        rig.ticks(2);
        ASSERT_TRUE(rig.cell().latest().digital.guide_laser);
        rig.speak(!silent);
        rig.ticks(200);
        EXPECT_FALSE(rig.cell().latest().digital.guide_laser);
        EXPECT_EQ(rig.state(), State::idle);
    }
}

}  // namespace
}  // namespace sc::test
