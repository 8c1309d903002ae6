// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/host/bridge/fake_cell.hpp"

#include <algorithm>

#include "shared/hash/crc.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/config.hpp"

namespace sc::host::test {
namespace {

constexpr Nanoseconds kPeriod{20'000'000};

std::array<std::uint8_t, link::kConfigSize> config_bytes(const MachineConfig& machine) {
    std::array<std::uint8_t, link::kConfigSize> bytes{};
    link::serialise(machine, bytes);
    return bytes;
}

}  // namespace

FakeCell::FakeCell(const Trouble& trouble) : trouble_(trouble), random_(trouble.seed) {}

bool FakeCell::chance(double share) { return share > 0.0 && static_cast<double>(random_() >> 11U) * 0x1p-53 < share; }

void FakeCell::post(std::span<const std::uint8_t> frame, bool to_cell) {
    std::vector<std::uint8_t> bytes(frame.begin(), frame.end());
    if (chance(trouble_.drop)) {
        return;
    }
    if (chance(trouble_.corrupt)) {
        bytes[random_() % (bytes.size() - 1)] ^= 0x55U;
    }
    const int copies = chance(trouble_.repeat) ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
        way_.push({now_ + trouble_.delay, order_++, to_cell, bytes});
    }
}

template <class Message>
void FakeCell::say(const Message& message) {
    if (mute) {
        return;
    }
    std::array<std::uint8_t, link::kSerialCapacity> frame{};
    const std::size_t size = link::encode_serial(message, counter_++, frame, minor);
    post(std::span(frame).first(size), false);
}

void FakeCell::send(std::span<const std::uint8_t> bytes) { post(bytes, true); }

void FakeCell::deliver(const Parcel& parcel) {
    if (!parcel.to_cell) {
        arrived_.insert(arrived_.end(), parcel.bytes.begin(), parcel.bytes.end());
        return;
    }
    receiver_.receive(parcel.bytes, [this](const link::Envelope& envelope) {
        heard_ = envelope.counter;
        link::dispatch(link::HostMessages{}, envelope, [this](const auto& message) { take(message); });
    });
}

