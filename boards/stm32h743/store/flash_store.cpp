// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/flash_store.hpp"

#include <algorithm>

#include "shared/hash/crc.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::uint16_t kMagic = 0x5CE1;
constexpr std::size_t kFirstPart = FlashMemory::kWordBytes;
constexpr std::size_t kSecondPart = FlashStore::kBytes - kFirstPart;

}  // namespace

FlashStore::Record FlashStore::make(Head head, std::span<const std::uint8_t> content) noexcept {
    std::array<std::uint8_t, sizeof(Record)> bytes{};
    std::copy_n(content.begin(), std::min(content.size(), kBytes), bytes.begin());
    ByteWriter out{std::span(bytes).subspan(kBytes)};
    out.put(static_cast<std::uint8_t>(head.kind));
    out.put(head.key);
    out.put(kMagic);
    out.put(crc32(std::span(bytes).first(bytes.size() - 4)));
    Record record{};
    std::copy_n(bytes.begin(), kFirstPart, record[0].begin());
    std::copy_n(bytes.begin() + kFirstPart, FlashMemory::kWordBytes, record[1].begin());
    return record;
}

std::optional<FlashStore::Head> FlashStore::check(const Record& record) noexcept {
    ByteReader in{std::span(record[1]).subspan(kSecondPart)};
    const auto kind = in.get<std::uint8_t>();
    const auto key = in.get<std::uint8_t>();
    const auto magic = in.get<std::uint16_t>();
    const auto crc = in.get<std::uint32_t>();
    Crc32 of;
    of.update(record[0]).update(std::span(record[1]).first(FlashMemory::kWordBytes - 4));
    const bool known = kind >= static_cast<std::uint8_t>(Kind::head) && kind <= static_cast<std::uint8_t>(Kind::drop);
    if (magic != kMagic || crc != of.value() || !known || key >= kKeys) {
        return std::nullopt;
    }
    return Head{static_cast<Kind>(kind), key};
}

FlashStore::Content FlashStore::content_of(const Record& record) noexcept {
    Content content{};
    std::copy_n(record[0].begin(), kFirstPart, content.begin());
    std::copy_n(record[1].begin(), kSecondPart, content.begin() + kFirstPart);
    return content;
}

Address FlashStore::place(std::size_t sector, unsigned slot) const noexcept {
    return FlashMemory::sector_start(sectors_[sector]) + static_cast<Address>(slot * sizeof(Record));
}

bool FlashStore::read(std::size_t sector, unsigned slot, Record& out) const noexcept {
    const Address at = place(sector, slot);
    return flash_->read(at, out[0]) == FlashMemory::Read::good &&
           flash_->read(at + static_cast<Address>(kFirstPart), out[1]) == FlashMemory::Read::good;
}

bool FlashStore::blank(std::size_t sector, unsigned slot) const noexcept {
    Record record{};
    return read(sector, slot, record) && std::ranges::all_of(record, FlashMemory::erased);
}

/// 0: the sector holds no log.
std::uint32_t FlashStore::generation_of(std::size_t sector) const noexcept {
    Record record{};
    if (!read(sector, 0, record)) {
        return 0;
    }
    const std::optional<Head> head = check(record);
    return head && head->kind == Kind::head ? ByteReader(record[0]).get<std::uint32_t>() : 0;
}

void FlashStore::take(const Record& record, Head head, unsigned slot) noexcept {
    if (head.kind == Kind::content) {
        at_[head.key] = static_cast<std::uint16_t>(slot);
    } else if (head.kind == Kind::drop) {
        const std::size_t first = std::min<std::size_t>(record[0][0], kKeys);
        const std::size_t count = std::min<std::size_t>(record[0][1], kKeys - first);
        std::fill_n(at_.begin() + static_cast<std::ptrdiff_t>(first), count, std::uint16_t{0});
    }
}

bool FlashStore::start() noexcept {
    phase_ = Phase::idle;
    begun_ = false;
    at_ = {};
    const std::array<std::uint32_t, 2> generations{generation_of(0), generation_of(1)};
    active_ = generations[1] >= generations[0] ? 1 : 0;
    generation_ = generations[active_];
    last_ = next_ = 0;
    if (generation_ == 0) {
        return false;
    }
    for (unsigned slot = 1; slot < kSlots && slot - last_ <= kMostBlank; ++slot) {
        Record record{};
        const bool good = read(active_, slot, record);
        if (good && std::ranges::all_of(record, FlashMemory::erased)) {
            continue;
        }
        last_ = slot;
        if (const std::optional<Head> head = good ? check(record) : std::nullopt) {
            take(record, *head, slot);
        }
    }
    // One is left out: a program that was cut so early that its word reads as erased may have begun there.
    next_ = last_ + 2;
    return true;
}

