// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/io_image.hpp"

#include "shared/wire/bytes.hpp"

namespace sc::recording {
namespace {

constexpr std::uint8_t kStillMirrors = 1;  ///< one galvo frame stands for all

std::uint8_t bits_of(const DigitalOutputs& d) noexcept {
    return static_cast<std::uint8_t>((d.master_oscillator ? 1U : 0U) | (d.guide_laser ? 2U : 0U) |
                                     (d.light_red ? 4U : 0U) | (d.light_yellow ? 8U : 0U) | (d.light_green ? 16U : 0U) |
                                     (d.shutter_open ? 32U : 0U));
}
DigitalOutputs digital_outputs(std::uint8_t bits) noexcept {
    return {(bits & 1U) != 0, (bits & 2U) != 0,  (bits & 4U) != 0,
            (bits & 8U) != 0, (bits & 16U) != 0, (bits & 32U) != 0};
}

void put(ByteWriter& out, const DriveFrame& frame) noexcept {
    out.put(frame.id);
    out.put(frame.size);
    out.put_bytes(frame.data);
}
DriveFrame get_drive_frame(ByteReader& in) noexcept {
    DriveFrame frame;
    frame.id = in.get<std::uint16_t>();
    frame.size = in.get<std::uint8_t>();
    const auto bytes = in.get_bytes(frame.data.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        frame.data[i] = bytes[i];
    }
    return frame;
}
void put(ByteWriter& out, std::span<const DriveFrame> frames) noexcept {
    out.put(static_cast<std::uint16_t>(frames.size()));
    for (const DriveFrame& frame : frames) {
        put(out, frame);
    }
}
std::size_t get_drive_frames(ByteReader& in, std::span<DriveFrame> out) noexcept {
    const std::size_t count = in.get<std::uint16_t>();
    if (count > out.size()) {
        in.fail();
        return 0;
    }
    for (std::size_t i = 0; i < count; ++i) {
        out[i] = get_drive_frame(in);
    }
    return count;
}
std::size_t get_link_bytes(ByteReader& in, std::span<std::uint8_t> out) noexcept {
    const std::size_t count = in.get<std::uint16_t>();
    if (count > out.size()) {
        in.fail();
        return 0;
    }
    const auto bytes = in.get_bytes(count);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        out[i] = bytes[i];
    }
    return bytes.size();
}

void put_source(ByteWriter& out, std::span<const std::uint8_t> bytes) noexcept {
    out.put(static_cast<std::uint8_t>(bytes.size()));
    out.put_bytes(bytes);
}
std::size_t get_source(ByteReader& in, std::span<std::uint8_t, kSourceBytesPerTick> out) noexcept {
    const std::size_t count = in.get<std::uint8_t>();
    if (count > out.size()) {
        in.fail();
        return 0;
    }
    const auto bytes = in.get_bytes(count);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        out[i] = bytes[i];
    }
    return bytes.size();
}

void put_sensors(ByteWriter& out, std::span<const SensorByte> bytes) noexcept {
    out.put(static_cast<std::uint8_t>(bytes.size()));
    for (const SensorByte& byte : bytes) {
        out.put(byte.data);
        out.put(byte.flags);
        out.put(byte.age_us);
    }
}
std::size_t get_sensors(ByteReader& in, std::span<SensorByte, kSensorBytesPerTick> out) noexcept {
    const std::size_t count = in.get<std::uint8_t>();
    if (count > out.size()) {
        in.fail();
        return 0;
    }
    for (SensorByte& byte : out.first(count)) {
        byte.data = in.get<std::uint8_t>();
        byte.flags = in.get<std::uint8_t>();
        byte.age_us = in.get<std::uint16_t>();
    }
    return count;
}
void put(ByteWriter& out, const SensorTransmission& sent) noexcept {
    out.put(sent.size);
    if (sent.size > 0) {
        out.put(sent.delay_ns);
        out.put_bytes(std::span(sent.bytes).first(sent.size));
    }
}
void get(ByteReader& in, SensorTransmission& sent) noexcept {
    sent.size = in.get<std::uint8_t>();
    if (sent.size > sent.bytes.size()) {
        in.fail();
        sent.size = 0;
    }
    if (sent.size > 0) {
        sent.delay_ns = in.get<std::uint32_t>();
        const auto bytes = in.get_bytes(sent.size);
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            sent.bytes[i] = bytes[i];
        }
    }
}

