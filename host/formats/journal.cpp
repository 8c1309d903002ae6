// SPDX-License-Identifier: Apache-2.0
#include "host/formats/journal.hpp"

#include <array>
#include <bit>
#include <chrono>
#include <cstdio>
#include <string_view>

#include "host/formats/error.hpp"

namespace sc::host {

namespace {

constexpr std::array kOutcomes{JobOutcome::open, JobOutcome::done, JobOutcome::aborted, JobOutcome::failed};

std::string utc_now() {
    const auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
    const auto day = std::chrono::floor<std::chrono::days>(now);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss time(now - day);
    std::array<char, 64> text{};
    const int size =
        std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                      static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                      static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()),
                      static_cast<int>(time.seconds().count()), static_cast<int>(time.subseconds().count()));
    return {text.data(), static_cast<std::size_t>(size)};
}

std::string hex(std::uint64_t value) {
    std::array<char, 24> text{};
    const int size = std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return {text.data(), static_cast<std::size_t>(size)};
}

struct LatestJob {
    std::int64_t row = 0;
    JournalSummary summary;
};

std::optional<LatestJob> latest_job(Database& database) {
    Statement query =
        database.prepare("SELECT id, hash, items, name, created, state FROM jobs ORDER BY id DESC LIMIT 1");
    if (!query.step()) {
        return std::nullopt;
    }
    LatestJob out;
    out.row = query.integer(0);
    out.summary.job = {.hash = std::bit_cast<std::uint64_t>(query.integer(1)),
                       .items = static_cast<std::uint32_t>(query.integer(2)),
                       .name = query.text(3)};
    out.summary.created = query.text(4);
    const std::string state = query.text(5);
    for (const JobOutcome outcome : kOutcomes) {
        if (name_of(outcome) == state) {
            out.summary.outcome = outcome;
        }
    }
    return out;
}

struct TimedProgress {
    JobProgress progress;
    std::string time;
};

std::optional<TimedProgress> latest_progress(Database& database, std::int64_t job) {
    Statement query = database.prepare(
        "SELECT sent, planned, fired, path, pass, pulses, cell_state, time FROM progress WHERE job = ? "
        "ORDER BY id DESC LIMIT 1");
    query.bind(1, job);
    if (!query.step()) {
        return std::nullopt;
    }
    const auto count = [&query](int column) { return static_cast<std::uint32_t>(query.integer(column)); };
    return TimedProgress{{.sent = count(0),
                          .planned = count(1),
                          .fired = count(2),
                          .path = count(3),
                          .pass = static_cast<std::uint8_t>(query.integer(4)),
                          .pulses = count(5),
                          .cell_state = static_cast<State>(query.integer(6))},
                         query.text(7)};
}

/// A file that an older program has written has no such column.
std::optional<std::uint32_t> session_of(Database& database, std::int64_t job) {
    constexpr int kSince = 3;
    if (database.version() < kSince) {
        return std::nullopt;
    }
    Statement query = database.prepare("SELECT session FROM jobs WHERE id = ? AND session IS NOT NULL");
    query.bind(1, job);
    return query.step() ? std::optional(static_cast<std::uint32_t>(query.integer(0))) : std::nullopt;
}

std::int64_t add_job(Database& database, const JournalJob& job) {
    Statement insert = database.prepare("INSERT INTO jobs (hash, items, name, created) VALUES (?, ?, ?, ?)");
    insert.bind(1, std::bit_cast<std::int64_t>(job.hash)).bind(2, std::int64_t{job.items});
    insert.bind(3, std::string_view(job.name)).bind(4, std::string_view(utc_now()));
    static_cast<void>(insert.step());
    return database.last_row();
}

void set_outcome(Database& database, std::int64_t job, JobOutcome outcome) {
    Statement update = database.prepare("UPDATE jobs SET state = ? WHERE id = ?");
    update.bind(1, name_of(outcome)).bind(2, job);
    static_cast<void>(update.step());
}

std::int64_t open_job(Database& database, const JournalJob& job, JournalStart start) {
    Transaction transaction(database);
    const auto latest = latest_job(database);
    const bool go_on = start == JournalStart::resume && latest.has_value();
    if (go_on && (latest->summary.job.hash != job.hash || latest->summary.job.items != job.items)) {
        throw InputError({.file = database.file().string(),
                          .problem = "is the journal of another job (" + latest->summary.job.name + ")",
                          .value = hex(latest->summary.job.hash) + ", not " + hex(job.hash),
                          .action = "name another journal, or start this job anew"});
    }
    const std::int64_t row = go_on ? latest->row : add_job(database, job);
    if (go_on) {
        set_outcome(database, row, JobOutcome::open);
    }
    transaction.commit();
    return row;
}

}  // namespace

std::string_view name_of(JobOutcome outcome) noexcept {
    switch (outcome) {
        case JobOutcome::open: return "open";
        case JobOutcome::done: return "done";
        case JobOutcome::aborted: return "aborted";
        case JobOutcome::failed: return "failed";
    }
    return "?";
}

Journal::Journal(const std::filesystem::path& path, const JournalJob& job, JournalStart start)
    : database_(path, DatabaseAccess::read_write_create), job_row_(open_job(database_, job, start)) {}

void Journal::record(const JobProgress& p) {
    Statement insert = database_.prepare(
        "INSERT INTO progress (job, time, sent, planned, fired, path, pass, pulses, cell_state) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)");
    insert.bind(1, job_row_).bind(2, std::string_view(utc_now())).bind(3, std::int64_t{p.sent});
    insert.bind(4, std::int64_t{p.planned}).bind(5, std::int64_t{p.fired}).bind(6, std::int64_t{p.path});
    insert.bind(7, std::int64_t{p.pass}).bind(8, std::int64_t{p.pulses});
    insert.bind(9, static_cast<std::int64_t>(p.cell_state));
    static_cast<void>(insert.step());
}

void Journal::note_session(std::uint32_t session) {
    Statement update = database_.prepare("UPDATE jobs SET session = ? WHERE id = ?");
    update.bind(1, std::int64_t{session}).bind(2, job_row_);
    static_cast<void>(update.step());
}

void Journal::close(JobOutcome outcome) { set_outcome(database_, job_row_, outcome); }

std::optional<JobProgress> Journal::last() {
    const auto latest = latest_progress(database_, job_row_);
    return latest ? std::optional<JobProgress>(latest->progress) : std::nullopt;
}

JournalSummary read_journal(const std::filesystem::path& path) {
    Database database(path, DatabaseAccess::read_only);
    auto latest = database.version() > 0 ? latest_job(database) : std::nullopt;
    if (!latest) {
        throw InputError({.file = path.string(),
                          .problem = "is a journal without a job",
                          .action = "name the journal of a job that was started"});
    }
    latest->summary.session = session_of(database, latest->row);
    if (const auto progress = latest_progress(database, latest->row)) {
        latest->summary.last = progress->progress;
        latest->summary.last_time = progress->time;
    }
    return latest->summary;
}

}  // namespace sc::host
