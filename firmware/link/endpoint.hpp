// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/link/job_stream.hpp"
#include "firmware/link/reply_memory.hpp"
#include "firmware/link/seal_gate.hpp"
#include "firmware/link/telemetry_sender.hpp"
#include "shared/link/config.hpp"
#include "shared/link/counter.hpp"
#include "shared/link/messages.hpp"
#include "shared/link/serial.hpp"
#include "shared/machine/machine.hpp"
#include "shared/path/item.hpp"
#include "shared/path/item_queue.hpp"

namespace sc::link {

/// Something the controller must decide on. A command, job_open, job_resume, compensation, map_chunk, set_map,
/// galvo_field, power_curve, galvo_lag, surface, seating or store_parameters is owed a `reply` with its sequence, a
/// position_request a `position`, sensors a `report`.
struct LinkEvent {
    enum class Kind : std::uint8_t {
        none,
        command,
        job_open,
        job_resume,
        position_request,
        compensation,
        map_chunk,
        set_map,
        galvo_field,
        power_curve,
        galvo_lag,
        surface,
        seating,
        store_parameters,
        sensors,
        session_open,     ///< another host than before, or the first: nothing of an earlier session may go on by itself
        session_resumed,  ///< the same session said hello again
    };
    Kind kind = Kind::none;
    Command command;
    JobOpen job_open;
    JobResume job_resume;
    PositionRequest position_request;
    SetCompensation compensation;
    MapChunk map_chunk;
    SetMap set_map;
    SetGalvoField galvo_field;
    SetPowerCurve power_curve;
    SetGalvoLag galvo_lag;
    SetSurface surface;
    CheckSeating seating;
    StoreParameters store_parameters;
};

/// Monotonic counts since start.
struct LinkCounters {
    std::uint32_t frames_bad = 0;         ///< cut, too long, wrong checksum, unknown or malformed
    std::uint32_t messages_lost = 0;      ///< gaps in the message counter
    std::uint32_t messages_repeated = 0;  ///< counter had come before
    std::uint32_t items_repeated = 0;
    std::uint32_t blocks_ahead = 0;  ///< blocks that came while one before them was missing
    std::uint32_t events_lost = 0;   ///< requests dropped because the controller had not taken the earlier ones
    std::uint32_t hellos_refused = 0;
    SealCounters seals;  ///< of a controller that has a key
};

/// What differs from a controller's link when the link itself is measured.
struct EndpointOptions {
    StreamRules rules;
    std::uint32_t items_per_tick = 6;            ///< of the job that are read: half more than 4 000 points/s
    std::uint8_t newest_minor = kProtocolMinor;  ///< 0: speaks as version 1.0 did
};

/// The controller's end of the link, serial carrier (COBS frames; docs/link.md has the rules). It holds the session,
/// the window, the acknowledgements and the answers; the controller holds the decisions. One context: the servo step.
/// Each tick: `receive` (also without bytes, it carries the time), `poll` until empty, pops from `items()`, `progress`,
/// `status`, `transmit`.
///
/// Cost of a tick: `receive` at most one pass over the bytes, one decode per message and two walks per block, so
/// proportional to the bytes given; `transmit` proportional to the bytes written. No heap, no blocking. About 90 kB,
/// most of it the queue of items: static storage, not a stack.
class Endpoint {
public:
    static constexpr std::int64_t kAckEveryTicks = 5;     ///< progress alone is told no more often
    static constexpr std::int64_t kAckRepeatTicks = 100;  ///< told again even if unchanged, should it have been lost
    static constexpr std::int64_t kRefusedRepeatTicks = 50;
    static constexpr std::int64_t kClockEveryTicks = 50;  ///< heartbeats between are not answered

    /// `boot_id` should differ at each start of the controller. The configuration is serialised here, once.
    Endpoint(const MachineConfig& machine, std::uint32_t boot_id, const EndpointOptions& options = {}) noexcept;

    /// From now on host messages count only if they are sealed (shared/link/seal.hpp). Once, before the first tick.
    void fit_key(const SealSecret& secret) noexcept;
    /// The plan step's share of a tick: checks seals. Nothing without a key; else up to SealGate::kBlocksPerTick blocks
    /// of AES.
    void check_seals() noexcept {
        if (gate_.fitted()) {
            gate_.work();
        }
    }

    /// Takes the bytes that came since the last tick. Ticks must not go backwards.
    void receive(std::int64_t tick, std::span<const std::uint8_t> bytes) noexcept;
    /// The next event; false and Kind::none when there is none. At most 8 wait; requests beyond are dropped, counted,
    /// and come again.
    bool poll(LinkEvent& out) noexcept;
    /// Answers a request and remembers the answer: the same sequence again is answered again without an event (the last
    /// 8). Sequences that are unknown or answered already are ignored.
    void reply(std::uint32_t sequence, Refusal refusal, std::int64_t detail) noexcept;

