// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "boards/stm32h743/store/flash_memory.hpp"
#include "boards/stm32h743/store/flash_store.hpp"

/// Two places for the firmware's image, A and B. One runs while the other is written; what was written is on trial
/// until it confirms itself, and an image that does not is left for the other one. What is known of both is one record,
/// so it changes at once. Wherever the power goes, the boot loader finds an image to start. One context.

namespace sc::stm32h743 {

/// Sectors of the flash and what they hold. A record never shares a sector with an image. All that changes lies in bank
/// 2, except slot A, which is written by the image in slot B: code in bank 1 goes on while bank 2 works.
namespace flash_layout {
inline constexpr unsigned kBootLoader = 0;
inline constexpr std::array<unsigned, 2> kSlots{1, 8};  ///< the first sector of each
inline constexpr unsigned kSlotSectors = 3;
inline constexpr std::array<unsigned, 2> kStates{12, 13};
inline constexpr std::array<unsigned, 2> kStore{14, 15};
}  // namespace flash_layout

enum class Slot : std::uint8_t { a, b };
enum class SlotState : std::uint8_t {
    empty,      ///< or being written
    written,    ///< whole, and never started
    on_trial,   ///< started, and has not confirmed itself
    confirmed,  ///< has run well
    bad,        ///< has not confirmed itself, or was not whole when it was to be started
};

struct SlotRecord {
    std::array<SlotState, 2> state{};
    std::uint8_t starts = 0;  ///< of the image on trial
    Slot newest = Slot::a;    ///< which one is started when both are confirmed
    bool operator==(const SlotRecord&) const noexcept = default;
};

/// So often an image on trial is started.
inline constexpr std::uint8_t kTrialStarts = 3;

struct Choice {
    std::optional<Slot> slot;          ///< none: neither may be started
    std::optional<SlotRecord> record;  ///< to be written before the start
};
/// What to start. `verified`: the image there is whole and signed. Every start on trial counts, whatever has ended it:
/// a watchdog's reset and a power cut look alike to an image that hangs. Without `trial` (the count could not be
/// written) no image on trial is started. No record: a new board; what is verified counts as confirmed.
[[nodiscard]] Choice choose(const std::optional<SlotRecord>& record, bool verified_a, bool verified_b,
                            bool trial = true) noexcept;

/// Changes the slots and their record, as the boot loader and the running image need it. One thing is begun at a time,
/// step() does it.
class Slots {
public:
    using Word = FlashMemory::Word;
    using Progress = FlashStore::Progress;
    static constexpr std::size_t kBytes = flash_layout::kSlotSectors * FlashMemory::kSectorBytes;
    static constexpr std::size_t kWords = kBytes / FlashMemory::kWordBytes;
    [[nodiscard]] static constexpr Address start_of(Slot slot) noexcept {
        return FlashMemory::sector_start(flash_layout::kSlots[static_cast<std::size_t>(slot)]);
    }

    /// `states`: in flash_layout::kStates, of nobody else.
    Slots(FlashMemory& flash, FlashStore& states) noexcept : flash_(&flash), states_(&states) {}
    /// The states' store has been started.
    void start() noexcept;
    [[nodiscard]] const std::optional<SlotRecord>& record() const noexcept { return record_; }
    [[nodiscard]] bool busy() const noexcept { return phase_ != Phase::idle; }

    /// The boot loader's choice; false while busy. When step() has told `done`, chosen() is to be started.
    bool begin_choice(bool verified_a, bool verified_b) noexcept;
    [[nodiscard]] std::optional<Slot> chosen() const noexcept { return chosen_; }

    enum class Refusal : std::uint8_t {
        none,
        busy,
        marking,    ///< the laser may come on
        not_ready,  ///< an update from an image that is on trial: the other one is what it goes back to
        order,      ///< no update is open, or the slot is full, or not what it was announced to be
    };
    /// Erases the slot that does not run: 3 s, 12 s at most.
    Refusal begin_update(Slot running) noexcept;
    /// The next word of the image: 0.1 ms.
    Refusal write(const Word& word) noexcept;
    /// The image is whole; `verified` as read from the flash. The next start is its trial.
    Refusal finish(bool verified) noexcept;
    /// The running image has seen that all is well. None: nothing is to be done, or step() does it.
    Refusal confirm(Slot running) noexcept;

    /// `done` and `failed` are told once. A failed update is over: it begins anew.
    Progress step(std::uint32_t now_ms) noexcept;

private:
    enum class Phase : std::uint8_t { idle, choice, invalidate, erase, word, finish, confirm };

    [[nodiscard]] bool put(const SlotRecord& record, Phase phase) noexcept;
    [[nodiscard]] SlotRecord known() const noexcept { return record_.value_or(SlotRecord{}); }
    Progress step_flash(std::uint32_t now_ms) noexcept;
    Progress step_record(std::uint32_t now_ms) noexcept;
    Progress end(Progress how) noexcept;

    FlashMemory* flash_;
    FlashStore* states_;
    std::optional<SlotRecord> record_;
    SlotRecord wanted_;  ///< being written
    Phase phase_ = Phase::idle;
    bool begun_ = false;

    std::array<bool, 2> verified_{};
    std::optional<Slot> chosen_;
    bool on_trial_ = false;  ///< what was chosen

    std::optional<Slot> updating_;
    unsigned erased_ = 0;  ///< sectors
    std::size_t next_word_ = 0;
    Word word_{};
};

}  // namespace sc::stm32h743
