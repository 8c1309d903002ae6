// SPDX-License-Identifier: Apache-2.0
#include "host/formats/pcd.hpp"

#include <array>
#include <limits>

#include "host/formats/byte_file.hpp"

namespace sc::host {

namespace {

struct Field {
    std::string name;
    std::size_t size = 4;
    char type = 'F';
    std::size_t count = 1;
    std::size_t offset = 0;  ///< in a point's record
};
struct Header {
    std::vector<Field> fields;
    std::size_t points = 0;
    std::size_t record = 0;  ///< bytes
    std::string data;
    std::size_t end = 0;
    int lines = 0;
    std::array<const Field*, 3> xyz{};
};

std::vector<std::string_view> words_of_line(TextCursor& text) {
    std::vector<std::string_view> out;
    for (std::string_view word = text.word_in_line(); !word.empty(); word = text.word_in_line()) {
        out.push_back(word);
    }
    return out;
}

std::size_t count_of(const TextCursor& text, std::string_view word) {
    std::size_t value = 0;
    if (!parse_count(word, value)) {
        text.fail("not a whole number in the header", word, "this is not a PCD header");
    }
    return value;
}

void finish(TextCursor& text, Header& header) {
    for (Field& field : header.fields) {
        if (field.count > 65536 || (field.size != 1 && field.size != 2 && field.size != 4 && field.size != 8)) {
            text.fail("a field has no possible size or count", field.name, "this is not a PCD header");
        }
        field.offset = header.record;
        header.record += field.size * field.count;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (field.name == std::string(1, static_cast<char>('x' + axis))) {
                header.xyz[axis] = &field;
            }
        }
    }
    for (const Field* field : header.xyz) {
        if (field == nullptr || field->type != 'F' || field->size < 4) {
            text.fail("the fields x, y, z are not all there as F 4 or F 8", "", "write FIELDS x y z");
        }
    }
}

Header read_header(TextCursor& text) {
    Header header;
    while (header.data.empty()) {
        if (text.at_end()) {
            text.fail("the header has no DATA line", "", "give the whole file");
        }
        const std::vector<std::string_view> words = words_of_line(text);
        const std::string_view key = words.empty() ? std::string_view{} : words[0];
        const bool of_fields = key == "SIZE" || key == "TYPE" || key == "COUNT";
        if (of_fields && words.size() != header.fields.size() + 1) {
            text.fail("not one entry for each field", key, "this is not a PCD header");
        }
        if ((key == "POINTS" || key == "DATA") && words.size() < 2) {
            text.fail("a line of the header has no value", key, "this is not a PCD header");
        }
        for (std::size_t i = 1; i < words.size(); ++i) {
            if (key == "FIELDS") {
                header.fields.push_back({.name = std::string(words[i])});
            } else if (key == "SIZE") {
                header.fields[i - 1].size = count_of(text, words[i]);
            } else if (key == "TYPE") {
                header.fields[i - 1].type = words[i].front();
            } else if (key == "COUNT") {
                header.fields[i - 1].count = count_of(text, words[i]);
            }
        }
        if (key == "POINTS") {
            header.points = count_of(text, words[1]);
        } else if (key == "DATA") {
            header.data = words[1];
            finish(text, header);
        }
        static_cast<void>(text.rest_of_line());
    }
    header.end = text.offset();
    header.lines = text.line();
    return header;
}

double load_real(std::string_view bytes, std::size_t at, std::size_t size) {
    return size == 4 ? static_cast<double>(load<float>(bytes, at)) : load<double>(bytes, at);
}

std::vector<double> from_text(TextCursor& text, const Header& header) {
    std::vector<double> out;
    out.reserve(3 * header.points);
    for (std::size_t i = 0; i < header.points; ++i) {
        std::array<double, 3> place{};
        for (const Field& field : header.fields) {
            for (std::size_t k = 0; k < field.count; ++k) {
                const std::string_view word = text.word();
                double value = 0.0;
                if (!parse_any_number(word, value)) {
                    text.fail(word.empty() ? "the file ends before its last point" : "not a number", word,
                              "the header promises " + std::to_string(header.points) + " points");
                }
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    place[axis] = header.xyz[axis] == &field ? value : place[axis];
                }
            }
        }
        out.insert(out.end(), place.begin(), place.end());
    }
    return out;
}