    /// The controller accepted a JobOpen. The same job, still open and not refused, keeps what has arrived.
    void open_job(std::uint64_t job, std::uint32_t items) noexcept;
    /// The controller accepted a JobResume: the job begins anew, in its midst.
    void resume_job(const JobResume& resume) noexcept;
    /// Ends the job: nothing more is taken, the queue is emptied, JobRefused is no longer repeated. The last
    /// acknowledgement goes on being repeated until another job opens, so that its loss costs nothing.
    void close_job() noexcept;
    /// Items of the open job, in order, each exactly once. The controller pops.
    [[nodiscard]] ItemQueue& items() noexcept { return stream_.items(); }
    [[nodiscard]] const ItemQueue& items() const noexcept { return stream_.items(); }
    /// Items of the open job that have arrived (the number of the next one wanted).
    [[nodiscard]] std::uint32_t received() const noexcept { return stream_.received(); }
    /// Every item of the job has arrived and their hash is the job's.
    [[nodiscard]] bool job_hash_ok() const noexcept { return stream_.hash_ok(); }
    /// Tells the host that an item was refused; repeated until the job is closed. The first refusal of a job counts.
    /// `value` is in wire units of the axis.
    void refuse_item(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept;
    /// Why the open job was refused, by the controller or by the endpoint itself (malformed_block, too_many_points,
    /// job_mismatch); none when it was not. The controller stops in good order and closes the job.
    [[nodiscard]] Refusal job_refusal() const noexcept { return static_cast<Refusal>(stream_.refused().refusal); }
    /// Items planned and fired (cumulative) and the fired position, for the next acknowledgement.
    void progress(std::uint32_t planned, std::uint32_t fired, const FiredPosition& position) noexcept;

    /// Answers a position_request.
    void position(const Position& position) noexcept { position_ = position; }
    /// The job that is or was open, 0 before the first, and its number of items.
    [[nodiscard]] std::uint64_t job() const noexcept { return job_seen_ ? stream_.job() : 0; }
    [[nodiscard]] std::uint32_t job_items() const noexcept { return stream_.job_items(); }

    /// Sends this in place of any status not yet sent. The link's own counters are filled in.
    void status(const Status& status) noexcept { status_ = status; }
    /// What the sensors say; sent in place of one not yet sent.
    void report(const SensorReport& report) noexcept { report_ = report; }

    [[nodiscard]] bool session_open() const noexcept { return session_open_; }
    /// Minor version that the session speaks.
    [[nodiscard]] std::uint8_t minor() const noexcept { return minor_; }
    /// A session is open and a valid message of it came no longer ago than the heartbeat timeout.
    [[nodiscard]] bool alive(std::int64_t tick) const noexcept;
    /// Tick of the last valid message of the session; meaningless while none is open.
    [[nodiscard]] std::int64_t last_heard() const noexcept { return last_heard_; }

    /// Frames that are due, most urgent first: answer to hello, replies, refusal, acknowledgement, gaps, position,
    /// status, clock, sensors, configuration. Returns the bytes written; what does not fit stays due. 80 bytes or more
    /// let everything through in time (a chunk of configuration shrinks to the room).
    std::size_t transmit(std::span<std::uint8_t> out) noexcept;
    /// Channels of telemetry that are to be sent in this tick, after the above; mostly none.
    [[nodiscard]] std::uint32_t telemetry_due() const noexcept;
    std::size_t transmit(std::span<std::uint8_t> out, const TelemetryValues& values) noexcept;
    /// What is asked of the black box, until it has been sent.
    [[nodiscard]] const std::optional<BlackboxRequest>& blackbox_wanted() const noexcept { return blackbox_wanted_; }
    std::size_t transmit(std::span<std::uint8_t> out, const BlackboxChunk& chunk) noexcept;
    /// And of the stored parameters.
    [[nodiscard]] const std::optional<ParametersRequest>& parameters_wanted() const noexcept {
        return parameters_wanted_;
    }
    std::size_t transmit(std::span<std::uint8_t> out, const Parameters& told) noexcept;

    [[nodiscard]] LinkCounters counters() const noexcept;

private:
    static constexpr std::size_t kEvents = 8;
    /// An event that has not been taken yet: kept as it came, since the longest is a quarter of all of them.
    struct Pending {
        LinkEvent::Kind kind = LinkEvent::Kind::none;
        std::uint8_t size = 0;
        std::array<std::uint8_t, kPayloadCapacity> payload{};
    };
    struct Outbox {
        std::span<std::uint8_t> out;
        std::size_t size = 0;
    };
    struct Progress {
        std::uint32_t planned = 0;
        std::uint32_t fired = 0;
        FiredPosition position;
    };

    void take_checked() noexcept;
    void sift(const Envelope& envelope) noexcept;
    void take_seal_hello(const SealGate::Checked& checked) noexcept;
    void refuse_expired() noexcept;
    void take(const Envelope& envelope) noexcept;
    void on_hello(const Hello& hello, std::uint16_t counter) noexcept;
    void answer_hello(std::uint32_t session, Refusal refusal) noexcept;
    void on(const Heartbeat& heartbeat) noexcept;
    void on(const PositionRequest& request) noexcept;
    void on(const Block& /*block*/) noexcept {}  ///< see take_block
    void take_block(std::span<const std::uint8_t> payload) noexcept;
    void on(const SensorsRequest& request) noexcept;
    void on(const ConfigRequest& request) noexcept;
    void on(const TelemetryRequest& wanted) noexcept;
    void on(const BlackboxRequest& wanted) noexcept;
    void on(const ParametersRequest& wanted) noexcept;
    template <class Message>
    void on(const Message& message) noexcept;
    [[nodiscard]] Refusal judge(const Hello& hello) const noexcept;
    [[nodiscard]] bool fresh(std::uint32_t sequence) noexcept;
    void answer_unremembered(std::uint32_t sequence, Refusal refusal) noexcept;
    bool push_event(LinkEvent::Kind kind) noexcept;
    [[nodiscard]] std::uint64_t cell_time_us() const noexcept {
        return static_cast<std::uint64_t>(tick_ * control_period_ns_ / 1000);
    }
    [[nodiscard]] bool busy_tick() const noexcept;

    template <class Message>
    bool send(Outbox& box, const Message& message) noexcept;
    bool send_hello(Outbox& box) noexcept;
    bool send_challenge(Outbox& box) noexcept;
    bool send_replies(Outbox& box) noexcept;
    bool send_refused(Outbox& box) noexcept;
    bool send_ack(Outbox& box) noexcept;
    bool send_missing(Outbox& box) noexcept;
    bool send_position(Outbox& box) noexcept;
    bool send_status(Outbox& box) noexcept;
    bool send_config(Outbox& box) noexcept;
    bool send_report(Outbox& box) noexcept;
    bool send_clock(Outbox& box) noexcept;
    [[nodiscard]] StreamAck current_ack() const noexcept;
    [[nodiscard]] bool ack_due(const StreamAck& ack) const noexcept;

    std::array<std::uint8_t, kConfigSize> config_{};
    std::uint32_t config_crc_;
    std::uint32_t boot_id_;
    std::int64_t control_period_ns_;
    std::uint32_t items_per_tick_;
    std::uint8_t newest_minor_;
    std::int64_t tick_ = 0;

    SerialReceiver receiver_;
    CounterWatch watch_;
    LinkCounters counters_;
    std::uint16_t send_counter_ = 0;
    std::uint16_t heard_ = 0;  ///< counter of the newest message of the session
    std::uint8_t minor_ = kProtocolMinor;

    bool session_open_ = false;
    std::uint32_t session_ = 0;
    std::int64_t timeout_ticks_ = 0;
    std::int64_t last_heard_ = 0;

    std::span<const std::uint8_t> payload_;  ///< of the message that is being taken
    std::array<Pending, kEvents> events_{};
    std::size_t event_head_ = 0;
    std::size_t event_count_ = 0;
    ReplyMemory replies_;
    std::optional<CommandReply> unremembered_;
    std::optional<HelloReply> hello_reply_;

    JobStream stream_;
    bool job_seen_ = false;
    Progress progress_;
    StreamAck last_ack_;
    bool ack_now_ = false;
    bool gap_told_ = true;  ///< since the last block
    std::int64_t last_ack_tick_ = 0;
    std::int64_t next_refused_tick_ = 0;

    std::optional<Position> position_;
    std::optional<Status> status_;
    std::optional<std::uint16_t> config_wanted_;
    std::optional<SensorReport> report_;
    std::int64_t last_status_tick_ = -1;
    std::optional<ClockReply> clock_;
    std::int64_t last_clock_tick_ = -kClockEveryTicks;
    TelemetrySender telemetry_;
    std::optional<BlackboxRequest> blackbox_wanted_;
    std::optional<ParametersRequest> parameters_wanted_;
    SealGate gate_;
    std::int64_t next_expired_tick_ = 0;
};

}  // namespace sc::link
