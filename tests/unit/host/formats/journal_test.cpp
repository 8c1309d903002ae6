// SPDX-License-Identifier: Apache-2.0
#include "host/formats/journal.hpp"

#include <array>
#include <csignal>

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/formats/schema.hpp"
#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

constexpr JobProgress kSome{
    .sent = 300, .planned = 200, .fired = 100, .path = 7, .pass = 1, .pulses = 42, .cell_state = State::marking};
const JournalJob kJob{.hash = 0xFEDCBA9876543210ULL, .items = 1234, .name = "ras3dm"};
const JournalJob kOther{.hash = 0x1ULL, .items = 1234, .name = "other"};

JobProgress numbered(std::uint32_t i) {
    JobProgress p = kSome;
    p.fired = i;
    return p;
}

TEST(Journal, RemembersTheLastLineAndTheOutcome) {
    const TempDir dir;
    const auto path = dir / "j.sqlite";
    {
        Journal journal(path, kJob);
        EXPECT_FALSE(journal.last());
        journal.record(kSome);
        journal.record(numbered(101));
        EXPECT_EQ(journal.last(), numbered(101));
        JournalSummary summary = read_journal(path);  // while the writer is open, as monitor does
        EXPECT_EQ(summary.last, numbered(101));
        EXPECT_EQ(summary.outcome, JobOutcome::open);
        journal.close(JobOutcome::aborted);
    }
    const JournalSummary summary = read_journal(path);
    EXPECT_EQ(summary.job.hash, kJob.hash);
    EXPECT_EQ(summary.job.items, kJob.items);
    EXPECT_EQ(summary.job.name, kJob.name);
    EXPECT_EQ(summary.outcome, JobOutcome::aborted);
    EXPECT_EQ(summary.last, numbered(101));
    EXPECT_EQ(summary.created.size(), std::string("2026-01-31T12:00:00.000Z").size());
    EXPECT_GE(summary.last_time, summary.created);
}

TEST(Journal, GoesOnWithTheSameJob) {
    const TempDir dir;
    const auto path = dir / "j.sqlite";
    {
        Journal journal(path, kJob);
        journal.record(kSome);
        journal.close(JobOutcome::failed);
    }
    Journal journal(path, kJob);
    EXPECT_EQ(journal.last(), kSome);
    EXPECT_EQ(read_journal(path).outcome, JobOutcome::open);
}

TEST(Journal, RefusesAnotherJobAndNamesBothHashes) {
    const TempDir dir;
    const auto path = dir / "j.sqlite";
    {
        Journal(path, kJob).record(kSome);
    }
    expect_refusal([&] { const Journal journal(path, kOther); }, {.file = path.string(),
                                                                  .value = "fedcba9876543210, not 0000000000000001",
                                                                  .problem = "journal of another job (ras3dm)"});
    EXPECT_EQ(read_journal(path).last, kSome) << "nothing has changed";
    JournalJob shorter = kJob;
    shorter.items = 5;
    EXPECT_THROW(Journal(path, shorter), InputError);
}

TEST(Journal, KeepsTheOldJobAsHistoryWhenAskedForANewOne) {
    const TempDir dir;
    const auto path = dir / "j.sqlite";
    {
        Journal(path, kJob).record(kSome);
    }
    {
        Journal journal(path, kOther, JournalStart::new_job);
        EXPECT_FALSE(journal.last());
    }
    EXPECT_EQ(read_journal(path).job.hash, kOther.hash);
    Database database(path, DatabaseAccess::read_only);
    Statement count = database.prepare("SELECT count(*) FROM jobs");
    ASSERT_TRUE(count.step());
    EXPECT_EQ(count.integer(0), 2);
}

TEST(Journal, SurvivesKillOfItsWriterAtAnyMoment) {
    const TempDir dir;
    for (int round = 0; round < 5; ++round) {
        const auto path = dir / ("j" + std::to_string(round) + ".sqlite");
        std::array<int, 2> pipe{};
        ASSERT_EQ(::pipe(pipe.data()), 0);
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            // Tells the number of each line once record() has returned, and never stops by itself.
            Journal journal(path, kJob);
            for (std::uint32_t i = 1;; ++i) {
                journal.record(numbered(i));
                if (::write(pipe[1], &i, sizeof i) != static_cast<ssize_t>(sizeof i)) {
                    ::_exit(1);
                }
            }
        }
        ::close(pipe[1]);
        std::uint32_t told = 0;
        while (told < 3U + 4U * static_cast<std::uint32_t>(round)) {
            ASSERT_EQ(::read(pipe[0], &told, sizeof told), static_cast<ssize_t>(sizeof told));
        }
        ASSERT_EQ(::kill(child, SIGKILL), 0);
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        ASSERT_TRUE(WIFSIGNALED(status));
        while (::read(pipe[0], &told, sizeof told) == static_cast<ssize_t>(sizeof told)) {
        }
        ::close(pipe[0]);

        const JournalSummary summary = read_journal(path);
        EXPECT_EQ(summary.outcome, JobOutcome::open);
        ASSERT_TRUE(summary.last);
        // All that was told is there; at most the one line that was being written is there besides.
        EXPECT_GE(summary.last->fired, told);
        EXPECT_LE(summary.last->fired, told + 1);
        EXPECT_EQ(summary.last->path, kSome.path);
        Journal again(path, kJob);
        again.record(numbered(9999));
        EXPECT_EQ(again.last(), numbered(9999));
    }
}

