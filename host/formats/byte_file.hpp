// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

/// Reading of large files (meshes, clouds), for the sources of this folder only.

namespace sc::host {

/// A file mapped into memory, read only. Throws InputError if it is missing, no file, empty or unreadable.
class ByteFile {
public:
    explicit ByteFile(const std::filesystem::path& path);
    ~ByteFile();
    ByteFile(const ByteFile&) = delete;
    ByteFile& operator=(const ByteFile&) = delete;

    [[nodiscard]] std::string_view bytes() const noexcept { return {data_, size_}; }
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

private:
    std::filesystem::path path_;
    const char* data_ = nullptr;
    std::size_t size_ = 0;
};

/// Words and numbers of a text, with the line they stand on.
class TextCursor {
public:
    TextCursor(const std::filesystem::path& file, std::string_view text, int line = 1)
        : file_(&file), text_(text), line_(line) {}

    /// The next word, over line ends; empty at the end.
    [[nodiscard]] std::string_view word();
    /// The next word of this line; empty at its end.
    [[nodiscard]] std::string_view word_in_line();
    /// The rest of this line, and on to the next; sets `line()` to the line it stood on.
    [[nodiscard]] std::string_view rest_of_line();
    /// A finite number. Throws InputError for the end, text, NaN or infinity.
    [[nodiscard]] double number(std::string_view what);
    [[nodiscard]] bool at_end() const noexcept { return at_ >= text_.size(); }
    [[nodiscard]] int line() const noexcept { return line_; }
    [[nodiscard]] std::size_t offset() const noexcept { return at_; }
    [[noreturn]] void fail(std::string_view problem, std::string_view value, std::string_view action) const;

private:
    void skip_blanks(bool over_lines) noexcept;

    const std::filesystem::path* file_;
    std::string_view text_;
    std::size_t at_ = 0;
    int line_;
};

/// A word as a number in C notation ("nan" and "inf" included), whatever the locale; false if it is none.
[[nodiscard]] bool parse_any_number(std::string_view word, double& out) noexcept;
/// A word as a whole number.
[[nodiscard]] bool parse_count(std::string_view word, std::size_t& out) noexcept;

/// A value of type T at byte `at`, little-endian unless `big`. The caller has checked the bounds.
template <class T>
[[nodiscard]] T load(std::string_view bytes, std::size_t at, bool big = false) noexcept {
    static_assert(sizeof(T) <= 8);
    unsigned char raw[sizeof(T)];
    std::memcpy(raw, bytes.data() + at, sizeof(T));
    if (big) {
        for (std::size_t i = 0; i < sizeof(T) / 2; ++i) {
            const unsigned char other = raw[sizeof(T) - 1 - i];
            raw[sizeof(T) - 1 - i] = raw[i];
            raw[i] = other;
        }
    }
    T out;
    std::memcpy(&out, raw, sizeof(T));
    return out;
}

/// Throws InputError; the place is said in the problem.
[[noreturn]] void fail_at_byte(const std::filesystem::path& file, std::size_t offset, std::string_view problem,
                               std::string_view value, std::string_view action);

}  // namespace sc::host
