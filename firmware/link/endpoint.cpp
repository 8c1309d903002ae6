// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/endpoint.hpp"

#include <algorithm>
#include <type_traits>

#include "shared/hash/crc.hpp"

namespace sc::link {

Endpoint::Endpoint(const MachineConfig& machine, std::uint32_t boot_id, const EndpointOptions& options) noexcept
    : config_crc_(0),
      boot_id_(boot_id),
      control_period_ns_(std::max<std::int64_t>(machine.control_period_ns, 1)),
      items_per_tick_(options.items_per_tick),
      newest_minor_(options.newest_minor),
      stream_(options.rules) {
    serialise(machine, config_);
    config_crc_ = crc32(config_);
}

// --- receiving ----------------------------------------------------------------------------------------------------

void Endpoint::receive(std::int64_t tick, std::span<const std::uint8_t> bytes) noexcept {
    tick_ = tick;
    receiver_.receive(bytes, [this](const Envelope& envelope) noexcept { take(envelope); });
    stream_.step(items_per_tick_);
}

void Endpoint::take(const Envelope& envelope) noexcept {
    if (session_open_ && envelope.id != Hello::kId) {
        if (!watch_.take(envelope.counter)) {
            return;
        }
        last_heard_ = tick_;
        heard_ = envelope.counter;
    }
    if (envelope.id == Block::kId) {
        take_block(envelope.payload);
        return;
    }
    const Dispatch result = dispatch(HostMessages{}, envelope, [this, &envelope](const auto& message) noexcept {
        if constexpr (std::is_same_v<decltype(message), const Hello&>) {
            on_hello(message, envelope.counter);
        } else {
            on(message);
        }
    });
    if (result != Dispatch::handled) {
        ++counters_.frames_bad;
    }
}

Refusal Endpoint::judge(const Hello& hello) const noexcept {
    constexpr std::uint16_t kShortestTimeoutMs = 20;
    constexpr std::uint16_t kLongestTimeoutMs = 500;
    if (hello.major != kProtocolMajor) {
        return Refusal::version_mismatch;
    }
    if (minor_of(hello.schema).value_or(0xFF) > newest_minor_) {
        return Refusal::schema_mismatch;
    }
    if (hello.heartbeat_timeout_ms < kShortestTimeoutMs || hello.heartbeat_timeout_ms > kLongestTimeoutMs) {
        return Refusal::bad_config;
    }
    return hello.session != session_ && alive(tick_) ? Refusal::wrong_state : Refusal::none;
}

void Endpoint::on_hello(const Hello& hello, std::uint16_t counter) noexcept {
    const Refusal refusal = judge(hello);
    if (refusal == Refusal::none) {
        const bool resumed = session_open_ && hello.session == session_;
        if (!resumed) {
            event_count_ = 0;
            replies_ = {};
            unremembered_.reset();
        }
        LinkEvent event;
        event.kind = resumed ? LinkEvent::Kind::session_resumed : LinkEvent::Kind::session_open;
        if (!push_event(event)) {
            return;
        }
        session_open_ = true;
        session_ = hello.session;
        minor_ = minor_of(hello.schema).value_or(kProtocolMinor);
        receiver_.set_minor(minor_);
        heard_ = counter;
        timeout_ticks_ = std::int64_t{hello.heartbeat_timeout_ms} * 1'000'000 / control_period_ns_;
        last_heard_ = tick_;
        watch_.restart(counter);
    } else {
        ++counters_.hellos_refused;
    }
    HelloReply reply;
    // To a peer that is refused: the newest that is spoken here, so that it may choose an older one.
    const std::uint8_t minor = refusal == Refusal::none ? minor_ : newest_minor_;
    reply.schema = kSchemaHashes[minor];
    reply.minor = minor;
    reply.refusal = static_cast<std::uint16_t>(refusal);
    reply.session = hello.session;
    reply.boot = boot_id_;
    reply.config_bytes = static_cast<std::uint16_t>(config_.size());
    reply.config_crc = config_crc_;
    reply.last_sequence = replies_.newest();
    hello_reply_ = reply;
}

void Endpoint::on(const Heartbeat& /*heartbeat*/) noexcept {}

void Endpoint::on(const Command& command) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::command;
    event.command = command;
    request(command.sequence, event);
}

