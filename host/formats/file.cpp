// SPDX-License-Identifier: Apache-2.0
#include "host/formats/file.hpp"

#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "host/formats/error.hpp"

namespace sc::host {

namespace {

namespace fs = std::filesystem;

std::string reason_of(int error) { return std::error_code(error, std::generic_category()).message(); }

class OutputFile {
public:
    explicit OutputFile(const fs::path& path) : path_(path) {
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): open() is variadic by POSIX.
        descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    }
    ~OutputFile() {
        if (descriptor_ >= 0) {
            ::close(descriptor_);
        }
    }
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// 0, or the errno of what failed; a file that failed is removed.
    int write_all(std::string_view text) {
        const int error = descriptor_ < 0 ? errno : write_and_sync(text);
        if (error != 0 && descriptor_ >= 0) {
            ::unlink(path_.c_str());
        }
        return error;
    }

private:
    [[nodiscard]] int write_and_sync(std::string_view text) const {
        while (!text.empty()) {
            const ssize_t n = ::write(descriptor_, text.data(), text.size());
            if (n < 0 && errno == EINTR) {
                continue;
            }
            if (n <= 0) {
                return errno;
            }
            text.remove_prefix(static_cast<std::size_t>(n));
        }
        return ::fsync(descriptor_) == 0 ? 0 : errno;
    }

    fs::path path_;
    int descriptor_ = -1;
};

[[noreturn]] void fail_to_write(const fs::path& path, const std::string& reason) {
    throw InputError({.file = path.string(),
                      .problem = "cannot be written",
                      .value = reason,
                      .action = "check the folder, the free space and the permissions"});
}

}  // namespace

std::string read_text_file(const fs::path& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) {
        throw InputError({.file = path.string(),
                          .problem = "there is no such file",
                          .action = "check the path; paths inside a file are relative to its folder"});
    }
    if (!fs::is_regular_file(status)) {
        throw InputError(
            {.file = path.string(), .problem = "is not a file", .action = "name a file, not a folder or a device"});
    }
    if (const auto size = fs::file_size(path, error); !error && size > kTextFileLimit) {
        throw InputError({.file = path.string(),
                          .problem = "is too large for this kind of file",
                          .value = std::to_string(size) + " bytes",
                          .action = "check the path"});
    }
    std::ifstream in(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in.is_open() || in.bad()) {
        throw InputError(
            {.file = path.string(), .problem = "cannot be read", .action = "check the file's permissions"});
    }
    return text;
}

void write_text_file(const fs::path& path, std::string_view text) {
    fs::path beside_it = path;
    beside_it += ".part" + std::to_string(::getpid());
    OutputFile file(beside_it);
    if (const int error = file.write_all(text); error != 0) {
        fail_to_write(path, reason_of(error));
    }
    std::error_code error;
    fs::rename(beside_it, path, error);
    if (error) {
        std::error_code ignored;
        fs::remove(beside_it, ignored);
        fail_to_write(path, error.message());
    }
}

void make_folder(const fs::path& path) {
    std::error_code failed;
    fs::create_directories(path, failed);
    if (failed) {
        throw InputError({.file = path.string(),
                          .problem = "cannot be made",
                          .value = failed.message(),
                          .action = "name a folder that can be written"});
    }
}

fs::path beside(const fs::path& file, const fs::path& path) {
    return path.is_absolute() ? path : (file.parent_path() / path).lexically_normal();
}

std::string stored_path(const fs::path& file, const fs::path& path) {
    if (path.is_absolute() != file.is_absolute()) {
        return fs::absolute(path).lexically_normal().string();
    }
    return path.lexically_proximate(file.parent_path()).string();
}

}  // namespace sc::host
