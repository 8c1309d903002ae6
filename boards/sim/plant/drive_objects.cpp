// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_objects.hpp"

#include <algorithm>
#include <utility>

namespace sc::sim {
namespace {

constexpr std::uint32_t kOk = 0;
constexpr std::uint32_t kReadOnly = 0x0601'0002;
constexpr std::uint32_t kNotMappable = 0x0604'0041;
constexpr std::uint32_t kMappingTooLong = 0x0604'0042;
constexpr std::uint32_t kBadValue = 0x0609'0030;
constexpr std::uint32_t kWrongState = 0x0800'0022;

constexpr std::uint32_t kPdoOff = 0x8000'0000;
constexpr std::uint32_t kPdoIdMask = 0x1FFF'FFFF;
constexpr std::uint32_t kNoRemoteRequest = 0x4000'0000;
constexpr std::uint32_t kLongestPeriodUs = 20'000;
constexpr std::uint8_t kMappingEntries = 4;

bool is_pdo_communication(std::uint16_t index) noexcept {
    return (index >= 0x1400 && index <= 0x1403) || (index >= 0x1800 && index <= 0x1803);
}
bool is_pdo_mapping(std::uint16_t index) noexcept {
    return (index >= 0x1600 && index <= 0x1603) || (index >= 0x1A00 && index <= 0x1A03);
}

bool is_homing_method(std::uint32_t value) noexcept {
    const auto low = static_cast<int>(value & 0xFFU);
    const int method = low < 128 ? low : low - 256;
    const bool switches = (method >= 17 && method <= 22) || method == 1 || method == 2;
    return switches || (method >= -4 && method <= -1) || method == 33 || method == 34 || method == 35 || method == 37;
}

}  // namespace

ObjectDictionary::ObjectDictionary(std::uint8_t node, const DriveQuirks& quirks) : quirks_(quirks) {
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
        {0x60FE, 0, 1, read_only, 2},           {0x60FE, 1, 4, read_write, 0},
        {0x60FE, 2, 4, read_write, 0},          {0x60FD, 0, 4, read_only, 0},
        {0x1003, 0, 1, read_write, 0},          {0x1003, 1, 4, read_only, 0},
    };
    texts_ = {{0x1008, read_only, "scribecell simulated servo drive"},
              {0x1009, read_only, "1.0"},
              {0x100A, read_only, "CiA 402 CSP and homing"},
              {0x2000, read_write, "axis"}};
    for (std::uint16_t n = 0; n < 2; ++n) {
        add_pdo(static_cast<std::uint16_t>(0x1400 + n), 0x200U + 0x100U * n + node, read_write);
        add_pdo(static_cast<std::uint16_t>(0x1800 + n), 0x180U + 0x100U * n + node, read_write);
    }
    apply_quirks(node);
}

void ObjectDictionary::apply_quirks(std::uint8_t node) {
    if (quirks_.no_period) {
        set(0x60C2, 1, 0);
        set(0x60C2, 2, 0);
    }
    if (quirks_.no_6007) {
        std::erase_if(entries_, [](const Entry& e) { return e.index == 0x6007 || e.index == 0x1006; });
    }
    if (quirks_.bit_30) {
        for (const std::uint16_t index : std::array<std::uint16_t, 4>{0x1400, 0x1401, 0x1800, 0x1801}) {
            set(index, 1, get(index, 1) | kNoRemoteRequest);
        }
    }
    if (quirks_.event_driven) {
        set(0x1800, 1, 0x180U + node + (quirks_.bit_30 ? kNoRemoteRequest : 0U));
        set(0x1A00, 1, 0x6041'0010);
        set(0x1A00, 0, 1);
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
        case 0x6098: return is_homing_method(value) ? kOk : kBadValue;
        case 0x1006: return is_period(value) ? kOk : kBadValue;
        case 0x605A: return value == 2 ? kOk : kBadValue;
        case 0x60C2: return entry.sub != 1 || value != 0 ? kOk : kBadValue;
        default: return kOk;
    }
}

bool ObjectDictionary::is_period(std::uint32_t us) const noexcept {
    return quirks_.period_step_us == 0 || (us % quirks_.period_step_us == 0 && us <= kLongestPeriodUs);
}

std::uint32_t ObjectDictionary::check_pdo(const Entry& entry, std::uint32_t value) const noexcept {
    if (entry.sub == 2) {
        return value <= 240 || value >= 254 ? kOk : kBadValue;
    }
    if (quirks_.bit_30 && entry.index >= 0x1800 && (value & kNoRemoteRequest) == 0) {
        return kBadValue;
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
        const bool dummy = value >> 8U == 0x0007'00 && !quirks_.no_dummy && entry.index < 0x1800;
        const std::uint8_t size =
            dummy ? std::uint8_t{4}
                  : size_of(static_cast<std::uint16_t>(value >> 16U), static_cast<std::uint8_t>(value >> 8U));
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
