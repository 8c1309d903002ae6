// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/progress.hpp"

#include <algorithm>
#include <cmath>

namespace sc::host {
namespace {

constexpr double kTurnSeconds = 5.0;
constexpr double kApproachSeconds = 0.7;

/// Walks through the items and tells the seconds that each takes.
class Weigher {
public:
    double operator()(const PathBegin& begin) {
        begin_ = begin;
        has_point_ = false;
        return kApproachSeconds;
    }
    double operator()(const PathPoint& point) {
        const double speed = std::max(1.0, static_cast<double>(begin_.speed_um_s)) * 1e-6;
        const double length = has_point_ ? distance(last_, point) : 0.0;
        last_ = point;
        has_point_ = true;
        return length / speed;
    }
    /// As long as its chords: at most a tenth too short up to a half circle.
    double operator()(const PathArc& arc) { return (*this)(arc.via) + (*this)(arc.to); }
    double operator()(const PathLight&) { return 0.0; }
    double operator()(const StageCurve&) { return 0.0; }
    double operator()(const StageKnot&) { return 0.0; }
    double operator()(const PathEnd&) { return 0.0; }
    double operator()(const Turn&) { return kTurnSeconds; }
    double operator()(const JobEnd&) { return kApproachSeconds; }
    double operator()(const Look& look) {
        const PathPoint place{look.x, look.y, look.z};
        const double way = distance(look_, place);
        look_ = place;
        return look.speed_um_s == 0 ? kApproachSeconds : way / (static_cast<double>(look.speed_um_s) * 1e-6);
    }

private:
    static double distance(const PathPoint& a, const PathPoint& b) {
        const auto d = [](std::int32_t p, std::int32_t q) { return static_cast<double>(p) - static_cast<double>(q); };
        return std::hypot(d(a.x, b.x), d(a.y, b.y), d(a.z, b.z)) / kWireUnitsPerMetre;
    }
    PathBegin begin_;
    PathPoint last_;
    PathPoint look_;
    bool has_point_ = false;
};

}  // namespace

ProgressEstimate::ProgressEstimate(std::span<const Item> items, double expected_seconds) : expected_(expected_seconds) {
    Weigher weigh;
    until_.reserve(items.size() + 1);
    until_.push_back(0.0);
    for (const Item& item : items) {
        until_.push_back(until_.back() + std::visit(weigh, item));
    }
}

double ProgressEstimate::fraction(std::uint32_t fired) const noexcept {
    const double whole = until_.back();
    return whole > 0.0 ? until_[std::min<std::size_t>(fired, until_.size() - 1)] / whole : 1.0;
}

std::optional<Nanoseconds> ProgressEstimate::left(double fraction, Nanoseconds elapsed) const noexcept {
    const double seconds = static_cast<double>(elapsed.count()) * 1e-9;
    const double whole_by_pace = fraction > 0.0 ? seconds / fraction : 0.0;
    if (whole_by_pace <= 0.0 && expected_ <= 0.0) {
        return std::nullopt;
    }
    // The pace is trusted in the measure in which the job is done.
    const double trust = expected_ > 0.0 ? fraction : 1.0;
    const double whole = trust * whole_by_pace + (1.0 - trust) * expected_;
    const double left_s = std::clamp((1.0 - fraction) * whole, 0.0, 1e9);
    return Nanoseconds(std::llround(left_s * 1e9));
}

}  // namespace sc::host
