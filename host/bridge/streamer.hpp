// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>

#include "host/bridge/client.hpp"
#include "host/bridge/progress.hpp"
#include "host/formats/journal.hpp"
#include "shared/path/item.hpp"

namespace sc::host {

struct StreamOptions {
    std::uint32_t items_per_block = 0;       ///< 0: as many as a block can hold
    Nanoseconds resend_after{60'000'000};    ///< silence after which the cell is asked what it has, at the latest
    Nanoseconds journal_period{50'000'000};  ///< of the real clock, between records that no intent asks for
    /// Asked all along with the override in force; what it returns is set. Empty: never asked.
    std::function<std::optional<std::uint8_t>(std::uint8_t percent)> wanted_override{};
    /// Asked all along: true pauses the job (a stop on the path, laser off), and the next true lets it go on. Empty:
    /// never asked.
    std::function<bool()> wanted_pause{};
};

/// What of a job is to be streamed; all of it must outlive the streamer.
struct StreamJob {
    std::uint64_t hash = 0;
    std::span<const Item> items;
    double expected_seconds = 0.0;
};

/// Streams the items of an opened job: blocks within the controller's window, each item as often as the carrier needs
/// and taken exactly once (the controller counts; its `received` is the only truth). What the cell has missed is sent
/// again, alone; with a controller of minor version 0, which cannot tell, everything from there on. What is about to be
/// sent is written to the journal first, so that after any crash the journal's `sent` bounds what can have been burnt.
class Streamer {
public:
    Streamer(CellClient& client, const StreamJob& job, const StreamOptions& options, Journal* journal);

    /// Called about five times a second of the cell's time, and at the end.
    void on_progress(std::function<void(const Progress&)> listener) { on_progress_ = std::move(listener); }

    /// The job goes on from here: the items before need not be sent. Before `run`.
    void begin_at(std::uint32_t item, const JobProgress& progress);

    /// Streams until the cell reports the job done. A starved or silenced job that the cell holds is resumed. Throws
    /// CellFault, CellRefused (an item; `detail` is its number), LinkError, Interrupted; CellError when the cell has
    /// dropped the job.
    void run();
    /// Journal's view after the last message: for what is said when a job ends early.
    [[nodiscard]] const JobProgress& progress() const noexcept { return progress_; }
    [[nodiscard]] std::uint64_t blocks_repeated() const noexcept { return blocks_repeated_; }
    /// Writes the present place to the journal, if it has moved since the last record.
    void record();
    /// After `run` has ended early: takes in what the cell still has to say on how far it came. Throws as the client's
    /// `pump` does.
    void hear_out();

private:
    [[nodiscard]] bool believable(const link::StreamAck& ack);
    void take_ack();
    void send_window();
    bool send_block(std::uint32_t end);
    void resend_when_silent();
    [[nodiscard]] HostTime next_question() const;
    void resend_missing();
    void resend(std::uint32_t from, std::uint32_t until, std::uint16_t heard);
    void resume_when_held();
    void change_override();
    void pause_or_go_on();
    void check_refused() const;
    void check_running();
    [[nodiscard]] bool done() const;
    [[nodiscard]] std::uint32_t window_end() const;
    void report(bool last);
    void record_sometimes();

    CellClient* client_;
    StreamJob job_;
    StreamOptions options_;
    Journal* journal_;
    ProgressEstimate estimate_;
    std::function<void(const Progress&)> on_progress_;

    /// A block on its way or lost, by its first item.
    struct Sent {
        std::uint32_t end = 0;
        std::uint16_t counter = 0;  ///< of the message that carried it last
    };
    std::map<std::uint32_t, Sent> unacknowledged_;
    std::uint64_t blocks_repeated_ = 0;
    std::uint32_t received_ = 0;
    std::uint32_t sent_ = 0;    ///< next item to send
    std::uint32_t free_;        ///< as the last ack says; a guess before the first
    std::uint32_t widest_ = 0;  ///< largest window seen
    bool running_seen_ = false;
    bool paused_ = false;  ///< by a person
    HostTime begun_{};
    HostTime moved_{};                    ///< when `received` last moved, or sending began again
    HostTime asked_{};                    ///< what is missing
    Nanoseconds pace_;                    ///< usual time between two acknowledgements that move on
    std::optional<HostTime> less_since_;  ///< the cell has acknowledged less than `received_`
    HostTime asked_resume_{};
    HostTime reported_{};
    std::int64_t recorded_at_ns_ = 0;  ///< real clock
    JobProgress progress_;
    JobProgress recorded_;
};

}  // namespace sc::host
