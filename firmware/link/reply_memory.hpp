// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/link/messages.hpp"

namespace sc::link {

/// Remembers the last requests and what was answered, so that a repeated request is answered again and not done again.
/// Sequences rise; the difference of two is read as signed, so the count may wrap.
class ReplyMemory {
public:
    static constexpr std::size_t kCapacity = 8;

    enum class Verdict : std::uint8_t {
        fresh,    ///< to be done; `answer` is expected later
        pending,  ///< has come before, its answer is not known yet
        repeat,   ///< has come before; the answer will be sent again
        stale,    ///< older than the newest taken, and not remembered
        full,     ///< too many requests wait for their answers: drop it, it will come again
    };

    [[nodiscard]] Verdict take(std::uint32_t sequence) noexcept {
        if (Slot* known = find(sequence)) {
            known->due = known->answered;
            return known->answered ? Verdict::repeat : Verdict::pending;
        }
        if (any_ && static_cast<std::int32_t>(sequence - newest_) <= 0) {
            return Verdict::stale;
        }
        Slot& slot = slots_[next_];
        if (slot.used && !slot.answered) {
            return Verdict::full;
        }
        slot = {};
        slot.used = true;
        slot.reply.sequence = sequence;
        next_ = (next_ + 1) % kCapacity;
        newest_ = sequence;
        any_ = true;
        return Verdict::fresh;
    }
    /// The first answer counts; an unknown sequence is ignored.
    void answer(std::uint32_t sequence, Refusal refusal, std::int64_t detail) noexcept {
        Slot* known = find(sequence);
        if (known == nullptr || known->answered) {
            return;
        }
        known->reply.refusal = static_cast<std::uint16_t>(refusal);
        known->reply.detail = detail;
        known->answered = true;
        known->due = true;
    }
    /// The oldest answer that is to be sent, or nullptr.
    [[nodiscard]] const CommandReply* due() const noexcept {
        for (std::size_t i = 0; i < kCapacity; ++i) {
            const Slot& slot = slots_[(next_ + i) % kCapacity];
            if (slot.due) {
                return &slot.reply;
            }
        }
        return nullptr;
    }
    void sent(std::uint32_t sequence) noexcept {
        if (Slot* known = find(sequence)) {
            known->due = false;
        }
    }
    /// Newest sequence taken; 0 when there was none.
    [[nodiscard]] std::uint32_t newest() const noexcept { return newest_; }

private:
    struct Slot {
        CommandReply reply;
        bool used = false;
        bool answered = false;
        bool due = false;
    };
    Slot* find(std::uint32_t sequence) noexcept {
        for (Slot& slot : slots_) {
            if (slot.used && slot.reply.sequence == sequence) {
                return &slot;
            }
        }
        return nullptr;
    }

    std::array<Slot, kCapacity> slots_{};
    std::size_t next_ = 0;
    std::uint32_t newest_ = 0;
    bool any_ = false;
};

}  // namespace sc::link
