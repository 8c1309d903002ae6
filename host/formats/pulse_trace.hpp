// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "shared/geometry/frames.hpp"
#include "shared/trace/trace.hpp"

/// Readers of the traces that a cell writes: what the laser burnt, and what the axes were told. Layout
/// (docs/formats.md): 8 bytes magic, u32 little-endian length of a JSON header, the header, records to the end of the
/// file.

namespace sc::host {

/// An error that the traced world really has, as its header lists it.
struct KnownError {
    std::string name;
    double value = 0.0;
    std::string unit;
    std::string compensated_by;  ///< "none" or "": by nothing
    bool operator==(const KnownError&) const = default;
};

struct TraceHeader {
    AxisLine axis;  ///< the turntable's true axis, h (metres); vertical through the origin if the header has none
    std::vector<KnownError> errors;
    std::string machine;  ///< JSON text of the header's `machine`, "" if absent
    std::string json;     ///< the whole header as it stands in the file
};

struct PulseTrace {
    std::filesystem::path file;
    TraceHeader header;
    std::vector<trace::PulseRecord> pulses;
};

/// Reads a whole pulse trace (77 bytes of file, 88 of memory a pulse). Throws InputError for a missing file, another
/// kind of file, a header that is no JSON, and a file cut short (value = the byte offset of the cut record).
[[nodiscard]] PulseTrace read_pulse_trace(const std::filesystem::path& path);
/// The same as a stream: constant memory. Returns the header; a cut file throws after all whole records were handed on.
TraceHeader for_each_pulse(const std::filesystem::path& path,
                           const std::function<void(const trace::PulseRecord&)>& handle);
/// One tick: its set-points and its galvo frames (none: mirrors at zero throughout).
using SampleHandler = std::function<void(const trace::SampleRecord&, std::span<const trace::GalvoSample>)>;
/// The header of a sample trace alone. Throws as above.
[[nodiscard]] TraceHeader read_sample_header(const std::filesystem::path& path);
/// Streams a sample trace. Throws as above, and for a record that claims neither 0 nor 100 galvo frames.
TraceHeader for_each_sample(const std::filesystem::path& path, const SampleHandler& handle);

}  // namespace sc::host
