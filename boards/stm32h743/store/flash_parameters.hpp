// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "boards/stm32h743/store/flash_store.hpp"
#include "firmware/hal/parameter_memory.hpp"
#include "firmware/hal/retained.hpp"

/// What a controller keeps in flash: the parameters' slots, each unit a record, and how far a job came. Both in one
/// FlashStore, of which one is at work at a time. Servo context, or the context of the store.

namespace sc::stm32h743 {

/// The slots are read from a copy in RAM that is changed when the flash has been.
class FlashParameters final : public ParameterMemory {
public:
    static constexpr std::size_t kUnits = kSlotBytes / kUnit;
    static constexpr std::size_t kKeysUsed = kSlots * kUnits;  ///< from 0 on

    explicit FlashParameters(FlashStore& store) noexcept : store_(&store) {}
    /// Reads what is kept; the store has been started.
    void start() noexcept;

    [[nodiscard]] std::span<const std::uint8_t, kSlotBytes> slot(std::size_t slot) const noexcept override {
        return slots_[slot];
    }
    [[nodiscard]] bool ready() const noexcept override { return pending_ == Pending::none && !store_->busy(); }
    void erase(std::size_t slot) noexcept override;
    void write(std::size_t slot, std::size_t unit, const Unit& bytes) noexcept override;
    /// Goes on with what was begun here.
    FlashStore::Progress step(std::uint32_t now_ms) noexcept;

private:
    enum class Pending : std::uint8_t { none, erase, write };
    FlashStore* store_;
    std::array<std::array<std::uint8_t, kSlotBytes>, kSlots> slots_{};
    Pending pending_ = Pending::none;
    std::size_t slot_ = 0;
    std::size_t unit_ = 0;
    Unit bytes_{};
};

/// How far a job came, for a start after the battery of the backup RAM has failed. It is kept where a power cut cannot
/// make it wrong: written when the laser is off and at rest, taken back before it may come on again.
class FiredRecord {
public:
    static constexpr std::size_t kKey = FlashParameters::kKeysUsed;

    explicit FiredRecord(FlashStore& store) noexcept : store_(&store) {}
    /// The store has been started.
    void start() noexcept;
    /// As it was at the start, or kept since.
    [[nodiscard]] const std::optional<JobRecord>& record() const noexcept { return record_; }

    /// Both begin a change, which step() does; false while the store is busy.
    bool keep(const JobRecord& record) noexcept;
    bool forget() noexcept;
    /// True when the flash holds no record that firing would make wrong.
    [[nodiscard]] bool may_mark() const noexcept { return pending_ == Pending::none && !in_flash_; }
    FlashStore::Progress step(std::uint32_t now_ms) noexcept;

private:
    enum class Pending : std::uint8_t { none, keep, forget };
    FlashStore* store_;
    std::optional<JobRecord> record_;
    JobRecord wanted_;
    Pending pending_ = Pending::none;
    bool in_flash_ = true;  ///< until start() has looked
};

/// What a controller starts from: the backup RAM's record, or else the flash's, which then goes into the backup RAM.
[[nodiscard]] std::optional<JobRecord> starting_record(RetainedMemory& retained, const FiredRecord& fired) noexcept;

}  // namespace sc::stm32h743
