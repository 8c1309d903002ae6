// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sc::host {

/// A comma-separated file with a header line, read strictly: what cannot be understood is refused with file, line and
/// value, never guessed. Fields are separated by commas, numbers have a decimal point; LF and CRLF, blank lines, lines
/// that start with `#` and blanks around a field are fine; quotes are not part of the format.
///
/// Reading refuses: an empty file, a header with an empty or repeated name, a row with more or fewer fields than the
/// header. Semicolons and decimal commas ("12,5", which makes a row too long) are named as such.
class CsvTable {
public:
    struct Row {
        int line = 0;                     ///< in the file, from 1
        std::vector<std::string> fields;  ///< as many as columns
    };

    /// Reads the whole file. Throws InputError.
    [[nodiscard]] static CsvTable read(const std::filesystem::path& path);
    /// The same from text in memory; `path` is for messages only.
    [[nodiscard]] static CsvTable parse(const std::filesystem::path& path, std::string_view text);
    /// The same of a file without a header: `header` stands in for it.
    [[nodiscard]] static CsvTable parse(const std::filesystem::path& path, std::string_view text,
                                        std::string_view header);

    [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }
    [[nodiscard]] std::size_t size() const noexcept { return rows_.size(); }
    [[nodiscard]] const std::vector<std::string>& columns() const noexcept { return columns_; }
    [[nodiscard]] int line(std::size_t row) const { return rows_.at(row).line; }
    [[nodiscard]] int header_line() const noexcept { return header_line_; }

    /// Index of a column by name. Throws InputError that names the missing column and lists those present.
    [[nodiscard]] std::size_t column(std::string_view name) const;
    [[nodiscard]] bool has(std::string_view name) const noexcept;
    /// Throws InputError if a column is none of these.
    void refuse_columns_beyond(const std::vector<std::string_view>& known) const;

    /// The field as a finite number. Throws InputError for an empty field, text, a decimal comma, NaN, infinity, or a
    /// magnitude that no double holds.
    [[nodiscard]] double number(std::size_t row, std::size_t column) const;
    /// The field as a whole number within int. Throws InputError.
    [[nodiscard]] int integer(std::size_t row, std::size_t column) const;
    [[nodiscard]] const std::string& text(std::size_t row, std::size_t column) const;

private:
    std::filesystem::path file_;
    std::vector<std::string> columns_;
    int header_line_ = 1;
    std::vector<Row> rows_;
};

/// The whole of `text` as a finite number with a decimal point, whatever the locale; false if it is none.
[[nodiscard]] bool parse_number(std::string_view text, double& out) noexcept;

}  // namespace sc::host
