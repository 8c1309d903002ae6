// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/trace_file.hpp"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace sc::sim {
namespace {

constexpr std::size_t kBufferSize = 1U << 16U;

[[noreturn]] void fail(const std::filesystem::path& path) {
    throw std::system_error(errno, std::generic_category(), path.string());
}

int open_new(const std::filesystem::path& path) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file < 0) {
        fail(path);
    }
    return file;
}

void write_all(int file, std::span<const std::uint8_t> bytes, const std::filesystem::path& path) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(file, bytes.data(), bytes.size());
        if (n < 0 && errno != EINTR) {
            fail(path);
        }
        bytes = bytes.subspan(n > 0 ? static_cast<std::size_t>(n) : 0);
    }
}

std::filesystem::path with_part(const std::filesystem::path& path) {
    std::filesystem::path part = path;
    part += ".part";
    return part;
}

}  // namespace

TraceFile::TraceFile(std::filesystem::path path, const std::array<char, 8>& magic, const std::string& header_json)
    : path_(std::move(path)), part_(with_part(path_)), file_(open_new(part_)) {
    buffer_.reserve(kBufferSize + 4096);
    buffer_.assign(magic.begin(), magic.end());
    const auto length = static_cast<std::uint32_t>(header_json.size());
    for (unsigned shift = 0; shift < 32; shift += 8) {
        buffer_.push_back(static_cast<std::uint8_t>(length >> shift));
    }
    buffer_.insert(buffer_.end(), header_json.begin(), header_json.end());
    flush();
}

TraceFile::~TraceFile() {
    if (file_ >= 0) {
        ::close(file_);
    }
}

void TraceFile::write(std::span<const std::uint8_t> record) {
    buffer_.insert(buffer_.end(), record.begin(), record.end());
    if (buffer_.size() >= kBufferSize) {
        flush();
    }
}

void TraceFile::flush() {
    if (!buffer_.empty()) {
        write_all(file_, buffer_, part_);
        buffer_.clear();
    }
}

void TraceFile::close() {
    flush();
    if (::close(std::exchange(file_, -1)) != 0) {
        fail(part_);
    }
    std::filesystem::rename(part_, path_);
}

void write_whole_file(const std::filesystem::path& path, const std::string& text) {
    const std::filesystem::path part = with_part(path);
    const int file = open_new(part);
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    try {
        write_all(file, bytes, part);
    } catch (...) {
        ::close(file);
        throw;
    }
    if (::close(file) != 0) {
        fail(part);
    }
    std::filesystem::rename(part, path);
}

}  // namespace sc::sim
