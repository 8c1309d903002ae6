// SPDX-License-Identifier: Apache-2.0
#include "firmware/store/parameter_store.hpp"

#include <algorithm>

#include "shared/hash/crc.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::store {
namespace {

constexpr std::uint32_t kMagic = 0x50'52'43'53;  // "SCRP"
constexpr std::size_t kUnit = ParameterMemory::kUnit;

/// Of the head's fields before it, and of the content.
std::uint32_t check_of(std::uint32_t generation, std::uint16_t layout, std::span<const std::uint8_t> bytes) noexcept {
    std::array<std::uint8_t, 8> fields{};
    ByteWriter out(fields);
    out.put(generation);
    out.put(layout);
    out.put(static_cast<std::uint16_t>(bytes.size()));
    Crc32 crc;
    crc.update(fields);
    crc.update(bytes);
    return crc.value();
}

std::optional<Stored> read(const ParameterMemory& memory, std::size_t slot) noexcept {
    const auto all = memory.slot(slot);
    ByteReader in(all.first(kUnit));
    const auto magic = in.get<std::uint32_t>();
    Stored stored;
    stored.slot = slot;
    stored.generation = in.get<std::uint32_t>();
    stored.layout = in.get<std::uint16_t>();
    const auto size = in.get<std::uint16_t>();
    const auto check = in.get<std::uint32_t>();
    if (magic != kMagic || stored.generation == 0 || size == 0 || size > kMostBytes) {
        return std::nullopt;
    }
    stored.bytes = all.subspan(kUnit, size);
    if (check != check_of(stored.generation, stored.layout, stored.bytes)) {
        return std::nullopt;
    }
    Crc32 crc;
    crc.update(stored.bytes);
    stored.crc = crc.value();
    return stored;
}

}  // namespace

std::optional<Stored> newest(const ParameterMemory& memory) noexcept {
    std::optional<Stored> best;
    for (std::size_t slot = 0; slot < ParameterMemory::kSlots; ++slot) {
        const std::optional<Stored> found = read(memory, slot);
        if (found && (!best || found->generation > best->generation)) {
            best = found;
        }
    }
    return best;
}

void ParameterStore::keep_in(ParameterMemory* memory) noexcept {
    memory_ = memory;
    stored_ = memory_ != nullptr ? newest(*memory_) : std::nullopt;
}

void ParameterStore::begin(std::span<const std::uint8_t> bytes, std::uint16_t layout) noexcept {
    slot_ = stored_ ? 1 - stored_->slot : 0;
    generation_ = stored_ ? stored_->generation + 1 : 1;
    bytes_ = bytes;
    layout_ = layout;
    unit_ = 0;
    phase_ = Phase::erase;
}

ParameterStore::Progress ParameterStore::step(bool allowed) noexcept {
    if (phase_ == Phase::idle) {
        return Progress::idle;
    }
    if (!allowed || !memory_->ready()) {
        return Progress::writing;
    }
    switch (phase_) {
        case Phase::idle: break;
        case Phase::erase:
            // Of both the older one first: until the newest goes, it counts.
            memory_->erase(slot_);
            phase_ = bytes_.empty() ? Phase::erase_other : Phase::content;
            break;
        case Phase::erase_other:
            memory_->erase(1 - slot_);
            phase_ = Phase::look;
            break;
        case Phase::content: {
            const auto rest = bytes_.subspan(unit_ * kUnit);
            ParameterMemory::Unit unit{};
            std::copy_n(rest.begin(), rest.size() < kUnit ? rest.size() : kUnit, unit.begin());
            ++unit_;
            memory_->write(slot_, unit_, unit);
            phase_ = rest.size() > kUnit ? Phase::content : Phase::head;
            break;
        }
        case Phase::head: {
            ParameterMemory::Unit unit{};
            ByteWriter out(unit);
            out.put(kMagic);
            out.put(generation_);
            out.put(layout_);
            out.put(static_cast<std::uint16_t>(bytes_.size()));
            out.put(check_of(generation_, layout_, bytes_));
            memory_->write(slot_, 0, unit);
            phase_ = Phase::look;
            break;
        }
        case Phase::look: {
            phase_ = Phase::idle;
            stored_ = newest(*memory_);
            if (bytes_.empty()) {
                return stored_ ? Progress::failed : Progress::done;
            }
            const bool whole =
                stored_ && stored_->generation == generation_ && std::ranges::equal(stored_->bytes, bytes_);
            return whole ? Progress::done : Progress::failed;
        }
    }
    return Progress::writing;
}

}  // namespace sc::store
