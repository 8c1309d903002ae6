// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "host/bridge/client.hpp"
#include "host/bridge/resume.hpp"
#include "host/bridge/streamer.hpp"
#include "host/formats/journal.hpp"

namespace sc::host {

/// How a job ended, from the cell's own words.
struct RunResult {
    double cell_seconds = 0.0;  ///< of the cell's time, from power-on of the axes to their power-off
    JobProgress progress;
    std::uint32_t pulses = 0;  ///< fired, as the cell counts them
    std::uint32_t starvations = 0;
    std::uint32_t items_repeated = 0;
    std::uint64_t requests_repeated = 0;
    WireCounters wire;
};

/// What a preview came to.
struct PreviewResult {
    std::uint32_t rounds = 0;  ///< whole ones
    bool stopped = false;      ///< ended by a person within a round
    double cell_seconds = 0.0;
};

struct SessionOptions {
    StreamOptions stream;
    bool reset_fault = false;          ///< acknowledge a latched fault before powering the axes
    std::function<void()> on_fault{};  ///< before it is acknowledged: what the cell still knows of it may be kept
    std::function<void(const Progress&)> on_progress;
    std::function<void(const std::string&)> on_step;  ///< "homing" and so on, for a person
};

/// The order of things around a job. Motion begins with `prepare_to_mark`; whatever ends a call early, the cell is left
/// at rest, laser off, axes unpowered, as far as the link still reaches it.
class Session {
public:
    /// `client` is connected and outlives the session.
    Session(CellClient& client, SessionOptions options);

    /// Powers the axes, homes them unless they are, arms; opens, starts and streams the job; disarms and unpowers.
    /// Throws as Streamer::run and CellClient::wait_for do, after `make_safe`. The journal, if any, is closed: done,
    /// failed, or (after Interrupted) aborted.
    RunResult run(const StreamJob& job, Journal* journal);
    /// How a job stands that an earlier host has begun.
    struct Standing {
        enum class Kind : std::uint8_t { under_way, done, broken_off };
        Kind kind = Kind::broken_off;
        KnownPlace place;  ///< of one that is broken off
    };
    /// Asks the cell. `last` is the journal's view.
    [[nodiscard]] Standing look(const StreamJob& job, const std::optional<JobProgress>& last);
    /// Takes over a job that is under way: streams on, resumes it if it is held, ends as `run` does.
    RunResult rejoin(const StreamJob& job, Journal* journal);
    /// Ends a job that is done: disarms and unpowers.
    void finish(Journal* journal);
    /// As above, from `from` on.
    RunResult run(const StreamJob& job, Journal* journal, const ResumePoint& from);
    /// Powers and homes the axes, traces the job with the guide laser `rounds` times (0: until the stop check says so,
    /// which is then no error), unpowers. Throws as `run` does, after `make_safe`; CellError if the cell tells of a
    /// master oscillator, an open shutter, a gate or a pulse meanwhile.
    PreviewResult preview(const StreamJob& job, std::uint32_t rounds);
    /// Makes the cell ready to be set up: acknowledges a latched fault if the options say so, drops a job that an
    /// earlier host has left behind. The cell is then in boot, disabled or idle. Throws CellFault if a fault stays.
    void clear();
    /// Powers and homes the axes (what a jog needs). Makes no attempt to end safely by itself.
    void enable_and_home();
    /// Hold, abort, wait for rest, disarm, disable: each step is tried, whatever became of the one before. Never
    /// throws; false when the cell could not be brought to `disabled` or `fault`.
    bool make_safe() noexcept;

private:
    void step(const std::string& what) const;
    void mark(const StreamJob& job, Streamer& streamer, const ResumePoint& from);
    void take_over(const StreamJob& job, Streamer& streamer, Journal* journal);
    RunResult run_guarded(const StreamJob& job, Journal* journal, const std::function<void(Streamer&)>& work);
    void home();
    void arm();
    void disarm_and_disable();
    void disable();
    void trace(const StreamJob& job, std::uint32_t rounds, PreviewResult& result);
    void check_dark(std::uint32_t pulses_before) const;
    void ease_towards_rest();

    CellClient* client_;
    SessionOptions options_;
};

}  // namespace sc::host
