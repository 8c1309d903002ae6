// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/stm32h743/model/core.hpp"
#include "tests/stm32h743/model/machine.hpp"

/// The embedded flash with its two banks, their ECC and keys, a data cache before it, and power that goes at any word.
/// Numbers: tests/data/stm32h743/flash.csv. End-of-program flags, options, CRC unit and single errors are not modelled.

namespace sc::model {

class Flash {
public:
    static constexpr std::uint32_t kArray = 0x08000000;
    static constexpr std::uint32_t kRegisters = 0x52002000;
    static constexpr std::uint32_t kSecondBank = 0x100;
    static constexpr std::uint32_t kKey = 0x04;
    static constexpr std::uint32_t kControl = 0x0C;
    static constexpr std::uint32_t kStatus = 0x10;
    static constexpr std::uint32_t kClear = 0x14;
    static constexpr std::uint32_t kBytes = 2U << 20U;
    static constexpr std::uint32_t kWord = 32;
    static constexpr std::uint32_t kSector = 128U << 10U;
    /// REGISTER.FIELD, of the first bank's registers.
    static const std::map<std::string, std::uint32_t> kMasks;

    /// What the word, or each word of the sector, is when the power has gone while it was worked upon.
    enum class Cut : std::uint8_t { untouched, whole, broken, random, mixed };

    explicit Flash(Machine& machine);

    /// The power goes during the n-th erase or program from now, 0 the next one.
    void cut(unsigned n, Cut outcome) {
        left_ = static_cast<int>(n);
        outcome_ = outcome;
    }
    [[nodiscard]] bool dead() const { return dead_; }
    /// As after a reset; what the cells hold stays. A cut that has not happened is called off.
    void power_on();
    /// Words programmed and sectors erased.
    [[nodiscard]] unsigned works() const { return works_; }
    /// So long each erase and program takes from now on.
    void set_times(std::int64_t erase_ns, std::int64_t program_ns) {
        erase_ns_ = erase_ns;
        program_ns_ = program_ns;
    }
    /// A word whose ECC has more errors than it can put right.
    void spoil(std::uint32_t at) { lost_.at((at - kArray) / kWord) = true; }
    /// The next work ends with these flags of the status, undone.
    void fail_next(std::uint32_t flags) { fail_ = flags; }
    /// Cells as they are, for tests to look at and to fill.
    [[nodiscard]] std::vector<std::uint8_t>& cells() { return cells_; }
    /// What the cells hold, to go back to.
    struct Content {
        std::vector<std::uint8_t> cells;
        std::vector<bool> lost;
    };
    [[nodiscard]] Content content() const { return {cells_, lost_}; }
    void set_content(const Content& content) {
        cells_ = content.cells;
        lost_ = content.lost;
        cache_.clear();
    }
    /// Both banks.
    [[nodiscard]] bool locked() const { return (banks_[0].control & banks_[1].control & 1U) != 0; }
    [[nodiscard]] Core& core() { return core_; }

private:
    struct Bank {
        std::uint32_t control = 1;
        std::uint32_t status = 0;
        unsigned keys = 0;
        bool shut = false;  ///< wrong keys: until the next reset
        std::uint32_t word = 0;
        std::uint32_t filled = 0;  ///< bit a 32-bit part of the buffer
        std::array<std::uint32_t, 8> buffer{};
        std::int64_t until_ns = Peripheral::kNever;
        bool erasing = false;
    };
    struct Registers final : Peripheral {
        explicit Registers(Flash& flash) : flash_(flash) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
        [[nodiscard]] std::int64_t next_ns() const override;
        void act(std::int64_t now_ns) override;
        Flash& flash_;
    };
    struct Array final : Peripheral {
        explicit Array(Flash& flash) : flash_(flash) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override { return flash_.load(offset); }
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override {
            flash_.store(offset, value, bytes);
        }
        Flash& flash_;
    };
    void key(Bank& bank, std::uint32_t value);
    void control(Bank& bank, std::uint32_t value);
    [[nodiscard]] std::uint32_t load(std::uint32_t offset);
    void store(std::uint32_t offset, std::uint32_t value, unsigned bytes);
    void begin(Bank& bank, std::int64_t duration_ns);
    void end(Bank& bank, unsigned number);
    void program(const Bank& bank, Cut outcome);
    void erase(std::uint32_t first_word, Cut outcome);
    void scramble(std::uint32_t word);
    [[nodiscard]] bool blank(std::uint32_t word) const;

    Machine& machine_;
    Core core_;
    std::vector<std::uint8_t> cells_;
    std::vector<bool> lost_;
    std::array<Bank, 2> banks_{};
    std::map<std::uint32_t, std::array<std::uint32_t, 8>> cache_;
    std::int64_t erase_ns_ = 1'000'000'000;
    std::int64_t program_ns_ = 100'000;
    unsigned works_ = 0;
    int left_ = -1;
    Cut outcome_ = Cut::whole;
    bool dead_ = false;
    std::uint32_t fail_ = 0;
    std::mt19937 random_{1};
    Registers registers_{*this};
    Array array_{*this};
};

}  // namespace sc::model
