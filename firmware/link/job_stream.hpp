// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/messages.hpp"
#include "shared/path/block.hpp"
#include "shared/path/item_queue.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::link {

/// The receiving end of one job's items. An item is stored if and only if it is the next one wanted and there is room,
/// so each arrives exactly once and in order, whatever blocks come, how often and how cut. A block that begins behind
/// the next item wanted is not kept (go-back-n): the host learns from the acknowledgement where to go on. Keeping such
/// blocks (selective repeat) would change nothing on the wire.
///
/// Blocks are kept as they came and read item by item, some each tick: a block of 255 items makes no tick longer than a
/// small one does.
class JobStream {
public:
    enum class Taken : std::uint8_t {
        foreign,  ///< no job is open, or it is a block of another
        stored,   ///< kept for step(): it holds at least one new item, or none at all
        known,    ///< nothing new
        ahead,    ///< begins behind the next item wanted
        full,     ///< no room to keep it
        refused,  ///< the job has been refused, now or before
    };

    /// Begins a job with an empty queue; the same job that is still open and not refused goes on instead.
    void open(std::uint64_t job, std::uint32_t items) noexcept;
    /// Ends intake and drops what is queued. How far the job came stays readable.
    void close() noexcept;
    /// Copies the block at most.
    Taken take(const BlockView& block) noexcept;
    Taken take(const Block& block) noexcept { return take(view_of(block)); }
    /// Reads up to `items` of what is kept, as far as the queue has room. A block that is malformed refuses the job at
    /// the item where it goes wrong.
    void step(std::uint32_t items) noexcept;
    /// The first refusal of a job counts. Ignored when no job is open.
    void refuse(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept;

    [[nodiscard]] ItemQueue& items() noexcept { return queue_; }
    [[nodiscard]] const ItemQueue& items() const noexcept { return queue_; }
    [[nodiscard]] bool is_open() const noexcept { return open_; }
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
    static constexpr std::size_t kKept = 8;
    struct Kept {
        std::uint32_t first = 0;
        std::uint8_t count = 0;
        std::size_t size = 0;
        std::array<std::uint8_t, kPayloadCapacity> bytes{};
    };
    void keep(const BlockView& block) noexcept;
    void drop_kept() noexcept;
    void read_item() noexcept;
    void verify() noexcept;

    ItemQueue queue_;
    JobHasher hasher_;
    JobRefused refused_;
    std::uint64_t job_ = 0;
    std::uint32_t items_ = 0;
    std::uint32_t received_ = 0;
    std::array<Kept, kKept> kept_{};
    std::size_t kept_first_ = 0;
    std::size_t kept_size_ = 0;
    std::uint32_t kept_end_ = 0;  ///< number of the item behind the last that is kept
    BlockReader reader_{{}, 0};   ///< of the first that is kept, while `reading_`
    std::uint32_t reading_item_ = 0;
    bool reading_ = false;
    std::uint32_t items_repeated_ = 0;
    std::uint32_t blocks_ahead_ = 0;
    bool open_ = false;
    bool hash_ok_ = false;
};

}  // namespace sc::link
