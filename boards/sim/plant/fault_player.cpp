// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/fault_player.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

namespace sc::sim {

FaultPlayer::FaultPlayer(std::vector<FaultEvent> events) {
    for (FaultEvent& event : events) {
        (event.at_ns ? timed_ : counted_).push_back(std::move(event));
    }
    sort();
}

void FaultPlayer::add(FaultEvent event) {
    (event.at_ns ? timed_ : counted_).push_back(std::move(event));
    sort();
}

void FaultPlayer::sort() {
    for (auto* list : {&timed_, &counted_}) {
        std::ranges::sort(*list, std::ranges::greater{},
                          [](const FaultEvent& e) { return std::tuple(e.at_ns, e.after_pulse, e.line); });
    }
}

std::int64_t FaultPlayer::next_time() const noexcept {
    return timed_.empty() ? std::numeric_limits<std::int64_t>::max() : *timed_.back().at_ns;
}

std::optional<FaultEvent> FaultPlayer::take_at(std::int64_t t_ns) {
    if (next_time() > t_ns) {
        return std::nullopt;
    }
    FaultEvent event = std::move(timed_.back());
    timed_.pop_back();
    records_.push_back({*event.at_ns, event.text, std::nullopt});
    return event;
}

std::optional<FaultEvent> FaultPlayer::take_after(std::uint64_t pulses, std::int64_t t_ns) {
    if (counted_.empty() || *counted_.back().after_pulse > pulses) {
        return std::nullopt;
    }
    FaultEvent event = std::move(counted_.back());
    counted_.pop_back();
    records_.push_back({t_ns, event.text, std::nullopt});
    return event;
}

void FaultPlayer::saw_pulse(std::int64_t t_ns) noexcept {
    for (std::size_t i = first_open_; i < records_.size(); ++i) {
        if (records_[i].open && t_ns > records_[i].t_ns) {
            records_[i].last_pulse_ns = t_ns;
        }
    }
}

void FaultPlayer::came_to_rest() noexcept {
    for (; first_open_ < records_.size(); ++first_open_) {
        records_[first_open_].open = false;
    }
}

}  // namespace sc::sim
