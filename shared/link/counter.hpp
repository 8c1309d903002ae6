// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::link {

/// Watches the counter of arriving messages. A carrier keeps order, so a counter that is not ahead of the last is a
/// message that has come twice or late, and one that is too far ahead means that others were lost. A counter more than
/// 64 behind is taken as far ahead: after a long silence either is possible, and refusing all would never end.
class CounterWatch {
public:
    /// The counter of a message that opens or reopens the session: whatever was before does not count.
    constexpr void restart(std::uint16_t counter) noexcept { last_ = counter; }
    /// True when the message is new. False: repeated or late, to be dropped.
    [[nodiscard]] constexpr bool take(std::uint16_t counter) noexcept {
        constexpr unsigned kLateWindow = 64;
        const auto behind = static_cast<std::uint16_t>(last_ - counter);
        if (behind < kLateWindow) {
            ++repeated_;
            return false;
        }
        lost_ += static_cast<std::uint16_t>(counter - last_ - 1);
        last_ = counter;
        return true;
    }
    [[nodiscard]] constexpr std::uint32_t lost() const noexcept { return lost_; }
    [[nodiscard]] constexpr std::uint32_t repeated() const noexcept { return repeated_; }

private:
    std::uint16_t last_ = 0xFFFF;
    std::uint32_t lost_ = 0;
    std::uint32_t repeated_ = 0;
};

}  // namespace sc::link
