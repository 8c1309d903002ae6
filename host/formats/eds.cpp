// SPDX-License-Identifier: Apache-2.0
#include "host/formats/eds.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <limits>
#include <utility>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

constexpr unsigned kVariable = 7;
constexpr unsigned kArray = 8;
constexpr unsigned kRecord = 9;
constexpr unsigned kDomain = 2;

std::string lower(std::string_view text) {
    std::string out(text);
    std::ranges::transform(out, out.begin(),
                           [](char c) { return (c >= 'A' && c <= 'Z') ? static_cast<char>(c + 32) : c; });
    return out;
}

struct Entry {
    std::string value;
    int line = 0;
};
struct Section {
    int line = 0;
    std::map<std::string, Entry> entries;  ///< by key in lower case
};

/// One place of the file, for messages.
struct Place {
    const std::filesystem::path* file;
    int line;
};
[[noreturn]] void refuse(const Place& place, std::string problem, std::string_view value, std::string action) {
    throw InputError({.file = place.file->string(),
                      .line = place.line,
                      .problem = std::move(problem),
                      .value = shortened(value),
                      .action = std::move(action)});
}

std::optional<std::int64_t> plain_number(std::string_view text) {
    const bool negative = text.starts_with('-');
    if (negative) {
        text.remove_prefix(1);
    }
    int base = 10;
    if (text.starts_with("0x") || text.starts_with("0X")) {
        base = 16;
        text.remove_prefix(2);
    } else if (text.size() > 1 && text.front() == '0') {
        base = 8;
    }
    std::uint64_t value = 0;
    const char* const begin = text.data();
    const char* const end = begin + text.size();
    const auto [next, error] = std::from_chars(begin, end, value, base);
    if (text.empty() || error != std::errc{} || next != end || value > std::uint64_t{INT64_MAX}) {
        return std::nullopt;
    }
    const auto found = static_cast<std::int64_t>(value);
    return negative ? -found : found;
}

/// $NODEID+number, number+$NODEID, $NODEID or a number.
std::optional<EdsNumber> number_of(std::string_view text) {
    constexpr std::string_view kNode = "$nodeid";
    const std::string small = lower(text);
    const std::size_t at = small.find(kNode);
    if (at == std::string::npos) {
        const auto value = plain_number(text);
        return value ? std::optional(EdsNumber{false, *value}) : std::nullopt;
    }
    std::string_view rest = text;
    if (at == 0) {
        rest = trimmed(rest.substr(kNode.size()));
        if (rest.empty()) {
            return EdsNumber{true, 0};
        }
        if (!rest.starts_with('+')) {
            return std::nullopt;
        }
        rest = trimmed(rest.substr(1));
    } else {
        if (at + kNode.size() != text.size()) {
            return std::nullopt;
        }
        rest = trimmed(rest.substr(0, at));
        if (!rest.ends_with('+')) {
            return std::nullopt;
        }
        rest = trimmed(rest.substr(0, rest.size() - 1));
    }
    const auto value = plain_number(rest);
    return value ? std::optional(EdsNumber{true, *value}) : std::nullopt;
}

class Reader {
public:
    Reader(const std::filesystem::path& file, std::string_view text) {
        eds_.file = file;
        split(text);
        read_device();
        read_objects();
        compare_lists();
        if (eds_.objects.empty()) {
            refuse(at(0), "no objects are in this file", "", "give the electronic data sheet (.eds) of the drive");
        }
    }
    [[nodiscard]] Eds take() { return std::move(eds_); }

private:
    [[nodiscard]] Place at(int line) const { return {&eds_.file, line}; }
    void note(int line, std::string text) { eds_.notes.push_back({line, std::move(text)}); }

    void split(std::string_view text);
    void take_line(std::string_view line, int number);
    void read_device();
    void read_objects();
    void read_object(std::uint16_t index, const Section& section);
    void read_parts(std::uint16_t index, const Section& section);
    void read_compact(std::uint16_t index, const Section& section, std::int64_t count);
    [[nodiscard]] EdsObject variable(const Section& section);
    void compare_lists();

