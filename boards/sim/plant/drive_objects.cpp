// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_objects.hpp"

#include <algorithm>
#include <utility>

namespace sc::sim {
namespace {

constexpr std::uint32_t kOk = 0;
constexpr std::uint32_t kBadCommand = 0x0504'0001;
constexpr std::uint32_t kReadOnly = 0x0601'0002;
constexpr std::uint32_t kNoObject = 0x0602'0000;
constexpr std::uint32_t kNotMappable = 0x0604'0041;
constexpr std::uint32_t kMappingTooLong = 0x0604'0042;
constexpr std::uint32_t kBadLength = 0x0607'0010;
constexpr std::uint32_t kNoSubIndex = 0x0609'0011;
constexpr std::uint32_t kBadValue = 0x0609'0030;
constexpr std::uint32_t kWrongState = 0x0800'0022;

constexpr std::uint32_t kPdoOff = 0x8000'0000;
constexpr std::uint32_t kPdoIdMask = 0x1FFF'FFFF;
constexpr std::uint32_t kHomingHomeSwitch = 19;
constexpr std::uint32_t kHomingHere = 37;
constexpr std::uint8_t kMappingEntries = 4;

std::uint32_t little_endian(const std::array<std::uint8_t, 8>& bytes, std::size_t at, std::size_t count) noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = count; i > 0; --i) {
        value = (value << 8U) | bytes.at(at + i - 1);
    }
    return value;
}

std::array<std::uint8_t, 8> answer(std::uint8_t command, const std::array<std::uint8_t, 8>& request,
                                   std::uint32_t value) noexcept {
    return {command,
            request[1],
            request[2],
            request[3],
            static_cast<std::uint8_t>(value),
            static_cast<std::uint8_t>(value >> 8U),
            static_cast<std::uint8_t>(value >> 16U),
            static_cast<std::uint8_t>(value >> 24U)};
}

bool is_pdo_communication(std::uint16_t index) noexcept {
    return (index >= 0x1400 && index <= 0x1403) || (index >= 0x1800 && index <= 0x1803);
}
bool is_pdo_mapping(std::uint16_t index) noexcept {
    return (index >= 0x1600 && index <= 0x1603) || (index >= 0x1A00 && index <= 0x1A03);
}

}  // namespace

ObjectDictionary::ObjectDictionary(std::uint8_t node) {
    using enum Access;
    entries_ = {
        {0x1000, 0, 4, read_only, 0x0002'0192}, {0x1001, 0, 1, read_only, 0},
        {0x1006, 0, 4, read_write, 0},          {0x1016, 0, 1, read_only, 1},
        {0x1016, 1, 4, read_write, 0},          {0x1017, 0, 2, read_write, 0},
        {0x1018, 0, 1, read_only, 4},           {0x1018, 1, 4, read_only, 0},
        {0x1018, 2, 4, read_only, 0},           {0x1018, 3, 4, read_only, 1},
        {0x1018, 4, 4, read_only, node},        {0x6007, 0, 2, read_write, 1},
        {0x603F, 0, 2, read_only, 0},           {0x6040, 0, 2, read_write, 0},
        {0x6041, 0, 2, read_only, 0},           {0x605A, 0, 2, read_write, 2},
        {0x6060, 0, 1, read_write, 0},          {0x6061, 0, 1, read_only, 0},
        {0x6064, 0, 4, read_only, 0},           {0x6065, 0, 4, read_write, 0},
        {0x6066, 0, 2, read_write, 0},          {0x607A, 0, 4, read_write, 0},
        {0x607C, 0, 4, read_write, 0},          {0x6085, 0, 4, read_write, 1'000'000},
        {0x6098, 0, 1, read_write, 0},          {0x6099, 0, 1, read_only, 2},
        {0x6099, 1, 4, read_write, 0},          {0x6099, 2, 4, read_write, 0},
        {0x609A, 0, 4, read_write, 1'000'000},  {0x60C2, 0, 1, read_only, 2},
        {0x60C2, 1, 1, read_write, 1},          {0x60C2, 2, 1, read_write, 0xFD},
        {0x60F4, 0, 4, read_only, 0},           {0x6502, 0, 4, read_only, 0xA0},
    };
    for (std::uint16_t n = 0; n < 2; ++n) {
        add_pdo(static_cast<std::uint16_t>(0x1400 + n), 0x200U + 0x100U * n + node, read_write);
        add_pdo(static_cast<std::uint16_t>(0x1800 + n), 0x180U + 0x100U * n + node, read_write);
    }
}

void ObjectDictionary::add_pdo(std::uint16_t communication, std::uint32_t cob_id, Access first_mapping) {
    const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
    entries_.push_back({communication, 0, 1, Access::read_only, 2});
    entries_.push_back({communication, 1, 4, Access::read_write, cob_id | kPdoOff});
    entries_.push_back({communication, 2, 1, Access::read_write, 255});
    for (std::uint8_t sub = 0; sub <= kMappingEntries; ++sub) {
        entries_.push_back({mapping, sub, static_cast<std::uint8_t>(sub == 0 ? 1 : 4), first_mapping, 0});
    }
}

const ObjectDictionary::Entry* ObjectDictionary::find(std::uint16_t index, std::uint8_t sub) const noexcept {
    const auto at = std::ranges::find_if(entries_, [&](const Entry& e) { return e.index == index && e.sub == sub; });
    return at == entries_.end() ? nullptr : &*at;
}
ObjectDictionary::Entry* ObjectDictionary::find(std::uint16_t index, std::uint8_t sub) noexcept {
    return const_cast<Entry*>(std::as_const(*this).find(index, sub));
}
bool ObjectDictionary::has_index(std::uint16_t index) const noexcept {
    return std::ranges::any_of(entries_, [&](const Entry& e) { return e.index == index; });
}

std::uint32_t ObjectDictionary::get(std::uint16_t index, std::uint8_t sub) const noexcept {
    const Entry* entry = find(index, sub);
    return entry == nullptr ? 0 : entry->value;
}
std::uint8_t ObjectDictionary::size_of(std::uint16_t index, std::uint8_t sub) const noexcept {
    const Entry* entry = find(index, sub);
    return entry == nullptr ? 0 : entry->size;
}
void ObjectDictionary::set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) noexcept {
    if (Entry* entry = find(index, sub)) {
        entry->value = value;
    }
}

