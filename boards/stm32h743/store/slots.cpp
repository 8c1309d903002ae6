// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/slots.hpp"

#include <span>

#include "shared/wire/bytes.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::size_t kKey = 0;
constexpr std::uint8_t kLayout = 1;

constexpr bool disjoint() noexcept {
    std::array<bool, FlashMemory::kSectors> used{};
    bool once = true;
    const auto use = [&](unsigned first, unsigned count) {
        for (unsigned i = first; i < first + count; ++i) {
            once = once && !used[i];
            used[i] = true;
        }
    };
    use(flash_layout::kBootLoader, 1);
    for (std::size_t i = 0; i < 2; ++i) {
        use(flash_layout::kSlots[i], flash_layout::kSlotSectors);
        use(flash_layout::kStates[i], 1);
        use(flash_layout::kStore[i], 1);
    }
    return once;
}
static_assert(disjoint());
// A sector of a bank cannot be read while another of it is erased: an image never works upon its own bank's slot.
static_assert(flash_layout::kSlots[0] + flash_layout::kSlotSectors <= FlashMemory::kSectors / 2 &&
              flash_layout::kSlots[1] >= FlashMemory::kSectors / 2);

constexpr std::size_t index(Slot slot) noexcept { return static_cast<std::size_t>(slot); }
constexpr Slot other(Slot slot) noexcept { return slot == Slot::a ? Slot::b : Slot::a; }

std::optional<SlotRecord> decode(const FlashStore::Content& content) noexcept {
    ByteReader in(content);
    const auto layout = in.get<std::uint8_t>();
    SlotRecord record;
    bool valid = layout == kLayout;
    for (SlotState& state : record.state) {
        state = static_cast<SlotState>(in.get<std::uint8_t>());
        valid = valid && state <= SlotState::bad;
    }
    record.starts = in.get<std::uint8_t>();
    record.newest = static_cast<Slot>(in.get<std::uint8_t>());
    return valid && record.newest <= Slot::b ? std::optional(record) : std::nullopt;
}

}  // namespace

Choice choose(const std::optional<SlotRecord>& record, bool verified_a, bool verified_b, bool trial) noexcept {
    const std::array<bool, 2> verified{verified_a, verified_b};
    SlotRecord next;
    if (record) {
        next = *record;
    } else {
        next.state = {verified_a ? SlotState::confirmed : SlotState::empty,
                      verified_b ? SlotState::confirmed : SlotState::empty};
        next.newest = verified_a ? Slot::a : Slot::b;
    }
    std::optional<Slot> slot;
    const std::array<Slot, 2> order{other(next.newest), next.newest};
    for (const Slot one : order) {
        SlotState& state = next.state[index(one)];
        if (slot || (state != SlotState::written && state != SlotState::on_trial)) {
            continue;
        }
        const std::uint8_t starts = state == SlotState::written ? std::uint8_t{0} : next.starts;
        if (!verified[index(one)] || starts >= kTrialStarts) {
            state = SlotState::bad;
        } else if (trial) {
            state = SlotState::on_trial;
            next.starts = static_cast<std::uint8_t>(starts + 1);
            slot = one;
        }
    }
    for (const SlotState state : {SlotState::confirmed, SlotState::empty}) {
        for (const Slot one : {next.newest, other(next.newest)}) {
            // The last resort: an image that is whole, though the record of that was cut.
            if (!slot && next.state[index(one)] == state && verified[index(one)]) {
                slot = one;
            }
        }
    }
    Choice choice;
    choice.slot = slot;
    if (record != next && (record || slot)) {
        choice.record = next;
    }
    return choice;
}

void Slots::start() noexcept {
    phase_ = Phase::idle;
    begun_ = false;
    chosen_.reset();
    updating_.reset();
    const auto content = states_->get(kKey);
    record_ = content ? decode(*content) : std::nullopt;
}

bool Slots::put(const SlotRecord& record, Phase phase) noexcept {
    std::array<std::uint8_t, 5> content{};
    ByteWriter out(content);
    out.put(kLayout);
    out.put(static_cast<std::uint8_t>(record.state[0]));
    out.put(static_cast<std::uint8_t>(record.state[1]));
    out.put(record.starts);
    out.put(static_cast<std::uint8_t>(record.newest));
    if (!states_->put(kKey, content)) {
        return false;
    }
    wanted_ = record;
    phase_ = phase;
    return true;
}

