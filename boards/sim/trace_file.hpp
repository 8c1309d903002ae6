// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sc::sim {

/// A trace on disk: magic, u32 little-endian length of a JSON header, the header, records. Grows as `<path>.part` and
/// takes its name when closed, so that a trace with its proper name is whole. What was flushed survives a kill of the
/// process as a readable prefix in the .part file. Throws std::system_error when the disk refuses.
class TraceFile {
public:
    TraceFile(std::filesystem::path path, const std::array<char, 8>& magic, const std::string& header_json);
    TraceFile(const TraceFile&) = delete;
    TraceFile& operator=(const TraceFile&) = delete;
    /// Without `close` the file stays a .part.
    ~TraceFile();

    /// Adds one record; written out in pieces of whole records.
    void write(std::span<const std::uint8_t> record);
    /// Hands all records so far to the system. Cheap when there are none.
    void flush();
    void close();

private:
    std::filesystem::path path_;
    std::filesystem::path part_;
    int file_ = -1;
    std::vector<std::uint8_t> buffer_;
};

/// Writes a text file under its name at once: to a neighbour first, then renamed. Throws std::system_error.
void write_whole_file(const std::filesystem::path& path, const std::string& text);

}  // namespace sc::sim
