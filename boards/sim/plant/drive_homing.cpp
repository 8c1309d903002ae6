// SPDX-License-Identifier: Apache-2.0
// The homing of SimDrive. CiA 402: 1, 2 limit switch and index; 17, 18 limit switch; 19 to 22 home switch; 33, 34 next
// index; 35, 37 here. This maker's: −1, −2 hard stop and index, −3, −4 hard stop.
#include <algorithm>
#include <bit>
#include <cmath>

#include "boards/sim/plant/drive.hpp"

namespace sc::sim {
namespace {

constexpr std::int64_t kSettleNs = 20'000'000;
constexpr std::uint16_t kHomingStartBit = 0x10;
/// How far past the edge of the home switch a drive runs before it comes back slowly, as a share of the index pitch.
constexpr double kOvershoot = 0.2;

}  // namespace

SimDrive::HomingWay SimDrive::homing_way() const noexcept {
    const double here = servo_.position();
    const double reference = options_.servo.reference_position;
    const double pitch = options_.index_pitch;
    const auto index_above = [&](double place) { return reference + std::ceil((place - reference) / pitch) * pitch; };
    const auto index_below = [&](double place) { return reference + std::floor((place - reference) / pitch) * pitch; };
    const double low_stop = options_.negative_limit - options_.hard_stop;
    const double high_stop = options_.positive_limit + options_.hard_stop;
    switch (static_cast<std::int8_t>(objects_.get(0x6098))) {
        case 1: return {options_.negative_limit, index_above(options_.negative_limit), false};
        case 2: return {options_.positive_limit, index_below(options_.positive_limit), false};
        case 17: return {options_.negative_limit, options_.negative_limit, false};
        case 18: return {options_.positive_limit, options_.positive_limit, false};
        case 20:
        case 21: return {reference - kOvershoot * pitch, reference, false};
        case 22: return {reference + kOvershoot * pitch, reference, false};
        case 33: return {here, index_below(here), true};
        case 34: return {here, index_above(here), true};
        case 35:
        case 37: return {here, here, true};
        case -1: return {low_stop, index_above(low_stop), false};
        case -2: return {high_stop, index_below(high_stop), false};
        case -3: return {low_stop, low_stop, false};
        case -4: return {high_stop, high_stop, false};
        default: return {here, reference, true};
    }
}

void SimDrive::actuate_homing(std::uint16_t controlword) {
    const bool bit = (controlword & kHomingStartBit) != 0;
    const bool moving = homing_ == Homing::to_switch || homing_ == Homing::searching || homing_ == Homing::settling;
    if (bit && !homing_bit_) {
        way_ = homing_way();
        homing_ = way_.direct ? Homing::searching : Homing::to_switch;
        demand_.go_to(way_.direct ? way_.end : way_.turn, in_units(objects_.get(0x6099, 1)),
                      in_units(objects_.get(0x6099, 2)), in_units(objects_.get(0x609A)));
    } else if (!bit && moving) {
        homing_ = Homing::broken_off;
        demand_.ramp_down(in_units(objects_.get(0x609A)));
    }
    homing_bit_ = bit;
}

void SimDrive::advance_homing(std::int64_t dt_ns) {
    if (homing_ == Homing::to_switch && demand_.at_rest()) {
        homing_ = Homing::searching;
        const double creep = in_units(objects_.get(0x6099, 2));
        demand_.go_to(way_.end, creep, creep, in_units(objects_.get(0x609A)));
    }
    if (homing_ == Homing::searching && demand_.at_rest()) {
        homing_ = reference_hidden_ ? Homing::failed : Homing::settling;
        settled_ns_ = 0;
    }
    if (homing_ != Homing::settling) {
        return;
    }
    settled_ns_ = std::abs(following_error_counts()) <= 1.0 ? settled_ns_ + dt_ns : 0;
    if (settled_ns_ >= kSettleNs) {
        servo_.set_counts_at(way_.end, std::bit_cast<std::int32_t>(objects_.get(0x607C)));
        demand_.hold(way_.end);
        homing_ = Homing::attained;
    }
}

}  // namespace sc::sim
