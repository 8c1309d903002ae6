// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/trace/trace.hpp"

/// A camera that measures crosses burnt on a plate: what a metrology laboratory would send back. It sees the marks, in
/// the order in which they were burnt, and knows nothing of commands or of the head.

namespace sc::sim {

/// Where a cross lies, metres, h: the plate stays where it was burnt.
struct SeenCross {
    Vec3 place;
};

/// Strokes are told apart by the pauses between them; two in a row make a cross, which is where their best lines meet.
/// Throws std::runtime_error for an odd number of strokes, a stroke of fewer than three marks, or two that are
/// parallel.
[[nodiscard]] std::vector<SeenCross> find_plate_crosses(std::span<const trace::PulseRecord> pulses);

/// The pulses of a trace file. Throws std::runtime_error.
[[nodiscard]] std::vector<trace::PulseRecord> read_pulses(const std::filesystem::path& file);

/// CSV as docs/formats.md has it (no,x,y,z,sigma; mm), x and z with normal noise of `sigma` metres.
[[nodiscard]] std::string measured_csv(std::span<const SeenCross> crosses, double sigma, std::uint64_t seed);

/// One mark of a line: strokes are told apart by the dark between them. Numbers of lines from 1, of marks from 0, a
/// pulse that left none counted too.
struct SeenMark {
    int line = 0;
    int mark = 0;
    Vec3 place;
};
[[nodiscard]] std::vector<SeenMark> find_plate_marks(std::span<const trace::PulseRecord> pulses);
/// Columns line,mark,x,y,z,sigma in millimetres, with normal noise of `sigma` metres in x and in z.
[[nodiscard]] std::string marks_csv(std::span<const SeenMark> marks, double sigma, std::uint64_t seed);

}  // namespace sc::sim
