// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/codes/codes.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/messages.hpp"
#include "shared/path/block.hpp"
#include "shared/path/item_queue.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::link {

/// What is left out to show what it earns (scribecell bench link); a controller has all of it.
struct StreamRules {
    bool keeps_ahead =
        true;  ///< false: a block behind a gap is dropped, and all behind the gap comes again (go-back-n)
    bool checks_index = true;  ///< false: items are taken as they come
};

/// The receiving end of one job's items. An item is stored if and only if it is the next one wanted and there is room,
/// so each arrives exactly once and in order, whatever blocks come, how often and how cut. A block that begins behind
/// the next item wanted is kept until the gap before it is filled (selective repeat); `missing()` lists the gaps.
///
/// Blocks are kept as they came and read item by item, some each tick: a block of 255 items makes no tick longer than a
/// small one does.
class JobStream {
public:
    enum class Taken : std::uint8_t {
        foreign,  ///< no job is open, or it is a block of another
        stored,   ///< kept for step(): it holds at least one new item, or none at all
        known,    ///< nothing new
        ahead,    ///< begins behind the next item wanted: a gap is open
        full,     ///< no room to keep it
        refused,  ///< the job has been refused, now or before
    };
    /// Where a job is taken up again: items before `first` are done, their hash is `hash_before`.
    struct Start {
        std::uint32_t first = 0;
        std::uint64_t hash_before = JobHasher{}.value();
    };
    /// A run of items that are wanted though later ones have come.
    struct Gap {
        std::uint32_t from = 0;
        std::uint32_t until = 0;
    };
    static constexpr std::size_t kKept = 16;

    explicit JobStream(const StreamRules& rules = {}) noexcept : rules_(rules) { drop_kept(); }

    /// Begins a job with an empty queue; the same job that is still open and not refused goes on instead.
    void open(std::uint64_t job, std::uint32_t items) noexcept;
    /// Begins a job in its midst, always anew.
    void open_at(std::uint64_t job, std::uint32_t items, const Start& start) noexcept;
    /// Ends intake and drops what is queued. How far the job came stays readable.
    void close() noexcept;
    /// Copies the block at most; at most kKept comparisons.
    Taken take(const BlockView& block) noexcept;
    Taken take(const Block& block) noexcept { return take(view_of(block)); }
    /// Reads up to `items` of what is kept, as far as the queue has room. A block that is malformed refuses the job at
    /// the item where it goes wrong.
    void step(std::uint32_t items) noexcept;
    /// The first refusal of a job counts. Ignored when no job is open.
    void refuse(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept;
    /// The first gaps, as many as fit; how many. None while there is no room to keep what would fill them.
    [[nodiscard]] std::size_t missing(std::span<Gap> out) const noexcept;
    /// Items from `received` on that the host may send: what the queue takes, and no more than the room for blocks
    /// takes if those to come hold as many items as the largest so far.
    [[nodiscard]] std::uint32_t window() const noexcept;

    [[nodiscard]] ItemQueue& items() noexcept { return queue_; }
    [[nodiscard]] const ItemQueue& items() const noexcept { return queue_; }
    [[nodiscard]] bool is_open() const noexcept { return open_; }
    [[nodiscard]] std::uint64_t job() const noexcept { return job_; }
    [[nodiscard]] std::uint32_t job_items() const noexcept { return items_; }
    [[nodiscard]] std::uint32_t job_low() const noexcept { return static_cast<std::uint32_t>(job_ & 0xFFFFFFFFU); }
    /// Number of the next item wanted.
    [[nodiscard]] std::uint32_t received() const noexcept { return received_; }
    /// Every item has arrived and their hash is the job's.
    [[nodiscard]] bool hash_ok() const noexcept { return hash_ok_; }
    /// What the open job was refused for; `refusal` in it is 0 when it was not.
    [[nodiscard]] const JobRefused& refused() const noexcept { return refused_; }
    [[nodiscard]] std::uint32_t items_repeated() const noexcept { return items_repeated_; }
    [[nodiscard]] std::uint32_t blocks_ahead() const noexcept { return blocks_ahead_; }

private:
    struct Kept {
        std::uint32_t first = 0;
        std::uint8_t count = 0;
        std::size_t size = 0;
        std::array<std::uint8_t, kPayloadCapacity> bytes{};
        [[nodiscard]] std::uint32_t end() const noexcept { return first + count; }
    };
    static constexpr std::uint8_t kFirstCount = 16;  ///< a guess at the items of a block, before the first has come

    void begin(std::uint64_t job, std::uint32_t items, const Start& start) noexcept;
    [[nodiscard]] const Kept& kept(std::size_t place) const noexcept { return kept_[order_[place]]; }
    [[nodiscard]] bool make_room(std::uint32_t first) noexcept;
    [[nodiscard]] bool known(const BlockView& block) const noexcept;
    void keep(const BlockView& block) noexcept;
    void drop(std::size_t place) noexcept;
    void drop_kept() noexcept;
    void find_end() noexcept;
    [[nodiscard]] bool begin_reading() noexcept;
    void read_item() noexcept;
    void verify() noexcept;

    StreamRules rules_;
    ItemQueue queue_;
    JobHasher hasher_;
    JobRefused refused_;
    std::uint64_t job_ = 0;
    std::uint32_t items_ = 0;
    std::uint32_t received_ = 0;
    std::array<Kept, kKept> kept_{};
    std::array<std::uint8_t, kKept>
        order_{};  ///< places in kept_: those in use first, by their first item; then the free
    std::size_t kept_size_ = 0;
    std::uint32_t kept_end_ = 0;              ///< every item below has been received or is kept
    std::uint8_t usual_count_ = kFirstCount;  ///< items of a block: a mean over the last few
    BlockReader reader_{{}, 0};               ///< of the first that is kept, while `reading_`
    std::uint32_t reading_item_ = 0;
    bool reading_ = false;
    std::uint32_t items_repeated_ = 0;
    std::uint32_t blocks_ahead_ = 0;
    bool open_ = false;
    bool hash_ok_ = false;
};

}  // namespace sc::link
