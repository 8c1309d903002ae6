// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/motion/element.hpp"

namespace sc::motion {

/// Elements of the present path, numbered from 0. Some that have been passed are kept, so that a held path can be
/// backed up.
class ElementRing {
public:
    static constexpr std::size_t kCapacity = 768;

    void clear() noexcept {
        first_ = end_ = 0;
        tau_ = distance_ = 0.0;
    }
    [[nodiscard]] std::uint32_t first() const noexcept { return first_; }
    [[nodiscard]] std::uint32_t end() const noexcept { return end_; }
    [[nodiscard]] std::size_t free() const noexcept { return kCapacity - (end_ - first_); }
    [[nodiscard]] const Element& at(std::uint32_t number) const noexcept { return ring_[number % kCapacity]; }
    /// Sum of all lengths so far: tau and true distance at the end.
    [[nodiscard]] double tau() const noexcept { return tau_; }
    [[nodiscard]] double distance() const noexcept { return distance_; }

    /// The caller has made sure of free() > 0. Places the element behind the last one.
    void append(Element element) noexcept {
        element.start = tau_;
        element.distance = distance_;
        ring_[end_ % kCapacity] = element;
        ++end_;
        tau_ = tau_ + element.length;
        distance_ = distance_ + element.true_length;
    }
    void forget_before(std::uint32_t number) noexcept {
        if (number > first_ && number < end_) {
            first_ = number;
        }
    }

private:
    std::array<Element, kCapacity> ring_{};
    std::uint32_t first_ = 0;
    std::uint32_t end_ = 0;
    double tau_ = 0.0;
    double distance_ = 0.0;
};

}  // namespace sc::motion
