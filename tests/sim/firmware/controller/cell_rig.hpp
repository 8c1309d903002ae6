// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "boards/sim/cell.hpp"
#include "shared/hash/sha256.hpp"
#include "shared/link/blackbox.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/map_codec.hpp"
#include "shared/link/messages.hpp"
#include "shared/link/schema.hpp"
#include "shared/link/serial.hpp"
#include "shared/path/job_hash.hpp"
#include "shared/trace/trace.hpp"

namespace sc::test {

/// A simulated cell with the smallest host that can run it, in one process and one thread.
class CellRig {
public:
    struct Options {
        std::string script;  ///< faults, as in a script file
        std::size_t items_per_block = 255;
        bool with_default_errors = true;
        std::uint32_t baud = 921'600;
        std::filesystem::path world{};   ///< empty = the reference cell
        std::filesystem::path memory{};  ///< of what the controller keeps without power; empty = nothing
        std::filesystem::path record{};  ///< log of the controller's inputs; empty = none
        MachineConfig machine = reference_machine();
        sim::MakeController controller = sim::make_local_controller;
        sim::PlantDrives drives{};
        bool troubled_stream = false;  ///< each block comes twice, and before it a spoilt one of another job
    };
    CellRig() : CellRig(Options{}) {}
    explicit CellRig(const Options& options);

    sim::SimCell& cell() { return *cell_; }
    const sim::SimCell& cell() const { return *cell_; }
    State state() const { return cell_->state(); }
    const std::vector<trace::PulseRecord>& pulses() const { return pulses_; }
    const std::vector<PathPulse>& path_pulses() const { return path_pulses_; }
    const std::vector<AxisPositions>& set_points() const { return set_points_; }
    const link::Status& status() const { return status_; }
    const link::StreamAck& ack() const { return ack_; }
    const std::optional<link::JobRefused>& refused() const { return refused_; }
    bool connected() const { return connected_; }
    std::string command_hash() const;

    void connect();
    /// Sends the command and waits for its answer.
    link::CommandReply command(link::Verb verb, std::int32_t arg0 = 0, std::int32_t arg1 = 0, std::int32_t arg2 = 0);
    /// Enable, home, arm.
    void make_ready();
    link::CommandReply set_compensation(const Compensation& compensation);
    link::CommandReply set_map(const AxisMap& map);
    link::CommandReply send_map_chunk(std::uint16_t offset, std::span<const std::uint8_t> bytes);
    link::CommandReply commit_map(std::uint16_t bytes, std::uint32_t crc);
    link::CommandReply set_power_curve(const PowerCurve& curve);
    link::CommandReply set_galvo_lag(const GalvoLag& lag);
    link::CommandReply set_galvo_field(link::SetGalvoField message);
    link::CommandReply set_surface(link::SetSurface message);
    /// Waits for the answer as long as it takes.
    link::CommandReply check_seating(link::CheckSeating message);
    link::SensorReport sensors();
    /// Sends bytes and asks to keep them; the sequence of the request.
    std::uint32_t send_store(std::span<const std::uint8_t> bytes, std::uint16_t layout);
    link::CommandReply store(std::span<const std::uint8_t> bytes, std::uint16_t layout);
    bool answered(std::uint32_t sequence) const { return replies_.contains(sequence); }
    link::Parameters parameters(std::uint16_t offset = 0);
    link::CommandReply subscribe(link::TelemetryRequest message);
    const std::vector<link::Telemetry>& telemetry() const { return telemetry_; }
    const std::vector<link::ClockReply>& clock_replies() const { return clock_replies_; }
    link::BlackboxChunk black_box(link::BlackboxPart part, std::uint32_t first);
    /// `flip`: bits of the job's hash that are told wrongly.
    link::CommandReply open_job(std::vector<Item> items, std::uint64_t flip = 0);
    /// Items below this number may be sent (all by default).
    void limit_items(std::uint32_t items) { limit_ = items; }
    /// False stops heartbeats and everything else from the host.
    void speak(bool on) { speaking_ = on; }

    /// Told of each tick.
    void watch(std::function<void()> on_tick) { on_tick_ = std::move(on_tick); }
    void ticks(int count);
    /// Ticks until the predicate holds; false after `limit` ticks.
    bool until(const std::function<bool()>& predicate, int limit = 200'000);
    bool until_state(State state, int limit = 200'000) {
        return until([&] { return this->state() == state; }, limit);
    }

private:
    void tick();
    void pump();
    link::CommandReply reply_to(std::uint32_t sequence);
    template <class Message>
    void send(const Message& message);
    void receive();

    Options options_;
    std::unique_ptr<sim::SimCell> cell_;
    link::SerialReceiver receiver_;
    std::uint16_t counter_ = 0;
    std::uint32_t sequence_ = 100;
    std::map<std::uint32_t, link::CommandReply> replies_;
    link::Status status_;
    link::StreamAck ack_;
    std::optional<link::JobRefused> refused_;
    std::optional<link::Position> position_;
    std::optional<link::SensorReport> sensors_;
    std::optional<link::BlackboxChunk> chunk_;
    std::optional<link::Parameters> parameters_;
    std::vector<link::Telemetry> telemetry_;
    std::vector<link::ClockReply> clock_replies_;
    bool connected_ = false;
    bool speaking_ = true;
    std::uint64_t job_ = 0;
    std::vector<Item> items_;
    std::uint32_t sent_ = 0;
    std::uint32_t limit_ = 0xFFFFFFFF;
    std::int64_t ack_tick_ = 0;
    std::int64_t tick_ = 0;
    std::vector<trace::PulseRecord> pulses_;
    std::vector<PathPulse> path_pulses_;
    std::vector<AxisPositions> set_points_;
    std::vector<std::uint8_t> bytes_;
    std::function<void()> on_tick_;
};

/// A short job on face 0: turn, one cross by the galvo, one line by the axes.
std::vector<Item> short_job(double line_mm = 20.0);

}  // namespace sc::test
