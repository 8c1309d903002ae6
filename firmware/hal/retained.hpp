// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "shared/hash/fnv.hpp"
#include "shared/path/item.hpp"

/// What a board keeps while it has no power (battery-backed RAM; a file in the simulated cell). Plain memory, written
/// by the servo step alone.

namespace sc {

/// How far a job has come.
struct JobPlace {
    std::uint32_t fired = 0;  ///< every item below is done
    FiredPosition at;         ///< and of the path in hand, so many pulses
    constexpr bool operator==(const JobPlace&) const noexcept = default;
};

/// What is known of a job's pulses: those up to `certain` have left, none beyond `reached` has.
struct JobRecord {
    std::uint64_t job = 0;  ///< hash of its items
    std::uint32_t items = 0;
    JobPlace certain;
    JobPlace reached;
    constexpr bool operator==(const JobRecord&) const noexcept = default;
};

/// Two slots, written in turn, so that one is whole whenever the power goes: `reached` is written before the pulses it
/// tells of are released, so the older slot is right as long as the newer one is not.
class RetainedMemory {
public:
    /// Some 300 operations.
    void write(const JobRecord& record) noexcept {
        ++generation_;
        Slot& slot = slots_[generation_ % slots_.size()];
        slot.check = ~slot.check;
        slot.generation = generation_;
        slot.record = record;
        slot.check = check_of(slot);
    }
    /// The newest whole record; nothing after a battery has failed. Finds the place to go on writing, too.
    [[nodiscard]] std::optional<JobRecord> read() noexcept {
        const Slot* newest = nullptr;
        for (const Slot& slot : slots_) {
            const bool whole = slot.generation != 0 && slot.check == check_of(slot);
            if (whole && (newest == nullptr || slot.generation > newest->generation)) {
                newest = &slot;
            }
        }
        generation_ = newest == nullptr ? 0 : newest->generation;
        return newest == nullptr ? std::nullopt : std::optional(newest->record);
    }

private:
    struct Slot {
        std::uint32_t generation = 0;  ///< 0: never written
        JobRecord record;
        std::uint64_t check = 0;
    };
    static void add(Fnv1a64& hash, const JobPlace& place) noexcept {
        hash.update_word(place.fired).update_word(place.at.path).update_word(place.at.pass);
        hash.update_word(place.at.item).update_word(place.at.pulses);
    }
    [[nodiscard]] static std::uint64_t check_of(const Slot& slot) noexcept {
        Fnv1a64 hash;
        const JobRecord& record = slot.record;
        hash.update_word(slot.generation).update_word(static_cast<std::uint32_t>(record.job));
        hash.update_word(static_cast<std::uint32_t>(record.job >> 32U)).update_word(record.items);
        add(hash, record.certain);
        add(hash, record.reached);
        return hash.value();
    }

    std::array<Slot, 2> slots_{};
    std::uint32_t generation_ = 0;  ///< of the newest slot
};

}  // namespace sc
