// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/link/messages.hpp"
#include "shared/path/item_queue.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::link {

/// The receiving end of one job's items. An item is stored if and only if it is the next one wanted and there is room,
/// so each arrives exactly once and in order, whatever blocks come, how often and how cut. A block that begins behind
/// the next item wanted is not kept (go-back-n): the host learns from the acknowledgement where to go on. Keeping such
/// blocks (selective repeat) would change nothing on the wire.
class JobStream {
public:
    enum class Taken : std::uint8_t {
        foreign,  ///< no job is open, or it is a block of another
        stored,   ///< at least one new item, or an empty block
        known,    ///< nothing new
        ahead,    ///< begins behind the next item wanted
        full,     ///< no room for even one item
        refused,  ///< the job has been refused, now or before
    };

    /// Begins a job with an empty queue; the same job that is still open and not refused goes on instead.
    void open(std::uint64_t job, std::uint32_t items) noexcept;
    /// Ends intake and drops what is queued. How far the job came stays readable.
    void close() noexcept;
    /// At most one walk to check the block and one to store it.
    Taken take(const Block& block) noexcept;
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
    Taken store(const Block& block) noexcept;
    void verify() noexcept;

    ItemQueue queue_;
    JobHasher hasher_;
    JobRefused refused_;
    std::uint64_t job_ = 0;
    std::uint32_t items_ = 0;
    std::uint32_t received_ = 0;
    std::uint32_t items_repeated_ = 0;
    std::uint32_t blocks_ahead_ = 0;
    bool open_ = false;
    bool hash_ok_ = false;
};

}  // namespace sc::link
