// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "boards/stm32h743/store/flash_memory.hpp"

/// Small records under numbers, in two sectors of flash: a log, of which the newest whole record of a number counts. A
/// full sector is copied into the other one, whose head is written last. Wherever the power goes, the next start()
/// finds each number with what it held before the change under way or after it. One context.

namespace sc::stm32h743 {

class FlashStore {
public:
    static constexpr std::size_t kKeys = 96;
    static constexpr std::size_t kBytes = 56;  ///< of a record's content
    using Content = std::array<std::uint8_t, kBytes>;

    enum class Progress : std::uint8_t {
        idle,
        working,
        put_off,  ///< the laser may come on: it goes on when it may not
        done,
        failed,  ///< what was kept before is kept
    };

    FlashStore(FlashMemory& flash, unsigned first_sector, unsigned second_sector) noexcept
        : flash_(&flash), sectors_{first_sector, second_sector} {}

    /// Finds what is kept; before all else. Reads the log: 4 ms when it is full. False: nothing is kept.
    bool start() noexcept;
    /// A change is under way.
    [[nodiscard]] bool busy() const noexcept { return phase_ != Phase::idle; }
    /// Only while not busy: the bank could not be read.
    [[nodiscard]] std::optional<Content> get(std::size_t key) const noexcept;
    [[nodiscard]] bool has(std::size_t key) const noexcept { return key < kKeys && at_[key] != 0; }

    /// These begin a change, which step() does; false while busy or for keys or sizes that do not exist. Content that
    /// is shorter than kBytes is filled with 0.
    bool put(std::size_t key, std::span<const std::uint8_t> content) noexcept;
    /// All keys from `first` on, at once.
    bool drop(std::size_t first, std::size_t count) noexcept;
    /// `done` and `failed` are told once. Some 200 accesses at most, a read of a record included. A change takes 0.3
    /// ms; one that finds its sector full 1.2 s, 5 s at most.
    Progress step(std::uint32_t now_ms) noexcept;

private:
    using Word = FlashMemory::Word;
    using Record = std::array<Word, 2>;
    enum class Kind : std::uint8_t { head = 1, content = 2, drop = 3 };
    enum class Phase : std::uint8_t { idle, erase, copy, seal, append };
    struct Head {
        Kind kind = Kind::head;
        std::uint8_t key = 0;
    };

    static constexpr unsigned kSlots = FlashMemory::kSectorBytes / sizeof(Record);
    static constexpr unsigned kTries = 3;
    static constexpr unsigned kMostBlank = 8;  ///< blank slots between records

    [[nodiscard]] static Record make(Head head, std::span<const std::uint8_t> content) noexcept;
    [[nodiscard]] static std::optional<Head> check(const Record& record) noexcept;
    [[nodiscard]] static Content content_of(const Record& record) noexcept;
    [[nodiscard]] Address place(std::size_t sector, unsigned slot) const noexcept;
    [[nodiscard]] bool read(std::size_t sector, unsigned slot, Record& out) const noexcept;
    [[nodiscard]] bool blank(std::size_t sector, unsigned slot) const noexcept;
    [[nodiscard]] std::uint32_t generation_of(std::size_t sector) const noexcept;
    void take(const Record& record, Head head, unsigned slot) noexcept;
    bool begin(const Record& record) noexcept;
    [[nodiscard]] bool room() const noexcept { return next_ < kSlots && next_ - last_ < kMostBlank; }

    Progress begin_work() noexcept;
    Progress after_work(bool well) noexcept;
    Progress failed() noexcept;
    void next_copy() noexcept;

    FlashMemory* flash_;
    std::array<unsigned, 2> sectors_;
    std::size_t active_ = 0;
    std::uint32_t generation_ = 0;           ///< of the active sector; 0: none is
    unsigned last_ = 0;                      ///< slot that holds something, none beyond it does
    unsigned next_ = 0;                      ///< to be written
    std::array<std::uint16_t, kKeys> at_{};  ///< slot of the newest; 0: none

    Phase phase_ = Phase::idle;
    Record wanted_{};   ///< the change
    Record writing_{};  ///< what is being written
    unsigned slot_ = 0;
    std::size_t word_ = 0;
    unsigned tries_ = 0;
    bool begun_ = false;
    std::size_t copy_key_ = 0;
    unsigned copied_last_ = 0;  ///< slot of the last copy
    std::array<std::uint16_t, kKeys> copied_at_{};
};

}  // namespace sc::stm32h743
