// SPDX-License-Identifier: Apache-2.0
#include "shared/link/map_codec.hpp"

#include "shared/hash/crc.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::link {
namespace {

// Structured bindings name every member: one that is added breaks the build here and not the machine.
template <class Visitor, class Map>
constexpr void visit_map(Visitor& v, Map& m) noexcept {
    auto& [first, spacing, linear, turn, pivot, backlash, take_up] = m;
    v(first), v(spacing);
    for (auto& of : linear) {
        for (auto& along : of) {
            v(along);
        }
    }
    for (auto& table : turn) {
        v(table);
    }
    v(pivot.x), v(pivot.y), v(pivot.z);
    v(backlash), v(take_up);
}

struct Writer {
    ByteWriter& out;
    template <WireNumber T>
    void operator()(const T& value) noexcept {
        out.put(value);
    }
    template <WireNumber T, std::size_t N>
    void operator()(const std::array<T, N>& values) noexcept {
        for (const T& value : values) {
            out.put(value);
        }
    }
};
/// The CRC of what a Writer would write, number by number: a map is too large for a stack.
struct Summer {
    Crc32& crc;
    template <WireNumber T>
    void operator()(const T& value) noexcept {
        std::array<std::uint8_t, sizeof(T)> bytes{};
        ByteWriter out(bytes);
        out.put(value);
        crc.update(bytes);
    }
    template <WireNumber T, std::size_t N>
    void operator()(const std::array<T, N>& values) noexcept {
        for (const T& value : values) {
            (*this)(value);
        }
    }
};
struct Reader {
    ByteReader& in;
    template <WireNumber T>
    void operator()(T& value) noexcept {
        value = in.get<T>();
    }
    template <WireNumber T, std::size_t N>
    void operator()(std::array<T, N>& values) noexcept {
        for (T& value : values) {
            value = in.get<T>();
        }
    }
};

}  // namespace

void serialise(const AxisMap& map, std::span<std::uint8_t, kMapSize> out) noexcept {
    ByteWriter bytes(out);
    bytes.put(kMapVersion);
    Writer writer{bytes};
    visit_map(writer, map);
}

bool deserialise_map(std::span<const std::uint8_t> bytes, AxisMap& map) noexcept {
    ByteReader in(bytes);
    if (in.get<std::uint16_t>() != kMapVersion) {
        return false;
    }
    Reader reader{in};
    visit_map(reader, map);
    return in.exhausted();
}

std::uint32_t map_crc(const AxisMap& map) noexcept {
    if (map.is_identity()) {
        return 0;
    }
    Crc32 crc;
    Summer summer{crc};
    summer(kMapVersion);
    visit_map(summer, map);
    return crc.value();
}

}  // namespace sc::link
