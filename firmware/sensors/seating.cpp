// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/seating.hpp"

namespace sc::sensors {
namespace {

using Three = std::array<std::int64_t, kTripleCount>;

constexpr std::int64_t magnitude(std::int64_t v) noexcept { return v < 0 ? -v : v; }

std::int64_t mean(const Three& v) noexcept { return (v[0] + v[1] + v[2]) / 3; }

std::int64_t spread(const Three& v) noexcept {
    std::int64_t least = v[0];
    std::int64_t most = v[0];
    for (const std::int64_t one : v) {
        least = one < least ? one : least;
        most = one > most ? one : most;
    }
    return most - least;
}

bool fits(const Three& deviation, const SeatingWanted& wanted) noexcept {
    for (const std::int64_t one : deviation) {
        if (magnitude(one) > wanted.tolerance) {
            return false;
        }
    }
    return spread(deviation) <= wanted.tilt;
}

/// Every other order of three.
constexpr std::array<std::array<std::uint8_t, kTripleCount>, 5> kOrders{
    {{0, 2, 1}, {1, 0, 2}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}}};

}  // namespace

bool SeatingCheck::begin(const SeatingWanted& wanted, std::int64_t now_ns) noexcept {
    bool sound = wanted.samples >= 1 && wanted.samples <= kMostSamples && wanted.tolerance > 0 && wanted.tilt > 0;
    for (const SensorValue one : wanted.expected) {
        sound = sound && one > 0;
    }
    if (!sound) {
        return false;
    }
    wanted_ = wanted;
    busy_ = true;
    begun_ns_ = now_ns;
    until_ns_ = now_ns + (wanted.samples + 1) * kPatienceNs;
    taken_ = {};
    sum_ = {};
    seen_ = {};
    return true;
}

SeatingCheck::Result SeatingCheck::step(const SensorHub& hub, std::int64_t now_ns) noexcept {
    if (!busy_) {
        return {};
    }
    bool all = true;
    for (std::size_t i = 0; i < kTripleCount; ++i) {
        const Sample sample = hub.sample(kFirstTriple + i);
        const bool fresh = usable(sample.quality) && sample.count != seen_[i] && sample.measured_ns >= begun_ns_;
        if (fresh && taken_[i] < wanted_.samples) {
            seen_[i] = sample.count;
            ++taken_[i];
            sum_[i] += sample.value;
        }
        all = all && taken_[i] == wanted_.samples;
        if (now_ns >= until_ns_ && taken_[i] < wanted_.samples) {
            busy_ = false;
            const auto code = sample.code == SensorCode::none ? SensorCode::too_old : sample.code;
            return {true, Refusal::seating_no_value,
                    static_cast<std::int64_t>(i + 1) * 1000 + static_cast<std::int64_t>(code)};
        }
    }
    if (!all) {
        return {};
    }
    busy_ = false;
    return compare();
}

SeatingCheck::Result SeatingCheck::compare() noexcept {
    Three found{};
    Three deviation{};
    for (std::size_t i = 0; i < kTripleCount; ++i) {
        found[i] = sum_[i] / wanted_.samples;
        deviation[i] = found[i] - wanted_.expected[i];
        deviation_[i] = static_cast<SensorValue>(deviation[i]);
    }
    if (fits(deviation, wanted_)) {
        return {true, Refusal::none, 0};
    }
    for (const auto& order : kOrders) {
        Three other{};
        for (std::size_t i = 0; i < kTripleCount; ++i) {
            other[i] = found[order[i]] - wanted_.expected[i];
        }
        if (fits(other, wanted_)) {
            return {true, Refusal::seating_swapped, (order[0] + 1) * 100 + (order[1] + 1) * 10 + order[2] + 1};
        }
    }
    const std::int64_t off = mean(deviation);
    return magnitude(off) > wanted_.tolerance ? Result{true, Refusal::seating_off, off}
                                              : Result{true, Refusal::seating_tilted, spread(deviation)};
}

}  // namespace sc::sensors