TEST(ReadJournal, RefusesWhatIsNoJournalAndLeavesItAlone) {
    const TempDir dir;
    expect_refusal([&] { static_cast<void>(read_journal(dir / "no")); },
                   {.file = (dir / "no").string(), .problem = "no such journal"});
    const auto text = dir.write("text", std::string(5000, 'x'));
    expect_refusal([&] { static_cast<void>(read_journal(text)); },
                   {.file = text.string(), .problem = "not a journal of this program"});
    EXPECT_THROW(Journal(text, kJob), InputError);
    EXPECT_EQ(test::slurp(text), std::string(5000, 'x'));
    const auto empty = dir.write("empty", "");
    expect_refusal([&] { static_cast<void>(read_journal(empty)); },
                   {.file = empty.string(), .problem = "without a job"});
    EXPECT_THROW(Journal((dir / "missing") / "j", kJob), InputError);
}

TEST(Database, RefusesAFileOfAnotherProgramAndOfANewerSchema) {
    const TempDir dir;
    const auto path = dir / "x.sqlite";
    sqlite3* handle = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &handle), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(handle, "CREATE TABLE t (a)", nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(handle);
    EXPECT_THROW(Database(path, DatabaseAccess::read_write_create), InputError);

    const auto newer = dir / "newer.sqlite";
    {
        Database(newer, DatabaseAccess::read_write_create).run("PRAGMA user_version = 99");
    }
    expect_refusal([&] { const Database database(newer, DatabaseAccess::read_write_create); },
                   {.file = newer.string(), .value = "99", .problem = "newer schema"});
}

TEST(Database, MigratesStepByStepAndKeepsWhatIsThere) {
    const TempDir dir;
    const auto path = dir / "old.sqlite";
    sqlite3* handle = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &handle), SQLITE_OK);
    const std::string first = std::string(schema_migrations()[0]) +
                              "PRAGMA user_version = 1; PRAGMA application_id = " + std::to_string(kApplicationId) +
                              "; INSERT INTO jobs (hash, name, items, created) VALUES (5, 'old', 3, 'then')";
    ASSERT_EQ(sqlite3_exec(handle, first.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(handle);
    sqlite3_close(handle);

    Database database(path, DatabaseAccess::read_write_create);
    EXPECT_EQ(database.version(), static_cast<int>(schema_migrations().size()));
    Statement jobs = database.prepare("SELECT name FROM jobs");
    ASSERT_TRUE(jobs.step());
    EXPECT_EQ(jobs.text(0), "old");
    database.run(
        "INSERT INTO measurements (job, time, kind, subject, quantity, value, unit) "
        "VALUES (1, 'now', 'verification', 'face 0 marker 1', 'dx', 1e-5, 'm')");
    EXPECT_THROW(database.run("INSERT INTO progress (job, time, sent, planned, fired, path, pass, pulses, cell_state) "
                              "VALUES (77, 'now', 0, 0, 0, 0, 0, 0, 0)"),
                 DatabaseError)
        << "a line of a job that does not exist";
}

TEST(Transaction, RollsBackUnlessCommitted) {
    const TempDir dir;
    Database database(dir / "t.sqlite", DatabaseAccess::read_write_create);
    const auto jobs = [&database] {
        Statement count = database.prepare("SELECT count(*) FROM jobs");
        return count.step() ? count.integer(0) : -1;
    };
    constexpr std::string_view kInsert = "INSERT INTO jobs (hash, name, items, created) VALUES (1, 'a', 1, 'now')";
    {
        const Transaction transaction(database);
        database.run(kInsert);
        EXPECT_EQ(jobs(), 1);
    }
    EXPECT_EQ(jobs(), 0);
    {
        Transaction transaction(database);
        database.run(kInsert);
        transaction.commit();
    }
    EXPECT_EQ(jobs(), 1);
}

}  // namespace
}  // namespace sc::host
