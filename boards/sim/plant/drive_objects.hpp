// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "boards/sim/plant/drive_quirks.hpp"

namespace sc::sim {

/// Object dictionary of the simulated drive with its SDO server, expedited and segmented. Values are kept as 32 bits;
/// signed ones are sign-extended by the accessors of the drive.
class ObjectDictionary {
public:
    explicit ObjectDictionary(std::uint8_t node, const DriveQuirks& quirks = {});

    /// Value of an object that exists; 0 for one that does not.
    [[nodiscard]] std::uint32_t get(std::uint16_t index, std::uint8_t sub = 0) const noexcept;
    /// Size in bytes, 0 if there is no such object.
    [[nodiscard]] std::uint8_t size_of(std::uint16_t index, std::uint8_t sub) const noexcept;
    /// From inside the drive: no access check; ignored if there is no such object.
    void set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) noexcept;

    /// Answers one SDO request of 8 bytes. Aborts as CiA 301 says: 0504 0001 command, 0601 0001/0002 access, 0602 0000
    /// no object, 0609 0011 no sub-index, 0607 0010 length, 0609 0030 value, 0604 0041/0042 mapping, 0800 0022 state.
    /// 0503 0000 toggle bit, 0607 0012 too long. A client's abort ends a segmented transfer and is answered with zeros,
    /// which are not to be sent.
    [[nodiscard]] std::array<std::uint8_t, 8> serve(const std::array<std::uint8_t, 8>& request);
    /// A text object; empty if there is none. 1008, 1009 and 100A say what the drive is; 2000 may be written.
    [[nodiscard]] std::string text(std::uint16_t index) const;

private:
    enum class Access : std::uint8_t { read_only, read_write };
    struct Entry {
        std::uint16_t index;
        std::uint8_t sub;
        std::uint8_t size;
        Access access;
        std::uint32_t value;
    };
    struct Text {
        std::uint16_t index;
        Access access;
        std::string value;
    };
    /// A segmented transfer that is under way.
    struct Transfer {
        std::uint16_t index = 0;
        bool upload = false;
        bool toggle = false;
        std::size_t at = 0;
        std::string bytes;
    };
    using Frame = std::array<std::uint8_t, 8>;
    [[nodiscard]] Text* find_text(std::uint16_t index) noexcept;
    [[nodiscard]] Frame begin_upload(Text& text, const Frame& request);
    [[nodiscard]] Frame begin_download(Text& text, const Frame& request);
    [[nodiscard]] Frame upload_segment(const Frame& request);
    [[nodiscard]] Frame download_segment(const Frame& request);
    [[nodiscard]] const Entry* find(std::uint16_t index, std::uint8_t sub) const noexcept;
    [[nodiscard]] Entry* find(std::uint16_t index, std::uint8_t sub) noexcept;
    [[nodiscard]] bool has_index(std::uint16_t index) const noexcept;
    void add_pdo(std::uint16_t communication, std::uint32_t cob_id, Access first_mapping);
    void apply_quirks(std::uint8_t node);
    [[nodiscard]] std::uint32_t check_write(const Entry& entry, std::uint32_t value) const noexcept;
    [[nodiscard]] bool is_period(std::uint32_t us) const noexcept;
    [[nodiscard]] std::uint32_t check_pdo(const Entry& entry, std::uint32_t value) const noexcept;
    [[nodiscard]] std::uint32_t check_mapping(const Entry& entry, std::uint32_t value) const noexcept;

    DriveQuirks quirks_;
    std::vector<Entry> entries_;
    std::vector<Text> texts_;
    Transfer transfer_;
    bool transferring_ = false;
};

}  // namespace sc::sim
