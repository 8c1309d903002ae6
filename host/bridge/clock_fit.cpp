// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/clock_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace sc::host {
namespace {

constexpr int kSteps = 80;
/// What the cell truncates of its time.
constexpr double kCellGrain = 1e-6;
constexpr double kRounding = 1e-12;

double seconds(Nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }

/// Smallest value of a convex function, by thirds.
template <class Function>
double least_place(double low, double high, const Function& f) {
    for (int i = 0; i < kSteps; ++i) {
        const double a = low + (high - low) / 3.0;
        const double b = high - (high - low) / 3.0;
        (f(a) <= f(b) ? high : low) = f(a) <= f(b) ? b : a;
    }
    return 0.5 * (low + high);
}

/// Where a function that holds at `inside` stops to hold towards `outside`.
template <class Predicate>
double edge(double inside, double outside, const Predicate& holds) {
    if (holds(outside)) {
        return outside;
    }
    for (int i = 0; i < kSteps; ++i) {
        const double middle = 0.5 * (inside + outside);
        (holds(middle) ? inside : outside) = middle;
    }
    return inside;
}

}  // namespace

/// Bounds of offset + rate · x, x in seconds from the reference.
struct ClockFit::Lines {
    struct Point {
        double x;
        double y;
    };
    std::vector<Point> upper;
    std::vector<Point> lower;

    /// Largest and smallest offset at the reference that a rate leaves.
    [[nodiscard]] double high(double rate) const {
        double least = std::numeric_limits<double>::max();
        for (const Point& p : upper) {
            least = std::min(least, p.y - rate * p.x);
        }
        return least;
    }
    [[nodiscard]] double low(double rate) const {
        double most = std::numeric_limits<double>::lowest();
        for (const Point& p : lower) {
            most = std::max(most, p.y - rate * p.x);
        }
        return most;
    }
    /// By how much the bounds contradict each other; convex.
    [[nodiscard]] double gap(double rate) const { return low(rate) - high(rate); }
};

ClockFit::Lines ClockFit::lines(HostTime reference) const {
    Lines out;
    // Rates that drift bend the lines: an old bound is a looser one.
    const auto slack = [&](HostTime at) {
        const double age = seconds(bins_.back().upper.at - at);
        return 0.5 * kRateChange * age * age;
    };
    for (const Bin& bin : bins_) {
        out.upper.push_back({seconds(bin.upper.at - reference), bin.upper.offset_s + slack(bin.upper.at)});
        out.lower.push_back({seconds(bin.lower.at - reference), bin.lower.offset_s - slack(bin.lower.at)});
    }
    return out;
}

void ClockFit::insert(const ClockSample& sample) {
    const Bound upper{sample.sent, static_cast<double>(sample.cell_received_us) * 1e-6 + kCellGrain -
                                       seconds(sample.sent.time_since_epoch())};
    const Bound lower{sample.received,
                      static_cast<double>(sample.cell_sent_us) * 1e-6 - seconds(sample.received.time_since_epoch())};
    const double in_cell = static_cast<double>(sample.cell_sent_us - sample.cell_received_us) * 1e-6;
    const double round_trip = seconds(sample.received - sample.sent) - in_cell;
    round_trip_s_ = samples_ == 0 ? round_trip : std::min(round_trip_s_, round_trip);
    ++samples_;
    if (bins_.empty() || sample.sent.time_since_epoch() / kBin != bins_.back().upper.at.time_since_epoch() / kBin) {
        bins_.push_back({upper, lower});
        if (bins_.size() > kBins) {
            bins_.pop_front();
        }
        return;
    }
    Bin& bin = bins_.back();
    if (upper.offset_s < bin.upper.offset_s) {
        bin.upper = upper;
    }
    if (lower.offset_s > bin.lower.offset_s) {
        bin.lower = lower;
    }
}

void ClockFit::add(const ClockSample& sample) {
    if (sample.received < sample.sent || (!bins_.empty() && sample.sent < bins_.back().upper.at - kBin)) {
        return;
    }
    insert(sample);
    const Lines all = lines(sample.received);
    const double rate = least_place(-kRateMost, kRateMost, [&](double r) { return all.gap(r); });
    if (all.gap(rate) > kJump) {
        bins_.clear();
        samples_ = 0;
        ++restarts_;
        insert(sample);
    }
}

std::optional<ClockEstimate> ClockFit::at(HostTime time) const {
    if (bins_.empty()) {
        return std::nullopt;
    }
    const Lines all = lines(bins_.back().lower.at);
    const double best = least_place(-kRateMost, kRateMost, [&](double r) { return all.gap(r); });
    // So much each bound must give way for any line to be left.
    const double give = std::max(0.0, 0.5 * all.gap(best));
    const auto holds = [&](double r) { return all.gap(r) <= 2.0 * give + kRounding; };
    const double slowest = edge(best, -kRateMost, holds);
    const double fastest = edge(best, kRateMost, holds);
    const double x = seconds(time - bins_.back().lower.at);
    const double drift = 0.5 * kRateChange * x * x;
    const auto highest = [&](double r) { return -(all.high(r) + r * x); };
    const auto lowest = [&](double r) { return all.low(r) + r * x; };
    const double high = -highest(least_place(slowest, fastest, highest)) + give;
    const double low = lowest(least_place(slowest, fastest, lowest)) - give;

    ClockEstimate estimate;
    estimate.rate = 0.5 * (slowest + fastest);
    estimate.rate_uncertainty = 0.5 * (fastest - slowest);
    estimate.offset_s = 0.5 * (all.high(estimate.rate) + all.low(estimate.rate)) + estimate.rate * x;
    estimate.uncertainty_s =
        std::max({high - estimate.offset_s, estimate.offset_s - low, 0.0}) + drift + give + kCellGrain;
    estimate.round_trip_s = round_trip_s_;
    estimate.inconsistency_s = give;
    estimate.samples = samples_;
    estimate.restarts = restarts_;
    return estimate;
}

std::optional<HostTime> ClockFit::host_time(std::uint64_t cell_us) const {
    if (bins_.empty()) {
        return std::nullopt;
    }
    const HostTime reference = bins_.back().lower.at;
    const auto estimate = at(reference);
    const double cell_at_reference = seconds(reference.time_since_epoch()) + estimate->offset_s;
    const double since = (static_cast<double>(cell_us) * 1e-6 - cell_at_reference) / (1.0 + estimate->rate);
    return reference + Nanoseconds(std::llround(since * 1e9));
}

}  // namespace sc::host