void Endpoint::on(const JobOpen& open) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::job_open;
    event.job_open = open;
    request(open.sequence, event);
}

void Endpoint::on(const JobResume& resume) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::job_resume;
    event.job_resume = resume;
    request(resume.sequence, event);
}

void Endpoint::on(const PositionRequest& request) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::position_request;
    event.position_request = request;
    if (session_open_) {
        push_event(event);
    }
}

void Endpoint::on(const SetCompensation& compensation) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::compensation;
    event.compensation = compensation;
    request(compensation.sequence, event);
}

// Apart from the decoder, whose frame holds the whole message already.
[[gnu::noinline]] void Endpoint::on(const MapChunk& chunk) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::map_chunk;
    event.map_chunk = chunk;
    request(chunk.sequence, event);
}

void Endpoint::on(const SetMap& map) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::set_map;
    event.set_map = map;
    request(map.sequence, event);
}

[[gnu::noinline]] void Endpoint::on(const SetGalvoField& field) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::galvo_field;
    event.galvo_field = field;
    request(field.sequence, event);
}

[[gnu::noinline]] void Endpoint::on(const SetPowerCurve& curve) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::power_curve;
    event.power_curve = curve;
    request(curve.sequence, event);
}

void Endpoint::on(const SetGalvoLag& lag) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::galvo_lag;
    event.galvo_lag = lag;
    request(lag.sequence, event);
}

void Endpoint::on(const SetSurface& surface) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::surface;
    event.surface = surface;
    request(surface.sequence, event);
}

void Endpoint::on(const CheckSeating& seating) noexcept {
    LinkEvent event;
    event.kind = LinkEvent::Kind::seating;
    event.seating = seating;
    request(seating.sequence, event);
}

void Endpoint::on(const SensorsRequest& /*request*/) noexcept {
    if (session_open_) {
        LinkEvent event;
        event.kind = LinkEvent::Kind::sensors;
        static_cast<void>(push_event(event));
    }
}

void Endpoint::take_block(std::span<const std::uint8_t> payload) noexcept {
    const std::optional<BlockView> block = view_block(payload);
    if (!block) {
        ++counters_.frames_bad;
    } else if (session_open_ && stream_.take(*block) != JobStream::Taken::foreign) {
        ack_now_ = true;
        gap_told_ = false;
    }
}

void Endpoint::on(const ConfigRequest& request) noexcept {
    if (session_open_) {
        config_wanted_ = request.offset;
    }
}

void Endpoint::request(std::uint32_t sequence, const LinkEvent& event) noexcept {
    if (!session_open_) {
        answer_unremembered(sequence, Refusal::not_connected);
        return;
    }
    if (event_count_ == kEvents) {
        ++counters_.events_lost;
        return;
    }
    switch (replies_.take(sequence)) {
        case ReplyMemory::Verdict::fresh: push_event(event); break;
        case ReplyMemory::Verdict::stale: answer_unremembered(sequence, Refusal::wrong_state); break;
        case ReplyMemory::Verdict::full: ++counters_.events_lost; break;
        case ReplyMemory::Verdict::pending:
        case ReplyMemory::Verdict::repeat: break;
    }
}

void Endpoint::answer_unremembered(std::uint32_t sequence, Refusal refusal) noexcept {
    unremembered_ = CommandReply{sequence, static_cast<std::uint16_t>(refusal), 0};
}

bool Endpoint::push_event(const LinkEvent& event) noexcept {
    if (event_count_ == kEvents) {
        ++counters_.events_lost;
        return false;
    }
    events_[(event_head_ + event_count_) % kEvents] = event;
    ++event_count_;
    return true;
}

