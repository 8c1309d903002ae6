// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/hal/io.hpp"
#include "firmware/link/seal_gate.hpp"
#include "firmware/recording/digest.hpp"
#include "firmware/recording/log_writer.hpp"
#include "shared/machine/machine.hpp"

namespace sc::replay {

/// Records a controller's inputs into a file. Each chunk (a second at most) is handed to the system when it is full, so
/// that a kill or a power loss costs one second. The file never grows beyond its limit; it ends with a record that says
/// so. Some 70 kB: not on a small stack.
class LogFile {
public:
    struct Options {
        std::filesystem::path file;
        std::uint64_t limit_bytes = 100'000'000;
        MachineConfig machine;
        std::uint32_t boot_id = 0;
        std::uint32_t plan_units = 0;
        std::optional<link::SealSecret> seal{};  ///< its key is not written, only what tells it from others
    };
    /// Makes the file, or empties it. Throws std::system_error when that fails, std::invalid_argument for a limit below
    /// LogWriter::kLeastLimit.
    explicit LogFile(const Options& options);
    LogFile(const LogFile&) = delete;
    LogFile& operator=(const LogFile&) = delete;
    /// Ends the log if `close` was not called.
    ~LogFile();

    /// One tick: what the controller was given, and what it answered. Never throws: a disk that refuses ends the
    /// recording, not the cell.
    void tick(const ServoInputs& inputs, const ServoOutputs& outputs) noexcept;
    void close() noexcept;

    [[nodiscard]] std::uint64_t bytes() const noexcept { return writer_.bytes(); }
    [[nodiscard]] std::uint64_t ticks() const noexcept { return writer_.ticks(); }
    /// The limit has been reached; nothing more is recorded.
    [[nodiscard]] bool full() const noexcept { return writer_.full(); }
    /// What the system said when it refused to write; empty while it did not.
    [[nodiscard]] const std::string& error() const noexcept { return error_; }

private:
    void store(std::span<const std::uint8_t> chunk) noexcept;
    void close_file() noexcept;

    std::string name_;
    recording::LogWriter writer_;
    recording::OutputsDigester digester_;
    int file_ = -1;
    std::string error_;
};

/// A whole file in memory. Throws std::system_error when it cannot be read.
[[nodiscard]] std::vector<std::uint8_t> read_log_file(const std::filesystem::path& file);

}  // namespace sc::replay
