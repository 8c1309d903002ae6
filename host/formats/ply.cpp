// SPDX-License-Identifier: Apache-2.0
#include "host/formats/ply.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "host/formats/byte_file.hpp"
#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

enum class Kind : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

constexpr std::array<std::size_t, 8> kSize{1, 1, 2, 2, 4, 4, 4, 8};

std::optional<Kind> kind_of(std::string_view word) {
    constexpr std::array<std::array<std::string_view, 2>, 8> kNames{{{"char", "int8"},
                                                                     {"uchar", "uint8"},
                                                                     {"short", "int16"},
                                                                     {"ushort", "uint16"},
                                                                     {"int", "int32"},
                                                                     {"uint", "uint32"},
                                                                     {"float", "float32"},
                                                                     {"double", "float64"}}};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
        if (word == kNames[i][0] || word == kNames[i][1]) {
            return static_cast<Kind>(i);
        }
    }
    return std::nullopt;
}

double load_as_double(std::string_view bytes, std::size_t at, Kind kind, bool big) {
    switch (kind) {
        case Kind::i8: return load<std::int8_t>(bytes, at, big);
        case Kind::u8: return load<std::uint8_t>(bytes, at, big);
        case Kind::i16: return load<std::int16_t>(bytes, at, big);
        case Kind::u16: return load<std::uint16_t>(bytes, at, big);
        case Kind::i32: return load<std::int32_t>(bytes, at, big);
        case Kind::u32: return load<std::uint32_t>(bytes, at, big);
        case Kind::f32: return static_cast<double>(load<float>(bytes, at, big));
        case Kind::f64: return load<double>(bytes, at, big);
    }
    return 0.0;
}

enum class Role : std::uint8_t { other, x, y, z, view, corners };

struct Property {
    std::string name;
    Kind kind = Kind::f32;
    std::optional<Kind> count;  ///< of a list
    Role role = Role::other;
};
struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
    int line = 0;
};
struct Header {
    bool ascii = false;
    bool big = false;
    std::vector<Element> elements;
    std::size_t end = 0;
    int lines = 0;
};

Role role_of(const std::string& element, const Property& property) {
    const std::string& name = property.name;
    if (element == "vertex" && !property.count) {
        if (name == "x" || name == "y" || name == "z") {
            return name == "x" ? Role::x : (name == "y" ? Role::y : Role::z);
        }
        return name == "view" || name == "scan" || name == "scan_id" ? Role::view : Role::other;
    }
    const bool corners = name == "vertex_indices" || name == "vertex_index";
    return element == "face" && property.count && corners ? Role::corners : Role::other;
}

void read_property(TextCursor& text, std::vector<Element>& elements) {
    if (elements.empty()) {
        text.fail("a property stands before any element", "", "this is not a PLY header");
    }
    Property property;
    std::string_view word = text.word_in_line();
    if (word == "list") {
        property.count = kind_of(text.word_in_line());
        word = text.word_in_line();
        if (!property.count || *property.count >= Kind::f32) {
            text.fail("the count of a list is of no whole-number type", word, "write property list uchar int NAME");
        }
    }
    const auto kind = kind_of(word);
    if (!kind) {
        text.fail("unknown type of a property", word, "PLY knows char uchar short ushort int uint float double");
    }
    property.kind = *kind;
    property.name = text.word_in_line();
    property.role = role_of(elements.back().name, property);
    elements.back().properties.push_back(property);
}

Header read_header(const std::filesystem::path& file, std::string_view bytes) {
    TextCursor text(file, bytes);
    Header header;
    bool format_seen = false;
    static_cast<void>(text.rest_of_line());
    while (true) {
        if (text.at_end()) {
            text.fail("the header has no end_header", "", "give the whole file");
        }
        const std::string_view word = text.word_in_line();
        if (word == "end_header") {
            break;
        }
        if (word == "format") {
            const std::string_view name = text.word_in_line();
            header.ascii = name == "ascii";
            header.big = name == "binary_big_endian";
            format_seen = true;
            if (!header.ascii && !header.big && name != "binary_little_endian") {
                text.fail("unknown format", name, "write ascii, binary_little_endian or binary_big_endian");
            }
        } else if (word == "element") {
            Element element;
            element.name = text.word_in_line();
            element.line = text.line();
            const std::string_view count = text.word_in_line();
            if (!parse_count(count, element.count)) {
                text.fail("the count of an element is no whole number", count, "write element NAME COUNT");
            }
            header.elements.push_back(element);
        } else if (word == "property") {
            read_property(text, header.elements);
        } else if (word != "comment" && word != "obj_info" && !word.empty()) {
            text.fail("unknown line in the header", word, "this is not a PLY header");
        }
        static_cast<void>(text.rest_of_line());
    }
    static_cast<void>(text.rest_of_line());
    if (!format_seen) {
        text.fail("the header states no format", "", "add a line 'format ascii 1.0'");
    }
    header.end = text.offset();
    header.lines = text.line();
    return header;
}

