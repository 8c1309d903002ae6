// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/job_stream.hpp"

#include "shared/link/blocks.hpp"

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
    open_ = true;
    hash_ok_ = false;
    verify();
}

void JobStream::close() noexcept {
    open_ = false;
    queue_.clear();
    refused_ = {};
}

void JobStream::refuse(std::uint32_t item, Refusal refusal, std::uint8_t axis, std::int64_t value) noexcept {
    if (!open_ || refused_.refusal != 0) {
        return;
    }
    refused_ = {job_low(), item, static_cast<std::uint16_t>(refusal), axis, value};
}

JobStream::Taken JobStream::take(const Block& block) noexcept {
    if (!open_ || block.job_low != job_low()) {
        return Taken::foreign;
    }
    if (refused_.refusal != 0) {
        return Taken::refused;
    }
    if (!block_is_sound(std::span(block.items.data).first(block.items.size), block.count)) {
        refuse(block.first, Refusal::malformed_block, 0, block.count);
        return Taken::refused;
    }
    if (std::uint64_t{block.first} + block.count > items_) {
        refuse(items_, Refusal::too_many_points, 0, items_);
        return Taken::refused;
    }
    if (block.first > received_) {
        ++blocks_ahead_;
        return Taken::ahead;
    }
    return store(block);
}

JobStream::Taken JobStream::store(const Block& block) noexcept {
    BlockReader reader = read_block(block);
    const std::uint32_t before = received_;
    std::uint32_t number = block.first;
    Item item;
    while (reader.next(item).value_or(false)) {
        if (number < before) {
            ++items_repeated_;
        } else if (queue_.push(item)) {
            hasher_.add(item);
            ++received_;
        } else {
            break;
        }
        ++number;
    }
    if (received_ != before) {
        verify();
        return Taken::stored;
    }
    if (block.count == 0) {
        return Taken::stored;
    }
    return number < block.first + block.count ? Taken::full : Taken::known;
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
