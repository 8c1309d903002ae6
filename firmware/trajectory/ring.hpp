// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace sc::trajectory {

/// Elements with consecutive numbers in memory of the caller; its size must be a power of two. Numbers count from
/// clear() and wrap after 2^32.
template <class T>
class Ring {
public:
    explicit Ring(std::span<T> memory) noexcept : memory_(memory) {}

    void clear() noexcept { first_ = end_ = 0; }
    [[nodiscard]] std::uint32_t first() const noexcept { return first_; }
    [[nodiscard]] std::uint32_t end() const noexcept { return end_; }
    [[nodiscard]] std::uint32_t size() const noexcept { return end_ - first_; }
    [[nodiscard]] std::uint32_t capacity() const noexcept { return static_cast<std::uint32_t>(memory_.size()); }
    [[nodiscard]] std::uint32_t free() const noexcept { return capacity() - size(); }
    [[nodiscard]] const T& operator[](std::uint32_t number) const noexcept {
        return memory_[number & (capacity() - 1)];
    }
    [[nodiscard]] T& operator[](std::uint32_t number) noexcept { return memory_[number & (capacity() - 1)]; }
    /// The element behind the last. Only while free() > 0.
    T& push() noexcept {
        T& slot = memory_[end_ & (capacity() - 1)];
        ++end_;
        return slot;
    }
    /// Takes back what was pushed last, from `number` on.
    void drop_from(std::uint32_t number) noexcept { end_ = number; }
    void forget_before(std::uint32_t number) noexcept {
        if (static_cast<std::int32_t>(number - first_) > 0) {
            first_ = static_cast<std::int32_t>(end_ - number) < 0 ? end_ : number;
        }
    }

private:
    std::span<T> memory_;
    std::uint32_t first_ = 0;
    std::uint32_t end_ = 0;
};

}  // namespace sc::trajectory
