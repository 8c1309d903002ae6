// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "shared/codes/codes.hpp"
#include "shared/path/item.hpp"
#include "shared/wire/bytes.hpp"

/// Items as bytes. A block is a sequence of segments and can be decoded without any other block:
///
///     points      01  n  x y z (i32 each)  then (n − 1) × three varints
///     path_begin  02  path u32, actuator u8, pass u8, speed u32, pitch u32, energy u32, tolerance u32, anchor 3 × i32
///     path_end    03
///     turn        04  c i32
///     job_end     05
///     path_arc    06  via x y z (i32 each), to x y z (i32 each)
///     path_light  07  on u8 (0 or 1)
///     stage_curve 08  spacing u32
///     stage_knot  09  x y z (i32 each)
///     look        0A  speed u32, x y z (i32 each)
///
/// Integers are little-endian. A varint is a zigzag number in groups of 7 bits, low group first, of minimal length. The
/// second point of a run is coded as its difference from the first, every later one as the change of that difference:
/// a smooth dense line costs three to four bytes a point.

namespace sc {

inline constexpr std::uint8_t kBlockGrammarVersion = 4;
/// Items that one block may hold, as its count is a byte.
inline constexpr std::size_t kBlockItems = 255;
/// Bytes of the longest single item that begins a block.
inline constexpr std::size_t kLongestItem = 35;

namespace block_tag {
inline constexpr std::uint8_t kPoints = 1;
inline constexpr std::uint8_t kPathBegin = 2;
inline constexpr std::uint8_t kPathEnd = 3;
inline constexpr std::uint8_t kTurn = 4;
inline constexpr std::uint8_t kJobEnd = 5;
inline constexpr std::uint8_t kPathArc = 6;
inline constexpr std::uint8_t kPathLight = 7;
inline constexpr std::uint8_t kStageCurve = 8;
inline constexpr std::uint8_t kStageKnot = 9;
inline constexpr std::uint8_t kLook = 10;
}  // namespace block_tag

/// One coordinate's predictor, the same on both sides: the last place goes on by the last difference.
struct BlockPredictor {
    std::int64_t place = 0;
    std::int64_t difference = 0;
};

struct BlockSize {
    std::size_t items = 0;  ///< how many of the items fitted, from the first
    std::size_t bytes = 0;  ///< how many bytes they took
};

/// Encodes as many items as fit into `out` and into one block. `items` is 0 only if `out` is shorter than the first
/// item, or nothing was given. One pass over what fitted.
[[nodiscard]] BlockSize encode_block(std::span<const Item> items, std::span<std::uint8_t> out) noexcept;

/// Walks through a block's items. Reads nothing outside the bytes; any error is final.
class BlockReader {
public:
    /// `count` is the number of items that the block is said to hold. The bytes must outlive the reader.
    BlockReader(std::span<const std::uint8_t> bytes, std::size_t count) noexcept : in_(bytes), left_(count) {}

    /// True: `out` is the next item. False: the block has ended, with its count met and every byte used.
    /// Refusal::malformed_block: unknown tag, an empty run of points, a varint that is too long or not minimal, a
    /// coordinate that leaves 32 bits, an unknown actuator, a light that is neither on nor off, bytes missing or left
    /// over, more or fewer items than `count`. At most 15 varint bytes of work an item.
    [[nodiscard]] std::expected<bool, Refusal> next(Item& out) noexcept;

private:
    bool read_item(Item& out) noexcept;
    bool read_segment(Item& out) noexcept;
    bool read_path_begin(Item& out) noexcept;
    [[nodiscard]] PathPoint read_place() noexcept;
    bool begin_run(Item& out) noexcept;
    bool continue_run(Item& out) noexcept;

    ByteReader in_;
    std::size_t left_;
    std::size_t run_left_ = 0;
    BlockPredictor x_;
    BlockPredictor y_;
    BlockPredictor z_;
    bool broken_ = false;
};

}  // namespace sc
