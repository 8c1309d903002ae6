// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/link/messages.hpp"
#include "shared/path/block.hpp"

namespace sc::link {

/// Fills a message's run of bytes with as many of the items as fit; how many that is. 0 only for no items.
[[nodiscard]] inline std::size_t encode_block(std::span<const Item> items, Bytes& out) noexcept {
    const BlockSize size = sc::encode_block(items, std::span<std::uint8_t>(out.data));
    out.size = static_cast<std::uint8_t>(size.bytes);
    return size.items;
}

/// The block message that begins with items[first] of a job and holds as many items as fit. `first` must be an index
/// into `items`.
[[nodiscard]] inline Block make_block(std::uint64_t job, std::span<const Item> items, std::uint32_t first) noexcept {
    Block block;
    block.job_low = static_cast<std::uint32_t>(job & 0xFFFFFFFFU);
    block.first = first;
    block.count = static_cast<std::uint8_t>(encode_block(items.subspan(first), block.items));
    return block;
}

/// Reader of the block's items; the block must outlive it.
[[nodiscard]] inline BlockReader read_block(const Block& block) noexcept {
    return {std::span(block.items.data).first(block.items.size), block.count};
}

}  // namespace sc::link