bool Endpoint::alive(std::int64_t tick) const noexcept { return session_open_ && tick - last_heard_ <= timeout_ticks_; }

// --- the controller's side ----------------------------------------------------------------------------------------

bool Endpoint::poll(LinkEvent& out) noexcept {
    if (event_count_ == 0) {
        out = {};
        return false;
    }
    out = events_[event_head_];
    event_head_ = (event_head_ + 1) % kEvents;
    --event_count_;
    return true;
}

void Endpoint::reply(std::uint32_t sequence, Refusal refusal, std::int64_t detail) noexcept {
    replies_.answer(sequence, refusal, detail);
}

void Endpoint::open_job(std::uint64_t job, std::uint32_t items) noexcept {
    stream_.open(job, items);
    if (stream_.received() == 0) {
        progress_ = {};
    }
    job_seen_ = true;
    ack_now_ = true;
    next_refused_tick_ = tick_;
}

void Endpoint::resume_job(const JobResume& resume) noexcept {
    stream_.open_at(resume.job, resume.items, {resume.first, resume.hash_before});
    progress_ = {};
    progress_.planned = progress_.fired = resume.first;
    job_seen_ = true;
    ack_now_ = true;
    next_refused_tick_ = tick_;
}

void Endpoint::close_job() noexcept { stream_.close(); }

