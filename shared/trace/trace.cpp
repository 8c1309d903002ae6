// SPDX-License-Identifier: Apache-2.0
#include "shared/trace/trace.hpp"

#include "shared/wire/bytes.hpp"

namespace sc::trace {
namespace {

template <class T, std::size_t N>
void put(ByteWriter& out, const std::array<T, N>& values) noexcept {
    for (const T value : values) {
        out.put(value);
    }
}
template <class T, std::size_t N>
void get(ByteReader& in, std::array<T, N>& values) noexcept {
    for (T& value : values) {
        value = in.get<T>();
    }
}

}  // namespace

void pack(const PulseRecord& record, std::span<std::uint8_t, kPulseRecordSize> out) noexcept {
    ByteWriter writer(out);
    writer.put(record.t_ns);
    put(writer, record.place_pm);
    put(writer, record.table_pm);
    writer.put(record.defocus_pm);
    writer.put(record.c_ndeg);
    writer.put(record.energy_nj);
    writer.put(record.hit);
}

PulseRecord unpack_pulse(std::span<const std::uint8_t, kPulseRecordSize> bytes) noexcept {
    ByteReader reader(bytes);
    PulseRecord record;
    record.t_ns = reader.get<std::int64_t>();
    get(reader, record.place_pm);
    get(reader, record.table_pm);
    record.defocus_pm = reader.get<std::int64_t>();
    record.c_ndeg = reader.get<std::int64_t>();
    record.energy_nj = reader.get<std::uint32_t>();
    record.hit = reader.get<std::uint8_t>();
    return record;
}

void pack(const SampleRecord& record, std::span<std::uint8_t, kSampleRecordSize> out) noexcept {
    ByteWriter writer(out);
    writer.put(record.tick);
    put(writer, record.set_point);
    put(writer, record.actual);
    writer.put(record.state);
    writer.put(record.gate);
    writer.put(record.galvo_frames);
}

SampleRecord unpack_sample(std::span<const std::uint8_t, kSampleRecordSize> bytes) noexcept {
    ByteReader reader(bytes);
    SampleRecord record;
    record.tick = reader.get<std::int64_t>();
    get(reader, record.set_point);
    get(reader, record.actual);
    record.state = reader.get<std::uint8_t>();
    record.gate = reader.get<std::uint8_t>();
    record.galvo_frames = reader.get<std::uint16_t>();
    return record;
}

void pack(const GalvoSample& record, std::span<std::uint8_t, kGalvoSampleSize> out) noexcept {
    ByteWriter writer(out);
    writer.put(record.x_pm);
    writer.put(record.z_pm);
}

GalvoSample unpack_galvo(std::span<const std::uint8_t, kGalvoSampleSize> bytes) noexcept {
    ByteReader reader(bytes);
    GalvoSample record;
    record.x_pm = reader.get<std::int64_t>();
    record.z_pm = reader.get<std::int64_t>();
    return record;
}

void pack(const CommandRecord& record, std::span<std::uint8_t, kCommandRecordSize> out) noexcept {
    ByteWriter writer(out);
    writer.put(record.path);
    writer.put(record.pass);
    writer.put(record.number);
    writer.put(record.s_pm);
    put(writer, record.place_pm);
    writer.put(record.energy_code);
    writer.put(record.t_ns);
}

}  // namespace sc::trace
