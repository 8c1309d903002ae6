// SPDX-License-Identifier: Apache-2.0
#include "shared/path/block.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "shared/path/item_codec.hpp"

namespace sc {
namespace {

// Coordinates have 32 bits, so differences have 33 and their changes 34 with sign, 35 as zigzag: five groups of seven.
constexpr unsigned kVarintBits = 35;
constexpr std::size_t kRunHeader = 2;

void put_varint(ByteWriter& out, std::int64_t value) noexcept {
    auto zigzag = (static_cast<std::uint64_t>(value) << 1U) ^ static_cast<std::uint64_t>(value >> 63);
    while (zigzag >= 0x80U) {
        out.put(static_cast<std::uint8_t>((zigzag & 0x7FU) | 0x80U));
        zigzag >>= 7U;
    }
    out.put(static_cast<std::uint8_t>(zigzag));
}

std::optional<std::int64_t> get_varint(ByteReader& in) noexcept {
    std::uint64_t zigzag = 0;
    for (unsigned shift = 0; shift < kVarintBits; shift += 7) {
        const auto group = in.get<std::uint8_t>();
        if (!in.ok() || (group == 0 && shift != 0)) {
            return std::nullopt;
        }
        zigzag |= static_cast<std::uint64_t>(group & 0x7FU) << shift;
        if ((group & 0x80U) == 0) {
            return static_cast<std::int64_t>(zigzag >> 1U) ^ -static_cast<std::int64_t>(zigzag & 1U);
        }
    }
    return std::nullopt;
}

/// The change of difference that takes the predictor to `place`.
std::int64_t advance_to(BlockPredictor& p, std::int64_t place) noexcept {
    const std::int64_t difference = place - p.place;
    const std::int64_t change = difference - p.difference;
    p = {place, difference};
    return change;
}

/// The inverse; false when the coordinate leaves its 32 bits.
bool advance_by(BlockPredictor& p, ByteReader& in, std::int32_t& out) noexcept {
    const std::optional<std::int64_t> change = get_varint(in);
    if (!change) {
        return false;
    }
    p.difference += *change;
    p.place += p.difference;
    if (p.place < std::numeric_limits<std::int32_t>::min() || p.place > std::numeric_limits<std::int32_t>::max()) {
        return false;
    }
    out = static_cast<std::int32_t>(p.place);
    return true;
}

class BlockWriter {
public:
    explicit BlockWriter(std::span<std::uint8_t> out) noexcept : out_(out) {}

    /// False when the item does not fit; nothing has been written then.
    bool add(const Item& item) noexcept {
        std::array<std::uint8_t, kLongestItem> scratch{};
        ByteWriter code(scratch);
        const auto* point = std::get_if<PathPoint>(&item);
        const bool starts_run = point != nullptr && run_ == 0;
        std::array<BlockPredictor, 3> next = predictors_;
        if (point != nullptr) {
            starts_run ? begin_run(code, *point, next) : continue_run(code, *point, next);
        } else {
            put_item(code, item);
        }
        if (!code.ok() || code.size() > out_.size() - size_) {
            return false;
        }
        std::copy_n(scratch.begin(), code.size(), out_.begin() + static_cast<std::ptrdiff_t>(size_));
        predictors_ = next;
        count_run(point != nullptr, starts_run);
        size_ += code.size();
        return true;
    }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }

private:
    static void begin_run(ByteWriter& code, const PathPoint& p, std::array<BlockPredictor, 3>& next) noexcept {
        code.put(block_tag::kPoints);
        code.put(std::uint8_t{1});
        code.put(p.x);
        code.put(p.y);
        code.put(p.z);
        next = {BlockPredictor{p.x, 0}, BlockPredictor{p.y, 0}, BlockPredictor{p.z, 0}};
    }
    static void continue_run(ByteWriter& code, const PathPoint& p, std::array<BlockPredictor, 3>& next) noexcept {
        put_varint(code, advance_to(next[0], p.x));
        put_varint(code, advance_to(next[1], p.y));
        put_varint(code, advance_to(next[2], p.z));
    }
    void count_run(bool point, bool starts) noexcept {
        if (starts) {
            run_count_at_ = size_ + kRunHeader - 1;
        }
        run_ = point ? run_ + 1 : 0;
        if (point) {
            out_[run_count_at_] = static_cast<std::uint8_t>(run_);
        }
    }

