// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/bridge/black_box.hpp"
#include "host/bridge/clock_fit.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/transport.hpp"
#include "host/bridge/wire.hpp"
#include "shared/codes/state.hpp"
#include "shared/crypto/aes128.hpp"
#include "shared/machine/axis_map.hpp"
#include "shared/machine/galvo_field.hpp"
#include "shared/machine/galvo_lag.hpp"
#include "shared/machine/machine.hpp"
#include "shared/machine/power_curve.hpp"

namespace sc::host {

struct ClientOptions {
    std::uint32_t session = 1;  ///< a reconnect with the same number may go on with its job
    Nanoseconds heartbeat_timeout{100'000'000};
    Nanoseconds reply_wait{200'000'000};  ///< before a request is sent again
    int attempts = 10;                    ///< of one request
    std::optional<crypto::Key> key{};     ///< of the cell: only a sealed session is opened
    Nanoseconds silence{10'000'000'000};  ///< without a message from the cell: the link counts as lost
};

struct LinkOptions;
/// Of a session, with the key that the link's options name. Throws as read_key_file does.
[[nodiscard]] ClientOptions client_options(const LinkOptions& link, std::uint32_t session);

/// Parameters that a controller keeps without power.
struct StoredParameters {
    bool fitted = false;           ///< it can keep any
    bool in_force = false;         ///< it runs with them since its start
    std::uint32_t generation = 0;  ///< 0: none are kept
    std::uint16_t layout = 0;      ///< link::kConfigVersion of who stored them
    std::vector<std::uint8_t> bytes;
};

/// One session with a controller: handshake, heartbeats, requests that are repeated until answered, and the cell's last
/// word on everything. All time passes in `pump` (every other call that waits pumps): a program that stays away longer
/// than the heartbeat timeout has gone silent, which the cell answers with a hold. One thread.
class CellClient {
public:
    /// `transport` must outlive the client.
    CellClient(Transport& transport, const ClientOptions& options);

    /// Opens the session, or opens it again. With a key it is a sealed one or none. Throws CellRefused when host and
    /// controller differ in schema, version or key, LinkError when nobody answers.
    void connect();
    /// The machine as the controller has it. Throws LinkError when it cannot be had whole with the right checksum.
    [[nodiscard]] MachineConfig read_config();
    /// The following throw CellRefused with the controller's reason, LinkError without an answer. What minor version 0
    /// has no message for is refused here (unknown_command), unless it takes away what is not there.
    void set_compensation(const Compensation& compensation);
    /// An empty field takes the one in force away.
    void set_galvo_field(const GalvoField& field);
    /// A curve without points takes the one in force away.
    void set_power_curve(const PowerCurve& curve);
    /// An empty lag takes the one in force away.
    void set_galvo_lag(const GalvoLag& lag);
    /// Sends the map and puts it in force; the identity takes one away. Throws CellRefused with axis and node if the
    /// machine cannot take it.
    void set_map(const AxisMap& map);
    /// What the Y sensor is used for.
    void set_surface(const link::SetSurface& surface);
    /// Waits until the cell has measured and judged the workpiece's seat. Throws CellRefused with what is wrong.
    void check_seating(const link::CheckSeating& seating);
    /// What the distance sensors say now. Throws LinkError without an answer.
    [[nodiscard]] link::SensorReport read_sensors();
    /// Telemetry at the rates asked for, `sequence` filled in; no channels end it. Throws CellRefused with
    /// telemetry_over_budget, whose detail is the period in ticks that would fit.
    void subscribe(const link::TelemetryRequest& wanted);
    /// What the controller keeps without power. Throws LinkError when it does not tell.
    [[nodiscard]] StoredParameters read_parameters();
    /// Keeps a configuration from the controller's next start on; none: what its board was built with. Throws
    /// CellRefused while the laser may come on or anything moves, and for a board that keeps none.
    void store_parameters(const std::optional<MachineConfig>& machine);
    /// Called for each sample.
    void on_telemetry(std::function<void(const link::Telemetry&)> listener) { on_telemetry_ = std::move(listener); }
    /// All that the cell's black box holds. Throws LinkError without an answer.
    [[nodiscard]] BlackBoxContent read_black_box();
    /// The cell's clock against the host's. Empty with a controller before version 1.2.
    [[nodiscard]] const ClockFit& clock() const noexcept { return clock_; }
    void command(link::Verb verb, std::int32_t arg0 = 0, std::int32_t arg1 = 0, std::int32_t arg2 = 0);
    void open_job(std::uint64_t job, std::uint32_t items);
    /// Opens a job that has been burnt in part; `sequence` is filled in. Throws CellRefused with unknown_command when
    /// the controller speaks minor version 0, which has no such thing.
    void resume_job(link::JobResume resume);
    /// How far the controller knows the last job to have come. nullopt when it speaks minor version 0.
    [[nodiscard]] std::optional<link::Position> position();
    /// Sends without waiting for an answer (`ack` and `take_missing` will show it). Returns the message's counter.
    /// In a sealed session it waits until the controller has time to check it, and throws as `pump` does.
    std::uint16_t send_block(const link::Block& block);
    /// Of 16 bytes, that the controller has time to check; 0 in a session that is not sealed.
    [[nodiscard]] std::uint32_t sealed_blocks_per_s() const noexcept {
        return wire_.sealed() && challenge_ ? challenge_->blocks_per_s : 0;
    }
    /// Bytes of a block's items.
    [[nodiscard]] std::size_t items_capacity() const noexcept;
    /// What the cell has missed, once.
    [[nodiscard]] std::optional<link::StreamMissing> take_missing();
    /// The minor version of the protocol that both sides speak.
    [[nodiscard]] std::uint8_t minor() const noexcept { return wire_.minor(); }

