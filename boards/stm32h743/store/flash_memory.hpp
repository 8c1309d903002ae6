// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "boards/stm32h743/registers/access.hpp"

/// The embedded flash: two banks of eight sectors of 128 KB, written in words of 32 bytes that carry their ECC
/// (reference manual, section Embedded flash memory). Erasing and programming are begun here and followed by step(): a
/// sector takes 1 s (4 s at most), a word 0.1 ms. While a bank works, nothing can be read from it: the processor would
/// stall, so code that must go on runs from the other bank or from RAM. Nothing here blocks; each function costs some
/// 100 accesses at most. One context.

namespace sc::stm32h743 {

class FlashMemory {
public:
    static constexpr std::size_t kWordBytes = 32;
    static constexpr std::size_t kSectorBytes = 128UL * 1024UL;
    static constexpr unsigned kSectors = 16;  ///< 0 to 7: bank 1
    static constexpr Address kStart = 0x08000000;
    static constexpr std::uint32_t kEraseLimitMs = 5000;
    static constexpr std::uint32_t kProgramLimitMs = 10;
    using Word = std::array<std::uint8_t, kWordBytes>;

    enum class Begin : std::uint8_t {
        begun,
        marking,     ///< nothing is written while the laser may come on
        place,       ///< no such sector, or no start of a word
        busy,        ///< the last work has not ended
        locked,      ///< the keys were not taken
        not_erased,  ///< the word holds something: a second program would spoil its ECC
    };
    enum class Progress : std::uint8_t { idle, working, done, failed };

    [[nodiscard]] static constexpr Address sector_start(unsigned sector) noexcept {
        return kStart + static_cast<Address>(sector * kSectorBytes);
    }

    /// True while the laser may come on. Work that has begun goes on.
    void set_marking(bool marking) noexcept { marking_ = marking; }
    [[nodiscard]] bool marking() const noexcept { return marking_; }
    Begin erase(unsigned sector) noexcept;
    Begin program(Address at, const Word& bytes) noexcept;
    /// How the work goes on; `done` and `failed` are told once. A word that does not read back as it was written has
    /// failed. `now_ms` may wrap.
    Progress step(std::uint32_t now_ms) noexcept;
    [[nodiscard]] bool working() const noexcept { return work_ != Work::none; }
    /// SR of the work that has failed; 0 when it took too long or read back wrong.
    [[nodiscard]] std::uint32_t failure() const noexcept { return failure_; }

    enum class Read : std::uint8_t {
        good,
        lost,  ///< more bits are wrong than ECC puts right; `out` is all 0
        away,  ///< no place of a word, or its bank works
    };
    /// Never from the cache. Interrupts are off meanwhile, some 0.5 us.
    Read read(Address at, Word& out) noexcept;
    [[nodiscard]] static bool erased(const Word& word) noexcept;

private:
    enum class Work : std::uint8_t { none, erase, program };
    Begin unlock(Address bank) const noexcept;
    [[nodiscard]] bool reads_back() noexcept;

    bool marking_ = true;  ///< until told otherwise
    Work work_ = Work::none;
    bool timed_ = false;
    std::uint32_t since_ms_ = 0;
    Address bank_ = 0;
    Address at_ = 0;
    Word word_{};
    std::uint32_t failure_ = 0;
};

}  // namespace sc::stm32h743
