// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/log_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "boards/replay/build_id.hpp"
#include "shared/link/seal.hpp"

namespace sc::replay {

LogFile::LogFile(const Options& options) : name_(options.file.string()) {
    if (options.limit_bytes < recording::LogWriter::kLeastLimit) {
        throw std::invalid_argument(name_ + ": a limit of " + std::to_string(options.limit_bytes) +
                                    " bytes is too small for a log; give at least " +
                                    std::to_string(recording::LogWriter::kLeastLimit));
    }
    file_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file_ < 0) {
        throw std::system_error(errno, std::generic_category(), name_);
    }
    recording::LogHeader header;
    header.machine = options.machine;
    header.boot_id = options.boot_id;
    header.plan_units = options.plan_units;
    if (options.seal) {
        header.sealed = true;
        header.key_check = link::seal_key_check(options.seal->key);
        header.entropy = options.seal->entropy;
    }
    const std::string id = build_id();
    std::copy_n(id.begin(), std::min(id.size(), header.build_id.size()), header.build_id.begin());
    store(writer_.begin(header, options.limit_bytes));
}

LogFile::~LogFile() { close(); }

void LogFile::tick(const ServoInputs& inputs, const ServoOutputs& outputs) noexcept {
    if (file_ < 0) {
        return;
    }
    store(writer_.add(inputs, digester_.digest(outputs)));
    if (writer_.ended()) {
        close_file();
    }
}

void LogFile::close() noexcept {
    store(writer_.flush());
    store(writer_.close());
    close_file();
}

void LogFile::close_file() noexcept {
    if (file_ >= 0) {
        ::close(std::exchange(file_, -1));
    }
}

void LogFile::store(std::span<const std::uint8_t> chunk) noexcept {
    while (file_ >= 0 && !chunk.empty()) {
        const ssize_t n = ::write(file_, chunk.data(), chunk.size());
        if (n < 0 && errno != EINTR) {
            error_ = name_ + ": " + std::strerror(errno);
            close_file();
        }
        chunk = chunk.subspan(static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    }
}

std::vector<std::uint8_t> read_log_file(const std::filesystem::path& file) {
    std::error_code failed;
    if (std::filesystem::is_directory(file, failed)) {
        throw std::system_error(EISDIR, std::generic_category(), file.string());
    }
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (!stream.is_open() || stream.bad()) {
        throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string());
    }
    return bytes;
}

}  // namespace sc::replay
