// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/tick_codec.hpp"

#include <span>

namespace sc::recording {
namespace {

// Flags, the first byte of a tick. The two lowest bits say how the drive frames are given.
constexpr std::uint8_t kNoFrames = 0;
constexpr std::uint8_t kSameList = 1;   ///< ids and sizes of the last tick that had frames, in that order
constexpr std::uint8_t kNewList = 2;    ///< ids are listed
constexpr std::uint8_t kRawFrames = 3;  ///< more ids than there are slots
constexpr std::uint8_t kFramesMask = 3;
constexpr std::uint8_t kLink = 4;
constexpr std::uint8_t kLines = 8;
constexpr std::uint8_t kTickJump = 16;
constexpr std::uint8_t kState = 32;
constexpr std::uint8_t kSource = 64;
constexpr std::uint8_t kMore = 0x80;  ///< a second byte of flags follows

constexpr std::uint8_t kMoreEncoders = 1;
constexpr std::uint8_t kMoreSensors = 2;

constexpr std::uint8_t kSizeFollows = 0x80;

/// Wraps where a foreign log would overflow.
std::int64_t after(std::int64_t tick) noexcept {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(tick) + 1U);
}

void put_varint(ByteWriter& out, std::size_t value) noexcept {
    while (value >= 0x80U) {
        out.put(static_cast<std::uint8_t>(value | 0x80U));
        value >>= 7U;
    }
    out.put(static_cast<std::uint8_t>(value));
}
std::size_t get_varint(ByteReader& in) noexcept {
    std::size_t value = 0;
    for (unsigned shift = 0; shift < 21; shift += 7) {
        const auto byte = in.get<std::uint8_t>();
        value |= static_cast<std::size_t>(byte & 0x7FU) << shift;
        if ((byte & 0x80U) == 0) {
            return value;
        }
    }
    in.fail();
    return 0;
}

std::size_t slot_of(const TickMemory& memory, std::uint16_t id) noexcept {
    std::size_t slot = 0;
    while (slot < memory.frame_count && memory.frames[slot].id != id) {
        ++slot;
    }
    return slot;
}

bool same_list(const TickMemory& memory, std::span<const DriveFrame> frames) noexcept {
    if (frames.size() != memory.list_size) {
        return false;
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const DriveFrame& last = memory.frames[memory.list[i]];
        if (last.id != frames[i].id || last.size != frames[i].size) {
            return false;
        }
    }
    return true;
}

/// Whether the slots suffice for all ids of these frames.
bool have_slots(const TickMemory& memory, std::span<const DriveFrame> frames) noexcept {
    std::size_t fresh = 0;
    for (const DriveFrame& frame : frames) {
        fresh += slot_of(memory, frame.id) == memory.frame_count ? 1U : 0U;
    }
    return fresh <= TickMemory::kSlots - memory.frame_count;
}

void put_list(TickMemory& memory, std::span<const DriveFrame> frames, ByteWriter& out) noexcept {
    out.put(static_cast<std::uint8_t>(frames.size()));
    memory.list_size = frames.size();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const DriveFrame& frame = frames[i];
        const std::size_t slot = slot_of(memory, frame.id);
        const auto number = static_cast<std::uint8_t>(slot);
        memory.list[i] = number;
        if (slot == memory.frame_count) {
            memory.frames[slot] = {frame.id, frame.size, {}};
            ++memory.frame_count;
            out.put(number);
            out.put(frame.id);
            out.put(frame.size);
        } else if (memory.frames[slot].size != frame.size) {
            memory.frames[slot].size = frame.size;
            out.put(static_cast<std::uint8_t>(number | kSizeFollows));
            out.put(frame.size);
        } else {
            out.put(number);
        }
    }
}

void get_list(TickMemory& memory, ByteReader& in) noexcept {
    memory.list_size = in.get<std::uint8_t>();
    if (memory.list_size > memory.list.size()) {
        in.fail();
        memory.list_size = 0;
    }
    for (std::uint8_t& entry : std::span(memory.list).first(memory.list_size)) {
        const auto number = in.get<std::uint8_t>();
        const std::size_t slot = number & ~std::size_t{kSizeFollows};
        const bool fresh = slot == memory.frame_count;
        if (slot > memory.frame_count || slot >= TickMemory::kSlots || (fresh && number != slot)) {
            in.fail();
            memory.list_size = 0;
            return;
        }
        entry = static_cast<std::uint8_t>(slot);
        DriveFrame& last = memory.frames[slot];
        if (fresh) {
            last = {in.get<std::uint16_t>(), 0, {}};
            ++memory.frame_count;
        }
        if (fresh || number != slot) {
            last.size = in.get<std::uint8_t>();
        }
    }
}