std::array<std::uint8_t, 8> ObjectDictionary::serve(const std::array<std::uint8_t, 8>& request) {
    const auto abort = [&](std::uint32_t code) { return answer(0x80, request, code); };
    const auto index = static_cast<std::uint16_t>(little_endian(request, 1, 2));
    const std::uint8_t command = request[0];
    const bool upload = command == 0x40;
    const bool download = (command & 0xF3U) == 0x23U;
    if (!upload && !download) {
        return abort(kBadCommand);
    }
    Entry* entry = find(index, request[3]);
    if (entry == nullptr) {
        return abort(has_index(index) ? kNoSubIndex : kNoObject);
    }
    const auto unused = static_cast<std::uint8_t>(4U - entry->size);
    if (upload) {
        return answer(static_cast<std::uint8_t>(0x43U | (static_cast<unsigned>(unused) << 2U)), request, entry->value);
    }
    if (((command >> 2U) & 3U) != unused) {
        return abort(kBadLength);
    }
    const std::uint32_t value = little_endian(request, 4, entry->size);
    if (const std::uint32_t refused = check_write(*entry, value); refused != kOk) {
        return abort(refused);
    }
    entry->value = value;
    return answer(0x60, request, 0);
}

std::uint32_t ObjectDictionary::check_write(const Entry& entry, std::uint32_t value) const noexcept {
    if (entry.access == Access::read_only) {
        return kReadOnly;
    }
    if (is_pdo_communication(entry.index)) {
        return check_pdo(entry, value);
    }
    if (is_pdo_mapping(entry.index)) {
        return check_mapping(entry, value);
    }
    switch (entry.index) {
        case 0x6060: return value == 6 || value == 8 ? kOk : kBadValue;
        case 0x6098: return value == kHomingHomeSwitch || value == kHomingHere ? kOk : kBadValue;
        case 0x605A: return value == 2 ? kOk : kBadValue;
        case 0x60C2: return entry.sub != 1 || value != 0 ? kOk : kBadValue;
        default: return kOk;
    }
}

std::uint32_t ObjectDictionary::check_pdo(const Entry& entry, std::uint32_t value) const noexcept {
    if (entry.sub == 2) {
        return value <= 240 || value >= 254 ? kOk : kBadValue;
    }
    // The identifier may change only while the PDO is off, before and after.
    const bool changes_id = ((entry.value ^ value) & kPdoIdMask) != 0;
    const bool off = ((entry.value | value) & kPdoOff) != 0;
    return !changes_id || off ? kOk : kBadValue;
}

std::uint32_t ObjectDictionary::check_mapping(const Entry& entry, std::uint32_t value) const noexcept {
    if ((get(static_cast<std::uint16_t>(entry.index - 0x200), 1) & kPdoOff) == 0) {
        return kWrongState;
    }
    if (entry.sub != 0) {
        const bool counting = get(entry.index, 0) != 0;
        const std::uint8_t size =
            size_of(static_cast<std::uint16_t>(value >> 16U), static_cast<std::uint8_t>(value >> 8U));
        return counting ? kWrongState : (size != 0 && 8U * size == (value & 0xFFU) ? kOk : kNotMappable);
    }
    if (value > kMappingEntries) {
        return kMappingTooLong;
    }
    std::uint32_t bits = 0;
    for (std::uint32_t sub = 1; sub <= value; ++sub) {
        bits += get(entry.index, static_cast<std::uint8_t>(sub)) & 0xFFU;
    }
    return bits <= 64 ? kOk : kMappingTooLong;
}

}  // namespace sc::sim
