// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/session.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "shared/path/job_hash.hpp"
#include "tests/unit/host/bridge/fake_cell.hpp"

namespace sc::host {
namespace {

using test::example_items;
using test::FakeCell;

class SessionTest : public ::testing::Test {
protected:
    void SetUp() override {
        file_ = std::filesystem::path(::testing::TempDir()) /
                (std::string("session_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".sqlite");
        std::filesystem::remove(file_);
        journal_ = std::make_unique<Journal>(
            file_, JournalJob{job_hash(items_), static_cast<std::uint32_t>(items_.size()), "test"},
            JournalStart::new_job);
        client_.connect();
    }
    void TearDown() override {
        journal_.reset();
        std::filesystem::remove(file_);
    }
    RunResult run() {
        Session session(client_, {});
        return session.run({job_hash(items_), items_, 0.0}, journal_.get());
    }

    std::vector<Item> items_ = example_items(10, 30);
    FakeCell cell_;
    CellClient client_{cell_, {}};
    std::filesystem::path file_;
    std::unique_ptr<Journal> journal_;
};

TEST_F(SessionTest, RunsAJobAndLeavesTheCellUnpowered) {
    const RunResult result = run();
    EXPECT_EQ(cell_.taken, items_);
    EXPECT_EQ(cell_.state, State::disabled);
    EXPECT_TRUE(cell_.homed);
    EXPECT_EQ(result.pulses, items_.size());
    EXPECT_GT(result.cell_seconds, 0.0);
    const JournalSummary summary = read_journal(file_);
    EXPECT_EQ(summary.outcome, JobOutcome::done);
    EXPECT_EQ(summary.last->fired, items_.size());
    EXPECT_EQ(summary.last->sent, items_.size());
}

TEST_F(SessionTest, PreviewsAsOftenAsAsked) {
    Session session(client_, {});
    const PreviewResult result = session.preview({job_hash(items_), items_, 0.0}, 3);
    EXPECT_EQ(result.rounds, 3U);
    EXPECT_FALSE(result.stopped);
    EXPECT_EQ(cell_.done[link::Verb::preview], 3);
    EXPECT_EQ(cell_.done[link::Verb::arm], 0);
    EXPECT_EQ(cell_.done[link::Verb::start], 0);
    EXPECT_EQ(cell_.state, State::disabled);
}

TEST_F(SessionTest, PreviewsAgainAndAgainUntilItIsStopped) {
    client_.set_stop_check([this] { return cell_.done[link::Verb::preview] == 4 && cell_.fired > 20; });
    Session session(client_, {});
    const PreviewResult result = session.preview({job_hash(items_), items_, 0.0}, 0);
    EXPECT_EQ(result.rounds, 3U);
    EXPECT_TRUE(result.stopped);
    EXPECT_EQ(cell_.state, State::disabled);
}

TEST_F(SessionTest, APreviewThatBurnsIsNoticed) {
    cell_.burns_in_preview = true;
    Session session(client_, {});
    EXPECT_THROW(static_cast<void>(session.preview({job_hash(items_), items_, 0.0}, 1)), CellError);
    EXPECT_EQ(cell_.state, State::disabled);
}

TEST_F(SessionTest, DoesNotHomeTwice) {
    cell_.homed = true;
    run();
    EXPECT_EQ(cell_.done[link::Verb::home], 0);
}

TEST_F(SessionTest, BringsTheCellToRestWhenInterrupted) {
    client_.set_stop_check([this] { return cell_.fired > 100; });
    EXPECT_THROW(run(), Interrupted);
    EXPECT_EQ(cell_.state, State::disabled);
    EXPECT_EQ(cell_.done[link::Verb::hold], 1);
    EXPECT_EQ(cell_.done[link::Verb::abort], 1);
    const JournalSummary summary = read_journal(file_);
    EXPECT_EQ(summary.outcome, JobOutcome::aborted);
    EXPECT_GT(summary.last->fired, 90U);
    EXPECT_LT(summary.last->fired, items_.size());
    EXPECT_GE(summary.last->sent, cell_.taken.size());
}

TEST_F(SessionTest, LeavesAFaultLatchedAndTheJournalFailed) {
    cell_.fault_at_item = 120;
    EXPECT_THROW(run(), CellFault);
    EXPECT_EQ(cell_.state, State::fault);
    EXPECT_EQ(cell_.done[link::Verb::reset_fault], 0);
    const JournalSummary summary = read_journal(file_);
    EXPECT_EQ(summary.outcome, JobOutcome::failed);
    EXPECT_GE(summary.last->fired, 100U);
}

TEST_F(SessionTest, DisarmsAfterARefusedItem) {
    cell_.refuse_item = 60;
    EXPECT_THROW(run(), CellRefused);
    EXPECT_EQ(cell_.state, State::disabled);
    EXPECT_EQ(read_journal(file_).outcome, JobOutcome::failed);
}

TEST_F(SessionTest, UnpowersWhenArmingIsRefused) {
    cell_.refuse[link::Verb::arm] = Refusal::interlock_open;
    EXPECT_THROW(run(), CellRefused);
    EXPECT_EQ(cell_.state, State::disabled);
    EXPECT_EQ(cell_.jobs_opened, 0);
}

TEST_F(SessionTest, GivesUpQuietlyWhenTheLinkHasGone) {
    cell_.each_period = [this] { cell_.unplugged = cell_.fired > 80; };
    EXPECT_THROW(run(), LinkError);
    const JournalSummary summary = read_journal(file_);
    EXPECT_EQ(summary.outcome, JobOutcome::failed);
    EXPECT_GE(summary.last->sent, summary.last->fired);
}

}  // namespace
}  // namespace sc::host