bool same(const GalvoFrame& a, const GalvoFrame& b) noexcept {
    return a.x_pm == b.x_pm && a.z_pm == b.z_pm && a.word_x == b.word_x && a.word_z == b.word_z;
}
void put(ByteWriter& out, const GalvoFrame& frame) noexcept {
    out.put(frame.x_pm);
    out.put(frame.z_pm);
    out.put(frame.word_x);
    out.put(frame.word_z);
}
GalvoFrame get_galvo_frame(ByteReader& in) noexcept {
    GalvoFrame frame;
    frame.x_pm = in.get<std::int64_t>();
    frame.z_pm = in.get<std::int64_t>();
    frame.word_x = in.get<std::uint32_t>();
    frame.word_z = in.get<std::uint32_t>();
    return frame;
}
void put_galvo(ByteWriter& out, std::span<const GalvoFrame, kGalvoFramesPerTick> frames) noexcept {
    bool still = true;
    for (const GalvoFrame& frame : frames) {
        still = still && same(frame, frames[0]);
    }
    out.put(still ? kStillMirrors : std::uint8_t{0});
    for (const GalvoFrame& frame : frames.first(still ? 1 : kGalvoFramesPerTick)) {
        put(out, frame);
    }
}
void get_galvo(ByteReader& in, std::span<GalvoFrame, kGalvoFramesPerTick> frames) noexcept {
    const auto flags = in.get<std::uint8_t>();
    if (flags > kStillMirrors) {
        in.fail();
    }
    frames[0] = get_galvo_frame(in);
    for (GalvoFrame& frame : frames.subspan<1>()) {
        frame = flags == kStillMirrors ? frames[0] : get_galvo_frame(in);
    }
}

void put(ByteWriter& out, const LaserRun& run) noexcept {
    out.put(run.t0_ns);
    out.put(run.period_ns256);
    out.put(run.change_ns256);
    out.put(run.count);
    out.put(run.pick);
    out.put(run.power);
    out.put(run.latch_ns);
}
LaserRun get_laser_run(ByteReader& in) noexcept {
    LaserRun run;
    run.t0_ns = in.get<std::int64_t>();
    run.period_ns256 = in.get<std::int64_t>();
    run.change_ns256 = in.get<std::int32_t>();
    run.count = in.get<std::uint16_t>();
    run.pick = in.get<std::uint8_t>();
    run.power = in.get<std::uint8_t>();
    run.latch_ns = in.get<std::uint16_t>();
    return run;
}
void put(ByteWriter& out, const PathPulse& pulse) noexcept {
    out.put(pulse.path);
    out.put(pulse.pass);
    out.put(pulse.energy_code);
    out.put(pulse.number);
    out.put(pulse.s_pm);
    for (const std::int64_t place : pulse.place_pm) {
        out.put(place);
    }
    out.put(pulse.t_ns);
}
PathPulse get_path_pulse(ByteReader& in) noexcept {
    PathPulse pulse;
    pulse.path = in.get<std::uint32_t>();
    pulse.pass = in.get<std::uint8_t>();
    pulse.energy_code = in.get<std::uint8_t>();
    pulse.number = in.get<std::uint32_t>();
    pulse.s_pm = in.get<std::int64_t>();
    for (std::int64_t& place : pulse.place_pm) {
        place = in.get<std::int64_t>();
    }
    pulse.t_ns = in.get<std::int64_t>();
    return pulse;
}

}  // namespace

void put(ByteWriter& out, const EncoderInputs& encoders) noexcept {
    out.put(encoders.valid ? std::uint8_t{1} : std::uint8_t{0});
    if (encoders.valid) {
        out.put(encoders.age_ns);
        for (const std::int64_t counts : encoders.counts) {
            out.put(counts);
        }
    }
}

EncoderInputs get_encoders(ByteReader& in) noexcept {
    EncoderInputs encoders;
    const auto flag = in.get<std::uint8_t>();
    if (flag > 1) {
        in.fail();
    }
    encoders.valid = flag == 1;
    if (encoders.valid) {
        encoders.age_ns = in.get<std::int32_t>();
        for (std::int64_t& counts : encoders.counts) {
            counts = in.get<std::int64_t>();
        }
    }
    return encoders;
}

std::size_t pack(const ServoInputs& inputs, std::span<std::uint8_t> out) noexcept {
    if (inputs.link_rx.size() > kLinkBytesPerTick || inputs.drive_rx.size() > kDriveFramesPerTick ||
        inputs.source_rx.size() > kSourceBytesPerTick || inputs.sensor_rx[0].size() > kSensorBytesPerTick ||
        inputs.sensor_rx[1].size() > kSensorBytesPerTick) {
        return 0;
    }
    ByteWriter writer(out);
    writer.put(inputs.tick);
    writer.put(bits_of(inputs.digital));
    writer.put(inputs.galvo_status);
    writer.put(inputs.guard_causes);
    writer.put(static_cast<std::uint16_t>(inputs.link_rx.size()));
    writer.put_bytes(inputs.link_rx);
    put(writer, inputs.drive_rx);
    put_source(writer, inputs.source_rx);
    put(writer, inputs.encoders);
    for (const auto& bus : inputs.sensor_rx) {
        put_sensors(writer, bus);
    }
    return writer.ok() ? writer.size() : 0;
}

