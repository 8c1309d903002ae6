// SPDX-License-Identifier: Apache-2.0
#include "host/formats/byte_file.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, const char* problem, const char* action) {
    throw InputError({.file = path.string(), .problem = problem, .action = action});
}

bool blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

}  // namespace

ByteFile::ByteFile(const std::filesystem::path& path) : path_(path) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): open() is variadic by POSIX.
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) {
        refuse(path, errno == ENOENT ? "there is no such file" : "cannot be read",
               "check the path and its permissions");
    }
    struct stat status{};
    const bool regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    size_ = regular ? static_cast<std::size_t>(status.st_size) : 0;
    void* mapped = size_ > 0 ? ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0) : MAP_FAILED;
    ::close(descriptor);
    if (!regular) {
        refuse(path, "is not a file", "name a file, not a folder or a device");
    }
    if (size_ == 0) {
        refuse(path, "is empty", "give a file with data; was it written to the end?");
    }
    if (mapped == MAP_FAILED) {
        refuse(path, "cannot be read", "check the file's permissions");
    }
    data_ = static_cast<const char*>(mapped);
}

ByteFile::~ByteFile() {
    if (data_ != nullptr) {
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): munmap() takes what mmap() gave.
        ::munmap(const_cast<char*>(data_), size_);
    }
}

void TextCursor::skip_blanks(bool over_lines) noexcept {
    while (at_ < text_.size() && (blank(text_[at_]) || (over_lines && text_[at_] == '\n'))) {
        line_ += text_[at_] == '\n' ? 1 : 0;
        ++at_;
    }
}

std::string_view TextCursor::word() {
    skip_blanks(true);
    return word_in_line();
}

std::string_view TextCursor::word_in_line() {
    skip_blanks(false);
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != '\n' && !blank(text_[at_])) {
        ++at_;
    }
    return text_.substr(begin, at_ - begin);
}

std::string_view TextCursor::rest_of_line() {
    const std::size_t begin = at_;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    at_ = std::min(end + 1, text_.size());
    line_ += end < text_.size() ? 1 : 0;
    return trimmed(text_.substr(begin, end - begin));
}

double TextCursor::number(std::string_view what) {
    const std::string_view text = word();
    double value = 0.0;
    if (text.empty()) {
        fail("ends before " + std::string(what), "", "give the whole file");
    }
    if (!parse_any_number(text, value) || !std::isfinite(value)) {
        fail(std::string(what) + " is not a finite number", text, "write numbers with a decimal point");
    }
    return value;
}

void TextCursor::fail(std::string_view problem, std::string_view value, std::string_view action) const {
    throw InputError({.file = file_->string(),
                      .line = line_,
                      .problem = std::string(problem),
                      .value = shortened(value),
                      .action = std::string(action)});
}

bool parse_any_number(std::string_view word, double& out) noexcept {
    if (!word.empty() && word.front() == '+') {
        word.remove_prefix(1);
    }
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
    if (error == std::errc::result_out_of_range) {
        out = 0.0;  // too small for a double; what is too large is caught as text
        return end == word.data() + word.size() && word.find("e-") != std::string_view::npos;
    }
    return error == std::errc{} && end == word.data() + word.size();
}

bool parse_count(std::string_view word, std::size_t& out) noexcept {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
    return error == std::errc{} && end == word.data() + word.size() && !word.empty();
}

void fail_at_byte(const std::filesystem::path& file, std::size_t offset, std::string_view problem,
                  std::string_view value, std::string_view action) {
    throw InputError({.file = file.string(),
                      .problem = "at byte " + std::to_string(offset) + ": " + std::string(problem),
                      .value = shortened(value),
                      .action = std::string(action)});
}

}  // namespace sc::host