std::size_t FakeCell::receive(std::span<std::uint8_t> out, HostTime until) {
    while (arrived_.empty() && !unplugged) {
        const HostTime next = way_.empty() ? next_period_ : std::min(next_period_, way_.top().due);
        if (next > until) {
            now_ = std::max(now_, until);
            return 0;
        }
        now_ = std::max(now_, next);
        if (!way_.empty() && way_.top().due == next) {
            const Parcel parcel = way_.top();
            way_.pop();
            deliver(parcel);
        } else {
            period();
        }
    }
    const std::size_t n = std::min(out.size(), arrived_.size());
    std::copy_n(arrived_.begin(), n, out.begin());
    arrived_.erase(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
}

void FakeCell::period() {
    next_period_ += kPeriod;
    if (each_period) {
        each_period();
    }
    if (state == State::running || state == State::previewing) {
        advance_job();
    }
    if (hellos > 0) {
        say_status();
    }
}

void FakeCell::advance_job() {
    const auto reaches = [this](std::optional<std::uint32_t>& item) {
        const bool here = item && fired >= *item;
        if (here) {
            item.reset();
        }
        return here;
    };
    fired = std::min(fired + items_per_period, static_cast<std::uint32_t>(taken.size()));
    if (refuse_item && fired >= *refuse_item) {
        say(link::JobRefused{.job_low = static_cast<std::uint32_t>(job_),
                             .item = *refuse_item,
                             .refusal = static_cast<std::uint16_t>(Refusal::out_of_travel)});
        enter(State::armed);
    } else if (fault_at_item && fired >= *fault_at_item) {
        fault_ = Fault::following_error;
        enter(State::fault);
    } else if (reaches(starve_at_item)) {
        enter(State::held);
    } else if (reaches(hold_link_at_item)) {
        hellos = 0;
        enter(State::held_link);
        say_status();
    } else if (fired == job_items_ && !taken.empty()) {
        job_done_ = true;
        enter(state == State::previewing ? State::idle : State::armed);
    }
    say_ack();
}

void FakeCell::enter(State next) {
    state = next;
    say_status();
}

void FakeCell::say_status() {
    link::Status status;
    status.cell_time_us = static_cast<std::uint64_t>(now_.time_since_epoch().count() / 1000);
    status.state = static_cast<std::uint8_t>(state);
    status.first_fault = static_cast<std::uint8_t>(fault_);
    status.faults = fault_ == Fault::none ? 0 : fault_bit(fault_);
    status.flags = static_cast<std::uint8_t>((homed ? link::kFlagHomed : 0) | (job_done_ ? link::kFlagJobDone : 0));
    status.pulses_total = previewed_ && !burns_in_preview ? 0 : fired;
    status.items_repeated = repeated;
    status.override_percent = static_cast<std::uint8_t>(override_percent);
    say(status);
}

void FakeCell::say_ack() {
    const auto received = static_cast<std::uint32_t>(taken.size());
    say(link::StreamAck{.job_low = static_cast<std::uint32_t>(job_),
                        .received = received,
                        .planned = fired,
                        .fired = fired,
                        .free_items = static_cast<std::uint16_t>(capacity - (received - fired)),
                        .path = 1,
                        .pulses = fired});
}

void FakeCell::answer(std::uint32_t sequence, Refusal refusal) {
    last_reply_ = link::CommandReply{.sequence = sequence, .refusal = static_cast<std::uint16_t>(refusal)};
    say(*last_reply_);
}

void FakeCell::take(const link::Hello& m) {
    ++hellos;
    const auto bytes = config_bytes(machine);
    link::HelloReply reply{.schema = schema, .minor = minor, .session = m.session, .boot = 7};
    reply.refusal = static_cast<std::uint16_t>(m.schema == schema ? Refusal::none : Refusal::schema_mismatch);
    receiver_.set_minor(minor);
    reply.config_bytes = static_cast<std::uint16_t>(bytes.size());
    reply.config_crc = crc32(bytes);
    reply.last_sequence = session_ == m.session && last_reply_ ? last_reply_->sequence : 0;
    session_ = m.session;
    say(reply);
}

void FakeCell::take(const link::PositionRequest& m) { say(link::Position{.token = m.token}); }

void FakeCell::take(const link::JobResume& m) {
    resumed = m;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::Heartbeat& m) {
    heartbeats.push_back(now_);
    if (clock_ahead && minor >= link::ClockReply::kSince) {
        const auto us = static_cast<std::uint64_t>((now_.time_since_epoch() + *clock_ahead).count() / 1000);
        say(link::ClockReply{m.host_time_us, us, us});
    }
}

void FakeCell::take(const link::TelemetryRequest& m) {
    telemetry = m;
    answer(m.sequence, refuse_telemetry);
}

void FakeCell::take(const link::StoreParameters& m) {
    parameters = m.bytes > 0 ? map : std::vector<std::uint8_t>{};
    ++generation;
    answer(m.sequence, m.bytes > 0 && m.crc != crc32(map) ? Refusal::parameters_bad : Refusal::none);
}

void FakeCell::take(const link::ParametersRequest& m) {
    link::Parameters told;
    told.fitted = 1;
    told.generation = parameters.empty() ? 0 : generation;
    told.layout = link::kConfigVersion;
    told.bytes = static_cast<std::uint16_t>(parameters.size());
    told.crc = parameters.empty() ? 0 : crc32(parameters);
    told.offset = m.offset;
    for (std::size_t i = m.offset; i < parameters.size() && told.count < told.kBytes; ++i) {
        told.data.at(told.count++) = parameters[i];
    }
    say(told);
}

void FakeCell::take(const link::BlackboxRequest& m) {
    link::BlackboxChunk chunk = black_box;
    chunk.part = m.part;
    chunk.first = m.first;
    const auto fill = [&](const auto& records) {
        using Record = typename std::decay_t<decltype(records)>::value_type;
        chunk.end = static_cast<std::uint32_t>(records.size());
        for (std::size_t i = m.first; i < records.size() && (chunk.count + 1U) * Record::kBytes <= chunk.kBytes; ++i) {
            std::array<std::uint8_t, Record::kBytes> bytes{};
            link::pack(records[i], bytes);
            std::copy(bytes.begin(), bytes.end(), chunk.records.begin() + chunk.count * std::ptrdiff_t{Record::kBytes});
            ++chunk.count;
        }
    };
    m.part == 0 ? fill(box_samples) : fill(box_events);
    say(chunk);
}

void FakeCell::take(const link::Command& m) {
    if (last_reply_ && last_reply_->sequence == m.sequence) {
        say(*last_reply_);
        return;
    }
    answer(m.sequence, carry_out(m));
    say_status();
}

Refusal FakeCell::carry_out(const link::Command& command) {
    const auto verb = static_cast<link::Verb>(command.verb);
    if (refuse.contains(verb)) {
        return refuse[verb];
    }
    ++done[verb];
    switch (verb) {
        case link::Verb::enable: state = State::idle; break;
        case link::Verb::disable: state = State::disabled; break;
        case link::Verb::home: homed = true; break;
        case link::Verb::arm: state = State::armed; break;
        case link::Verb::disarm: state = State::idle; break;
        case link::Verb::start: state = State::running; break;
        case link::Verb::preview:
            state = State::previewing;
            previewed_ = true;
            break;
        case link::Verb::hold: state = State::held; break;
        case link::Verb::resume: state = hellos > 0 ? State::running : state; break;
        case link::Verb::abort: state = state == State::previewing ? State::idle : State::armed; break;
        case link::Verb::reset_fault: state = State::disabled; break;
        case link::Verb::set_override: override_percent = command.arg0; break;
        case link::Verb::jog:
        case link::Verb::guide:
        case link::Verb::lasers_in_turn:
        case link::Verb::set_pulse_width:
        case link::Verb::stop: break;
    }
    return hellos > 0 ? Refusal::none : Refusal::not_connected;
}

void FakeCell::take(const link::JobOpen& m) {
    if (last_reply_ && last_reply_->sequence == m.sequence) {
        say(*last_reply_);
        return;
    }
    ++jobs_opened;
    job_ = m.job;
    job_items_ = m.items;
    taken.clear();
    fired = 0;
    job_done_ = false;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::Block& m) {
    if (m.job_low != static_cast<std::uint32_t>(job_)) {
        return;
    }
    if (stale_ack) {
        stale_ack->job_low = m.job_low;
        say(*stale_ack);
        stale_ack.reset();
    }
    if (blocks_lost > 0) {
        --blocks_lost;
        return;
    }
    block_sizes.push_back(m.count);
    BlockReader reader = link::read_block(m);
    Item item;
    std::uint32_t number = m.first;
    while (reader.next(item).value_or(false)) {
        const bool room = taken.size() - fired < capacity;
        if (number == taken.size() && room) {
            taken.push_back(item);
        } else if (number < taken.size()) {
            ++repeated;
        }
        ++number;
    }
    say_ack();
    if (m.first > taken.size() && minor > 0) {
        link::StreamMissing missing{.job_low = m.job_low, .heard = heard_, .count = 1};
        missing.from[0] = static_cast<std::uint32_t>(taken.size());
        missing.until[0] = m.first;
        say(missing);
    }
}

void FakeCell::take(const link::SetCompensation& m) {
    compensation = m;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::MapChunk& m) {
    if (last_reply_ && last_reply_->sequence == m.sequence) {
        say(*last_reply_);
        return;
    }
    map.resize(m.offset);
    map.insert(map.end(), m.data.data.begin(), m.data.data.begin() + m.data.size);
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::SetMap& m) {
    if (last_reply_ && last_reply_->sequence == m.sequence) {
        say(*last_reply_);
        return;
    }
    ++maps_set;
    set_map = m;
    answer(m.sequence, m.bytes == map.size() || m.bytes == 0 ? Refusal::none : Refusal::map_incomplete);
}

void FakeCell::take(const link::SetGalvoField& m) {
    galvo_field.insert(galvo_field.end(), m.numbers.begin(), m.numbers.begin() + m.count);
    galvo_field_ended = m.count == 0;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::SetPowerCurve& m) {
    power_curve = m;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::SetGalvoLag& m) {
    galvo_lag = m;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::SetSurface& m) {
    surface = m;
    answer(m.sequence, Refusal::none);
}

void FakeCell::take(const link::CheckSeating& m) {
    seating = m;
    last_reply_ = seating_answer;
    last_reply_->sequence = m.sequence;
    say(*last_reply_);
}

void FakeCell::take(const link::SensorsRequest& /*m*/) { say(sensors); }

void FakeCell::take(const link::ConfigRequest& m) {
    const auto bytes = config_bytes(machine);
    link::ConfigChunk chunk;
    chunk.offset = m.offset;
    const std::size_t left = bytes.size() - std::min<std::size_t>(m.offset, bytes.size());
    chunk.data.size = static_cast<std::uint8_t>(std::min(left, chunk.data.data.size()));
    std::copy_n(bytes.begin() + m.offset, chunk.data.size, chunk.data.data.begin());
    say(chunk);
}

std::vector<Item> example_items(std::uint32_t lines, std::uint32_t points) {
    std::vector<Item> items{Turn{9'000'000}};
    for (std::uint32_t line = 0; line < lines; ++line) {
        items.emplace_back(PathBegin{.path = line + 1, .speed_um_s = 20'000, .pitch_nm = 20'000, .energy_nj = 500'000});
        for (std::uint32_t i = 0; i < points; ++i) {
            const auto along = static_cast<std::int32_t>(i * 1000 + (i * i) % 37);
            items.emplace_back(PathPoint{-20'000'000 + along, -31'000'000, static_cast<std::int32_t>(line) * 5000});
        }
        items.emplace_back(PathEnd{});
    }
    items.emplace_back(JobEnd{});
    return items;
}

}  // namespace sc::host::test