/// Record after record (`packed` false), or field after field as binary_compressed has them.
std::vector<double> from_bytes(const Header& header, std::string_view bytes, bool packed) {
    std::vector<double> out(3 * header.points);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Field& field = *header.xyz[axis];
        const std::size_t stride = packed ? field.size * field.count : header.record;
        const std::size_t start = packed ? field.offset * header.points : field.offset;
        for (std::size_t i = 0; i < header.points; ++i) {
            out[3 * i + axis] = load_real(bytes, start + i * stride, field.size);
        }
    }
    return out;
}

}  // namespace

bool looks_like_pcd(std::string_view bytes) noexcept {
    const std::string_view start = bytes.substr(0, 512);
    return start.starts_with("# .PCD") || start.starts_with("VERSION") || start.find("\nVERSION .7") != start.npos ||
           start.find("\nVERSION 0.7") != start.npos;
}

std::string unpacked_lzf(std::string_view packed, std::size_t size) {
    std::string out;
    out.reserve(size);
    std::size_t at = 0;
    const auto byte = [&packed](std::size_t i) {
        return static_cast<std::size_t>(static_cast<unsigned char>(packed[i]));
    };
    while (at < packed.size()) {
        const std::size_t control = byte(at++);
        if (control < 32) {
            if (packed.size() - at < control + 1) {
                return {};
            }
            out.append(packed.substr(at, control + 1));
            at += control + 1;
            continue;
        }
        std::size_t length = control >> 5U;
        if (length == 7) {
            if (at >= packed.size()) {
                return {};
            }
            length += byte(at++);
        }
        if (at >= packed.size()) {
            return {};
        }
        const std::size_t back = ((control & 31U) << 8U) + byte(at++) + 1;
        if (back > out.size() || out.size() + length + 2 > size) {
            return {};
        }
        for (std::size_t i = 0; i < length + 2; ++i) {
            out.push_back(out[out.size() - back]);  // may run into what it writes itself
        }
    }
    return out.size() == size ? out : std::string{};
}

std::vector<double> parse_pcd(const std::filesystem::path& file, std::string_view bytes) {
    TextCursor text(file, bytes);
    const Header header = read_header(text);
    if (header.data == "ascii") {
        return from_text(text, header);
    }
    if (header.points > std::numeric_limits<std::uint32_t>::max()) {
        fail_at_byte(file, header.end, "the header promises too many points", std::to_string(header.points),
                     "give the file as it was written");
    }
    const std::size_t size = header.record * header.points;
    const std::string_view body = bytes.substr(header.end);
    if (header.data == "binary") {
        if (body.size() < size) {
            fail_at_byte(file, bytes.size(), "the file ends before its last point",
                         std::to_string(body.size()) + " of " + std::to_string(size) + " bytes", "give the whole file");
        }
        return from_bytes(header, body, false);
    }
    if (header.data != "binary_compressed") {
        text.fail("unknown kind of data", header.data, "write ascii, binary or binary_compressed");
    }
    const std::size_t packed_size = body.size() >= 8 ? load<std::uint32_t>(body, 0) : 0;
    if (body.size() < 8 || body.size() - 8 < packed_size || load<std::uint32_t>(body, 4) != size) {
        fail_at_byte(file, header.end, "the compressed part is cut off or does not fit the header",
                     std::to_string(body.size()) + " bytes", "give the whole file");
    }
    const std::string raw = unpacked_lzf(body.substr(8, packed_size), size);
    if (raw.empty() && size > 0) {
        fail_at_byte(file, header.end + 8, "the compressed part is damaged", "", "write the file again");
    }
    return from_bytes(header, raw, true);
}

}  // namespace sc::host