    [[nodiscard]] static const Entry* entry(const Section& section, const std::string& key) {
        const auto found = section.entries.find(key);
        return found == section.entries.end() || found->second.value.empty() ? nullptr : &found->second;
    }
    /// A number that has to be one; nothing where the key is not there.
    [[nodiscard]] std::optional<std::int64_t> whole(const Section& section, const std::string& key) const {
        const Entry* found = entry(section, key);
        if (found == nullptr) {
            return std::nullopt;
        }
        const auto value = plain_number(found->value);
        if (!value) {
            refuse(at(found->line), key + " is no number", found->value, "write it as 12, 0x0C or 014");
        }
        return value;
    }
    /// A default or limit: text is no fault where the object holds text.
    [[nodiscard]] std::optional<EdsNumber> relative(const Section& section, const std::string& key,
                                                    const EdsObject& object) const;

    Eds eds_;
    std::map<std::string, Section> sections_;  ///< by name in lower case
    std::string open_;
};

void Reader::split(std::string_view text) {
    constexpr std::string_view kMark = "\xEF\xBB\xBF";
    if (text.starts_with(kMark)) {
        text.remove_prefix(kMark.size());
    }
    int number = 0;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        take_line(trimmed(text.substr(0, end)), ++number);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
}

void Reader::take_line(std::string_view line, int number) {
    if (line.empty() || line.front() == ';' || line.front() == '#') {
        return;
    }
    if (line.front() == '[') {
        if (line.back() != ']') {
            refuse(at(number), "the name of a section has no end", line, "close it with ]");
        }
        open_ = lower(trimmed(line.substr(1, line.size() - 2)));
        const auto [place, fresh] = sections_.try_emplace(open_);
        if (!fresh) {
            refuse(at(number), "this section is there twice, first in line " + std::to_string(place->second.line),
                   open_, "take one of them out");
        }
        place->second.line = number;
        return;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) {
        refuse(at(number), "neither a section nor key=value", line, "correct the line, or make it a comment with ;");
    }
    if (open_.empty()) {
        refuse(at(number), "a value before the first section", line, "begin with [FileInfo]");
    }
    const std::string key = lower(trimmed(line.substr(0, equals)));
    const auto [place, fresh] =
        sections_[open_].entries.try_emplace(key, Entry{std::string(trimmed(line.substr(equals + 1))), number});
    if (!fresh) {
        refuse(at(number),
               "this key is there twice in its section, first in line " + std::to_string(place->second.line), key,
               "take one of them out");
    }
}

void Reader::read_device() {
    if (const auto device = sections_.find("deviceinfo"); device != sections_.end()) {
        const auto text = [&device](const char* key) {
            const Entry* found = entry(device->second, key);
            return found == nullptr ? std::string() : found->value;
        };
        eds_.vendor = text("vendorname");
        eds_.product = text("productname");
        eds_.vendor_number = static_cast<std::uint32_t>(whole(device->second, "vendornumber").value_or(0));
        eds_.product_number = static_cast<std::uint32_t>(whole(device->second, "productnumber").value_or(0));
        for (const std::uint32_t rate : {10U, 20U, 50U, 125U, 250U, 500U, 800U, 1000U}) {
            if (whole(device->second, "baudrate_" + std::to_string(rate)).value_or(0) != 0) {
                eds_.baud_rates.push_back(rate * 1000);
            }
        }
    }
    if (const auto dummies = sections_.find("dummyusage"); dummies != sections_.end()) {
        for (std::size_t type = 1; type < eds_.dummy.size(); ++type) {
            eds_.dummy[type] = whole(dummies->second, "dummy000" + std::to_string(type)).value_or(0) != 0;
        }
    }
}

