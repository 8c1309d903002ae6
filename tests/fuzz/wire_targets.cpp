// SPDX-License-Identifier: Apache-2.0
// Decoders of what comes over wires. Messages are given to the link with a right checksum, or mutations would never
// pass it.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "firmware/drives/drive_node.hpp"
#include "firmware/laser/mopa_serial.hpp"
#include "firmware/link/endpoint.hpp"
#include "firmware/recording/log_reader.hpp"
#include "firmware/sensors/sensor_hub.hpp"
#include "host/bridge/black_box.hpp"
#include "host/bridge/telemetry_values.hpp"
#include "host/bridge/wire.hpp"
#include "host/pendant/control.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/can_framing.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/config.hpp"
#include "shared/link/map_codec.hpp"
#include "shared/link/serial.hpp"
#include "shared/trace/trace.hpp"
#include "tests/fuzz/targets.hpp"

namespace sc::fuzz {
namespace {

/// id, length, payload of one message as a frame whose checksum is right.
std::vector<std::uint8_t> frame_of(Feed& feed, std::uint16_t counter) {
    std::vector<std::uint8_t> message{feed.byte()};
    const Bytes payload = feed.take(std::min<std::size_t>(feed.byte(), link::kPayloadCapacity));
    message.push_back(static_cast<std::uint8_t>(counter & 0xFFU));
    message.push_back(static_cast<std::uint8_t>(counter >> 8U));
    message.insert(message.end(), payload.begin(), payload.end());
    const std::uint32_t crc = link::codec_detail::message_crc(message, link::kProtocolMinor);
    for (unsigned shift = 0; shift < 32; shift += 8) {
        message.push_back(static_cast<std::uint8_t>((crc >> shift) & 0xFFU));
    }
    std::vector<std::uint8_t> frame(link::kSerialCapacity);
    frame.resize(link::cobs_encode(message, frame));
    return frame;
}

void answer(link::Endpoint& endpoint) {
    link::LinkEvent event;
    while (endpoint.poll(event)) {
        if (event.kind == link::LinkEvent::Kind::job_open) {
            endpoint.open_job(event.job_open.job, event.job_open.items);
            endpoint.reply(event.job_open.sequence, Refusal::none, 0);
        } else if (event.kind == link::LinkEvent::Kind::job_resume) {
            endpoint.resume_job(event.job_resume);
            endpoint.reply(event.job_resume.sequence, Refusal::none, 0);
        } else if (event.kind == link::LinkEvent::Kind::command) {
            endpoint.reply(event.command.sequence, Refusal::none, 0);
        }
    }
}

/// A session with the controller's end: messages in any order, items popped, answers sent.
void endpoint(Bytes input) {
    static const MachineConfig machine = reference_machine();
    const auto end = std::make_unique<link::Endpoint>(machine, 1);
    std::vector<std::uint8_t> hello(link::kSerialCapacity);
    link::Hello first;
    first.schema = link::kSchemaHash;
    first.major = link::kProtocolMajor;
    first.minor = link::kProtocolMinor;
    first.session = 1;
    first.heartbeat_timeout_ms = 100;
    hello.resize(link::encode_serial(first, 0, hello));
    end->receive(0, hello);
    Feed feed(input);
    std::array<std::uint8_t, 512> out{};
    for (std::uint16_t tick = 1; !feed.empty() && tick < 200; ++tick) {
        end->receive(tick, frame_of(feed, tick));
        answer(*end);
        end->items().clear();
        static_cast<void>(end->transmit(out));
        if (end->telemetry_due() != 0) {
            static_cast<void>(end->transmit(out, link::TelemetryValues{}));
        }
    }
}

/// Any bytes on the serial line, in portions, to the same.
void serial(Bytes input) {
    static const MachineConfig machine = reference_machine();
    const auto end = std::make_unique<link::Endpoint>(machine, 1);
    Feed feed(input);
    for (std::int64_t tick = 1; !feed.empty(); ++tick) {
        end->receive(tick, feed.take(feed.byte() % 64U + 1U));
        answer(*end);
    }
}

/// Bytes that a controller is said to have sent.
class Said final : public host::Transport {
public:
    explicit Said(Bytes bytes) noexcept : bytes_(bytes) {}
    void send(std::span<const std::uint8_t> /*bytes*/) override {}
    std::size_t receive(std::span<std::uint8_t> out, HostTime /*until*/) override {
        const std::size_t size = std::min(out.size(), bytes_.size());
        std::copy_n(bytes_.begin(), size, out.begin());
        bytes_ = bytes_.subspan(size);
        return size;
    }
    [[nodiscard]] HostTime now() const override { return {}; }
    [[nodiscard]] bool closed() const override { return bytes_.empty(); }

private:
    Bytes bytes_;
};

void host_wire(Bytes input) {
    Feed feed(input);
    std::vector<std::uint8_t> bytes;
    for (std::uint16_t counter = 1; !feed.empty(); ++counter) {
        const auto frame = frame_of(feed, counter);
        bytes.insert(bytes.end(), frame.begin(), frame.end());
    }
    Said said(bytes);
    host::Wire wire(said);
    while (!said.closed()) {
        static_cast<void>(wire.receive({}, [](const host::CellMessage& message) {
            host::BlackBoxContent content;
            if (const auto* chunk = std::get_if<link::BlackboxChunk>(&message)) {
                static_cast<void>(host::take_chunk(*chunk, content));
            } else if (const auto* sample = std::get_if<link::Telemetry>(&message)) {
                static_cast<void>(host::decode(*sample));
            }
        }));
    }
}

void can(Bytes input) {
    Feed feed(input);
    link::CanReassembler reassembler;
    while (!feed.empty()) {
        link::LinkCanFrame frame;
        const std::uint8_t head = feed.byte();
        frame.fd = (head & 0x80U) != 0;
        const Bytes data = feed.take(std::min<std::size_t>(head & 0x7FU, frame.fd ? 64U : 8U));
        frame.size = link::legal_can_size(data.size());
        std::copy(data.begin(), data.end(), frame.data.begin());
        if (const auto message = reassembler.push(frame)) {
            static_cast<void>(link::open_message(*message));
        }
    }
}

void block(Bytes input) {
    Feed feed(input);
    const std::uint8_t count = feed.byte();
    BlockReader reader(feed.take(link::kPayloadCapacity), count);
    Item item;
    for (auto found = reader.next(item); found && *found; found = reader.next(item)) {
    }
}

void machine_config(Bytes input) { static_cast<void>(link::deserialise(input)); }

void axis_map(Bytes input) {
    const auto map = std::make_unique<AxisMap>();
    static_cast<void>(link::deserialise_map(input, *map));
}

void recording(Bytes input) {
    recording::LogReader reader(input);
    recording::LoggedTick tick;
    while (reader.next(tick)) {
    }
}

void trace(Bytes input) {
    if (input.size() >= trace::kPulseRecordSize) {
        static_cast<void>(trace::unpack_pulse(input.first<trace::kPulseRecordSize>()));
    }
    if (input.size() >= trace::kSampleRecordSize) {
        static_cast<void>(trace::unpack_sample(input.first<trace::kSampleRecordSize>()));
    }
    if (input.size() >= trace::kGalvoSampleSize) {
        static_cast<void>(trace::unpack_galvo(input.first<trace::kGalvoSampleSize>()));
    }
}

/// All sensors of the reference cell and what comes back on their buses.
void sensors(Bytes input) {
    static const MachineConfig machine = reference_machine();
    const auto hub = std::make_unique<sensors::SensorHub>(machine.sensors, machine.control_period_ns);
    const auto in = std::make_unique<ServoInputs>();
    const auto out = std::make_unique<ServoOutputs>();
    Feed feed(input);
    constexpr std::size_t kMost = 16;  // bytes in a tick
    for (std::int64_t tick = 0; !feed.empty() && tick < 2000; ++tick) {
        in->tick = tick;
        std::array<std::array<SensorByte, kMost>, std::tuple_size_v<decltype(in->sensor_rx)>> heard{};
        for (std::size_t bus = 0; bus < heard.size(); ++bus) {
            const Bytes bytes = feed.take(feed.byte() % kMost);
            for (std::size_t i = 0; i < bytes.size(); ++i) {
                heard[bus][i] = {bytes[i], 0, 0};
            }
            in->sensor_rx[bus] = std::span(heard[bus]).first(bytes.size());
        }
        hub->step(*in, *out);
    }
}

void drive(Bytes input) {
    static const MachineConfig machine = reference_machine();
    drives::DriveNode node(machine, 0);
    Feed feed(input);
    for (std::int64_t tick = 0; !feed.empty(); ++tick) {
        constexpr std::array<std::uint16_t, 6> kIds{0x580, 0x180, 0x280, 0x700, 0x080, 0x380};
        DriveFrame frame;
        const std::uint8_t head = feed.byte();
        frame.id = static_cast<std::uint16_t>(kIds[head % kIds.size()] + node.address());
        const Bytes data = feed.take((head >> 4U) % 9U);
        frame.size = static_cast<std::uint8_t>(data.size());
        std::copy(data.begin(), data.end(), frame.data.begin());
        node.receive(frame, tick);
        node.update({.power = true}, tick, tick % 2 == 0);
        static_cast<void>(node.nmt_frame(tick / 2));
        static_cast<void>(node.sdo_frame(tick));
        static_cast<void>(node.rpdo_frame());
        static_cast<void>(node.measured(frame));
        static_cast<void>(node.tells_fault(frame));
        static_cast<void>(node.take_fresh());
    }
}

void mopa(Bytes input) {
    Feed feed(input);
    laser::MopaSerial port((feed.byte() & 1U) != 0 ? LaserSource::raycus : LaserSource::jpt, 1'000'000);
    std::array<std::uint8_t, kSourceBytesPerTick> out{};
    while (!feed.empty()) {
        if (!port.busy()) {
            port.begin(200);
        }
        static_cast<void>(port.transmit(out));
        static_cast<void>(port.step(feed.take(feed.byte() % 9U)));
    }
}

/// Reports, plugs and unplugs, while a cell moves or not. No report may ask for more than its bound.
void pendant(Bytes input) {
    Feed feed(input);
    host::pendant::PendantControl control;
    HostTime now{};
    while (!feed.empty()) {
        const std::uint8_t how = feed.byte();
        const host::pendant::CellView cell{.moving = (how & 1U) != 0, .override_percent = 100};
        now += Nanoseconds(std::int64_t{how} * 4'000'000);
        std::vector<host::pendant::Wish> wishes;
        if ((how & 0x0EU) == 0x02U) {
            control.plugged();
        } else if ((how & 0x0EU) == 0x04U) {
            wishes = control.unplugged(cell);
        } else {
            wishes = control.take(feed.take((how & 0x0EU) == 0x06U ? how >> 4U : 8U), now, Nanoseconds(0), cell);
        }
        for (const host::pendant::Wish& wish : wishes) {
            const double most =
                wish.axis == Axis::c ? host::pendant::PendantControl::kMostTurn : host::pendant::PendantControl::kMost;
            if (wish.kind == host::pendant::WishKind::jog &&
                (cell.moving || !control.connected() ||
                 !(wish.distance <= most + 1e-9 && wish.distance >= -most - 1e-9))) {
                std::abort();
            }
        }
        static_cast<void>(control.pass(now, cell));
    }
}

constexpr std::array<Target, 13> kTargets{{{"endpoint", endpoint},
                                           {"serial", serial},
                                           {"host_wire", host_wire},
                                           {"can", can},
                                           {"block", block},
                                           {"machine_config", machine_config},
                                           {"axis_map", axis_map},
                                           {"recording", recording},
                                           {"trace", trace},
                                           {"sensors", sensors},
                                           {"drive", drive},
                                           {"mopa", mopa},
                                           {"pendant", pendant}}};

}  // namespace

std::span<const Target> wire_targets() noexcept { return kTargets; }

}  // namespace sc::fuzz
