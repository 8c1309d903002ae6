// SPDX-License-Identifier: Apache-2.0
#include "cell_rig.hpp"

#include <stdexcept>

namespace sc::test {
namespace {

constexpr std::int32_t kMm = 100'000;  // wire units

}  // namespace

CellRig::CellRig(const Options& options) : options_(options) {
    sim::CellOptions cell;
    cell.machine = options.machine;
    cell.world = options.world.empty() ? std::string(SC_SOURCE_DIR) + "/boards/sim/world/default/world.toml"
                                       : options.world.string();
    cell.script = sim::parse_fault_script(options.script, "script");
    cell.baud = options.baud;
    cell.record = options.record;
    cell.memory = options.memory;
    cell.controller = options.controller;
    cell.drives = options.drives;
    cell.on_pulse = [this](const trace::PulseRecord& pulse) { pulses_.push_back(pulse); };
    cell_ = std::make_unique<sim::SimCell>(cell);
}

template <class Message>
void CellRig::send(const Message& message) {
    if (!speaking_) {
        return;
    }
    std::array<std::uint8_t, link::kSerialCapacity> out{};
    const std::size_t size = link::encode_serial(message, counter_++, out);
    cell_->push_link(std::span(out).first(size));
}

void CellRig::receive() {
    bytes_.clear();
    cell_->take_link(bytes_);
    receiver_.receive(bytes_, [&](const link::Envelope& envelope) {
        struct Handler {
            CellRig& rig;
            void operator()(const link::HelloReply& m) const { rig.connected_ = m.refusal == 0; }
            void operator()(const link::CommandReply& m) const { rig.replies_[m.sequence] = m; }
            void operator()(const link::Status& m) const { rig.status_ = m; }
            void operator()(const link::JobRefused& m) const { rig.refused_ = m; }
            void operator()(const link::StreamAck& m) const {
                if (m.received != rig.ack_.received) {
                    rig.ack_tick_ = rig.tick_;
                }
                rig.ack_ = m;
            }
            void operator()(const link::ConfigChunk& /*m*/) const {}
            void operator()(const link::Position& m) const { rig.position_ = m; }
            void operator()(const link::StreamMissing& /*m*/) const {}
            void operator()(const link::SensorReport& m) const { rig.sensors_ = m; }
            void operator()(const link::ClockReply& m) const { rig.clock_replies_.push_back(m); }
            void operator()(const link::Telemetry& m) const { rig.telemetry_.push_back(m); }
            void operator()(const link::BlackboxChunk& m) const { rig.chunk_ = m; }
            void operator()(const link::SealChallenge& /*m*/) const {}
            void operator()(const link::Parameters& m) const { rig.parameters_ = m; }
        };
        (void)link::dispatch(link::CellMessages{}, envelope, Handler{*this});
    });
}

void CellRig::pump() {
    if (connected_ && tick_ % 25 == 0) {
        send(link::Heartbeat{static_cast<std::uint64_t>(tick_) * 1000});
    }
    const std::uint32_t low = static_cast<std::uint32_t>(job_ & 0xFFFFFFFFU);
    if (items_.empty() || ack_.job_low != low) {
        return;
    }
    if (tick_ - ack_tick_ > 60) {
        sent_ = ack_.received;
        ack_tick_ = tick_;
    }
    const std::uint32_t last =
        std::min({static_cast<std::uint32_t>(items_.size()), limit_, ack_.received + ack_.free_items});
    while (sent_ < last) {
        const std::size_t count = std::min<std::size_t>(options_.items_per_block, last - sent_);
        link::Block block = link::make_block(job_, std::span(items_).first(sent_ + count), sent_);
        if (block.count == 0) {
            throw std::runtime_error("block holds nothing");
        }
        sent_ += block.count;
        if (options_.troubled_stream) {
            link::Block foreign = block;
            foreign.job_low ^= 1U;
            foreign.items.data.at(foreign.items.size / 2) ^= 1U;
            send(foreign);
            send(block);
        }
        send(block);
    }
}

void CellRig::tick() {
    pump();
    cell_->tick();
    const ServoOutputs& out = cell_->latest();
    path_pulses_.insert(path_pulses_.end(), out.pulses.begin(),
                        out.pulses.begin() + static_cast<std::ptrdiff_t>(out.pulses_size));
    set_points_.push_back(out.set_point);
    ++tick_;
    receive();
    if (on_tick_) {
        on_tick_();
    }
}

void CellRig::ticks(int count) {
    for (int i = 0; i < count; ++i) {
        tick();
    }
}

bool CellRig::until(const std::function<bool()>& predicate, int limit) {
    for (int i = 0; i < limit; ++i) {
        if (predicate()) {
            return true;
        }
        tick();
    }
    return predicate();
}

void CellRig::connect() {
    link::Hello hello;
    hello.schema = link::schema_hash();
    hello.session = 77;
    hello.heartbeat_timeout_ms = 100;
    send(hello);
    if (!until([&] { return connected_; }, 200)) {
        throw std::runtime_error("no session");
    }
}

link::CommandReply CellRig::command(link::Verb verb, std::int32_t arg0, std::int32_t arg1, std::int32_t arg2) {
    const std::uint32_t sequence = ++sequence_;
    send(link::Command{sequence, static_cast<std::uint8_t>(verb), arg0, arg1, arg2});
    return reply_to(sequence);
}

link::CommandReply CellRig::set_compensation(const Compensation& compensation) {
    link::SetCompensation message;
    message.sequence = ++sequence_;
    for (std::size_t i = 0; i < 9; ++i) {
        message.axis_matrix[i] = compensation.axis_from_h.row[i / 3][i % 3];
    }
    message.axis_offset = {compensation.axis_offset.x, compensation.axis_offset.y, compensation.axis_offset.z};
    message.galvo_matrix = compensation.galvo_from_field;
    message.galvo_offset = compensation.galvo_offset;
    send(message);
    return reply_to(message.sequence);
}

link::CommandReply CellRig::set_surface(link::SetSurface message) {
    message.sequence = ++sequence_;
    send(message);
    return reply_to(message.sequence);
}

link::CommandReply CellRig::check_seating(link::CheckSeating message) {
    message.sequence = ++sequence_;
    send(message);
    (void)until([&] { return replies_.contains(message.sequence); }, 130'000);
    return reply_to(message.sequence);
}

link::SensorReport CellRig::sensors() {
    sensors_.reset();
    send(link::SensorsRequest{});
    if (!until([&] { return sensors_.has_value(); }, 200)) {
        throw std::runtime_error("no report of the sensors");
    }
    return *sensors_;
}

link::CommandReply CellRig::subscribe(link::TelemetryRequest message) {
    message.sequence = ++sequence_;
    send(message);
    return reply_to(message.sequence);
}

link::BlackboxChunk CellRig::black_box(link::BlackboxPart part, std::uint32_t first) {
    chunk_.reset();
    send(link::BlackboxRequest{static_cast<std::uint8_t>(part), first});
    if (!until([&] { return chunk_.has_value(); }, 200)) {
        throw std::runtime_error("no black box");
    }
    return *chunk_;
}

std::uint32_t CellRig::send_store(std::span<const std::uint8_t> bytes, std::uint16_t layout) {
    for (std::size_t offset = 0; offset < bytes.size(); offset += 200) {
        const auto piece = bytes.subspan(offset, std::min<std::size_t>(200, bytes.size() - offset));
        static_cast<void>(send_map_chunk(static_cast<std::uint16_t>(offset), piece));
    }
    const std::uint32_t sequence = ++sequence_;
    send(link::StoreParameters{sequence, layout, static_cast<std::uint16_t>(bytes.size()), crc32(bytes)});
    return sequence;
}

link::CommandReply CellRig::store(std::span<const std::uint8_t> bytes, std::uint16_t layout) {
    return reply_to(send_store(bytes, layout));
}

link::Parameters CellRig::parameters(std::uint16_t offset) {
    parameters_.reset();
    send(link::ParametersRequest{offset});
    if (!until([&] { return parameters_.has_value(); }, 200)) {
        throw std::runtime_error("no parameters");
    }
    return *parameters_;
}

link::CommandReply CellRig::set_power_curve(const PowerCurve& curve) {
    link::SetPowerCurve message;
    message.sequence = ++sequence_;
    message.count = curve.count;
    message.bytes = curve.byte;
    message.watts = curve.watts;
    send(message);
    return reply_to(message.sequence);
}

link::CommandReply CellRig::set_galvo_lag(const GalvoLag& lag) {
    link::SetGalvoLag message;
    message.sequence = ++sequence_;
    message.latency_ns = static_cast<std::uint32_t>(lag.latency_ns);
    message.natural_frequency_hz = lag.natural_frequency.si();
    message.damping = lag.damping;
    send(message);
    return reply_to(message.sequence);
}

link::CommandReply CellRig::set_galvo_field(link::SetGalvoField message) {
    message.sequence = ++sequence_;
    send(message);
    return reply_to(message.sequence);
}

link::CommandReply CellRig::send_map_chunk(std::uint16_t offset, std::span<const std::uint8_t> bytes) {
    link::MapChunk chunk;
    chunk.sequence = ++sequence_;
    chunk.offset = offset;
    chunk.data.size = static_cast<std::uint8_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), chunk.data.data.begin());
    send(chunk);
    return reply_to(chunk.sequence);
}

