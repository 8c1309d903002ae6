// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/link/messages.hpp"
#include "shared/path/block.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::link {

/// Fills a message's run of bytes with as many of the items as fit into `capacity`; how many that is. 0 only for no
/// items.
[[nodiscard]] inline std::size_t encode_block(std::span<const Item> items, Bytes& out,
                                              std::size_t capacity = sizeof(Bytes::data)) noexcept {
    const BlockSize size = sc::encode_block(items, std::span<std::uint8_t>(out.data).first(capacity));
    out.size = static_cast<std::uint8_t>(size.bytes);
    return size.items;
}

/// The block message that begins with items[first] of a job and holds as many items as fit. `first` must be an index
/// into `items`.
[[nodiscard]] inline Block make_block(std::uint64_t job, std::span<const Item> items, std::uint32_t first,
                                      std::size_t capacity = sizeof(Bytes::data)) noexcept {
    Block block;
    block.job_low = static_cast<std::uint32_t>(job & 0xFFFFFFFFU);
    block.first = first;
    block.count = static_cast<std::uint8_t>(encode_block(items.subspan(first), block.items, capacity));
    return block;
}

/// A block message whose items stay where they came in.
struct BlockView {
    std::uint32_t job_low = 0;
    std::uint32_t first = 0;
    std::uint8_t count = 0;
    std::span<const std::uint8_t> items;
};
[[nodiscard]] inline BlockView view_of(const Block& block) noexcept {
    return {block.job_low, block.first, block.count, std::span(block.items.data).first(block.items.size)};
}
/// The same from a message's payload, without copying; nothing if that is no block's.
[[nodiscard]] inline std::optional<BlockView> view_block(std::span<const std::uint8_t> payload) noexcept {
    ByteReader in(payload);
    BlockView view;
    view.job_low = in.get<std::uint32_t>();
    view.first = in.get<std::uint32_t>();
    view.count = in.get<std::uint8_t>();
    view.items = in.get_bytes(in.get<std::uint8_t>());
    return in.exhausted() ? std::optional(view) : std::nullopt;
}

/// Reader of the block's items; the block must outlive it.
[[nodiscard]] inline BlockReader read_block(const Block& block) noexcept {
    return {std::span(block.items.data).first(block.items.size), block.count};
}

}  // namespace sc::link
