// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/flash_parameters.hpp"

#include <algorithm>

#include "shared/wire/bytes.hpp"

namespace sc::stm32h743 {
namespace {

static_assert(FiredRecord::kKey < FlashStore::kKeys);
static_assert(ParameterMemory::kUnit <= FlashStore::kBytes);

void put(ByteWriter& out, const JobPlace& place) noexcept {
    out.put(place.fired);
    out.put(place.at.path);
    out.put(place.at.pass);
    out.put(place.at.item);
    out.put(place.at.pulses);
}

void get(ByteReader& in, JobPlace& place) noexcept {
    place.fired = in.get<std::uint32_t>();
    place.at.path = in.get<std::uint32_t>();
    place.at.pass = in.get<std::uint8_t>();
    place.at.item = in.get<std::uint32_t>();
    place.at.pulses = in.get<std::uint32_t>();
}

bool ended(FlashStore::Progress progress) noexcept {
    return progress == FlashStore::Progress::done || progress == FlashStore::Progress::failed;
}

}  // namespace

void FlashParameters::start() noexcept {
    pending_ = Pending::none;
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
        for (std::size_t unit = 0; unit < kUnits; ++unit) {
            const auto to = slots_[slot].begin() + static_cast<std::ptrdiff_t>(unit * kUnit);
            if (const auto kept = store_->get(slot * kUnits + unit)) {
                std::copy_n(kept->begin(), kUnit, to);
            } else {
                std::fill_n(to, kUnit, std::uint8_t{0xFF});
            }
        }
    }
}

void FlashParameters::erase(std::size_t slot) noexcept {
    if (ready() && store_->drop(slot * kUnits, kUnits)) {
        pending_ = Pending::erase;
        slot_ = slot;
    }
}

void FlashParameters::write(std::size_t slot, std::size_t unit, const Unit& bytes) noexcept {
    if (ready() && store_->put(slot * kUnits + unit, bytes)) {
        pending_ = Pending::write;
        slot_ = slot;
        unit_ = unit;
        bytes_ = bytes;
    }
}

FlashStore::Progress FlashParameters::step(std::uint32_t now_ms) noexcept {
    if (pending_ == Pending::none) {
        return FlashStore::Progress::idle;
    }
    const FlashStore::Progress progress = store_->step(now_ms);
    if (!ended(progress)) {
        return progress;
    }
    auto& slot = slots_[slot_];
    if (progress == FlashStore::Progress::done && pending_ == Pending::erase) {
        slot.fill(0xFF);
    } else if (progress == FlashStore::Progress::done) {
        std::ranges::copy(bytes_, slot.begin() + static_cast<std::ptrdiff_t>(unit_ * kUnit));
    }
    pending_ = Pending::none;
    return progress;
}

void FiredRecord::start() noexcept {
    pending_ = Pending::none;
    record_.reset();
    in_flash_ = store_->has(kKey);
    if (const auto kept = store_->get(kKey)) {
        ByteReader in(*kept);
        JobRecord record;
        record.job = in.get<std::uint64_t>();
        record.items = in.get<std::uint32_t>();
        get(in, record.certain);
        get(in, record.reached);
        record_ = record;
    }
}

bool FiredRecord::keep(const JobRecord& record) noexcept {
    FlashStore::Content content{};
    ByteWriter out(content);
    out.put(record.job);
    out.put(record.items);
    put(out, record.certain);
    put(out, record.reached);
    if (pending_ != Pending::none || !out.ok() || !store_->put(kKey, content)) {
        return false;
    }
    wanted_ = record;
    in_flash_ = true;
    pending_ = Pending::keep;
    return true;
}

bool FiredRecord::forget() noexcept {
    if (pending_ != Pending::none || !store_->drop(kKey, 1)) {
        return false;
    }
    pending_ = Pending::forget;
    return true;
}

FlashStore::Progress FiredRecord::step(std::uint32_t now_ms) noexcept {
    if (pending_ == Pending::none) {
        return FlashStore::Progress::idle;
    }
    const FlashStore::Progress progress = store_->step(now_ms);
    if (!ended(progress)) {
        return progress;
    }
    if (progress == FlashStore::Progress::done) {
        in_flash_ = pending_ == Pending::keep;
        record_ = in_flash_ ? std::optional(wanted_) : std::nullopt;
    }
    pending_ = Pending::none;
    return progress;
}

std::optional<JobRecord> starting_record(RetainedMemory& retained, const FiredRecord& fired) noexcept {
    std::optional<JobRecord> record = retained.read();
    if (!record && fired.record()) {
        record = fired.record();
        retained.write(*record);
    }
    return record;
}

}  // namespace sc::stm32h743