/// A bit for each frame of the list whose data have changed; for each of them a bit for each byte, and the bytes. Sizes
/// are the list's: two frames of one id and other sizes in one tick go as raw frames.
void put_data(TickMemory& memory, std::span<const DriveFrame> frames, ByteWriter& out) noexcept {
    std::array<std::uint8_t, kDriveFramesPerTick * (1 + 8)> scratch{};
    ByteWriter changes(scratch);
    std::array<std::uint8_t, kDriveFramesPerTick / 8> changed{};
    for (std::size_t i = 0; i < frames.size(); ++i) {
        DriveFrame& last = memory.frames[memory.list[i]];
        unsigned mask = 0;
        for (std::size_t k = 0; k < last.data.size(); ++k) {
            mask |= last.data[k] != frames[i].data[k] ? 1U << k : 0U;
        }
        if (mask == 0) {
            continue;
        }
        changed[i / 8] = static_cast<std::uint8_t>(changed[i / 8] | (1U << (i % 8)));
        changes.put(static_cast<std::uint8_t>(mask));
        for (std::size_t k = 0; k < last.data.size(); ++k) {
            if ((mask >> k & 1U) != 0) {
                changes.put(frames[i].data[k]);
            }
        }
        last.data = frames[i].data;
    }
    out.put_bytes(std::span(changed).first((frames.size() + 7) / 8));
    out.put_bytes(changes.written());
}

void get_data(TickMemory& memory, ByteReader& in, std::span<DriveFrame> frames) noexcept {
    const auto changed = in.get_bytes((frames.size() + 7) / 8);
    if (!in.ok()) {
        return;
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
        DriveFrame& last = memory.frames[memory.list[i]];
        if ((changed[i / 8] >> (i % 8) & 1U) != 0) {
            const auto mask = in.get<std::uint8_t>();
            for (std::size_t k = 0; k < last.data.size(); ++k) {
                if ((mask >> k & 1U) != 0) {
                    last.data[k] = in.get<std::uint8_t>();
                }
            }
        }
        frames[i] = last;
    }
}

constexpr std::uint8_t kLargeStep = 0xFF;    ///< a step of two bytes follows
constexpr std::uint8_t kFlagsFollow = 0x80;  ///< in the count: a byte of flags with each

/// Ages fall from byte to byte, mostly by the same step.
void put_sensors(std::span<const SensorByte> bytes, ByteWriter& out) noexcept {
    bool flags = false;
    for (const SensorByte& byte : bytes) {
        flags = flags || byte.flags != 0;
    }
    out.put(static_cast<std::uint8_t>(bytes.size() | (flags ? kFlagsFollow : 0U)));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        out.put(bytes[i].data);
        if (flags) {
            out.put(bytes[i].flags);
        }
        const auto step = static_cast<std::uint16_t>(i == 0 ? bytes[i].age_us : bytes[i - 1].age_us - bytes[i].age_us);
        if (i == 0) {
            out.put(step);
        } else if (step < kLargeStep) {
            out.put(static_cast<std::uint8_t>(step));
        } else {
            out.put(kLargeStep);
            out.put(step);
        }
    }
}
std::size_t get_sensors(std::span<SensorByte> bytes, ByteReader& in) noexcept {
    const auto head = in.get<std::uint8_t>();
    const std::size_t count = head & ~std::size_t{kFlagsFollow};
    if (count > bytes.size()) {
        in.fail();
        return 0;
    }
    std::uint16_t age = 0;
    for (std::size_t i = 0; i < count; ++i) {
        bytes[i].data = in.get<std::uint8_t>();
        bytes[i].flags = (head & kFlagsFollow) != 0 ? in.get<std::uint8_t>() : std::uint8_t{0};
        if (i == 0) {
            age = in.get<std::uint16_t>();
        } else {
            const auto small = in.get<std::uint8_t>();
            age = static_cast<std::uint16_t>(age - (small == kLargeStep ? in.get<std::uint16_t>() : small));
        }
        bytes[i].age_us = age;
    }
    return count;
}

bool one_size_an_id(std::span<const DriveFrame> frames) noexcept {
    for (std::size_t i = 0; i < frames.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            if (frames[i].id == frames[k].id && frames[i].size != frames[k].size) {
                return false;
            }
        }
    }
    return true;
}

