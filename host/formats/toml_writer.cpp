// SPDX-License-Identifier: Apache-2.0
#include "host/formats/toml_writer.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "host/formats/csv.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

std::string escaped(std::string_view value) {
    constexpr std::string_view kHex = "0123456789ABCDEF";
    std::string out = "\"";
    for (const char c : value) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (c == '\n') {
            out += "\\n";
        } else if (byte < 0x20 || byte == 0x7F) {
            out += "\\u00";
            out += kHex[byte >> 4U];
            out += kHex[byte & 15U];
        } else {
            out += c;
        }
    }
    return out + "\"";
}

std::string listed(const std::vector<double>& values) {
    std::vector<std::string> words;
    words.reserve(values.size());
    for (const double value : values) {
        words.push_back(decimal(value));
    }
    return "[" + joined(words, ", ") + "]";
}

/// `value` to so many significant digits, as a double.
double to_digits(double value, int digits) noexcept {
    if (value == 0.0) {
        return 0.0;
    }
    std::array<char, 40> buffer{};
    const auto result =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::scientific, digits - 1);
    double out = value;
    const std::string_view text(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
    return parse_number(text, out) ? out : value;
}

}  // namespace

double file_value(double si, double divisor) noexcept {
    const double exact = si * divisor;
    for (const int digits : {12, 15, 16}) {
        if (const double value = to_digits(exact, digits); value / divisor == si) {
            return value;
        }
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const double value : {std::nextafter(exact, -kInfinity), std::nextafter(exact, kInfinity)}) {
        if (value / divisor == si) {
            return value;
        }
    }
    return exact;
}

TomlWriter::TomlWriter(std::string_view format) {
    text("format", format);
    integer("version", 1);
}

void TomlWriter::line(std::string_view key, std::string_view value) {
    text_ += key;
    text_ += " = ";
    text_ += value;
    text_ += '\n';
}

void TomlWriter::table(std::string_view name) { text_ += "\n[" + std::string(name) + "]\n"; }
void TomlWriter::item(std::string_view name) { text_ += "\n[[" + std::string(name) + "]]\n"; }
void TomlWriter::text(std::string_view key, std::string_view value) { line(key, escaped(value)); }
void TomlWriter::integer(std::string_view key, std::int64_t value) { line(key, std::to_string(value)); }

void TomlWriter::text_unless_empty(std::string_view key, std::string_view value) {
    if (!value.empty()) {
        text(key, value);
    }
}

void TomlWriter::texts(std::string_view key, const std::vector<std::string>& values) {
    std::vector<std::string> words;
    words.reserve(values.size());
    for (const std::string& value : values) {
        words.push_back(escaped(value));
    }
    line(key, "[" + joined(words, ", ") + "]");
}

void TomlWriter::integers(std::string_view key, const std::vector<int>& values) {
    std::vector<std::string> words;
    words.reserve(values.size());
    for (const int value : values) {
        words.push_back(std::to_string(value));
    }
    line(key, "[" + joined(words, ", ") + "]");
}

void TomlWriter::number(std::string_view key, double si, double divisor) {
    line(key, decimal(file_value(si, divisor)));
}

void TomlWriter::numbers(std::string_view key, const std::vector<double>& si, double divisor) {
    std::vector<double> values;
    values.reserve(si.size());
    for (const double value : si) {
        values.push_back(file_value(value, divisor));
    }
    line(key, listed(values));
}

void TomlWriter::vector(std::string_view key, const Vec3& si, double divisor) {
    numbers(key, {si.x, si.y, si.z}, divisor);
}

void TomlWriter::stops(std::string_view key, const std::vector<Stop>& stops, double divisor) {
    const auto place = [divisor](const Vec3& v) {
        return listed({file_value(v.x, divisor), file_value(v.y, divisor), file_value(v.z, divisor)});
    };
    std::string value = "[\n";
    for (const Stop& stop : stops) {
        value += stop.via ? "    { via = " + place(*stop.via) + ", to = " + place(stop.to) + " },\n"
                          : "    " + place(stop.to) + ",\n";
    }
    line(key, value + "]");
}

void TomlWriter::matrix(std::string_view key, const std::vector<std::vector<double>>& rows) {
    std::string value = "[\n";
    for (const auto& row : rows) {
        value += "    " + listed(row) + ",\n";
    }
    line(key, value + "]");
}

void TomlWriter::rotation(std::string_view key, const Mat3& rotation) {
    std::vector<std::vector<double>> rows;
    for (const Vec3& row : rotation.row) {
        rows.push_back({row.x, row.y, row.z});
    }
    matrix(key, rows);
}

}  // namespace sc::host
