// SPDX-License-Identifier: Apache-2.0
#include "host/formats/capture_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "host/formats/byte_file.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::uint32_t kNanosecondMagic = 0xA1B2'3C4DU;
constexpr std::uint32_t kMicrosecondMagic = 0xA1B2'C3D4U;
constexpr std::uint32_t kNextGenerationMagic = 0x0A0D'0D0AU;
constexpr std::uint32_t kUser0 = 147;
constexpr std::uint32_t kSocketCan = 227;
constexpr std::uint32_t kSnapLength = 262'144;
constexpr std::size_t kFileHead = 24;
constexpr std::size_t kPacketHead = 16;
constexpr std::size_t kCanHead = 8;
constexpr std::uint8_t kFdFlag = 4;
constexpr std::int64_t kSecond = 1'000'000'000;
/// A line without a 0x00 is garbage; it is cut here.
constexpr std::size_t kSerialLimit = 4096;

void put(std::vector<std::uint8_t>& out, std::uint64_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) {
        out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    }
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& problem, const std::string& value,
                         const std::string& action) {
    throw InputError({.file = file.string(), .problem = problem, .value = value, .action = action});
}

CaptureKind kind_of(const std::filesystem::path& file, std::uint32_t link_type) {
    if (link_type == kUser0) {
        return CaptureKind::serial;
    }
    if (link_type == kSocketCan) {
        return CaptureKind::can;
    }
    refuse(file, "is a capture of a link type that is not read here", std::to_string(link_type),
           "give a capture of SocketCAN (227), or one that --capture has written (147 or 227)");
}

}  // namespace

CaptureWriter::CaptureWriter(const std::filesystem::path& file, CaptureKind kind)
    : path_(file), file_(std::fopen(file.c_str(), "wbe")) {
    if (file_ == nullptr) {
        refuse(file, std::string("cannot be written: ") + std::strerror(errno), "", "name a file in a folder of yours");
    }
    std::vector<std::uint8_t> head;
    put(head, kNanosecondMagic, 4);
    put(head, 2, 2);
    put(head, 4, 2);
    put(head, 0, 8);
    put(head, kSnapLength, 4);
    put(head, kind == CaptureKind::can ? kSocketCan : kUser0, 4);
    std::fwrite(head.data(), 1, head.size(), file_);
}

CaptureWriter::~CaptureWriter() { close(); }

void CaptureWriter::close() {
    if (file_ == nullptr) {
        return;
    }
    flush(false);
    flush(true);
    if (std::fclose(file_) != 0 && error_.empty()) {
        error_ = path_.string() + ": " + std::strerror(errno);
    }
    file_ = nullptr;
}

void CaptureWriter::packet(std::span<const std::uint8_t> bytes, std::int64_t time_ns) {
    if (file_ == nullptr || !error_.empty()) {
        return;
    }
    std::vector<std::uint8_t> record;
    put(record, static_cast<std::uint64_t>(time_ns / kSecond), 4);
    put(record, static_cast<std::uint64_t>(time_ns % kSecond), 4);
    put(record, bytes.size(), 4);
    put(record, bytes.size(), 4);
    record.insert(record.end(), bytes.begin(), bytes.end());
    if (std::fwrite(record.data(), 1, record.size(), file_) != record.size()) {
        error_ = path_.string() + ": " + std::strerror(errno);
    }
}

void CaptureWriter::flush(bool to_controller) {
    Begun& begun = begun_.at(to_controller ? 1 : 0);
    if (!begun.bytes.empty()) {
        packet(begun.bytes, begun.time_ns);
        begun.bytes.clear();
    }
}

void CaptureWriter::serial(bool to_controller, std::span<const std::uint8_t> bytes, std::int64_t time_ns) {
    Begun& begun = begun_.at(to_controller ? 1 : 0);
    for (const std::uint8_t byte : bytes) {
        if (begun.bytes.empty()) {
            begun.bytes.push_back(to_controller ? 1 : 0);
        }
        begun.bytes.push_back(byte);
        begun.time_ns = time_ns;
        if (byte == 0 || begun.bytes.size() > kSerialLimit) {
            flush(to_controller);
        }
    }
}

void CaptureWriter::can(const CapturedFrame& frame, std::int64_t time_ns) {
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 4; i-- > 0;) {
        bytes.push_back(static_cast<std::uint8_t>(frame.id >> (8 * i)));  // the one number that is big-endian
    }
    bytes.push_back(static_cast<std::uint8_t>(frame.data.size()));
    bytes.push_back(frame.fd ? kFdFlag : std::uint8_t{0});
    put(bytes, 0, 2);
    bytes.insert(bytes.end(), frame.data.begin(), frame.data.end());
    packet(bytes, time_ns);
}

CaptureFile read_capture(const std::filesystem::path& file) {
    const ByteFile source(file);
    const std::string_view bytes = source.bytes();
    const auto u32 = [&bytes](std::size_t at) { return load<std::uint32_t>(bytes, at); };
    if (bytes.size() < kFileHead) {
        refuse(file, "is too short for a capture, bytes", std::to_string(bytes.size()), "give a pcap file");
    }
    const std::uint32_t magic = u32(0);
    if (magic == kNextGenerationMagic) {
        refuse(file, "is a pcapng file", "", "make a pcap of it: editcap -F nsecpcap IN.pcapng OUT.pcap");
    }
    if (magic != kNanosecondMagic && magic != kMicrosecondMagic) {
        refuse(file, "is no pcap file of this byte order", std::to_string(magic), "give a little-endian pcap file");
    }
    CaptureFile capture;
    capture.kind = kind_of(file, u32(20) & 0xFFFFU);
    const std::int64_t unit = magic == kNanosecondMagic ? 1 : 1000;
    for (std::size_t at = kFileHead; at < bytes.size();) {
        const std::string number = std::to_string(capture.packets.size() + 1);
        if (bytes.size() - at < kPacketHead || u32(at + 8) > bytes.size() - at - kPacketHead) {
            refuse(file, "is cut within packet", number, "give the whole file, or let editcap drop the packet");
        }
        const std::size_t size = u32(at + 8);
        if (size != u32(at + 12)) {
            refuse(file, "holds a part only of packet", number, "capture whole packets (snap length 0)");
        }
        CapturePacket& packet = capture.packets.emplace_back();
        packet.time_ns = std::int64_t{u32(at)} * kSecond + std::int64_t{u32(at + 4)} * unit;
        const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at + kPacketHead);
        packet.bytes.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
        at += kPacketHead + size;
    }
    return capture;
}

CapturedFrame captured_frame(const std::filesystem::path& file, const CaptureFile& capture, std::size_t number) {
    const std::vector<std::uint8_t>& bytes = capture.packets.at(number).bytes;
    if (bytes.size() < kCanHead || bytes[4] > bytes.size() - kCanHead) {
        refuse(file, "holds no CAN frame in packet", std::to_string(number + 1), "give a capture of SocketCAN");
    }
    CapturedFrame frame;
    for (std::size_t i = 0; i < 4; ++i) {
        frame.id = frame.id << 8U | bytes[i];
    }
    // Captures from before the flag was known tell it by the frame's size alone.
    frame.fd = (bytes[5] & kFdFlag) != 0 || bytes[4] > 8;
    frame.data.assign(bytes.begin() + kCanHead, bytes.begin() + kCanHead + bytes[4]);
    return frame;
}

}  // namespace sc::host
