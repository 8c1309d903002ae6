// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/surface.hpp"

#include "shared/math/scalar.hpp"

namespace sc::sensors {
namespace {

constexpr double kMetresPerValue = 1e-8;
constexpr double kLargestPlace = 1.0;     ///< m: origin and zero of any sensor that is beside a head
constexpr double kLargestWindow = 50e-3;  ///< m
constexpr double kSettled = 2e-6;         ///< m
constexpr double kNothing = 1e-13;        ///< m: below the set-points' grid
constexpr std::int64_t kEvery = 4;        ///< ticks from look-up to look-up

bool within(double value, double limit) noexcept { return value >= -limit && value <= limit; }

/// The middle one by y.
const Vec3& median(const std::array<Vec3, 3>& v) noexcept {
    if ((v[0].y <= v[1].y) == (v[1].y <= v[2].y)) {
        return v[1];
    }
    return (v[1].y <= v[0].y) == (v[0].y <= v[2].y) ? v[0] : v[2];
}

}  // namespace

Surface::Surface(std::int64_t period_ns, std::int64_t latency_ns) noexcept
    : period_ns_(period_ns), lag_ticks_(1 + (latency_ns + period_ns / 2) / period_ns) {}

bool Surface::set(const SurfaceSettings& s) noexcept {
    const double length = dot(s.direction, s.direction);
    const bool beam = within(s.origin.x, kLargestPlace) && within(s.origin.y, kLargestPlace) &&
                      within(s.origin.z, kLargestPlace) && within(s.zero, kLargestPlace) && length > 0.999 &&
                      length < 1.001 && s.direction.y < -0.5;
    const bool sound =
        s.mode == SurfaceMode::off || (beam && s.window > 0.0 && s.window <= kLargestWindow && s.bound >= 0.0 &&
                                       s.bound <= kMostBound && (s.mode != SurfaceMode::follow || s.bound > 0.0));
    if (!sound) {
        return false;
    }
    settings_ = s;
    rest();
    forget();
    return true;
}

void Surface::rest() noexcept {
    pole_ = {};
    target_ = 0.0;
    past_ticks_ = 0;
}

void Surface::forget() noexcept {
    strip_size_ = strip_next_ = 0;
    readings_ = 0;
    outside_ = 0;
    verdict_ = Verdict::waiting;
    waits_ = true;
}

std::array<double, 3> Surface::cost() const noexcept {
    if (settings_.mode != SurfaceMode::follow) {
        return {};
    }
    const double b = settings_.bound;
    return {2.0 * b / kTime, 4.0 * b / (kTime * kTime), 8.0 * b / (kTime * kTime * kTime)};
}

bool Surface::settled() const noexcept {
    return absolute(target_ - pole_[0]) < kSettled && absolute(target_ - pole_[2]) < kSettled;
}

void Surface::step(std::int64_t now_ns, const Sample& sample, const Vec3& place, bool near, bool steady) noexcept {
    tick_ = now_ns / period_ns_;
    past_[static_cast<std::size_t>(tick_) % kPast] = {place.x, place.y + pole_[2], place.z};
    ++past_ticks_;
    usable_now_ = usable(sample.quality);
    if (sample.count != count_) {
        count_ = sample.count;
        if (usable_now_) {
            take(sample);
        }
    }
    if (near && tick_ % kEvery == 0) {
        judge(now_ns, place);
        if (settings_.mode == SurfaceMode::follow && !steady) {
            aim(place);
        }
    }
    if (!near) {
        target_ = 0.0;
    }
    const double share = static_cast<double>(period_ns_) * (1e-9 / kTime);
    double input = target_;
    for (double& pole : pole_) {
        pole += share * (input - pole);
        input = pole;
    }
    if (target_ == 0.0 && within(pole_[0], kNothing) && within(pole_[1], kNothing) && within(pole_[2], kNothing)) {
        pole_ = {};
    }
}

void Surface::take(const Sample& sample) noexcept {
    const std::int64_t then = sample.measured_ns / period_ns_ - lag_ticks_;
    const std::int64_t oldest =
        tick_ - (past_ticks_ < static_cast<std::int64_t>(kPast) ? past_ticks_ : static_cast<std::int64_t>(kPast)) + 1;
    if (then < oldest || then > tick_ || then < 0) {
        return;
    }
    const double along = static_cast<double>(sample.value) * kMetresPerValue - settings_.zero;
    const Vec3 at = past_[static_cast<std::size_t>(then) % kPast] + settings_.origin + along * settings_.direction;
    last_ = {last_[1], last_[2], at};
    if (readings_ < last_.size()) {
        ++readings_;
        if (readings_ < last_.size()) {
            return;
        }
    }
    const Vec3& kept = median(last_);
    keep(static_cast<float>(kept.x), static_cast<float>(kept.z), static_cast<float>(kept.y));
}

void Surface::keep(float x, float z, float y) noexcept {
    if (strip_size_ > 0) {
        Seen& last = strip_[(strip_next_ + kStrip - 1) % kStrip];
        const float dx = x - last.x;
        const float dz = z - last.z;
        if (dx * dx + dz * dz < kSpacing * kSpacing) {
            last.count = static_cast<std::uint16_t>(last.count < 16 ? last.count + 1 : 16);
            const float share = 1.0F / static_cast<float>(last.count);
            last.y += share * (y - last.y);
            return;
        }
    }
    strip_[strip_next_] = {x, z, y, 1};
    strip_next_ = (strip_next_ + 1) % kStrip;
    strip_size_ = strip_size_ < kStrip ? strip_size_ + 1 : kStrip;
}

const Surface::Seen* Surface::find(double x, double z) const noexcept {
    const auto fx = static_cast<float>(x);
    const auto fz = static_cast<float>(z);
    const Seen* best = nullptr;
    float nearest = kReach * kReach;
    for (std::size_t i = 0; i < strip_size_; ++i) {
        const Seen& seen = strip_[i];
        const float dx = fx - seen.x;
        const float dz = fz - seen.z;
        const float apart = dx * dx + dz * dz;
        if (apart < nearest) {
            nearest = apart;
            best = &seen;
        }
    }
    return best;
}

/// Where the beam is, if the sensor has been there; else where the sensor is.
void Surface::judge(std::int64_t now_ns, const Vec3& place) noexcept {
    const Seen* const seen = find(place.x, place.z);
    if (waits_) {
        waits_ = false;
        seen_ns_ = now_ns;
    }
    if (seen == nullptr && !(usable_now_ && readings_ >= last_.size())) {
        if (now_ns - seen_ns_ > kPatienceNs) {
            verdict_ = Verdict::not_seen;
        }
        return;
    }
    seen_ns_ = now_ns;
    depth_ = seen != nullptr ? static_cast<double>(seen->y) : median(last_).y;
    if (within(depth_ - place.y, settings_.window)) {
        outside_ = 0;
        verdict_ = Verdict::fine;
    } else if (++outside_ >= kOutside) {
        outside_ = kOutside;
        verdict_ = Verdict::off;
    }
}

/// The surface where the beam will be once the low-passes have let its depth through.
void Surface::aim(const Vec3& place) noexcept {
    constexpr std::int64_t kBack = 16;
    Vec3 ahead = place;
    if (past_ticks_ > kBack) {
        const Vec3& before = past_[static_cast<std::size_t>(tick_ - kBack) % kPast];
        const double times = 3.0 * kTime / (static_cast<double>(kBack * period_ns_) * 1e-9);
        ahead.x += times * (place.x - before.x);
        ahead.z += times * (place.z - before.z);
    }
    const Seen* const seen = find(ahead.x, ahead.z);
    if (seen == nullptr && verdict_ != Verdict::fine) {
        return;
    }
    const double wanted = (seen != nullptr ? static_cast<double>(seen->y) : depth_) - place.y;
    target_ = larger(-settings_.bound, smaller(settings_.bound, wanted));
}

}  // namespace sc::sensors