std::uint8_t frames_flag(const TickMemory& memory, std::span<const DriveFrame> frames) noexcept {
    if (frames.empty()) {
        return kNoFrames;
    }
    if (same_list(memory, frames)) {
        return kSameList;
    }
    return have_slots(memory, frames) && one_size_an_id(frames) ? kNewList : kRawFrames;
}

void put_frames(std::uint8_t flag, TickMemory& memory, std::span<const DriveFrame> frames, ByteWriter& out) noexcept {
    if (flag == kRawFrames) {
        out.put(static_cast<std::uint8_t>(frames.size()));
        for (const DriveFrame& frame : frames) {
            out.put(frame.id);
            out.put(frame.size);
            out.put_bytes(frame.data);
        }
        return;
    }
    if (flag == kNewList) {
        put_list(memory, frames, out);
    }
    if (flag != kNoFrames) {
        put_data(memory, frames, out);
    }
}

std::size_t get_frames(std::uint8_t flag, TickMemory& memory, std::span<DriveFrame> frames, ByteReader& in) noexcept {
    if (flag == kRawFrames) {
        const std::size_t count = in.get<std::uint8_t>();
        if (count > frames.size()) {
            in.fail();
            return 0;
        }
        for (DriveFrame& frame : frames.first(count)) {
            frame.id = in.get<std::uint16_t>();
            frame.size = in.get<std::uint8_t>();
            for (std::uint8_t& byte : frame.data) {
                byte = in.get<std::uint8_t>();
            }
        }
        return count;
    }
    if (flag == kNoFrames) {
        return 0;
    }
    if (flag == kNewList) {
        get_list(memory, in);
    }
    get_data(memory, in, frames.first(memory.list_size));
    return memory.list_size;
}

constexpr auto kDrives = static_cast<std::size_t>(OutputPart::drives);

/// Keeps this tick's digest, and what the next tick's checks are expected to be.
void remember(TickMemory& memory, const OutputsDigest& now) noexcept {
    memory.expected = now.check;
    memory.expected[kDrives] = memory.digest.check[kDrives];
    memory.digest = now;
}

void put_checks(const TickMemory& memory, const OutputsDigest& now, ByteWriter& out) noexcept {
    out.put(now.crc);
    unsigned mask = 0;
    for (std::size_t part = 0; part < kOutputParts; ++part) {
        mask |= memory.expected[part] != now.check[part] ? 1U << part : 0U;
    }
    out.put(static_cast<std::uint8_t>(mask));
    for (std::size_t part = 0; part < kOutputParts; ++part) {
        if ((mask >> part & 1U) != 0) {
            out.put(now.check[part]);
        }
    }
}
void get_checks(const TickMemory& memory, OutputsDigest& digest, ByteReader& in) noexcept {
    digest.check = memory.expected;
    digest.crc = in.get<std::uint32_t>();
    const auto mask = in.get<std::uint8_t>();
    if ((mask >> kOutputParts) != 0) {
        in.fail();
    }
    for (std::size_t part = 0; part < kOutputParts; ++part) {
        if ((mask >> part & 1U) != 0) {
            digest.check[part] = in.get<std::uint8_t>();
        }
    }
}

}  // namespace

