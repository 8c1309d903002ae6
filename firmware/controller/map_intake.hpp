// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/hash/crc.hpp"
#include "shared/link/map_codec.hpp"

namespace sc {

/// Collects the pieces of an axis map, or of parameters to store, until they are whole. Servo context: proportional to
/// the bytes of a piece; `map` reads all 2 kB, for a tick that moves nothing.
class MapIntake {
public:
    /// Bytes from an offset on; 0 begins anew. False, and nothing taken, for any other that is not `size()`, and for
    /// more bytes than a map has.
    [[nodiscard]] bool take(std::size_t offset, std::span<const std::uint8_t> bytes) noexcept {
        if ((offset != 0 && offset != size_) || bytes.size() > bytes_.size() - offset) {
            return false;
        }
        if (offset == 0) {
            crc_ = {};
        }
        std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
        size_ = offset + bytes.size();
        crc_.update(bytes);
        return true;
    }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] bool whole(std::size_t bytes, std::uint32_t crc) const noexcept {
        return size_ == bytes && crc_.value() == crc;
    }
    /// What has come; stays as it is until the next `take`.
    [[nodiscard]] std::span<const std::uint8_t> bytes() const noexcept { return std::span(bytes_).first(size_); }
    /// Null when the bytes are no map of this version.
    [[nodiscard]] const AxisMap* map() noexcept {
        return link::deserialise_map(std::span(bytes_).first(size_), map_) ? &map_ : nullptr;
    }

private:
    link::MapBytes bytes_{};
    AxisMap map_;
    std::size_t size_ = 0;
    Crc32 crc_;
};

}  // namespace sc
