// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/job_stream.hpp"

#include <algorithm>
#include <expected>
#include <span>

namespace sc::link {

void JobStream::open(std::uint64_t job, std::uint32_t items) noexcept {
    if (open_ && job == job_ && items == items_ && refused_.refusal == 0) {
        return;
    }
    queue_.clear();
    hasher_ = {};
    refused_ = {};
    job_ = job;
    items_ = items;
    received_ = 0;
    drop_kept();
    open_ = true;
    hash_ok_ = false;
    verify();
}

void JobStream::close() noexcept {
    open_ = false;
    drop_kept();
    queue_.clear();
    refused_ = {};
}

void JobStream::refuse(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept {
    if (!open_ || refused_.refusal != 0) {
        return;
    }
    refused_ = {job_low(), item, static_cast<std::uint16_t>(refusal), axis, value};
}

JobStream::Taken JobStream::take(const BlockView& block) noexcept {
    if (!open_ || block.job_low != job_low()) {
        return Taken::foreign;
    }
    if (refused_.refusal != 0) {
        return Taken::refused;
    }
    if (std::uint64_t{block.first} + block.count > items_) {
        refuse(items_, Refusal::too_many_points, 0, items_);
        return Taken::refused;
    }
    if (block.first > kept_end_) {
        ++blocks_ahead_;
        return Taken::ahead;
    }
    if (block.count > 0 && block.first + block.count <= kept_end_) {
        items_repeated_ += block.count;
        return Taken::known;
    }
    if (kept_size_ == kKept || block.items.size() > kPayloadCapacity) {
        return Taken::full;
    }
    keep(block);
    return Taken::stored;
}

void JobStream::keep(const BlockView& block) noexcept {
    Kept& kept = kept_[(kept_first_ + kept_size_) % kKept];
    ++kept_size_;
    kept.first = block.first;
    kept.count = block.count;
    kept.size = block.items.size();
    std::copy(block.items.begin(), block.items.end(), kept.bytes.begin());
    kept_end_ = block.first + block.count > kept_end_ ? block.first + block.count : kept_end_;
}

void JobStream::drop_kept() noexcept {
    kept_first_ = kept_size_ = 0;
    kept_end_ = received_;
    reading_ = false;
}

void JobStream::step(std::uint32_t items) noexcept {
    for (std::uint32_t n = 0; n < items && kept_size_ > 0 && queue_.free() > 0; ++n) {
        if (!reading_) {
            const Kept& kept = kept_[kept_first_];
            reader_ = BlockReader(std::span(kept.bytes).first(kept.size), kept.count);
            reading_item_ = kept.first;
            reading_ = true;
        }
        read_item();
    }
}

void JobStream::read_item() noexcept {
    Item item;
    const std::expected<bool, Refusal> found = reader_.next(item);
    if (!found) {
        refuse(reading_item_, Refusal::malformed_block, 0, kept_[kept_first_].count);
        drop_kept();
        return;
    }
    if (!*found) {
        kept_first_ = (kept_first_ + 1) % kKept;
        --kept_size_;
        reading_ = false;
        return;
    }
    if (reading_item_ < received_) {
        ++items_repeated_;
    } else if (queue_.push(item)) {
        hasher_.add(item);
        ++received_;
        verify();
    }
    ++reading_item_;
}

void JobStream::verify() noexcept {
    if (received_ != items_) {
        return;
    }
    hash_ok_ = hasher_.value() == job_;
    if (!hash_ok_) {
        refuse(items_, Refusal::job_mismatch, 0, 0);
    }
}

}  // namespace sc::link
