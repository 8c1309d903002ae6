// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

/// Emitted set-points from a file, for the checker of motion and its plots. Layouts: docs/formats.md.

namespace sc::host {

struct MotionTrace {
    std::filesystem::path file;
    std::vector<AxisPositions> samples;  ///< one a tick, no tick missing
    std::vector<std::uint8_t> led;       ///< 1: by the controller's set-points, so that differences count
    std::int64_t first_tick = 0;
    double period = 1e-3;                  ///< seconds
    std::optional<MachineConfig> machine;  ///< a cell's sample trace: what its header says (machine_of_trace)
    bool has_c = false;
};

/// Reads either kind: a cell's sample trace by its magic, else a CSV: `t_s,x_m,y_m,z_m[,c_deg]` at 1 kHz, or
/// `tick,x_pm,y_pm,z_pm[,c_ndeg]` in whole numbers. Throws InputError with file, line and value for what is neither,
/// for a CSV of less than two samples, for ticks that do not follow one another (a cell's trace too: file and tick),
/// for samples beyond 1000 m or a million degrees, and for whatever the CSV and trace readers refuse. Memory: 33 bytes
/// a tick, while reading a CSV some ten times as much.
[[nodiscard]] MotionTrace read_motion_trace(const std::filesystem::path& path);
/// True if the file begins as a cell's sample trace does; false also if there is none.
[[nodiscard]] bool is_sample_trace(const std::filesystem::path& path);

/// The machine as the header of a cell's sample trace describes it. Where the header says nothing of a following window
/// it is infinite: then actual places are not judged. Throws InputError if a needed key is missing or out of range.
[[nodiscard]] MachineConfig machine_of_trace(const std::filesystem::path& path);

/// A polyline: CSV with the columns `x,y,z`, millimetres. Returns metres. Throws InputError for fewer than two points.
[[nodiscard]] std::vector<Vec3> read_polyline(const std::filesystem::path& path);

}  // namespace sc::host
