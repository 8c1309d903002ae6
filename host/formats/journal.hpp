// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "host/formats/database.hpp"
#include "shared/codes/state.hpp"

namespace sc::host {

/// How far a job has come. Counts as in the link's StreamAck: every item below the number has reached the stage.
struct JobProgress {
    std::uint32_t sent = 0;
    std::uint32_t planned = 0;
    std::uint32_t fired = 0;
    std::uint32_t path = 0;  ///< fired position
    std::uint8_t pass = 0;
    std::uint32_t pulses = 0;
    State cell_state = State::idle;
    constexpr bool operator==(const JobProgress&) const noexcept = default;
};

enum class JobOutcome : std::uint8_t { open, done, aborted, failed };
[[nodiscard]] std::string_view name_of(JobOutcome outcome) noexcept;

struct JournalJob {
    std::uint64_t hash = 0;  ///< of the job's items, as in the link's JobOpen
    std::uint32_t items = 0;
    std::string name;
};
/// What a journal says: its latest job and how far that came.
struct JournalSummary {
    JournalJob job;
    std::string created;  ///< ISO 8601, UTC
    JobOutcome outcome = JobOutcome::open;
    std::optional<std::uint32_t> session;  ///< of the link, in which the job was sent last
    std::optional<JobProgress> last;
    std::string last_time;  ///< of `last`; empty without it
};

enum class JournalStart : std::uint8_t {
    resume,   ///< go on with the latest job of the file; it must be this one
    new_job,  ///< a new job; what the file held before stays as history
};

/// The record on disk of one running job. Each record() is a transaction that survives kill -9 at any moment. One
/// writer; readers (monitor) may read at the same time. Not thread-safe.
class Journal {
public:
    /// Opens or creates. A file without a job gets this one. Throws InputError that names both hashes if start is
    /// `resume` and the latest job is another, if the file is no journal or of a newer version; DatabaseError if the
    /// disk fails.
    Journal(const std::filesystem::path& path, const JournalJob& job, JournalStart start = JournalStart::resume);

    /// Adds a line. Cost: one synced write, some milliseconds: call it at most some ten times a second.
    void record(const JobProgress& progress);
    /// The link's session in which the job is sent from now on.
    void note_session(std::uint32_t session);
    /// Sets the job's outcome.
    void close(JobOutcome outcome);
    /// The job's latest line, if any.
    [[nodiscard]] std::optional<JobProgress> last();

private:
    Database database_;
    std::int64_t job_row_ = 0;
};

/// Reads without changing anything. Throws InputError if the file is missing, no journal, of another version or empty.
[[nodiscard]] JournalSummary read_journal(const std::filesystem::path& path);

}  // namespace sc::host
