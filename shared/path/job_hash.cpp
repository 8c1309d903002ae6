// SPDX-License-Identifier: Apache-2.0
#include "shared/path/job_hash.hpp"

#include <array>

#include "shared/path/block.hpp"
#include "shared/path/item_codec.hpp"

namespace sc {
void JobHasher::add(const Item& item) noexcept {
    std::array<std::uint8_t, kLongestItem> code{};
    ByteWriter writer(code);
    put_item(writer, item);
    hash_.update(writer.written());
}

std::uint64_t job_hash(std::span<const Item> items) noexcept {
    JobHasher hasher;
    for (const Item& item : items) {
        hasher.add(item);
    }
    return hasher.value();
}

}  // namespace sc
