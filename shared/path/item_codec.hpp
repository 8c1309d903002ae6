// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "shared/path/item.hpp"
#include "shared/wire/bytes.hpp"

namespace sc {

/// Appends one item by itself: its block tag, then its fields as they are; of a point the three coordinates, without
/// differences. It is what a block holds for every item but points.
/// At most 35 bytes; what does not fit shows in `out.ok()`.
void put_item(ByteWriter& out, const Item& item) noexcept;

}  // namespace sc
