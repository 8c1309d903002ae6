// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Electronic data sheet of a CANopen device (CiA 306): what objects it has, of which type, and what may be done with
/// them. Only what is written is kept: a default may be absent. Host only.

namespace sc::host {

/// A number of an EDS: decimal, 0x hexadecimal, 0 octal, or $NODEID+number.
struct EdsNumber {
    bool node_relative = false;  ///< the node's number is to be added
    std::int64_t value = 0;
    [[nodiscard]] std::int64_t at(std::uint8_t node) const noexcept { return value + (node_relative ? node : 0); }
    bool operator==(const EdsNumber&) const = default;
};

struct EdsKey {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;  ///< 0 for an object without parts, too
    auto operator<=>(const EdsKey&) const = default;
};

enum class EdsAccess : std::uint8_t { read_only, write_only, read_write, constant };

/// An object without parts, or one part of an array or a record.
struct EdsObject {
    std::string name;
    std::uint16_t type = 0;  ///< CiA 301: 2 i8, 3 i16, 4 i32, 5 u8, 6 u16, 7 u32, 8 float, 9 text ...
    EdsAccess access = EdsAccess::read_write;
    bool may_be_mapped = false;         ///< into a PDO
    std::optional<EdsNumber> standard;  ///< value after a reset, where the file says one that is a number
    std::optional<EdsNumber> least;
    std::optional<EdsNumber> most;
    int line = 0;  ///< of its section
    [[nodiscard]] bool readable() const noexcept { return access != EdsAccess::write_only; }
    [[nodiscard]] bool writable() const noexcept {
        return access == EdsAccess::write_only || access == EdsAccess::read_write;
    }
    /// Bytes of a value; 0: none that fits an expedited transfer by its type (text, domain, 64 bit).
    [[nodiscard]] int size() const noexcept;
    [[nodiscard]] bool is_signed() const noexcept;
};

/// Something odd that does not keep the file from being read.
struct EdsNote {
    int line = 0;
    std::string text;
};

struct Eds {
    std::filesystem::path file;
    std::string vendor;
    std::string product;
    std::uint32_t vendor_number = 0;  ///< as 1018:1 has it; 0: not said
    std::uint32_t product_number = 0;
    std::vector<std::uint32_t> baud_rates;  ///< bit/s, that it says it can; empty: none stated
    std::array<bool, 8> dummy{};            ///< [DummyUsage]: type 1 to 7 may fill a place of an RPDO
    std::map<EdsKey, EdsObject> objects;    ///< parts of arrays and records, and objects without parts
    std::map<std::uint16_t, int> sections;  ///< of each object, by its line
    std::vector<EdsNote> notes;

    [[nodiscard]] const EdsObject* find(std::uint16_t index, std::uint8_t sub = 0) const;
    [[nodiscard]] bool has(std::uint16_t index) const { return sections.contains(index); }
};

/// Throws InputError with file and line: a line that is none of an EDS, a section or key that is there twice, a number
/// that is none, a part without its object, a file without objects.
[[nodiscard]] Eds read_eds(const std::filesystem::path& file);
[[nodiscard]] Eds parse_eds(const std::filesystem::path& file, std::string_view text);

/// "6040", "1A00:1".
[[nodiscard]] std::string eds_text(const EdsKey& key);

}  // namespace sc::host