std::optional<FlashStore::Content> FlashStore::get(std::size_t key) const noexcept {
    Record record{};
    if (busy() || !has(key) || !read(active_, at_[key], record) || !check(record)) {
        return std::nullopt;
    }
    return content_of(record);
}

bool FlashStore::put(std::size_t key, std::span<const std::uint8_t> content) noexcept {
    return key < kKeys && content.size() <= kBytes &&
           begin(make({Kind::content, static_cast<std::uint8_t>(key)}, content));
}

bool FlashStore::drop(std::size_t first, std::size_t count) noexcept {
    if (first >= kKeys || count > kKeys - first) {
        return false;
    }
    const std::array<std::uint8_t, 2> content{static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(count)};
    return begin(make({Kind::drop, 0}, content));
}

bool FlashStore::begin(const Record& record) noexcept {
    if (busy()) {
        return false;
    }
    wanted_ = writing_ = record;
    word_ = 0;
    tries_ = 0;
    slot_ = next_;
    phase_ = generation_ != 0 && room() ? Phase::append : Phase::erase;
    return true;
}

FlashStore::Progress FlashStore::step(std::uint32_t now_ms) noexcept {
    if (phase_ == Phase::idle) {
        return Progress::idle;
    }
    if (!begun_) {
        return begin_work();
    }
    const FlashMemory::Progress progress = flash_->step(now_ms);
    if (progress == FlashMemory::Progress::working) {
        return Progress::working;
    }
    begun_ = false;
    return after_work(progress == FlashMemory::Progress::done);
}

FlashStore::Progress FlashStore::begin_work() noexcept {
    if (flash_->working()) {
        return Progress::working;  // for somebody else
    }
    const std::size_t sector = phase_ == Phase::append ? active_ : 1 - active_;
    const Address at = place(sector, slot_) + static_cast<Address>(word_ * FlashMemory::kWordBytes);
    const FlashMemory::Begin begin =
        phase_ == Phase::erase ? flash_->erase(sectors_[sector]) : flash_->program(at, writing_[word_]);
    switch (begin) {
        case FlashMemory::Begin::begun: begun_ = true; return Progress::working;
        case FlashMemory::Begin::marking: return Progress::put_off;
        case FlashMemory::Begin::not_erased: return after_work(false);
        case FlashMemory::Begin::place:
        case FlashMemory::Begin::busy:
        case FlashMemory::Begin::locked: break;
    }
    return failed();
}

FlashStore::Progress FlashStore::after_work(bool well) noexcept {
    if (phase_ == Phase::erase) {
        if (!well) {
            return failed();
        }
        copied_at_ = {};
        copy_key_ = 0;
        slot_ = 1;
        next_copy();
        return Progress::working;
    }
    if (well && ++word_ < writing_.size()) {
        return Progress::working;
    }
    word_ = 0;
    if (!well) {
        if (phase_ == Phase::append) {
            last_ = blank(active_, slot_) ? last_ : slot_;
            next_ = slot_ + 1;
        }
        // The head has one place only; all else may lie in the next slot.
        if (phase_ == Phase::seal || ++tries_ == kTries || (phase_ == Phase::append && !room())) {
            return failed();
        }
        ++slot_;
        return Progress::working;
    }
    if (phase_ == Phase::copy) {
        copied_at_[copy_key_++] = static_cast<std::uint16_t>(slot_++);
        next_copy();
        return Progress::working;
    }
    if (phase_ == Phase::seal) {
        active_ = 1 - active_;
        ++generation_;
        at_ = copied_at_;
        last_ = copied_last_;
        slot_ = next_ = last_ + 1;
        writing_ = wanted_;
        tries_ = 0;
        phase_ = Phase::append;
        return Progress::working;
    }
    if (const std::optional<Head> head = check(wanted_)) {
        take(wanted_, *head, slot_);
    }
    last_ = slot_;
    next_ = slot_ + 1;
    phase_ = Phase::idle;
    return Progress::done;
}

/// The next record that is kept goes into the other sector, after the last one its head.
void FlashStore::next_copy() noexcept {
    for (; copy_key_ < kKeys; ++copy_key_) {
        if (at_[copy_key_] != 0 && read(active_, at_[copy_key_], writing_)) {
            phase_ = Phase::copy;
            return;
        }
    }
    std::array<std::uint8_t, 4> generation{};
    ByteWriter(generation).put(generation_ + 1);
    writing_ = make({Kind::head, 0}, generation);
    copied_last_ = slot_ - 1;
    slot_ = 0;
    phase_ = Phase::seal;
}

FlashStore::Progress FlashStore::failed() noexcept {
    phase_ = Phase::idle;
    return Progress::failed;
}

}  // namespace sc::stm32h743
