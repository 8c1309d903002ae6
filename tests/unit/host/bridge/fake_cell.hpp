// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <random>
#include <vector>

#include "host/bridge/transport.hpp"
#include "shared/codes/codes.hpp"
#include "shared/codes/state.hpp"
#include "shared/link/blackbox.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/serial.hpp"
#include "shared/machine/machine.hpp"
#include "shared/path/item.hpp"

namespace sc::host::test {

/// What goes wrong on the way, in both directions; shares of all messages.
struct Trouble {
    double drop = 0.0;
    double repeat = 0.0;
    double corrupt = 0.0;
    Nanoseconds delay{1'000'000};  ///< each way
    std::uint64_t seed = 1;
};

/// A scripted controller behind a carrier in virtual time: it speaks the real messages, and its behaviour is simple
/// enough to be judged by eye. It shares no code with the firmware.
class FakeCell final : public Transport {
public:
    explicit FakeCell(const Trouble& trouble = {});

    // Transport, as the host sees it.
    void send(std::span<const std::uint8_t> bytes) override;
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override;
    [[nodiscard]] HostTime now() const override { return now_; }
    [[nodiscard]] bool closed() const override { return unplugged; }

    // The script.
    bool unplugged = false;
    bool mute = false;  ///< takes everything, says nothing
    std::uint64_t schema = link::kSchemaHash;
    std::uint8_t minor = link::kProtocolMinor;
    MachineConfig machine = reference_machine();
    std::uint32_t capacity = 64;
    std::uint32_t items_per_period = 8;  ///< planned and fired every 20 ms while running
    std::map<link::Verb, Refusal> refuse;
    std::optional<std::uint32_t> refuse_item;
    std::optional<std::uint32_t> fault_at_item;
    std::optional<std::uint32_t> starve_at_item;     ///< holds once, resumes on command
    std::optional<std::uint32_t> hold_link_at_item;  ///< the same, and wants a hello first
    int blocks_lost = 0;                             ///< so many of the first, whatever the carrier does
    std::optional<link::StreamAck> stale_ack;        ///< said with the first block: an earlier start of the cell's
    std::function<void()> each_period;               ///< called every 20 ms

    // What has come of it.
    State state = State::disabled;
    bool homed = false;
    std::map<link::Verb, int> done;  ///< commands carried out (repeats are not)
    std::vector<Item> taken;
    std::vector<std::uint32_t> block_sizes;
    std::uint32_t fired = 0;
    std::uint32_t repeated = 0;
    int hellos = 0;
    int jobs_opened = 0;
    std::vector<HostTime> heartbeats;
    link::SetCompensation compensation;
    std::vector<double> galvo_field;  ///< numbers as they have come
    bool galvo_field_ended = false;   ///< and the message that ends them
    link::SetPowerCurve power_curve;
    link::SetGalvoLag galvo_lag;
    link::SetSurface surface;
    link::CheckSeating seating;
    link::CommandReply seating_answer;  ///< its refusal and detail
    link::SensorReport sensors;
    bool burns_in_preview = false;
    std::int32_t override_percent = 100;
    std::vector<std::uint8_t> map;  ///< pieces so far
    link::SetMap set_map;
    std::optional<link::JobResume> resumed;
    int maps_set = 0;
    std::optional<link::TelemetryRequest> telemetry;
    std::vector<std::uint8_t> parameters;  ///< that it keeps
    std::uint32_t generation = 0;
    Refusal refuse_telemetry = Refusal::none;
    std::optional<Nanoseconds> clock_ahead;  ///< of the host; empty: heartbeats are not answered
    link::BlackboxChunk black_box;           ///< its head
    std::vector<link::BlackboxSample> box_samples;
    std::vector<link::BlackboxEvent> box_events;

private:
    struct Parcel {
        HostTime due;
        std::uint64_t order;
        bool to_cell;
        std::vector<std::uint8_t> bytes;
        bool operator>(const Parcel& other) const { return due != other.due ? due > other.due : order > other.order; }
    };
    template <class Message>
    void say(const Message& message);
    void post(std::span<const std::uint8_t> frame, bool to_cell);
    void deliver(const Parcel& parcel);
    void period();
    void advance_job();
    void say_status();
    void say_ack();
    void enter(State next);
    bool chance(double share);
    [[nodiscard]] Refusal carry_out(const link::Command& command);
    void answer(std::uint32_t sequence, Refusal refusal);

    void take(const link::Hello& m);
    void take(const link::Heartbeat& m);
    void take(const link::PositionRequest& m);
    void take(const link::JobResume& m);
    void take(const link::Command& m);
    void take(const link::JobOpen& m);
    void take(const link::Block& m);
    void take(const link::SetCompensation& m);
    void take(const link::SetGalvoField& m);
    void take(const link::SetPowerCurve& m);
    void take(const link::SetGalvoLag& m);
    void take(const link::SetSurface& m);
    void take(const link::CheckSeating& m);
    void take(const link::SensorsRequest& m);
    void take(const link::TelemetryRequest& m);
    void take(const link::BlackboxRequest& m);
    void take(const link::StoreParameters& m);
    void take(const link::ParametersRequest& m);
    void take(const link::ConfigRequest& m);
    void take(const link::MapChunk& m);
    void take(const link::SetMap& m);
    void take(const link::SealRequest& /*m*/) {}  ///< has no key
    void take(const link::SealHello& /*m*/) {}

    Trouble trouble_;
    std::mt19937_64 random_;
    std::priority_queue<Parcel, std::vector<Parcel>, std::greater<>> way_;
    std::uint64_t order_ = 0;
    HostTime now_{};
    HostTime next_period_{};
    std::vector<std::uint8_t> arrived_;
    link::SerialReceiver receiver_;
    std::uint16_t counter_ = 0;
    std::uint16_t heard_ = 0;
    std::uint32_t session_ = 0;
    std::optional<link::CommandReply> last_reply_;
    std::uint64_t job_ = 0;
    std::uint32_t job_items_ = 0;
    bool job_done_ = false;
    bool previewed_ = false;
    Fault fault_ = Fault::none;
};

/// A job of `lines` straight lines of `points` points each, with a turn before and an end after.
[[nodiscard]] std::vector<Item> example_items(std::uint32_t lines, std::uint32_t points);

}  // namespace sc::host::test