bool Slots::begin_choice(bool verified_a, bool verified_b) noexcept {
    if (busy() || states_->busy()) {
        return false;
    }
    verified_ = {verified_a, verified_b};
    const Choice choice = choose(record_, verified_a, verified_b);
    chosen_ = choice.slot;
    on_trial_ = chosen_ && choice.record && choice.record->state[index(*chosen_)] == SlotState::on_trial;
    phase_ = Phase::choice;
    return !choice.record || put(*choice.record, Phase::choice);
}

Slots::Refusal Slots::begin_update(Slot running) noexcept {
    if (busy() || states_->busy() || flash_->working()) {
        return Refusal::busy;
    }
    if (flash_->marking()) {
        return Refusal::marking;
    }
    if (known().state[index(running)] != SlotState::confirmed) {
        return Refusal::not_ready;
    }
    SlotRecord next = known();
    next.state[index(other(running))] = SlotState::empty;
    next.newest = running;
    next.starts = 0;
    if (!put(next, Phase::invalidate)) {
        return Refusal::busy;
    }
    updating_ = other(running);
    erased_ = 0;
    next_word_ = 0;
    return Refusal::none;
}

Slots::Refusal Slots::write(const Word& word) noexcept {
    if (busy()) {
        return Refusal::busy;
    }
    if (!updating_ || next_word_ == kWords) {
        return Refusal::order;
    }
    word_ = word;
    phase_ = Phase::word;
    return Refusal::none;
}

Slots::Refusal Slots::finish(bool verified) noexcept {
    if (busy() || states_->busy()) {
        return Refusal::busy;
    }
    if (!updating_ || !verified) {
        updating_.reset();
        return Refusal::order;
    }
    SlotRecord next = known();
    next.state[index(*updating_)] = SlotState::written;
    next.starts = 0;
    return put(next, Phase::finish) ? Refusal::none : Refusal::busy;
}

Slots::Refusal Slots::confirm(Slot running) noexcept {
    if (busy() || states_->busy()) {
        return Refusal::busy;
    }
    SlotRecord next = known();
    if (next.state[index(running)] == SlotState::confirmed) {
        return Refusal::none;
    }
    next.state[index(running)] = SlotState::confirmed;
    next.newest = running;
    next.starts = 0;
    return put(next, Phase::confirm) ? Refusal::none : Refusal::busy;
}

Slots::Progress Slots::step(std::uint32_t now_ms) noexcept {
    switch (phase_) {
        case Phase::idle: return Progress::idle;
        case Phase::erase:
        case Phase::word: return step_flash(now_ms);
        case Phase::choice:
        case Phase::invalidate:
        case Phase::finish:
        case Phase::confirm: break;
    }
    return step_record(now_ms);
}

Slots::Progress Slots::step_record(std::uint32_t now_ms) noexcept {
    const Progress progress = states_->step(now_ms);
    if (progress == Progress::working || progress == Progress::put_off) {
        return progress;
    }
    if (progress == Progress::done) {
        record_ = wanted_;
    }
    if (phase_ == Phase::choice) {
        // The count is not kept: a trial would have no end.
        if (progress == Progress::failed && on_trial_) {
            chosen_ = choose(record_, verified_[0], verified_[1], false).slot;
        }
        return end(Progress::done);
    }
    if (phase_ == Phase::invalidate && progress == Progress::done) {
        phase_ = Phase::erase;
        return Progress::working;
    }
    updating_.reset();
    return end(progress);
}

Slots::Progress Slots::step_flash(std::uint32_t now_ms) noexcept {
    if (!begun_) {
        if (flash_->working()) {
            return Progress::working;  // for somebody else
        }
        const FlashMemory::Begin begin =
            phase_ == Phase::erase
                ? flash_->erase(flash_layout::kSlots[index(*updating_)] + erased_)
                : flash_->program(start_of(*updating_) + static_cast<Address>(next_word_ * FlashMemory::kWordBytes),
                                  word_);
        if (begin == FlashMemory::Begin::marking) {
            return Progress::put_off;
        }
        begun_ = begin == FlashMemory::Begin::begun;
        if (begun_) {
            return Progress::working;
        }
        updating_.reset();
        return end(Progress::failed);
    }
    const FlashMemory::Progress progress = flash_->step(now_ms);
    if (progress == FlashMemory::Progress::working) {
        return Progress::working;
    }
    begun_ = false;
    if (progress != FlashMemory::Progress::done) {
        updating_.reset();
        return end(Progress::failed);
    }
    if (phase_ == Phase::erase) {
        return ++erased_ == flash_layout::kSlotSectors ? end(Progress::done) : Progress::working;
    }
    ++next_word_;
    return end(Progress::done);
}

Slots::Progress Slots::end(Progress how) noexcept {
    phase_ = Phase::idle;
    return how;
}

}  // namespace sc::stm32h743
