// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// What passed over a link, as a file that Wireshark and its kin read (docs/formats.md): pcap with nanoseconds, of one
/// link type.

namespace sc::host {

enum class CaptureKind : std::uint8_t {
    serial,  ///< LINKTYPE_USER0: a byte of direction (0 to the host, 1 to the controller), then bytes up to a 0x00
    can,     ///< LINKTYPE_CAN_SOCKETCAN
};

/// A CAN frame of a capture.
struct CapturedFrame {
    std::uint32_t id = 0;  ///< with the kernel's flags (extended, remote, error) in its upper three bits
    bool fd = false;
    std::vector<std::uint8_t> data;
};

struct CapturePacket {
    std::int64_t time_ns = 0;
    std::vector<std::uint8_t> bytes;  ///< with the link type's own head
};

struct CaptureFile {
    CaptureKind kind = CaptureKind::serial;
    std::vector<CapturePacket> packets;
};

/// Writes a capture as it happens. An error after the start never disturbs the link: the file ends there, and `error`
/// says why.
class CaptureWriter {
public:
    /// Throws InputError when the file cannot be written.
    CaptureWriter(const std::filesystem::path& file, CaptureKind kind);
    CaptureWriter(const CaptureWriter&) = delete;
    CaptureWriter& operator=(const CaptureWriter&) = delete;
    ~CaptureWriter();

    /// Bytes of a serial link, in any portions: each packet of the file ends with a 0x00.
    void serial(bool to_controller, std::span<const std::uint8_t> bytes, std::int64_t time_ns);
    void can(const CapturedFrame& frame, std::int64_t time_ns);
    /// Writes what is left of a serial link's bytes, and all to the disk.
    void close();
    [[nodiscard]] const std::string& error() const noexcept { return error_; }

private:
    struct Begun {
        std::vector<std::uint8_t> bytes;
        std::int64_t time_ns = 0;
    };
    void flush(bool to_controller);
    void packet(std::span<const std::uint8_t> bytes, std::int64_t time_ns);

    std::filesystem::path path_;
    std::FILE* file_ = nullptr;
    std::array<Begun, 2> begun_;  ///< by direction
    std::string error_;
};

/// Reads a capture of these two link types. Throws InputError for a file that is none, is cut or is of another type.
[[nodiscard]] CaptureFile read_capture(const std::filesystem::path& file);
/// The frame of a packet of a CAN capture. Throws InputError, with the packet's number, if it is none.
[[nodiscard]] CapturedFrame captured_frame(const std::filesystem::path& file, const CaptureFile& capture,
                                           std::size_t number);

}  // namespace sc::host
