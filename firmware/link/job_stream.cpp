// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/job_stream.hpp"

#include <algorithm>
#include <expected>
#include <span>

namespace sc::link {

void JobStream::begin(std::uint64_t job, std::uint32_t items, const Start& start) noexcept {
    queue_.clear();
    hasher_ = JobHasher(start.hash_before);
    refused_ = {};
    job_ = job;
    items_ = items;
    received_ = start.first;
    usual_count_ = kFirstCount;
    drop_kept();
    open_ = true;
    hash_ok_ = false;
    verify();
}

void JobStream::open(std::uint64_t job, std::uint32_t items) noexcept {
    if (open_ && job == job_ && items == items_ && refused_.refusal == 0) {
        return;
    }
    begin(job, items, {});
}

void JobStream::open_at(std::uint64_t job, std::uint32_t items, const Start& start) noexcept {
    begin(job, items, start);
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

// --- blocks

bool JobStream::known(const BlockView& block) const noexcept {
    if (block.count == 0) {
        // It only asks how things stand: one at a place shows the gap before it, and none is kept without one.
        bool there = block.items.empty() && block.first <= kept_end_;
        for (std::size_t i = 0; i < kept_size_; ++i) {
            there = there || (kept(i).first == block.first && kept(i).count == 0);
        }
        return there;
    }
    const std::uint32_t end = block.first + block.count;
    if (end <= kept_end_) {
        return true;
    }
    for (std::size_t i = 0; i < kept_size_; ++i) {
        if (kept(i).first <= block.first && end <= kept(i).end()) {
            return true;
        }
    }
    return false;
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
    const bool ahead = rules_.checks_index && block.first > kept_end_;
    blocks_ahead_ += ahead ? 1U : 0U;
    if (ahead && !rules_.keeps_ahead) {
        return Taken::ahead;
    }
    if (rules_.checks_index && known(block)) {
        items_repeated_ += block.count;
        return ahead ? Taken::ahead : Taken::known;
    }
    if (block.items.size() > kPayloadCapacity || !make_room(block.first)) {
        return Taken::full;
    }
    keep(block);
    find_end();
    return ahead ? Taken::ahead : Taken::stored;
}

/// The last place is for what closes a gap: otherwise blocks behind it could shut it out for ever.
bool JobStream::make_room(std::uint32_t first) noexcept {
    const bool wanted_next = first <= kept_end_;
    if (kept_size_ + (wanted_next ? 0 : 1) < kKept) {
        return true;
    }
    if (wanted_next && kept_size_ == kKept && kept(kKept - 1).first > kept_end_) {
        drop(kKept - 1);
        return true;
    }
    return false;
}

void JobStream::keep(const BlockView& block) noexcept {
    const std::uint8_t slot = order_[kept_size_];
    Kept& kept_block = kept_[slot];
    kept_block.first = block.first;
    kept_block.count = block.count;
    kept_block.size = block.items.size();
    std::copy(block.items.begin(), block.items.end(), kept_block.bytes.begin());
    // The one that is being read stays in front, whatever comes.
    const std::size_t front = reading_ ? 1 : 0;
    std::size_t place = kept_size_;
    while (rules_.checks_index && place > front && kept(place - 1).first > block.first) {
        order_[place] = order_[place - 1];
        --place;
    }
    order_[place] = slot;
    ++kept_size_;
    if (block.count > 0) {
        usual_count_ = static_cast<std::uint8_t>((3U * usual_count_ + block.count) / 4U);
    }
}

void JobStream::drop(std::size_t place) noexcept {
    const std::uint8_t slot = order_[place];
    for (std::size_t i = place; i + 1 < kept_size_; ++i) {
        order_[i] = order_[i + 1];
    }
    --kept_size_;
    order_[kept_size_] = slot;
}

void JobStream::drop_kept() noexcept {
    for (std::size_t i = 0; i < kKept; ++i) {
        order_[i] = static_cast<std::uint8_t>(i);
    }
    kept_size_ = 0;
    kept_end_ = received_;
    reading_ = false;
}

void JobStream::find_end() noexcept {
    for (std::size_t i = 0; i < kept_size_ && kept(i).first <= kept_end_; ++i) {
        kept_end_ = std::max(kept_end_, kept(i).end());
    }
}

std::size_t JobStream::missing(std::span<Gap> out) const noexcept {
    if (!open_ || kept_size_ == kKept || refused_.refusal != 0) {
        return 0;
    }
    std::size_t count = 0;
    std::uint32_t end = kept_end_;
    for (std::size_t i = 0; i < kept_size_ && count < out.size(); ++i) {
        if (kept(i).first > end) {
            out[count++] = {end, kept(i).first};
        }
        end = std::max(end, kept(i).end());
    }
    return count;
}

std::uint32_t JobStream::window() const noexcept {
    const auto room = static_cast<std::uint32_t>(queue_.free());
    // One place stays for what closes a gap.
    const auto blocks = static_cast<std::uint32_t>(kept_size_ + 1 < kKept ? kKept - 1 - kept_size_ : 0);
    return std::min(room, kept_end_ - received_ + blocks * usual_count_);
}

// --- items

bool JobStream::begin_reading() noexcept {
    while (kept_size_ > 0) {
        const Kept& next = kept(0);
        if (rules_.checks_index && next.first > received_) {
            return false;
        }
        if (!rules_.checks_index || next.end() > received_ || next.count == 0) {
            reader_ = BlockReader(std::span(next.bytes).first(next.size), next.count);
            reading_item_ = next.first;
            reading_ = true;
            return true;
        }
        items_repeated_ += next.count;
        drop(0);
    }
    return false;
}

void JobStream::step(std::uint32_t items) noexcept {
    for (std::uint32_t n = 0; n < items && queue_.free() > 0; ++n) {
        if (!reading_ && !begin_reading()) {
            return;
        }
        read_item();
    }
}

void JobStream::read_item() noexcept {
    Item item;
    const std::expected<bool, Refusal> found = reader_.next(item);
    if (!found) {
        refuse(reading_item_, Refusal::malformed_block, 0, kept(0).count);
        drop_kept();
        return;
    }
    if (!*found) {
        drop(0);
        reading_ = false;
        return;
    }
    if (rules_.checks_index && reading_item_ < received_) {
        ++items_repeated_;
    } else if (queue_.push(item)) {
        hasher_.add(item);
        ++received_;
        kept_end_ = std::max(kept_end_, received_);
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
