// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// Records of the traces that a board writes and the host's verification reads. All little-endian, fixed size, packed
/// without gaps; the files' layout (magic, text header, records) is in docs/formats.md. Pure: no I/O here.

namespace sc::trace {

inline constexpr std::array<char, 8> kPulseMagic{'S', 'C', 'P', 'U', 'L', 'S', '0', '1'};
inline constexpr std::array<char, 8> kSampleMagic{'S', 'C', 'S', 'A', 'M', 'P', '0', '1'};

/// One laser pulse as the world saw it: where the light met the surface. Knows nothing of the job.
struct PulseRecord {
    std::int64_t t_ns = 0;                   ///< control time
    std::array<std::int64_t, 3> place_pm{};  ///< on the surface, in h, at the moment of the pulse
    std::array<std::int64_t, 3> table_pm{};  ///< the same spot in the turntable's frame t (h at C = 0)
    std::int64_t defocus_pm = 0;             ///< focus minus surface along +y: positive = focus nearer to the head
    std::int64_t c_ndeg = 0;                 ///< true angle of C
    std::uint32_t energy_nj = 0;
    std::uint8_t hit = 0;  ///< 1: marked the surface; 2: met it, too weak there to mark it; 0: missed it (places are 0)
};
inline constexpr std::size_t kPulseRecordSize = 8 + 24 + 24 + 8 + 8 + 4 + 1;

/// One tick of emitted set-points, as the checker of motion reads them.
struct SampleRecord {
    std::int64_t tick = 0;
    std::array<std::int64_t, 4> set_point{};  ///< pm, pm, pm, ndeg
    std::array<std::int64_t, 4> actual{};     ///< encoders, same units
    std::uint8_t state = 0;
    std::uint8_t gate = 0;           ///< pulses leave in this tick's window
    std::uint16_t galvo_frames = 0;  ///< frames that follow this record: 0 (mirrors at zero throughout) or 100
};
inline constexpr std::size_t kSampleRecordSize = 8 + 32 + 32 + 1 + 1 + 2;
/// A galvo frame after a SampleRecord: x_pm, z_pm.
struct GalvoSample {
    std::int64_t x_pm = 0;
    std::int64_t z_pm = 0;
};
inline constexpr std::size_t kGalvoSampleSize = 16;

/// One pulse in the path domain; `command_trace_sha256` is SHA-256 over these records in order.
struct CommandRecord {
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    std::uint32_t number = 0;
    std::int64_t s_pm = 0;
    std::array<std::int64_t, 3> place_pm{};
    std::uint8_t energy_code = 0;
    std::int64_t t_ns = 0;
};
inline constexpr std::size_t kCommandRecordSize = 4 + 1 + 4 + 8 + 24 + 1 + 8;

void pack(const PulseRecord& record, std::span<std::uint8_t, kPulseRecordSize> out) noexcept;
[[nodiscard]] PulseRecord unpack_pulse(std::span<const std::uint8_t, kPulseRecordSize> bytes) noexcept;
void pack(const SampleRecord& record, std::span<std::uint8_t, kSampleRecordSize> out) noexcept;
[[nodiscard]] SampleRecord unpack_sample(std::span<const std::uint8_t, kSampleRecordSize> bytes) noexcept;
void pack(const GalvoSample& record, std::span<std::uint8_t, kGalvoSampleSize> out) noexcept;
[[nodiscard]] GalvoSample unpack_galvo(std::span<const std::uint8_t, kGalvoSampleSize> bytes) noexcept;
void pack(const CommandRecord& record, std::span<std::uint8_t, kCommandRecordSize> out) noexcept;

}  // namespace sc::trace
