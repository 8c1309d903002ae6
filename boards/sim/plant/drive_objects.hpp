// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace sc::sim {

/// Object dictionary of the simulated drive with its expedited SDO server. Values are kept as 32 bits; signed ones are
/// sign-extended by the accessors of the drive.
class ObjectDictionary {
public:
    explicit ObjectDictionary(std::uint8_t node);

    /// Value of an object that exists; 0 for one that does not.
    [[nodiscard]] std::uint32_t get(std::uint16_t index, std::uint8_t sub = 0) const noexcept;
    /// Size in bytes, 0 if there is no such object.
    [[nodiscard]] std::uint8_t size_of(std::uint16_t index, std::uint8_t sub) const noexcept;
    /// From inside the drive: no access check; ignored if there is no such object.
    void set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) noexcept;

    /// Answers one SDO request of 8 bytes. Aborts as CiA 301 says: 0504 0001 command, 0601 0001/0002 access, 0602 0000
    /// no object, 0609 0011 no sub-index, 0607 0010 length, 0609 0030 value, 0604 0041/0042 mapping, 0800 0022 state.
    [[nodiscard]] std::array<std::uint8_t, 8> serve(const std::array<std::uint8_t, 8>& request);

private:
    enum class Access : std::uint8_t { read_only, read_write };
    struct Entry {
        std::uint16_t index;
        std::uint8_t sub;
        std::uint8_t size;
        Access access;
        std::uint32_t value;
    };
    [[nodiscard]] const Entry* find(std::uint16_t index, std::uint8_t sub) const noexcept;
    [[nodiscard]] Entry* find(std::uint16_t index, std::uint8_t sub) noexcept;
    [[nodiscard]] bool has_index(std::uint16_t index) const noexcept;
    void add_pdo(std::uint16_t communication, std::uint32_t cob_id, Access first_mapping);
    [[nodiscard]] std::uint32_t check_write(const Entry& entry, std::uint32_t value) const noexcept;
    [[nodiscard]] std::uint32_t check_pdo(const Entry& entry, std::uint32_t value) const noexcept;
    [[nodiscard]] std::uint32_t check_mapping(const Entry& entry, std::uint32_t value) const noexcept;

    std::vector<Entry> entries_;
};

}  // namespace sc::sim
