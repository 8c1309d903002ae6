// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "shared/path/item.hpp"

namespace sc {

/// Ring of items between link and planner. One owner: not for use from two contexts. No heap; every call is O(1).
template <std::size_t Capacity>
class BasicItemQueue {
    static_assert(Capacity > 0);

public:
    /// False, and nothing stored, when full.
    [[nodiscard]] bool push(const Item& item) noexcept {
        if (size_ == Capacity) {
            return false;
        }
        items_[(head_ + size_) % Capacity] = item;
        ++size_;
        return true;
    }
    /// Oldest item, or nullptr when empty. Valid until the next call that changes the queue.
    [[nodiscard]] const Item* front() const noexcept { return peek(0); }
    /// The item `ahead` places behind the oldest, or nullptr.
    [[nodiscard]] const Item* peek(std::size_t ahead) const noexcept {
        return ahead < size_ ? &items_[(head_ + ahead) % Capacity] : nullptr;
    }
    /// Drops the oldest; nothing happens when empty.
    void pop() noexcept {
        if (size_ > 0) {
            head_ = (head_ + 1) % Capacity;
            --size_;
        }
    }
    void clear() noexcept {
        head_ = 0;
        size_ = 0;
    }
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] std::size_t free() const noexcept { return Capacity - size_; }
    [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }

private:
    std::array<Item, Capacity> items_{};
    std::size_t head_ = 0;
    std::size_t size_ = 0;
};

inline constexpr std::size_t kItemQueueCapacity = 2048;
using ItemQueue = BasicItemQueue<kItemQueueCapacity>;

}  // namespace sc