void Endpoint::refuse_item(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept {
    stream_.refuse(item, refusal, axis, value);
}

void Endpoint::progress(std::uint32_t planned, std::uint32_t fired, const FiredPosition& position) noexcept {
    progress_ = {planned, fired, position};
}

LinkCounters Endpoint::counters() const noexcept {
    LinkCounters all = counters_;
    all.frames_bad += receiver_.frames_bad();
    all.messages_lost = watch_.lost();
    all.messages_repeated = watch_.repeated();
    all.items_repeated = stream_.items_repeated();
    all.blocks_ahead = stream_.blocks_ahead();
    return all;
}

// --- sending ------------------------------------------------------------------------------------------------------

std::size_t Endpoint::transmit(std::span<std::uint8_t> out) noexcept {
    Outbox box{out};
    static_cast<void>(send_hello(box) && send_replies(box) && send_refused(box) && send_ack(box) && send_missing(box) &&
                      send_position(box) && send_status(box) && send_report(box) && send_config(box));
    return box.size;
}

/// False when there is no room; everything less urgent then waits too.
template <class Message>
bool Endpoint::send(Outbox& box, const Message& message) noexcept {
    if (since<Message>() > minor_) {
        return true;  // the peer does not know it
    }
    const std::size_t size = encode_serial(message, send_counter_, box.out.subspan(box.size), minor_);
    if (size == 0) {
        return false;
    }
    ++send_counter_;
    box.size += size;
    return true;
}

bool Endpoint::send_hello(Outbox& box) noexcept {
    if (hello_reply_) {
        if (!send(box, *hello_reply_)) {
            return false;
        }
        hello_reply_.reset();
    }
    return true;
}

bool Endpoint::send_replies(Outbox& box) noexcept {
    while (const CommandReply* due = replies_.due()) {
        if (!send(box, *due)) {
            return false;
        }
        replies_.sent(due->sequence);
    }
    if (unremembered_) {
        if (!send(box, *unremembered_)) {
            return false;
        }
        unremembered_.reset();
    }
    return true;
}

bool Endpoint::send_refused(Outbox& box) noexcept {
    if (stream_.refused().refusal == 0 || tick_ < next_refused_tick_) {
        return true;
    }
    if (!send(box, stream_.refused())) {
        return false;
    }
    next_refused_tick_ = tick_ + kRefusedRepeatTicks;
    return true;
}

StreamAck Endpoint::current_ack() const noexcept {
    StreamAck ack;
    ack.job_low = stream_.job_low();
    ack.received = stream_.received();
    ack.planned = progress_.planned;
    ack.fired = progress_.fired;
    ack.free_items = stream_.is_open() ? static_cast<std::uint16_t>(stream_.window()) : std::uint16_t{0};
    ack.path = progress_.position.path;
    ack.pass = progress_.position.pass;
    ack.pulses = progress_.position.pulses;
    return ack;
}

bool Endpoint::ack_due(const StreamAck& ack) const noexcept {
    const bool changed = ack.planned != last_ack_.planned || ack.fired != last_ack_.fired ||
                         ack.free_items != last_ack_.free_items || ack.path != last_ack_.path ||
                         ack.pass != last_ack_.pass || ack.pulses != last_ack_.pulses;
    const std::int64_t age = tick_ - last_ack_tick_;
    return ack_now_ || (changed && age >= kAckEveryTicks) || age >= kAckRepeatTicks;
}

bool Endpoint::send_ack(Outbox& box) noexcept {
    if (!session_open_ || !job_seen_) {
        return true;
    }
    const StreamAck ack = current_ack();
    if (!ack_due(ack)) {
        return true;
    }
    if (!send(box, ack)) {
        return false;
    }
    last_ack_ = ack;
    ack_now_ = false;
    last_ack_tick_ = tick_;
    return true;
}

bool Endpoint::send_missing(Outbox& box) noexcept {
    if (gap_told_ || !session_open_) {
        return true;
    }
    std::array<JobStream::Gap, StreamMissing::kRuns> gaps;
    const std::size_t count = stream_.missing(gaps);
    if (count > 0) {
        StreamMissing missing;
        missing.job_low = stream_.job_low();
        missing.heard = heard_;
        missing.count = static_cast<std::uint8_t>(count);
        for (std::size_t i = 0; i < count; ++i) {
            missing.from[i] = gaps[i].from;
            missing.until[i] = gaps[i].until;
        }
        if (!send(box, missing)) {
            return false;
        }
    }
    gap_told_ = true;
    return true;
}

bool Endpoint::send_position(Outbox& box) noexcept {
    if (position_) {
        if (!send(box, *position_)) {
            return false;
        }
        position_.reset();
    }
    return true;
}

bool Endpoint::send_status(Outbox& box) noexcept {
    // Not in the tick of an acknowledgement: it can wait, and a tick must not carry both.
    if (!status_ || !session_open_ || last_ack_tick_ == tick_) {
        return true;
    }
    const LinkCounters now = counters();
    status_->frames_bad = now.frames_bad;
    status_->messages_lost = now.messages_lost;
    status_->items_repeated = now.items_repeated;
    if (!send(box, *status_)) {
        return false;
    }
    status_.reset();
    return true;
}

bool Endpoint::send_report(Outbox& box) noexcept {
    if (report_) {
        if (!send(box, *report_)) {
            return false;
        }
        report_.reset();
    }
    return true;
}

bool Endpoint::send_config(Outbox& box) noexcept {
    constexpr std::size_t kChunkOverhead = cobs_capacity(kMessageOverhead + sizeof(ConfigChunk::offset) + 1);
    constexpr std::size_t kSmallestChunk = 16;
    if (!config_wanted_) {
        return true;
    }
    ConfigChunk chunk;
    chunk.offset = *config_wanted_;
    const auto rest = std::span<const std::uint8_t>(config_).subspan(std::min<std::size_t>(chunk.offset, kConfigSize));
    const std::size_t room = box.out.size() - box.size;
    if (room < kChunkOverhead + std::min(kSmallestChunk, rest.size())) {
        return false;
    }
    const std::size_t size = std::min({rest.size(), chunk.data.data.size(), room - kChunkOverhead});
    std::copy_n(rest.begin(), size, chunk.data.data.begin());
    chunk.data.size = static_cast<std::uint8_t>(size);
    if (!send(box, chunk)) {
        return false;
    }
    config_wanted_.reset();
    return true;
}

}  // namespace sc::link
