// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/path/block.hpp"

namespace sc {

/// The count and the whole of a block are right, as a reader finds it.
inline bool block_is_sound(std::span<const std::uint8_t> bytes, std::size_t count) {
    BlockReader reader(bytes, count);
    Item item;
    while (true) {
        const auto step = reader.next(item);
        if (!step || !*step) {
            return step.has_value();
        }
    }
}

}  // namespace sc