link::CommandReply CellRig::commit_map(std::uint16_t bytes, std::uint32_t crc) {
    send(link::SetMap{++sequence_, bytes, crc});
    return reply_to(sequence_);
}

link::CommandReply CellRig::set_map(const AxisMap& map) {
    link::MapBytes bytes{};
    link::serialise(map, bytes);
    for (std::size_t offset = 0; offset < bytes.size();) {
        const std::size_t size = std::min<std::size_t>(200, bytes.size() - offset);
        const auto reply = send_map_chunk(static_cast<std::uint16_t>(offset), std::span(bytes).subspan(offset, size));
        if (reply.refusal != 0) {
            return reply;
        }
        offset += size;
    }
    return commit_map(static_cast<std::uint16_t>(bytes.size()), link::map_crc(map));
}

link::CommandReply CellRig::reply_to(std::uint32_t sequence) {
    if (!until([&] { return replies_.contains(sequence); }, 1000)) {
        throw std::runtime_error("no reply");
    }
    return replies_[sequence];
}

void CellRig::make_ready() {
    connect();
    if (!until_state(State::disabled, 5000) || command(link::Verb::enable).refusal != 0 ||
        !until_state(State::idle, 5000) || command(link::Verb::home).refusal != 0) {
        throw std::runtime_error("cannot enable");
    }
    if (!until_state(State::homing, 100) || !until_state(State::idle, 120'000) ||
        command(link::Verb::arm).refusal != 0 || !until_state(State::armed, 1000)) {
        throw std::runtime_error("cannot home or arm");
    }
}

link::CommandReply CellRig::open_job(std::vector<Item> items, std::uint64_t flip) {
    items_ = std::move(items);
    job_ = job_hash(items_) ^ flip;
    sent_ = 0;
    refused_.reset();
    link::JobOpen open;
    open.sequence = ++sequence_;
    open.job = job_;
    open.items = static_cast<std::uint32_t>(items_.size());
    send(open);
    if (!until([&] { return replies_.contains(open.sequence); }, 1000)) {
        throw std::runtime_error("no reply");
    }
    return replies_[open.sequence];
}

std::string CellRig::command_hash() const {
    Sha256 hash;
    for (const PathPulse& pulse : path_pulses_) {
        std::array<std::uint8_t, trace::kCommandRecordSize> bytes{};
        trace::pack(trace::CommandRecord{pulse.path, pulse.pass, pulse.number, pulse.s_pm, pulse.place_pm,
                                         pulse.energy_code, pulse.t_ns},
                    bytes);
        hash.update(bytes);
    }
    const auto text = to_hex(hash.digest());
    return {text.begin(), text.end()};
}

std::vector<Item> short_job(double line_mm) {
    std::vector<Item> items;
    items.emplace_back(Turn{0});
    const std::int32_t x = -250 * kMm;
    const std::int32_t y = static_cast<std::int32_t>(-319.0 * kMm);
    const std::int32_t z = -390 * kMm;
    std::uint32_t path = 0;
    for (const bool across : {true, false}) {
        PathBegin begin;
        begin.path = path++;
        begin.actuator = Actuator::galvo;
        begin.speed_um_s = 250'000;
        begin.pitch_nm = 20'000;
        begin.energy_nj = 300'000;
        begin.anchor_x = x;
        begin.anchor_y = y;
        begin.anchor_z = z;
        items.emplace_back(begin);
        items.emplace_back(PathPoint{x - (across ? 2 * kMm : 0), y, z - (across ? 0 : 2 * kMm)});
        items.emplace_back(PathPoint{x + (across ? 2 * kMm : 0), y, z + (across ? 0 : 2 * kMm)});
        items.emplace_back(PathEnd{});
    }
    PathBegin line;
    line.path = path;
    line.actuator = Actuator::axes;
    line.speed_um_s = 60'000;
    line.pitch_nm = 20'000;
    line.energy_nj = 300'000;
    line.tolerance_nm = 10'000;
    items.emplace_back(line);
    // A bend in the middle, so that a blend is passed.
    const auto half = static_cast<std::int32_t>(line_mm / 2 * kMm);
    items.emplace_back(PathPoint{x - half, y, z});
    items.emplace_back(PathPoint{x, y, z + kMm});
    items.emplace_back(PathPoint{x + half, y, z});
    items.emplace_back(PathEnd{});
    items.emplace_back(JobEnd{});
    return items;
}

}  // namespace sc::test
