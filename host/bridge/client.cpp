// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/client.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <utility>
#include <vector>

#include "shared/hash/crc.hpp"
#include "shared/link/config.hpp"
#include "shared/link/map_codec.hpp"
#include "shared/link/schema.hpp"

namespace sc::host {
namespace {

/// Four heartbeats within one timeout: one may be lost and one late.
constexpr int kHeartbeatsPerTimeout = 4;
constexpr int kBusyTries = 4;

Refusal refusal_of(std::uint16_t number) { return static_cast<Refusal>(number); }

std::string hex(std::uint64_t value) {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

std::string axis_name(std::uint8_t axis) { return axis < kAxisCount ? std::string(1, "XYZC"[axis]) : "?"; }

}  // namespace

std::string describe_map_place(const MapFinding& finding) {
    const std::string axis = "set-point of " + axis_name(finding.axis);
    return finding.along == MapFinding::kBacklash
               ? axis + ", backlash"
               : axis + ", table along " + axis_name(finding.along) + ", node " + std::to_string(finding.node);
}

std::string name_of(link::Verb verb) {
    switch (verb) {
        case link::Verb::enable: return "enable";
        case link::Verb::disable: return "disable";
        case link::Verb::home: return "home";
        case link::Verb::arm: return "arm";
        case link::Verb::disarm: return "disarm";
        case link::Verb::start: return "start";
        case link::Verb::hold: return "hold";
        case link::Verb::resume: return "resume";
        case link::Verb::abort: return "abort";
        case link::Verb::reset_fault: return "reset_fault";
        case link::Verb::jog: return "jog";
        case link::Verb::stop: return "stop";
        case link::Verb::set_override: return "set_override";
        case link::Verb::preview: return "preview";
        case link::Verb::set_pulse_width: return "set_pulse_width";
        case link::Verb::guide: return "guide";
        case link::Verb::lasers_in_turn: return "lasers_in_turn";
    }
    return "command " + std::to_string(static_cast<int>(verb));
}

CellClient::CellClient(Transport& transport, const ClientOptions& options)
    : transport_(&transport), wire_(transport), options_(options), last_heard_(transport.now()) {}

State CellClient::state() const noexcept { return status_ ? static_cast<State>(status_->state) : State::boot; }

void CellClient::keep_alive() {
    if (!connected_ || now() < next_heartbeat_) {
        return;
    }
    const auto us = now().time_since_epoch().count() / 1000;
    wire_.send(link::Heartbeat{static_cast<std::uint64_t>(us)});
    next_heartbeat_ = now() + options_.heartbeat_timeout / kHeartbeatsPerTimeout;
}

bool CellClient::pump(HostTime until) {
    for (;;) {
        if (stop_check_ && stop_check_()) {
            throw Interrupted();
        }
        if (seal_expired_ && connected_ && !connecting_) {
            connect();
        }
        keep_alive();
        const HostTime wake = connected_ ? std::min(until, next_heartbeat_) : until;
        const std::size_t taken = wire_.receive(wake, [this](const CellMessage& message) { take(message); });
        if (taken > 0) {
            last_heard_ = now();
            return true;
        }
        if (transport_->closed()) {
            throw LinkError("the link to the cell has closed");
        }
        if (now() - last_heard_ > options_.silence) {
            throw LinkError("the cell has been silent for " + std::to_string(options_.silence.count() / 1'000'000'000) +
                            " s: check its supply and the cable");
        }
        if (now() >= until) {
            return false;
        }
    }
}

bool CellClient::pump_until(const std::function<bool()>& done, Nanoseconds limit) {
    const HostTime end = now() + limit;
    while (!done() && now() < end) {
        pump(end);
    }
    return done();
}

void CellClient::check_fault() const {
    if (!status_ || state() != State::fault) {
        return;
    }
    const std::uint8_t number = status_->first_fault;
    const std::uint8_t axis = status_->first_fault_axis;
    std::string text = "the cell has stopped with a fault: " + describe_code(number);
    if (axis < kAxisCount) {
        text += ", axis " + axis_name(axis);
    }
    throw CellFault(text, static_cast<Fault>(number), axis);
}

void CellClient::wait_for(std::initializer_list<State> wanted, Nanoseconds limit, const std::string& doing) {
    const auto reached = [&] {
        return status_fresh_ && std::find(wanted.begin(), wanted.end(), state()) != wanted.end();
    };
    const auto over = [&] { return reached() || (status_fresh_ && state() == State::fault); };
    if (!pump_until(over, limit)) {
        throw CellError(doing + " has not ended within " + std::to_string(limit.count() / 1'000'000'000) +
                        " s; the cell is in state " + std::string(sc::name_of(state())));
    }
    if (!reached()) {
        check_fault();
    }
}

bool CellClient::repeat_until(const std::function<void()>& send, const std::function<bool()>& answered) {
    for (int attempt = 0; attempt < options_.attempts; ++attempt) {
        repeats_ += attempt > 0 ? 1U : 0U;
        send();
        if (pump_until(answered, options_.reply_wait)) {
            return true;
        }
    }
    return false;
}

void CellClient::connect() {
    struct Busy {
        bool& flag;
        explicit Busy(bool& busy) : flag(busy) { flag = true; }
        Busy(const Busy&) = delete;
        Busy& operator=(const Busy&) = delete;
        ~Busy() { flag = false; }
    };
    const Busy busy(connecting_);
    seal_expired_ = false;
    shake_hands();
    // Another host's session is open until it has been silent for its timeout: one that has just been killed, say.
    for (int i = 0; i < kBusyTries && refusal_of(hello_.refusal) == Refusal::wrong_state; ++i) {
        pump_until([] { return false; }, options_.reply_wait);
        shake_hands();
    }
    seal_expired_ = false;
    check_handshake();
    sequence_ = std::max(sequence_, hello_.last_sequence);
    if (!connected_) {
        connected_at_ = now();
    }
    connected_ = true;
    next_heartbeat_ = now();
    keep_alive();
}

/// Once more with an older minor version, if that is what the controller speaks.
void CellClient::shake_hands() {
    if (options_.key) {
        shake_hands_sealed();
        return;
    }
    const auto timeout_ms = static_cast<std::uint16_t>(options_.heartbeat_timeout.count() / 1'000'000);
    wire_.set_minor(link::kProtocolMinor);
    say_hello(timeout_ms);
    const std::optional<std::uint8_t> theirs = link::minor_of(hello_.schema);
    if (refusal_of(hello_.refusal) == Refusal::schema_mismatch && theirs && *theirs < link::kProtocolMinor) {
        wire_.set_minor(*theirs);
        say_hello(timeout_ms);
    }
}

void CellClient::say_hello(std::uint16_t timeout_ms) {
    const link::Hello hello{.schema = link::kSchemaHashes[wire_.minor()],
                            .minor = wire_.minor(),
                            .session = options_.session,
                            .heartbeat_timeout_ms = timeout_ms};
    hello_fresh_ = false;
    last_heard_ = now();
    if (!repeat_until([&] { wire_.send(hello); }, [this] { return hello_fresh_; })) {
        throw LinkError("no controller answers on this link: check the device, its speed and that the cell is on");
    }
}

void CellClient::check_handshake() const {
    Refusal why = refusal_of(hello_.refusal);
    if (why == Refusal::none && hello_.major != link::kProtocolMajor) {
        why = Refusal::version_mismatch;
    }
    if (why == Refusal::none && hello_.schema != link::kSchemaHashes[wire_.minor()]) {
        why = Refusal::schema_mismatch;
    }
    if (why == Refusal::none) {
        return;
    }
    const auto side = [](int major, int minor, std::uint64_t schema) {
        return "version " + std::to_string(major) + "." + std::to_string(minor) + ", schema " + hex(schema);
    };
    const std::string reason = why == Refusal::wrong_state ? "another host is connected to this cell; end it first"
                                                           : describe_code(static_cast<std::uint16_t>(why));
    throw CellRefused("connection refused: " + reason +
                          "; host: " + side(link::kProtocolMajor, link::kProtocolMinor, link::kSchemaHash) +
                          "; controller: " + side(hello_.major, hello_.minor, hello_.schema),
                      why, 0);
}

CellClient::Reply CellClient::await_reply(const Sender& send, const std::string& doing) {
    const std::uint32_t sequence = ++sequence_;
    reply_.reset();
    if (!repeat_until([&] { send(sequence); }, [&] { return reply_ && reply_->sequence == sequence; })) {
        throw LinkError("the cell does not answer to '" + doing + "'");
    }
    return *reply_;
}

void CellClient::request(const Sender& send, const std::string& doing) {
    Reply reply = await_reply(send, doing);
    if (refusal_of(reply.refusal) == Refusal::not_connected) {
        // The host was away for longer than the session lives (planning, say).
        connect();
        reply = await_reply(send, doing);
    }
    if (reply.refusal != 0) {
        throw CellRefused("the cell refused '" + doing + "' in state " + std::string(sc::name_of(state())) + ": " +
                              describe_code(reply.refusal) +
                              (reply.detail != 0 ? ", detail " + std::to_string(reply.detail) : ""),
                          refusal_of(reply.refusal), reply.detail);
    }
}

void CellClient::command(link::Verb verb, std::int32_t arg0, std::int32_t arg1, std::int32_t arg2) {
    const auto send = [&](std::uint32_t sequence) {
        wire_.send(link::Command{sequence, static_cast<std::uint8_t>(verb), arg0, arg1, arg2});
    };
    request(send, name_of(verb));
}

void CellClient::open_job(std::uint64_t job, std::uint32_t items) {
    ack_.reset();
    job_refused_.reset();
    request([&](std::uint32_t sequence) { wire_.send(link::JobOpen{sequence, job, items}); }, "open job");
    // What was said before the answer is about the job before, which may have been the same one.
    ack_.reset();
    job_refused_.reset();
}

void CellClient::set_compensation(const Compensation& compensation) {
    link::SetCompensation message;
    for (std::size_t i = 0; i < 9; ++i) {
        message.axis_matrix[i] = compensation.axis_from_h.row[i / 3][i % 3];
    }
    message.axis_offset = {compensation.axis_offset.x, compensation.axis_offset.y, compensation.axis_offset.z};
    message.galvo_matrix = compensation.galvo_from_field;
    message.galvo_offset = compensation.galvo_offset;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    request(send, "set compensation");
}

void CellClient::set_galvo_field(const GalvoField& field) {
    link::SetGalvoField message;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    const std::size_t numbers = field.empty() ? 0 : GalvoField::kNumbers;
    for (std::size_t first = 0; first < numbers; first += message.count) {
        message.first = static_cast<std::uint16_t>(first);
        message.count = static_cast<std::uint8_t>(std::min(message.numbers.size(), numbers - first));
        for (std::size_t i = 0; i < message.count; ++i) {
            message.numbers[i] = field.number(first + i);
        }
        request(send, "set galvo field");
    }
    message = {.first = static_cast<std::uint16_t>(numbers)};
    request(send, "set galvo field");
}

void CellClient::set_power_curve(const PowerCurve& curve) {
    link::SetPowerCurve message;
    message.count = curve.count;
    message.bytes = curve.byte;
    message.watts = curve.watts;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    request(send, "set the power curve");
}

void CellClient::set_galvo_lag(const GalvoLag& lag) {
    if (minor() < link::SetGalvoLag::kSince && lag.empty()) {
        return;
    }
    require(link::SetGalvoLag::kSince, "be told how its mirrors follow");
    link::SetGalvoLag message;
    message.latency_ns = static_cast<std::uint32_t>(std::clamp<std::int64_t>(lag.latency_ns, 0, 0xFFFF'FFFF));
    message.natural_frequency_hz = lag.natural_frequency.si();
    message.damping = lag.damping;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    request(send, "set the galvo's lag");
}

void CellClient::send_pieces(std::span<const std::uint8_t> bytes, const char* what) {
    link::MapChunk chunk;
    for (std::size_t offset = 0; offset < bytes.size(); offset += chunk.data.size) {
        chunk.offset = static_cast<std::uint16_t>(offset);
        chunk.data.size = static_cast<std::uint8_t>(std::min(chunk.data.data.size(), bytes.size() - offset));
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), chunk.data.size, chunk.data.data.begin());
        const auto send = [&](std::uint32_t sequence) {
            chunk.sequence = sequence;
            wire_.send(chunk);
        };
        request(send, what);
    }
}

void CellClient::set_map(const AxisMap& map) {
    link::MapBytes bytes{};
    link::SetMap set;
    if (!map.is_identity()) {
        link::serialise(map, bytes);
        set.bytes = static_cast<std::uint16_t>(bytes.size());
        set.crc = crc32(bytes);
    }
    send_pieces(std::span(bytes).first(set.bytes), "take a piece of the axis map");
    const auto send = [&](std::uint32_t sequence) {
        set.sequence = sequence;
        wire_.send(set);
    };
    try {
        request(send, "set the axis map");
    } catch (const CellRefused& refused) {
        if (refused.refusal != Refusal::bad_map && refused.refusal != Refusal::map_too_steep) {
            throw;
        }
        throw CellRefused(std::string(refused.what()) + " (" +
                              describe_map_place(MapFinding::from_detail(refused.refusal, refused.detail)) + ")",
                          refused.refusal, refused.detail);
    }
}

void CellClient::require(std::uint8_t since, const std::string& what) const {
    if (minor() < since) {
        throw CellRefused(
            "the controller speaks version 1." + std::to_string(minor()) + " of the link, which cannot " + what,
            Refusal::unknown_command, 0);
    }
}

void CellClient::resume_job(link::JobResume resume) {
    require(link::JobResume::kSince, "begin a job in its midst");
    const auto send = [&](std::uint32_t sequence) {
        resume.sequence = sequence;
        wire_.send(resume);
    };
    request(send, "open job in its midst");
    ack_.reset();
    job_refused_.reset();
}

std::optional<link::Position> CellClient::position() {
    if (minor() < link::PositionRequest::kSince) {
        return std::nullopt;
    }
    position_.reset();
    const link::PositionRequest wanted{++token_};
    const auto answered = [&] { return position_ && position_->token == wanted.token; };
    if (!repeat_until([&] { wire_.send(wanted); }, answered)) {
        throw LinkError("the cell does not tell how far its job has come");
    }
    return position_;
}

std::uint16_t CellClient::send_block(const link::Block& block) {
    await_room();
    return wire_.send(block);
}

std::optional<link::StreamMissing> CellClient::take_missing() { return std::exchange(missing_, std::nullopt); }

MachineConfig CellClient::read_config() {
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < hello_.config_bytes) {
        const link::ConfigRequest wanted{static_cast<std::uint16_t>(bytes.size())};
        chunk_.reset();
        const auto answered = [&] { return chunk_ && chunk_->offset == wanted.offset && chunk_->data.size > 0; };
        if (!repeat_until([&] { wire_.send(wanted); }, answered)) {
            throw LinkError("the cell does not tell its configuration");
        }
        const std::span<const std::uint8_t> data = std::span(chunk_->data.data).first(chunk_->data.size);
        bytes.insert(bytes.end(), data.begin(), data.end());
    }
    const auto config = link::deserialise(bytes);
    if (bytes.size() != hello_.config_bytes || crc32(bytes) != hello_.config_crc || !config) {
        throw LinkError("the cell's configuration came through damaged: report this, with the versions of both sides");
    }
    return *config;
}

void CellClient::take(const CellMessage& message) {
    std::visit([this](const auto& m) { take(m); }, message);
}

void CellClient::take(const link::HelloReply& message) {
    if (refusal_of(message.refusal) == Refusal::seal_expired) {
        seal_expired_ = true;  // no answer to a hello
        return;
    }
    if (message.session == options_.session || message.refusal != 0) {
        if (message.boot != hello_.boot) {
            clock_.clear();  // of another start
        }
        hello_ = message;
        hello_fresh_ = true;
    }
}

void CellClient::take(const link::CommandReply& message) {
    reply_ = Reply{message.sequence, message.refusal, message.detail};
    status_fresh_ = false;
}

void CellClient::take(const link::StreamAck& message) { ack_ = message; }

void CellClient::take(const link::JobRefused& message) { job_refused_ = message; }

void CellClient::take(const link::ConfigChunk& message) { chunk_ = message; }

void CellClient::take(const link::Status& message) {
    const State before = state();
    const bool first = !status_;
    status_ = message;
    status_fresh_ = true;
    if (on_state_ && (first || before != state())) {
        on_state_(before, state());
    }
}

}  // namespace sc::host