/// "1a00" or "1a00sub1" (its part); nothing for any other section.
struct Name {
    std::uint16_t index = 0;
    std::optional<std::uint8_t> sub;
};
std::optional<Name> object_name(std::string_view section) {
    constexpr std::size_t kDigits = 4;
    constexpr std::string_view kSub = "sub";
    if (section.size() < kDigits) {
        return std::nullopt;
    }
    const auto hex = [](std::string_view digits, auto& value) {
        const char* const begin = digits.data();
        const char* const end = begin + digits.size();
        const auto [next, error] = std::from_chars(begin, end, value, 16);
        return !digits.empty() && error == std::errc{} && next == end;
    };
    Name name;
    if (!hex(section.substr(0, kDigits), name.index)) {
        return std::nullopt;
    }
    section.remove_prefix(kDigits);
    if (section.empty()) {
        return name;
    }
    std::uint8_t sub = 0;
    if (!section.starts_with(kSub) || !hex(section.substr(kSub.size()), sub)) {
        return std::nullopt;
    }
    name.sub = sub;
    return name;
}

void Reader::read_objects() {
    for (const auto& [name, section] : sections_) {
        const auto object = object_name(name);
        if (object && !object->sub) {
            read_object(object->index, section);
        }
    }
    for (const auto& [name, section] : sections_) {
        const auto object = object_name(name);
        if (object && object->sub && !eds_.has(object->index)) {
            refuse(at(section.line), "a part of an object that is not there", name,
                   "add the section [" + name.substr(0, 4) + "]");
        }
    }
}

void Reader::read_object(std::uint16_t index, const Section& section) {
    eds_.sections.emplace(index, section.line);
    const std::int64_t kind = whole(section, "objecttype").value_or(kVariable);
    const std::int64_t compact = whole(section, "compactsubobj").value_or(0);
    if (compact > 0) {
        read_compact(index, section, compact);
    } else if (kind == kArray || kind == kRecord) {
        read_parts(index, section);
    } else if (kind == kVariable || kind == kDomain) {
        eds_.objects.emplace(EdsKey{index, 0}, variable(section));
    } else {
        note(section.line, "object " + eds_text({index, 0}) + " is of the unknown kind " + std::to_string(kind));
    }
}

void Reader::read_parts(std::uint16_t index, const Section& section) {
    std::array<char, 16> name{};
    std::int64_t found = 0;
    for (unsigned sub = 0; sub <= 0xFF; ++sub) {
        std::snprintf(name.data(), name.size(), "%04xsub%x", unsigned{index}, sub);
        const auto part = sections_.find(name.data());
        if (part != sections_.end()) {
            eds_.objects.emplace(EdsKey{index, static_cast<std::uint8_t>(sub)}, variable(part->second));
            ++found;
        }
    }
    const auto stated = whole(section, "subnumber");
    if (stated && *stated != found) {
        note(section.line, "object " + eds_text({index, 0}) + " says that it has " + std::to_string(*stated) +
                               " parts, and has " + std::to_string(found));
    }
}

/// An array whose parts are all alike, and have no sections.
void Reader::read_compact(std::uint16_t index, const Section& section, std::int64_t count) {
    constexpr std::int64_t kMost = 254;
    constexpr std::uint16_t kU8 = 5;
    if (count > kMost) {
        refuse(at(section.line), "an array has 254 parts at most", std::to_string(count), "correct CompactSubObj");
    }
    const EdsObject part = variable(section);
    EdsObject head;
    head.name = "Highest sub-index";
    head.type = kU8;
    head.access = EdsAccess::read_only;
    head.standard = EdsNumber{false, count};
    head.line = section.line;
    eds_.objects.emplace(EdsKey{index, 0}, head);
    for (std::int64_t sub = 1; sub <= count; ++sub) {
        eds_.objects.emplace(EdsKey{index, static_cast<std::uint8_t>(sub)}, part);
    }
}

EdsObject Reader::variable(const Section& section) {
    EdsObject object;
    object.line = section.line;
    if (const Entry* name = entry(section, "parametername")) {
        object.name = name->value;
    }
    const auto type = whole(section, "datatype");
    if (type && (*type < 0 || *type > std::int64_t{std::numeric_limits<std::uint16_t>::max()})) {
        refuse(at(section.entries.at("datatype").line), "there is no such data type", std::to_string(*type),
               "write a type of CiA 301, 0x0001 to 0x001B");
    }
    object.type = static_cast<std::uint16_t>(type.value_or(0));
    if (const Entry* access = entry(section, "accesstype")) {
        const std::string word = lower(access->value);
        if (word == "ro") {
            object.access = EdsAccess::read_only;
        } else if (word == "wo") {
            object.access = EdsAccess::write_only;
        } else if (word == "const") {
            object.access = EdsAccess::constant;
        } else if (word != "rw" && word != "rwr" && word != "rww") {
            refuse(at(access->line), "there is no such access", access->value, "write ro, wo, rw, rwr, rww or const");
        }
    }
    object.may_be_mapped = whole(section, "pdomapping").value_or(0) != 0;
    object.standard = relative(section, "defaultvalue", object);
    object.least = relative(section, "lowlimit", object);
    object.most = relative(section, "highlimit", object);
    return object;
}

