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
constexpr std::size_t kNext = 6;          ///< places about the last one found, tried first

bool within(double value, double limit) noexcept { return value >= -limit && value <= limit; }

/// Which is the middle one.
std::size_t median(const std::array<double, 3>& v) noexcept {
    if ((v[0] <= v[1]) == (v[1] <= v[2])) {
        return 1;
    }
    return (v[1] <= v[0]) == (v[0] <= v[2]) ? 0 : 2;
}

double apart2(double x, double z) noexcept { return x * x + z * z; }

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
    seen_size_ = seen_next_ = hint_ = 0;
    bin_count_ = 0;
    stands_ = has_good_ = false;
    look_ = Verdict::fine;
    verdict_ = Verdict::waiting;
    beam_outside_ = 0;
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

void Surface::step(std::int64_t now_ns, const Sample& sample, const Vec3& axes, bool looking) noexcept {
    tick_ = now_ns / period_ns_;
    past_[static_cast<std::size_t>(tick_) % kPast] = axes;
    ++past_ticks_;
    if (sample.count != count_) {
        count_ = sample.count;
        if (looking && usable(sample.quality)) {
            take(sample);
        }
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

// --- the look

void Surface::stand(bool begins) noexcept {
    stands_ = true;
    stood_ = tick_ + 1;
    at_stand_ = 0;
    if (begins) {
        begun_ = stood_;
        readings_ = 0;
        outside_ = 0;
        has_good_ = false;
        bin_count_ = 0;
        look_ = Verdict::fine;
    }
}

Surface::Verdict Surface::look() const noexcept {
    if (look_ != Verdict::fine) {
        return look_;
    }
    if (stands_ && at_stand_ >= last_.size()) {
        // Three readings here: their median is of this place.
        return outside_ > 0 ? Verdict::off : Verdict::fine;
    }
    return (tick_ - stood_) * period_ns_ > kPatienceNs ? Verdict::not_seen : Verdict::waiting;
}

void Surface::take(const Sample& sample) noexcept {
    const std::int64_t then = sample.measured_ns / period_ns_ - lag_ticks_;
    const std::int64_t oldest =
        tick_ - (past_ticks_ < static_cast<std::int64_t>(kPast) ? past_ticks_ : static_cast<std::int64_t>(kPast)) + 1;
    if (then < oldest || then > tick_ || then < begun_) {
        return;
    }
    const double along = static_cast<double>(sample.value) * kMetresPerValue - settings_.zero;
    const Vec3 at = past_[static_cast<std::size_t>(then) % kPast] + settings_.origin + along * settings_.direction;
    last_ = {last_[1], last_[2], at};
    off_ = {off_[1], off_[2], along * settings_.direction.y};
    readings_ += readings_ < last_.size() ? 1 : 0;
    at_stand_ += then >= stood_ ? 1 : 0;
    if (readings_ == last_.size()) {
        const std::size_t middle = median(off_);
        judge_reading(last_[middle], off_[middle]);
    }
}

void Surface::judge_reading(const Vec3& at, double off) noexcept {
    if (!within(off, settings_.window)) {
        depth_ = at.y;
        if (++outside_ >= kOutside) {
            look_ = Verdict::off;
        }
        return;
    }
    if (has_good_ && apart2(at.x - good_.x, at.z - good_.z) > kSurfaceGap * kSurfaceGap) {
        look_ = outside_ > 0 ? Verdict::off : Verdict::not_seen;
        return;
    }
    outside_ = 0;
    has_good_ = true;
    good_ = at;
    keep(at);
}

// --- the memory

void Surface::keep(const Vec3& at) noexcept {
    const auto x = static_cast<float>(at.x);
    const auto z = static_cast<float>(at.z);
    const auto y = static_cast<float>(at.y);
    constexpr auto kBin = static_cast<float>(kSurfaceBin);
    const float dx = x - bin_x_;
    const float dz = z - bin_z_;
    if (bin_count_ > 0 && dx * dx + dz * dz < kBin * kBin) {
        Seen& newest = seen_[(seen_next_ + kSurfacePlaces - 1) % kSurfacePlaces];
        bin_count_ += bin_count_ < 1000 ? 1 : 0;
        const float share = 1.0F / static_cast<float>(bin_count_);
        newest.x += share * (x - newest.x);
        newest.z += share * (z - newest.z);
        newest.y += share * (y - newest.y);
        return;
    }
    bin_x_ = x;
    bin_z_ = z;
    bin_count_ = 1;
    seen_[seen_next_] = {x, z, y};
    seen_next_ = (seen_next_ + 1) % kSurfacePlaces;
    seen_size_ = seen_size_ < kSurfacePlaces ? seen_size_ + 1 : kSurfacePlaces;
}

/// The nearest place within reach: about the last one found, or else of all.
const Surface::Seen* Surface::find(double x, double z) noexcept {
    const auto fx = static_cast<float>(x);
    const auto fz = static_cast<float>(z);
    constexpr auto kReach = static_cast<float>(kSurfaceReach);
    constexpr auto kNear = static_cast<float>(0.5 * kSurfaceBin);
    std::size_t best = seen_size_;
    float nearest = kReach * kReach;
    const auto look_at = [&](std::size_t i) noexcept {
        const float dx = fx - seen_[i].x;
        const float dz = fz - seen_[i].z;
        const float apart = dx * dx + dz * dz;
        if (apart < nearest) {
            nearest = apart;
            best = i;
        }
    };
    const std::size_t from = hint_ > kNext ? hint_ - kNext : 0;
    for (std::size_t i = from; i < seen_size_ && i < hint_ + kNext; ++i) {
        look_at(i);
    }
    if (!(nearest < kNear * kNear)) {
        for (std::size_t i = 0; i < seen_size_; ++i) {
            look_at(i);
        }
    }
    if (best == seen_size_) {
        return nullptr;
    }
    hint_ = best;
    return &seen_[best];
}

// --- the beam

Surface::Verdict Surface::verdict_at(const Vec3& place) noexcept {
    const Seen* const seen = find(place.x, place.z);
    depth_ = seen != nullptr ? static_cast<double>(seen->y) : place.y;
    if (seen == nullptr) {
        return Verdict::not_seen;
    }
    return within(depth_ - place.y, settings_.window) ? Verdict::fine : Verdict::off;
}

void Surface::expect(const Vec3& beam, bool lit, bool steady) noexcept {
    if ((tick_ + 1) % kEvery != 0) {
        return;
    }
    if (lit) {
        const Verdict now = verdict_at(beam);
        beam_outside_ = now == Verdict::off ? beam_outside_ + 1 : 0;
        if (now != Verdict::off || beam_outside_ >= kOutside) {
            verdict_ = now;
        }
    }
    if (settings_.mode == SurfaceMode::follow && !steady) {
        aim(beam);
    }
}

void Surface::release() noexcept {
    target_ = 0.0;
    verdict_ = Verdict::waiting;
    beam_outside_ = 0;
}

/// The surface where the beam will be once the low-passes have let its depth through; before the line has begun, and
/// where nothing has been seen, the shift stays.
void Surface::aim(const Vec3& beam) noexcept {
    constexpr std::int64_t kBack = 16;
    Vec3 ahead = beam;
    if (past_ticks_ > kBack) {
        const Vec3& now = past_[static_cast<std::size_t>(tick_) % kPast];
        const Vec3& before = past_[static_cast<std::size_t>(tick_ - kBack) % kPast];
        const double times = 3.0 * kTime / (static_cast<double>(kBack * period_ns_) * 1e-9);
        ahead.x += times * (now.x - before.x);
        ahead.y += times * (now.y - before.y);
        ahead.z += times * (now.z - before.z);
    }
    if (const Seen* const seen = find(ahead.x, ahead.z)) {
        target_ = larger(-settings_.bound, smaller(settings_.bound, static_cast<double>(seen->y) - ahead.y));
    }
}

}  // namespace sc::sensors
