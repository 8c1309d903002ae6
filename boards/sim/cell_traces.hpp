// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "boards/sim/plant/output_hashes.hpp"
#include "boards/sim/trace_file.hpp"
#include "boards/sim/world/world.hpp"
#include "firmware/hal/io.hpp"
#include "shared/trace/trace.hpp"

namespace sc::sim {

/// Magic of the optional file with the records that `command_trace_sha256` is made over.
inline constexpr std::array<char, 8> kCommandMagic{'S', 'C', 'C', 'M', 'N', 'D', '0', '1'};

/// JSON header of every trace: the table's true axis, the world's errors, the machine's limits.
[[nodiscard]] std::string trace_header_json(const MachineConfig& machine, const World& world);

/// The traces of one cell: pulses.trace and samples.trace, command.trace if wanted, and the hash of the commands.
class CellTraces {
public:
    /// `directory` empty: nothing is written, the hash is made all the same.
    CellTraces(const std::filesystem::path& directory, bool with_commands, const std::string& header_json);

    void pulse(const trace::PulseRecord& record);
    /// Outputs of a tick with the encoders at its beginning. Flushes ten times a second of control time.
    void tick(std::int64_t tick, const ServoOutputs& outputs, const AxisPositions& encoders);
    /// Of all commands, set-points and laser runs so far.
    [[nodiscard]] const OutputHashes& hashes() const { return hashes_; }
    void flush();
    /// Gives the files their names.
    void close();

private:
    void sample(std::int64_t tick, const ServoOutputs& outputs, const AxisPositions& encoders);
    void command(const PathPulse& pulse);

    std::unique_ptr<TraceFile> pulses_;
    std::unique_ptr<TraceFile> samples_;
    std::unique_ptr<TraceFile> commands_;
    OutputHashes hashes_;
};

}  // namespace sc::sim