std::optional<EdsNumber> Reader::relative(const Section& section, const std::string& key,
                                          const EdsObject& object) const {
    const Entry* found = entry(section, key);
    if (found == nullptr) {
        return std::nullopt;
    }
    auto number = number_of(found->value);
    if (!number && object.size() > 0) {
        refuse(at(found->line), key + " is no number", found->value, "write it as 12, 0x0C, 014 or $NODEID+0x0C");
    }
    // 0xFFFFFFFF of a signed object is -1.
    const int bits = object.size() * 8;
    if (number && object.is_signed() && bits > 0 && bits < 64 && number->value >= (std::int64_t{1} << (bits - 1)) &&
        number->value < (std::int64_t{1} << bits)) {
        number->value -= std::int64_t{1} << bits;
    }
    return number;
}

/// The lists of the file say which objects there are. A drive's maker edits one and forgets the other.
void Reader::compare_lists() {
    std::map<std::uint16_t, int> listed;
    bool lists = false;
    for (const char* name : {"mandatoryobjects", "optionalobjects", "manufacturerobjects"}) {
        const auto list = sections_.find(name);
        if (list == sections_.end()) {
            continue;
        }
        lists = true;
        std::int64_t count = 0;
        for (const auto& [key, found] : list->second.entries) {
            if (!plain_number(key)) {
                continue;
            }
            ++count;
            const auto index = plain_number(found.value);
            if (!index || *index < 0 || *index > 0xFFFF) {
                refuse(at(found.line), "a list names an object that cannot be", found.value,
                       "write its index as 0x1000 to 0xFFFF");
            }
            listed.emplace(static_cast<std::uint16_t>(*index), found.line);
            if (!eds_.has(static_cast<std::uint16_t>(*index))) {
                note(found.line,
                     "object " + eds_text({static_cast<std::uint16_t>(*index), 0}) + " is listed, but has no section");
            }
        }
        const auto stated = whole(list->second, "supportedobjects");
        if (stated && *stated != count) {
            note(list->second.line, "the list says that it has " + std::to_string(*stated) + " objects, and names " +
                                        std::to_string(count));
        }
    }
    for (const auto& [index, line] : eds_.sections) {
        if (lists && !listed.contains(index)) {
            note(line, "object " + eds_text({index, 0}) + " has a section, but is in no list");
        }
    }
    std::ranges::sort(eds_.notes, {}, &EdsNote::line);
}

}  // namespace

int EdsObject::size() const noexcept {
    switch (type) {
        case 0x01:
        case 0x02:
        case 0x05: return 1;
        case 0x03:
        case 0x06: return 2;
        case 0x10:
        case 0x16: return 3;
        case 0x04:
        case 0x07: return 4;
        default: return 0;
    }
}

bool EdsObject::is_signed() const noexcept { return type == 0x02 || type == 0x03 || type == 0x04 || type == 0x10; }

const EdsObject* Eds::find(std::uint16_t index, std::uint8_t sub) const {
    const auto found = objects.find({index, sub});
    return found == objects.end() ? nullptr : &found->second;
}

Eds read_eds(const std::filesystem::path& file) { return parse_eds(file, read_text_file(file)); }

Eds parse_eds(const std::filesystem::path& file, std::string_view text) { return Reader(file, text).take(); }

std::string eds_text(const EdsKey& key) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), key.sub == 0 ? "%04X" : "%04X:%X", unsigned{key.index}, unsigned{key.sub});
    return text.data();
}

}  // namespace sc::host