bool encode(const ServoInputs& inputs, const OutputsDigest& digest, TickMemory& memory, ByteWriter& out) noexcept {
    if (inputs.link_rx.size() > kLinkBytesPerTick || inputs.drive_rx.size() > kDriveFramesPerTick ||
        inputs.source_rx.size() > kSourceBytesPerTick || inputs.sensor_rx[0].size() > kSensorBytesPerTick ||
        inputs.sensor_rx[1].size() > kSensorBytesPerTick) {
        return false;
    }
    const bool sensors = !inputs.sensor_rx[0].empty() || !inputs.sensor_rx[1].empty();
    const std::uint8_t frames = frames_flag(memory, inputs.drive_rx);
    const bool lines = inputs.digital != memory.digital || inputs.galvo_status != memory.galvo_status ||
                       inputs.guard_causes != memory.guard_causes;
    const bool jump = inputs.tick != memory.tick;
    const bool state = digest.state != memory.digest.state || digest.faults != memory.digest.faults;
    const auto more =
        static_cast<std::uint8_t>((inputs.encoders.valid ? kMoreEncoders : 0U) | (sensors ? kMoreSensors : 0U));
    out.put(static_cast<std::uint8_t>(frames | (inputs.link_rx.empty() ? 0U : kLink) | (lines ? kLines : 0U) |
                                      (jump ? kTickJump : 0U) | (state ? kState : 0U) |
                                      (inputs.source_rx.empty() ? 0U : kSource) | (more != 0 ? kMore : 0U)));
    if (more != 0) {
        out.put(more);
    }
    if (jump) {
        out.put(inputs.tick);
    }
    if (lines) {
        out.put(bits_of(inputs.digital));
        out.put(inputs.galvo_status);
        out.put(inputs.guard_causes);
    }
    if (!inputs.link_rx.empty()) {
        put_varint(out, inputs.link_rx.size());
        out.put_bytes(inputs.link_rx);
    }
    if (!inputs.source_rx.empty()) {
        out.put(static_cast<std::uint8_t>(inputs.source_rx.size()));
        out.put_bytes(inputs.source_rx);
    }
    if (inputs.encoders.valid) {
        put(out, inputs.encoders);
    }
    if (sensors) {
        for (const auto& bus : inputs.sensor_rx) {
            put_sensors(bus, out);
        }
    }
    put_frames(frames, memory, inputs.drive_rx, out);
    if (state) {
        out.put(digest.state);
        out.put(digest.faults);
    }
    put_checks(memory, digest, out);
    memory.tick = after(inputs.tick);
    memory.digital = inputs.digital;
    memory.galvo_status = inputs.galvo_status;
    memory.guard_causes = inputs.guard_causes;
    remember(memory, digest);
    return out.ok();
}

bool decode(ByteReader& in, TickMemory& memory, StoredInputs& stored, OutputsDigest& digest) noexcept {
    const auto flags = in.get<std::uint8_t>();
    const std::uint8_t more = (flags & kMore) != 0 ? in.get<std::uint8_t>() : std::uint8_t{0};
    if ((more & ~unsigned{kMoreEncoders | kMoreSensors}) != 0) {
        in.fail();
    }
    if ((flags & kTickJump) != 0) {
        memory.tick = in.get<std::int64_t>();
    }
    if ((flags & kLines) != 0) {
        memory.digital = digital_inputs(in.get<std::uint16_t>());
        memory.galvo_status = in.get<std::uint16_t>();
        memory.guard_causes = in.get<std::uint8_t>();
    }
    std::size_t link_size = 0;
    if ((flags & kLink) != 0) {
        const auto bytes = in.get_bytes(get_varint(in));
        if (bytes.size() > stored.link_rx.size()) {
            in.fail();
            return false;
        }
        for (const std::uint8_t byte : bytes) {
            stored.link_rx[link_size++] = byte;
        }
    }
    std::size_t source_size = 0;
    if ((flags & kSource) != 0) {
        const auto bytes = in.get_bytes(in.get<std::uint8_t>());
        if (bytes.empty() || bytes.size() > stored.source_rx.size()) {
            in.fail();
            return false;
        }
        for (const std::uint8_t byte : bytes) {
            stored.source_rx[source_size++] = byte;
        }
    }
    const EncoderInputs encoders = (more & kMoreEncoders) != 0 ? get_encoders(in) : EncoderInputs{};
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        const std::size_t count = (more & kMoreSensors) != 0 ? get_sensors(stored.sensor_rx[bus], in) : 0;
        stored.inputs.sensor_rx[bus] = std::span(stored.sensor_rx[bus]).first(count);
    }
    const auto frames = static_cast<std::uint8_t>(flags & kFramesMask);
    const std::size_t frame_count = get_frames(frames, memory, stored.drive_rx, in);
    digest = memory.digest;
    if ((flags & kState) != 0) {
        digest.state = in.get<std::uint8_t>();
        digest.faults = in.get<std::uint64_t>();
    }
    get_checks(memory, digest, in);
    if (!in.ok()) {
        return false;
    }
    stored.inputs.tick = memory.tick;
    stored.inputs.digital = memory.digital;
    stored.inputs.galvo_status = memory.galvo_status;
    stored.inputs.guard_causes = memory.guard_causes;
    stored.inputs.link_rx = std::span(stored.link_rx).first(link_size);
    stored.inputs.drive_rx = std::span(stored.drive_rx).first(frame_count);
    stored.inputs.source_rx = std::span(stored.source_rx).first(source_size);
    stored.inputs.encoders = encoders;
    remember(memory, digest);
    memory.tick = after(memory.tick);
    return true;
}

}  // namespace sc::recording