    std::span<std::uint8_t> out_;
    std::size_t size_ = 0;
    std::size_t run_ = 0;  // points in the open run; at most kBlockItems, so its count is a byte
    std::size_t run_count_at_ = 0;
    std::array<BlockPredictor, 3> predictors_{};
};

}  // namespace

BlockSize encode_block(std::span<const Item> items, std::span<std::uint8_t> out) noexcept {
    BlockWriter writer(out);
    std::size_t done = 0;
    while (done < std::min(items.size(), kBlockItems) && writer.add(items[done])) {
        ++done;
    }
    return {done, writer.size()};
}

std::expected<bool, Refusal> BlockReader::next(Item& out) noexcept {
    if (!broken_ && left_ == 0 && run_left_ == 0 && in_.exhausted()) {
        return false;
    }
    broken_ = broken_ || left_ == 0 || !read_item(out);
    if (broken_) {
        return std::unexpected(Refusal::malformed_block);
    }
    --left_;
    return true;
}

bool BlockReader::read_item(Item& out) noexcept {
    if (run_left_ > 0) {
        --run_left_;
        return continue_run(out);
    }
    return read_segment(out);
}

bool BlockReader::read_segment(Item& out) noexcept {
    switch (in_.get<std::uint8_t>()) {
        case block_tag::kPoints: return begin_run(out);
        case block_tag::kPathBegin: return read_path_begin(out);
        case block_tag::kPathEnd: out = PathEnd{}; return in_.ok();
        case block_tag::kTurn: out = Turn{in_.get<std::int32_t>()}; return in_.ok();
        case block_tag::kJobEnd: out = JobEnd{}; return in_.ok();
        case block_tag::kPathArc: {
            PathArc arc;
            arc.via = read_place();
            arc.to = read_place();
            out = arc;
            return in_.ok();
        }
        case block_tag::kPathLight: {
            const auto on = in_.get<std::uint8_t>();
            out = PathLight{on != 0};
            return in_.ok() && on <= 1;
        }
        case block_tag::kStageCurve: out = StageCurve{in_.get<std::uint32_t>()}; return in_.ok();
        case block_tag::kStageKnot: {
            const PathPoint place = read_place();
            out = StageKnot{place.x, place.y, place.z};
            return in_.ok();
        }
        case block_tag::kLook: {
            const auto speed = in_.get<std::uint32_t>();
            const PathPoint place = read_place();
            out = Look{speed, place.x, place.y, place.z};
            return in_.ok();
        }
        default: return false;
    }
}

bool BlockReader::read_path_begin(Item& out) noexcept {
    PathBegin begin;
    begin.path = in_.get<std::uint32_t>();
    const auto actuator = in_.get<std::uint8_t>();
    begin.actuator = static_cast<Actuator>(actuator);
    begin.pass = in_.get<std::uint8_t>();
    begin.speed_um_s = in_.get<std::uint32_t>();
    begin.pitch_nm = in_.get<std::uint32_t>();
    begin.energy_nj = in_.get<std::uint32_t>();
    begin.tolerance_nm = in_.get<std::uint32_t>();
    begin.anchor_x = in_.get<std::int32_t>();
    begin.anchor_y = in_.get<std::int32_t>();
    begin.anchor_z = in_.get<std::int32_t>();
    out = begin;
    return in_.ok() && actuator <= static_cast<std::uint8_t>(Actuator::split);
}

PathPoint BlockReader::read_place() noexcept {
    PathPoint place;
    place.x = in_.get<std::int32_t>();
    place.y = in_.get<std::int32_t>();
    place.z = in_.get<std::int32_t>();
    return place;
}

bool BlockReader::begin_run(Item& out) noexcept {
    run_left_ = in_.get<std::uint8_t>();
    const PathPoint point = read_place();
    x_ = {point.x, 0};
    y_ = {point.y, 0};
    z_ = {point.z, 0};
    out = point;
    if (!in_.ok() || run_left_ == 0) {
        return false;
    }
    --run_left_;
    return true;
}

bool BlockReader::continue_run(Item& out) noexcept {
    PathPoint point;
    const bool good = advance_by(x_, in_, point.x) && advance_by(y_, in_, point.y) && advance_by(z_, in_, point.z);
    out = point;
    return good;
}

}  // namespace sc