bool unpack(std::span<const std::uint8_t> bytes, StoredInputs& stored) noexcept {
    ByteReader reader(bytes);
    stored.inputs.tick = reader.get<std::int64_t>();
    stored.inputs.digital = digital_inputs(reader.get<std::uint16_t>());
    stored.inputs.galvo_status = reader.get<std::uint16_t>();
    stored.inputs.guard_causes = reader.get<std::uint8_t>();
    stored.inputs.link_rx = std::span(stored.link_rx).first(get_link_bytes(reader, stored.link_rx));
    stored.inputs.drive_rx = std::span(stored.drive_rx).first(get_drive_frames(reader, stored.drive_rx));
    stored.inputs.source_rx = std::span(stored.source_rx).first(get_source(reader, stored.source_rx));
    stored.inputs.encoders = get_encoders(reader);
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        const std::size_t count = get_sensors(reader, stored.sensor_rx[bus]);
        stored.inputs.sensor_rx[bus] = std::span(stored.sensor_rx[bus]).first(count);
    }
    return reader.exhausted();
}

std::size_t pack(const ServoOutputs& outputs, std::span<std::uint8_t> out) noexcept {
    OutputPartEnds ends{};
    return pack(outputs, out, ends);
}

std::size_t pack(const ServoOutputs& outputs, std::span<std::uint8_t> out, OutputPartEnds& ends) noexcept {
    ByteWriter writer(out);
    const auto end_part = [&](OutputPart part) noexcept { ends[static_cast<std::size_t>(part)] = writer.size(); };
    writer.put(static_cast<std::uint16_t>(outputs.link_tx_size));
    writer.put_bytes(std::span(outputs.link_tx).first(outputs.link_tx_size));
    end_part(OutputPart::link);
    put(writer, std::span(outputs.drive_tx).first(outputs.drive_tx_size));
    end_part(OutputPart::drives);
    for (const std::int64_t set_point : outputs.set_point) {
        writer.put(set_point);
    }
    end_part(OutputPart::set_points);
    put_galvo(writer, outputs.galvo);
    end_part(OutputPart::mirrors);
    writer.put(static_cast<std::uint16_t>(outputs.laser_size));
    for (const LaserRun& run : std::span(outputs.laser).first(outputs.laser_size)) {
        put(writer, run);
    }
    end_part(OutputPart::laser);
    writer.put(static_cast<std::uint16_t>(outputs.pulses_size));
    for (const PathPulse& pulse : std::span(outputs.pulses).first(outputs.pulses_size)) {
        put(writer, pulse);
    }
    end_part(OutputPart::pulses);
    put_source(writer, std::span(outputs.source_tx).first(outputs.source_tx_size));
    for (const SensorTransmission& sent : outputs.sensor_tx) {
        put(writer, sent);
    }
    writer.put(bits_of(outputs.digital));
    writer.put(static_cast<std::uint8_t>((outputs.gate_allowed ? 1U : 0U) | (outputs.cancel_laser ? 2U : 0U) |
                                         (outputs.clear_power ? 4U : 0U)));
    writer.put(outputs.state);
    writer.put(outputs.faults);
    end_part(OutputPart::lines);
    return writer.ok() ? writer.size() : 0;
}

bool unpack(std::span<const std::uint8_t> bytes, ServoOutputs& outputs) noexcept {
    ByteReader reader(bytes);
    outputs.link_tx_size = get_link_bytes(reader, outputs.link_tx);
    outputs.drive_tx_size = get_drive_frames(reader, outputs.drive_tx);
    for (std::int64_t& set_point : outputs.set_point) {
        set_point = reader.get<std::int64_t>();
    }
    get_galvo(reader, outputs.galvo);
    outputs.laser_size = reader.get<std::uint16_t>();
    outputs.laser_size = outputs.laser_size <= outputs.laser.size() ? outputs.laser_size : 0;
    for (LaserRun& run : std::span(outputs.laser).first(outputs.laser_size)) {
        run = get_laser_run(reader);
    }
    outputs.pulses_size = reader.get<std::uint16_t>();
    outputs.pulses_size = outputs.pulses_size <= outputs.pulses.size() ? outputs.pulses_size : 0;
    for (PathPulse& pulse : std::span(outputs.pulses).first(outputs.pulses_size)) {
        pulse = get_path_pulse(reader);
    }
    outputs.source_tx_size = get_source(reader, outputs.source_tx);
    for (SensorTransmission& sent : outputs.sensor_tx) {
        get(reader, sent);
    }
    outputs.digital = digital_outputs(reader.get<std::uint8_t>());
    const auto flags = reader.get<std::uint8_t>();
    outputs.gate_allowed = (flags & 1U) != 0;
    outputs.cancel_laser = (flags & 2U) != 0;
    outputs.clear_power = (flags & 4U) != 0;
    outputs.state = reader.get<std::uint8_t>();
    outputs.faults = reader.get<std::uint64_t>();
    return reader.exhausted();
}

void clear(ServoOutputs& outputs) noexcept {
    outputs.link_tx_size = outputs.drive_tx_size = outputs.laser_size = outputs.pulses_size = 0;
    outputs.source_tx_size = 0;
    for (SensorTransmission& sent : outputs.sensor_tx) {
        sent.size = 0;
    }
    outputs.gate_allowed = outputs.cancel_laser = outputs.clear_power = false;
}

}  // namespace sc::recording
