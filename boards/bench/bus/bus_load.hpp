// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sc::bench {

/// A drive bus to be measured.
struct BusCase {
    std::string name;
    std::uint32_t axes = 4;
    std::uint32_t cycle_ticks = 1;  ///< of 1 ms
    std::uint8_t status_every = 1;
    bool paired = false;
    std::uint32_t buses = 1;  ///< axes are dealt out in turn
};
/// 3, 4 and 6 axes: 1 kHz, status with every 2nd SYNC, paired targets, 500 Hz, two buses.
[[nodiscard]] std::vector<BusCase> bus_cases();

/// Frames by kind, counted in a stretch of steady running.
struct FrameCounts {
    std::uint64_t sync = 0;
    std::uint64_t targets = 0;
    std::uint64_t status = 0;
    std::uint64_t heartbeats = 0;
    std::uint64_t other = 0;       ///< NMT, SDO, EMCY, controlwords by themselves: of the reserve
    std::uint64_t worst_bits = 0;  ///< of all but the others, each at its worst stuffing
    std::uint64_t wire_bits = 0;   ///< of the same, as they were
};

struct BusResult {
    BusCase of;
    double computed = 0.0;  ///< share of the fuller bus by shared/drives: cyclic frames and heartbeats
    double cyclic = 0.0;    ///< its cyclic part
    double total = 0.0;     ///< with the whole reserve: above 1.0 it is refused
    double counted = 0.0;   ///< the same frames as counted, each at its worst
    double wire = 0.0;      ///< as long as they really were
    double seconds = 0.0;
    bool carried = false;    ///< over the bit-timed bus; else the frames were only counted: they do not fit
    bool by_master = false;  ///< the drive master itself sent them; else single nodes of it, in a loop of this bench
    FrameCounts frames;      ///< of the fuller bus
    [[nodiscard]] double error_pct() const noexcept;
};

/// Boots, sets up and enables the drives, then counts for `seconds`. Throws std::runtime_error if they do not get
/// ready.
[[nodiscard]] BusResult measure_bus(const BusCase& which, bool by_master, double seconds);

/// How near frames can come to the computed worst case: the longest frame found for each number of data bytes.
struct StuffingResult {
    std::size_t bytes = 0;
    int bound = 0;  ///< as computed
    int found = 0;
};
[[nodiscard]] std::vector<StuffingResult> search_stuffing(std::uint32_t seed, int rounds);

}  // namespace sc::bench