/// Gives out the values of an element, one after the other, from text or bytes.
class Values {
public:
    Values(const std::filesystem::path& file, std::string_view bytes, const Header& header)
        : file_(&file),
          bytes_(bytes),
          header_(&header),
          at_(header.end),
          text_(file, bytes.substr(header.end), header.lines) {}

    double next(Kind kind, const std::string& what) {
        if (header_->ascii) {
            const std::string_view word = text_.word();
            double value = 0.0;
            if (word.empty()) {
                text_.fail("the file ends inside element " + what, "", "give the whole file");
            }
            if (!parse_any_number(word, value)) {
                text_.fail("not a number in element " + what, word, "write numbers with a decimal point");
            }
            return value;
        }
        const std::size_t size = kSize[static_cast<std::size_t>(kind)];
        if (bytes_.size() - at_ < size) {
            fail_at_byte(*file_, at_, "the file ends inside element " + what, "", "give the whole file");
        }
        at_ += size;
        return load_as_double(bytes_, at_ - size, kind, header_->big);
    }
    [[noreturn]] void fail(std::string_view problem, const std::string& value, std::string_view action) const {
        if (header_->ascii) {
            text_.fail(problem, value, action);
        }
        fail_at_byte(*file_, at_, problem, value, action);
    }

private:
    const std::filesystem::path* file_;
    std::string_view bytes_;
    const Header* header_;
    std::size_t at_;
    TextCursor text_;
};

void read_polygon(Values& values, const Property& property, const std::string& what, PlyContent& out) {
    const double count = values.next(*property.count, what);
    if (!(count >= 0.0) || count > 1e6) {
        values.fail("a polygon has no possible number of corners", about(count), "give the whole file, unchanged");
    }
    std::array<std::uint32_t, 2> fan{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const double corner = values.next(property.kind, what);
        if (!(corner >= 0.0) || corner >= static_cast<double>(out.vertices)) {
            values.fail("a polygon names a vertex that is not there", about(corner),
                        "there are " + std::to_string(out.vertices) + " vertices");
        }
        const auto index = static_cast<std::uint32_t>(corner);
        if (i < 2) {
            fan[i] = index;
        } else {
            out.index.insert(out.index.end(), {fan[0], fan[1], index});
            fan[1] = index;
        }
    }
}

void read_element(Values& values, const Element& element, PlyContent& out) {
    for (std::size_t i = 0; i < element.count; ++i) {
        std::array<double, 3> place{};
        for (const Property& property : element.properties) {
            if (property.role == Role::corners) {
                read_polygon(values, property, element.name, out);
                continue;
            }
            if (property.count) {
                const double count = values.next(*property.count, element.name);
                for (std::uint64_t k = 0; static_cast<double>(k) < count; ++k) {
                    static_cast<void>(values.next(property.kind, element.name));
                }
                continue;
            }
            const double value = values.next(property.kind, element.name);
            if (property.role == Role::view) {
                out.view.push_back(value >= 0.0 && value < 4e9 ? static_cast<std::uint32_t>(value) : 0);
            } else if (property.role != Role::other) {
                place[static_cast<std::size_t>(property.role) - 1] = value;
            }
        }
        if (element.name == "vertex") {
            out.xyz.insert(out.xyz.end(), place.begin(), place.end());
        }
    }
}

void require_places(const std::filesystem::path& file, const Element& element) {
    unsigned seen = 0;
    for (const Property& property : element.properties) {
        seen |= 1U << static_cast<unsigned>(property.role);
    }
    if ((seen & 0b1110U) != 0b1110U) {
        throw InputError({.file = file.string(),
                          .line = element.line,
                          .problem = "the element vertex lacks x, y or z",
                          .action = "write the properties x, y and z"});
    }
}

}  // namespace

bool looks_like_ply(std::string_view bytes) noexcept {
    return bytes.starts_with("ply\n") || bytes.starts_with("ply\r\n");
}

PlyContent parse_ply(const std::filesystem::path& file, std::string_view bytes) {
    const Header header = read_header(file, bytes);
    Values values(file, bytes, header);
    PlyContent out;
    for (const Element& element : header.elements) {
        if (element.name == "vertex") {
            require_places(file, element);
            out.vertices = element.count;
            // A wrong count must not take all memory: what is not there is found when it is read.
            out.xyz.reserve(std::min(3 * element.count, bytes.size()));
        }
        read_element(values, element, out);
    }
    return out;
}

}  // namespace sc::host
