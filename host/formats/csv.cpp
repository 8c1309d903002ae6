// SPDX-License-Identifier: Apache-2.0
#include "host/formats/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <system_error>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

/// One line of the file without its end; false at the end of the text.
bool next_line(std::string_view& rest, std::string_view& line) {
    if (rest.empty()) {
        return false;
    }
    const std::size_t end = rest.find('\n');
    line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    return true;
}

/// Splits at commas outside double quotes; a field in quotes loses them.
std::vector<std::string> split(std::string_view line) {
    std::vector<std::string> fields;
    std::string field;
    bool quoted = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
        } else if (c == ',' && !quoted) {
            fields.emplace_back(trimmed(field));
            field.clear();
        } else {
            field += c;
        }
    }
    fields.emplace_back(trimmed(field));
    return fields;
}

void check_header(const std::string& file, int line, std::string_view text, const std::vector<std::string>& names) {
    if (text.find(';') != std::string_view::npos) {
        throw InputError({.file = file,
                          .line = line,
                          .problem = "columns are separated by semicolons",
                          .value = shortened(text),
                          .action = "export with commas between columns and a decimal point"});
    }
    std::set<std::string> seen;
    for (const std::string& name : names) {
        if (name.empty()) {
            throw InputError({.file = file,
                              .line = line,
                              .problem = "a column of the header has no name",
                              .value = shortened(text),
                              .action = "name every column"});
        }
        if (!seen.insert(name).second) {
            throw InputError({.file = file,
                              .line = line,
                              .problem = "column appears twice in the header",
                              .value = shortened(name),
                              .action = "keep one of them"});
        }
    }
}

std::string counted(std::size_t fields, std::size_t columns) {
    return "row has " + std::to_string(fields) + " fields where the header names " + std::to_string(columns);
}

void check_row(const std::string& file, int line, std::string_view text, std::size_t fields, std::size_t columns) {
    if (fields == columns) {
        return;
    }
    InputProblem problem{.file = file,
                         .line = line,
                         .problem = counted(fields, columns),
                         .value = shortened(text),
                         .action = "give every row as many fields as the header"};
    if (text.find(';') != std::string_view::npos) {
        problem.problem += ", separated by semicolons";
        problem.action = "export with commas between columns and a decimal point";
    } else if (fields > columns) {
        problem.problem += ", as numbers with a decimal comma make it";
        problem.action = "write numbers with a decimal point";
    }
    throw InputError(std::move(problem));
}

bool is_decimal_comma(std::string_view text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string_view::npos) {
        return false;
    }
    std::string with_point(text);
    with_point[comma] = '.';
    double ignored = 0.0;
    return parse_number(with_point, ignored);
}

InputProblem number_problem(std::string_view text) {
    std::string lower(text);
    std::ranges::transform(lower, lower.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    const bool is_signed = lower.starts_with('-') || lower.starts_with('+');
    const std::string_view bare = std::string_view(lower).substr(is_signed ? 1 : 0);
    if (text.empty()) {
        return {.problem = "is empty", .action = "give a number"};
    }
    if (bare == "inf" || bare == "infinity" || bare.starts_with("nan")) {
        return {.problem = "is not a finite number", .action = "remove the row or measure the point again"};
    }
    if (is_decimal_comma(text)) {
        return {.problem = "has a decimal comma", .action = "write numbers with a decimal point"};
    }
    return {.problem = "is not a number", .action = "give a number with a decimal point"};
}

}  // namespace

bool parse_number(std::string_view text, double& out) noexcept {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
        text.remove_prefix(1);
    }
    double value = 0.0;
    const char* const end = std::to_address(text.end());
    const auto [stop, error] = std::from_chars(std::to_address(text.begin()), end, value);
    if (text.empty() || error != std::errc{} || stop != end || !std::isfinite(value)) {
        return false;
    }
    out = value;
    return true;
}

CsvTable CsvTable::read(const std::filesystem::path& path) { return parse(path, read_text_file(path)); }

CsvTable CsvTable::parse(const std::filesystem::path& path, std::string_view text) { return parse(path, text, {}); }

CsvTable CsvTable::parse(const std::filesystem::path& path, std::string_view text, std::string_view header) {
    CsvTable table;
    table.file_ = path;
    if (!header.empty()) {
        std::vector<std::string> names = split(header);
        check_header(path.string(), 0, header, names);
        table.columns_ = std::move(names);
        table.header_line_ = 0;
    }
    if (text.starts_with("\xEF\xBB\xBF")) {
        text.remove_prefix(3);
    }
    int number = 0;
    for (std::string_view line; next_line(text, line);) {
        ++number;
        line = trimmed(line);
        if (line.empty() || line.front() == '#') {
            continue;
        }
        std::vector<std::string> fields = split(line);
        if (table.columns_.empty()) {
            check_header(path.string(), number, line, fields);
            table.columns_ = std::move(fields);
            table.header_line_ = number;
        } else {
            check_row(path.string(), number, line, fields.size(), table.columns_.size());
            table.rows_.push_back({number, std::move(fields)});
        }
    }
    if (table.columns_.empty()) {
        throw InputError(
            {.file = path.string(), .problem = "is empty", .action = "give a header line and a row for each point"});
    }
    return table;
}

bool CsvTable::has(std::string_view name) const noexcept { return std::ranges::find(columns_, name) != columns_.end(); }

std::size_t CsvTable::column(std::string_view name) const {
    const auto at = std::ranges::find(columns_, name);
    if (at == columns_.end()) {
        throw InputError({.file = file_.string(),
                          .line = header_line_,
                          .problem = "column is missing",
                          .value = std::string(name),
                          .action = "the columns present are " + shortened(joined(columns_, ", "))});
    }
    return static_cast<std::size_t>(at - columns_.begin());
}

void CsvTable::refuse_columns_beyond(const std::vector<std::string_view>& known) const {
    for (const std::string& name : columns_) {
        if (std::ranges::find(known, name) == known.end()) {
            throw InputError({.file = file_.string(),
                              .line = header_line_,
                              .problem = "unknown column",
                              .value = shortened(name),
                              .action = "the columns of this file are " + joined(known, ", ")});
        }
    }
}

double CsvTable::number(std::size_t row, std::size_t column) const {
    const std::string& field = text(row, column);
    double value = 0.0;
    if (parse_number(field, value)) {
        return value;
    }
    InputProblem problem = number_problem(field);
    problem.problem = "column " + columns_[column] + " " + problem.problem;
    problem.file = file_.string();
    problem.line = line(row);
    problem.value = shortened(field);
    throw InputError(std::move(problem));
}

int CsvTable::integer(std::size_t row, std::size_t column) const {
    const double value = number(row, column);
    if (std::nearbyint(value) != value || std::abs(value) > 1e9) {
        throw InputError({.file = file_.string(),
                          .line = line(row),
                          .problem = "column " + columns_[column] + " is not a whole number",
                          .value = shortened(text(row, column)),
                          .action = "give a whole number"});
    }
    return static_cast<int>(value);
}

const std::string& CsvTable::text(std::size_t row, std::size_t column) const { return rows_.at(row).fields.at(column); }

}  // namespace sc::host