    /// Lets time pass: receives, answers, sends heartbeats. Returns true as soon as messages have been taken in, false
    /// at `until`. Throws LinkError when the carrier has closed or the cell has been silent for too long, Interrupted
    /// when the stop check says so.
    bool pump(HostTime until);
    /// Pumps until `done()` or for `limit`; returns what `done()` says then.
    bool pump_until(const std::function<bool()>& done, Nanoseconds limit);
    /// Pumps until a fresh status shows the cell in one of `wanted`. Throws CellFault as soon as it is in `fault`
    /// (unless wanted), CellError with `doing` after `limit`.
    void wait_for(std::initializer_list<State> wanted, Nanoseconds limit, const std::string& doing);
    /// Throws CellFault if the cell's last status shows `fault`.
    void check_fault() const;

    [[nodiscard]] HostTime now() const { return transport_->now(); }
    /// nullopt until the first one has come since `connect`.
    [[nodiscard]] const std::optional<link::Status>& status() const noexcept { return status_; }
    /// The status has come after the answer to the last request, so it shows what that has done.
    [[nodiscard]] bool status_is_fresh() const noexcept { return status_fresh_; }
    /// `boot` before the first status.
    [[nodiscard]] State state() const noexcept;
    [[nodiscard]] const std::optional<link::StreamAck>& ack() const noexcept { return ack_; }
    [[nodiscard]] const std::optional<link::JobRefused>& job_refused() const noexcept { return job_refused_; }
    [[nodiscard]] const link::HelloReply& hello() const noexcept { return hello_; }
    [[nodiscard]] WireCounters counters() const noexcept { return wire_.counters(); }
    [[nodiscard]] std::uint64_t repeats() const noexcept { return repeats_; }  ///< requests sent more than once

    /// Called at each change of state, after `status` has been brought up to date.
    void on_state(std::function<void(State from, State to)> listener) { on_state_ = std::move(listener); }
    /// Asked while waiting; true ends the wait with Interrupted. An empty function is never asked.
    void set_stop_check(std::function<bool()> check) { stop_check_ = std::move(check); }

private:
    struct Reply {
        std::uint32_t sequence;
        std::uint16_t refusal;
        std::int64_t detail;
    };
    using Sender = std::function<void(std::uint32_t sequence)>;
    void take(const CellMessage& message);
    void take(const link::HelloReply& message);
    void take(const link::CommandReply& message);
    void take(const link::StreamAck& message);
    void take(const link::JobRefused& message);
    void take(const link::Status& message);
    void take(const link::ConfigChunk& message);
    void take(const link::Position& message) { position_ = message; }
    void take(const link::StreamMissing& message) { missing_ = message; }
    void take(const link::SealChallenge& message) { challenge_ = message; }
    void say_hello(std::uint16_t timeout_ms);
    void take(const link::SensorReport& message);
    void take(const link::ClockReply& message);
    void take(const link::Telemetry& message);
    void take(const link::BlackboxChunk& message);
    void take(const link::Parameters& message);
    void send_pieces(std::span<const std::uint8_t> bytes, const char* what);
    /// Throws CellRefused with unknown_command when the controller speaks an older minor version than `since`.
    void require(std::uint8_t since, const std::string& what) const;
    void shake_hands();
    void shake_hands_sealed();
    void check_handshake() const;
    void await_room();
    void keep_alive();
    bool repeat_until(const std::function<void()>& send, const std::function<bool()>& answered);
    void request(const Sender& send, const std::string& doing);
    [[nodiscard]] Reply await_reply(const Sender& send, const std::string& doing);

    Transport* transport_;
    Wire wire_;
    ClientOptions options_;
    bool connected_ = false;
    HostTime connected_at_{};
    ClockFit clock_;
    HostTime next_heartbeat_{};
    HostTime last_heard_{};
    std::uint32_t sequence_ = 0;
    std::uint64_t repeats_ = 0;
    link::HelloReply hello_;
    bool hello_fresh_ = false;
    std::optional<link::SealChallenge> challenge_;
    bool connecting_ = false;
    bool seal_expired_ = false;  ///< the controller asks for a new challenge
    HostTime checked_until_{};   ///< when the controller will have checked what was sent
    bool status_fresh_ = false;
    std::optional<Reply> reply_;
    std::optional<link::ConfigChunk> chunk_;
    std::optional<link::Position> position_;
    std::optional<link::StreamMissing> missing_;
    std::uint32_t token_ = 0;
    std::optional<link::SensorReport> sensors_;
    std::optional<link::Status> status_;
    std::optional<link::StreamAck> ack_;
    std::optional<link::JobRefused> job_refused_;
    std::optional<link::BlackboxChunk> blackbox_;
    std::optional<link::Parameters> parameters_;
    std::function<void(const link::Telemetry&)> on_telemetry_;
    std::function<void(State, State)> on_state_;
    std::function<bool()> stop_check_;
};

/// "set-point of X, table along Z, node 7".
[[nodiscard]] std::string describe_map_place(const MapFinding& finding);
/// What a refused check of the seat (Refusal 151..154) says by its detail: "by 0.84 mm" ...; empty for other refusals.
[[nodiscard]] std::string describe_seating(Refusal refusal, std::int64_t detail);
/// "jog", "reset_fault" ...
[[nodiscard]] std::string name_of(link::Verb verb);

}  // namespace sc::host
