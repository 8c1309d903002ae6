// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_checker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr std::array<std::string_view, kAxisCount> kAxisName{"x", "y", "z", "c"};
constexpr std::array<Breach, 3> kBreach{Breach::speed, Breach::acceleration, Breach::jerk};
/// Samples beyond are refused: third differences of those within fit 64 bits and, exactly, a double.
constexpr std::int64_t kFarthest = 1'000'000'000'000'000;
/// Norm of three differences, each rounded by up to one unit.
constexpr double kNormRounding = 1.7320508075688772;

std::string axis_text(std::size_t axis) { return "axis " + std::string(kAxisName[axis]); }

void need_positive(double value, const std::string& what) {
    if (!(value > 0.0) || !std::isfinite(value)) {
        throw InputError({.problem = what + " is not a positive number",
                          .value = std::to_string(value),
                          .action = "give a finite limit above zero"});
    }
}

void check_input(std::span<const AxisPositions> samples, const MotionLimits& limits, std::span<const Vec3> path,
                 double tolerance) {
    if (samples.empty()) {
        throw InputError({.problem = "there are no samples", .action = "give a motion with at least one"});
    }
    for (std::size_t n = 0; n < samples.size(); ++n) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            if (samples[n][i] > kFarthest || samples[n][i] < -kFarthest) {
                throw InputError({.problem = "sample " + std::to_string(n) + " of " + axis_text(i) +
                                             " is beyond 1000 m or a million degrees",
                                  .value = std::to_string(samples[n][i]),
                                  .action = "check the units: picometres and nanodegrees"});
            }
        }
    }
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        need_positive(limits.axis[i].speed, "the speed limit of " + axis_text(i));
        need_positive(limits.axis[i].acceleration, "the acceleration limit of " + axis_text(i));
        need_positive(limits.axis[i].jerk, "the jerk limit of " + axis_text(i));
    }
    need_positive(limits.path_speed.value_or(1.0), "the limit of path speed");
    need_positive(limits.period, "the period");
    if (!(limits.allow >= 1.0 && limits.allow <= 10.0)) {
        throw InputError({.problem = "the pass limit is out of range",
                          .value = std::to_string(limits.allow),
                          .action = "give a factor from 1 to 10"});
    }
    if (!path.empty()) {
        need_positive(tolerance, "the tolerance of the path");
        need_positive(limits.cover, "the tolerance of vertices");
    }
}

/// Least and greatest part of a chord strictly inside a box, or nothing.
std::optional<std::pair<double, double>> inside(const Vec3& from, const Vec3& to, const Vec3& min, const Vec3& max) {
    double enter = 0.0;
    double leave = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double way = to[i] - from[i];
        if (way == 0.0) {
            if (from[i] <= min[i] || from[i] >= max[i]) {
                return std::nullopt;
            }
            continue;
        }
        const double a = (min[i] - from[i]) / way;
        const double b = (max[i] - from[i]) / way;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave ? std::optional(std::pair(enter, leave)) : std::nullopt;
}

class MotionJudge {
public:
    MotionJudge(std::span<const AxisPositions> samples, const MotionLimits& limits)
        : samples_(samples), limits_(limits), last_(static_cast<std::ptrdiff_t>(samples.size()) - 1) {
        report_.ticks = static_cast<std::int64_t>(samples.size());
        report_.first_tick = limits.first_tick;
        report_.seconds = limits.period * static_cast<double>(last_);
        report_.allow = limits.allow;
    }

    MotionReport run(std::span<const Vec3> path, double tolerance) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            judge_axis(i);
        }
        judge_path_speed();
        judge_travel();
        for (std::size_t box = 0; box < limits_.keep_out.size(); ++box) {
            judge_keep_out(limits_.keep_out[box]);
        }
        if (!path.empty()) {
            judge_deviation(path, tolerance);
        }
        return std::move(report_);
    }

private:
    [[nodiscard]] std::int64_t at(std::size_t axis, std::ptrdiff_t n) const noexcept {
        return samples_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(n, 0, last_))][axis];
    }
    [[nodiscard]] std::int64_t difference(std::size_t axis, std::ptrdiff_t n, std::size_t order) const noexcept {
        const std::int64_t a = at(axis, n);
        const std::int64_t b = at(axis, n - 1);
        if (order == 0) {
            return a - b;
        }
        const std::int64_t c = at(axis, n - 2);
        return order == 1 ? a - 2 * b + c : a - 3 * b + 3 * c - at(axis, n - 3);
    }
    [[nodiscard]] std::int64_t tick(std::ptrdiff_t n) const noexcept {
        return limits_.first_tick + std::clamp<std::ptrdiff_t>(n, 0, last_);
    }
    [[nodiscard]] Vec3 place(std::ptrdiff_t n) const noexcept {
        return {static_cast<double>(at(0, n)), static_cast<double>(at(1, n)), static_cast<double>(at(2, n))};
    }

    /// Of a run of ticks that break one rule the worst is kept: a place, not its ticks, is what one looks for.
    void add(const Violation& violation) {
        ++report_.violations;
        auto& kept = report_.first;
        const bool is_run = !kept.empty() && kept.back().breach == violation.breach &&
                            kept.back().axis == violation.axis && violation.tick <= run_end_ + 1;
        if (is_run) {
            run_end_ = violation.tick;
            if (std::abs(violation.value) > std::abs(kept.back().value)) {
                kept.back() = violation;
            }
        } else if (std::ranges::count(kept, violation.breach, &Violation::breach) <
                   static_cast<std::ptrdiff_t>(kKeptViolations)) {
            run_end_ = violation.tick;
            kept.push_back(violation);
        }
    }

    bool at_rest(std::size_t axis, std::ptrdiff_t n) {
        const double t = limits_.period;
        const double units = units_per_base(axis);
        const double most = limits_.axis[axis].jerk * t * t * t / 6.0;
        const double step = std::abs(static_cast<double>(difference(axis, n, 0)));
        if (step <= most * units * limits_.allow + kDifferenceRounding[0]) {
            return true;
        }
        add({.breach = Breach::not_at_rest,
             .tick = n == last_ ? tick(n) : tick(n - 1),
             .axis = kAxisName[axis],
             .value = step / units / t,
             .limit = most / t});
        return false;
    }

    void judge_axis(std::size_t axis) {
        const AxisLimits& limits = limits_.axis[axis];
        const bool rests_before = at_rest(axis, 1);
        const bool rests_after = last_ < 2 || at_rest(axis, last_);
        MotionRow row{std::string(kAxisName[axis]), axis == index(Axis::c) ? "deg" : "m", {}};
        const std::array<double, 3> most{limits.speed, limits.acceleration, limits.jerk};
        double scale = 1.0 / units_per_base(axis);
        for (std::size_t k = 0; k < 3; ++k) {
            scale /= limits_.period;
            const auto order = static_cast<std::ptrdiff_t>(k);
            Worst& worst = row.worst[k];
            worst = {0.0, most[k], 0.0, tick(0)};
            double largest = 0.0;
            const double bound = most[k] / scale * limits_.allow + kDifferenceRounding[k];
            const std::ptrdiff_t end = rests_after ? last_ + order : last_;
            for (std::ptrdiff_t n = rests_before ? 1 : order + 1; n <= end; ++n) {
                const double size = std::abs(static_cast<double>(difference(axis, n, k)));
                if (size > largest) {
                    largest = size;
                    worst.tick = tick(n);
                }
                if (size > bound) {
                    add({.breach = kBreach[k],
                         .tick = tick(n),
                         .axis = kAxisName[axis],
                         .value = size * scale,
                         .limit = most[k]});
                }
            }
            worst.value = largest * scale;
            worst.ratio = std::max(0.0, largest - kDifferenceRounding[k]) * scale / most[k];
        }
        report_.rows.push_back(std::move(row));
    }

    void judge_path_speed() {
        MotionRow row{"path", "m", {}};
        double scale = 1.0 / kPmPerMetre;
        for (std::size_t k = 0; k < 3; ++k) {
            scale /= limits_.period;
            const double limit = k == 0 ? limits_.path_speed.value_or(0.0) : 0.0;
            Worst& worst = row.worst[k];
            worst = {0.0, limit, 0.0, tick(0)};
            const double rounding = kNormRounding * kDifferenceRounding[k];
            const auto order = static_cast<std::ptrdiff_t>(k);
            for (std::ptrdiff_t n = order + 1; n <= last_; ++n) {
                const double size =
                    norm(Vec3{static_cast<double>(difference(0, n, k)), static_cast<double>(difference(1, n, k)),
                              static_cast<double>(difference(2, n, k))});
                if (size * scale > worst.value) {
                    worst.value = size * scale;
                    worst.tick = tick(n);
                }
                if (limit > 0.0 && size > limit / scale * limits_.allow + rounding) {
                    add({.breach = kBreach[k], .tick = tick(n), .axis = "path", .value = size * scale, .limit = limit});
                }
            }
            worst.ratio = limit > 0.0 ? std::max(0.0, worst.value - rounding * scale) / limit : 0.0;
        }
        report_.rows.push_back(std::move(row));
    }

    void judge_travel() {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            const AxisLimits& axis = limits_.axis[i];
            const double units = units_per_base(i);
            for (std::ptrdiff_t n = 0; n <= last_; ++n) {
                const auto value = static_cast<double>(at(i, n));
                const bool below = value < axis.travel_min * units - 1.0;
                if (below || value > axis.travel_max * units + 1.0) {
                    add({.breach = Breach::travel,
                         .tick = tick(n),
                         .axis = kAxisName[i],
                         .value = value / units,
                         .limit = below ? axis.travel_min : axis.travel_max});
                }
            }
        }
    }

    void judge_keep_out(const KeepOut& box) {
        // The boundary itself is allowed, and so is what rounding can make.
        const Vec3 grid{1.0, 1.0, 1.0};
        const Vec3 min = kPmPerMetre * box.min + grid;
        const Vec3 max = kPmPerMetre * box.max - grid;
        for (std::ptrdiff_t n = 0; n <= last_; ++n) {
            const Vec3 from = place(n - 1);
            const Vec3 to = place(n);
            const auto part = inside(from, to, min, max);
            if (!part) {
                continue;
            }
            const Vec3 middle = from + 0.5 * (part->first + part->second) * (to - from);
            double depth = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < 3; ++i) {
                depth = std::min({depth, middle[i] - min[i], max[i] - middle[i]});
            }
            if (depth > 0.0) {
                add({.breach = Breach::keep_out, .tick = tick(n), .axis = {}, .value = depth / kPmPerMetre});
            }
        }
    }

    void judge_deviation(std::span<const Vec3> path, double tolerance) {
        report_.tolerance = tolerance;
        report_.cover_tolerance = tolerance * limits_.cover;
        report_.deviation = path_deviation(samples_, path, {tolerance, report_.cover_tolerance, limits_.may_return});
        const PathDeviation& d = *report_.deviation;
        if (d.followed) {
            return;
        }
        const std::uint64_t before = report_.violations;
        const double bound = tolerance + 2.0 / kPmPerMetre;
        if (d.start_gap > bound) {
            add({.breach = Breach::path_end, .tick = tick(0), .axis = {}, .value = d.start_gap, .limit = tolerance});
        }
        if (d.end_gap > bound) {
            add({.breach = Breach::path_end, .tick = tick(last_), .axis = {}, .value = d.end_gap, .limit = tolerance});
        }
        for (std::size_t n = 0; n < d.of_sample.size(); ++n) {
            // A float keeps seven digits: the one that decided is the double.
            const double size = n == d.sample ? d.deviation : static_cast<double>(d.of_sample[n]);
            if (size > (n == d.sample ? bound : bound * (1.0 + 1e-6))) {
                add({.breach = Breach::deviation,
                     .tick = tick(static_cast<std::ptrdiff_t>(n)),
                     .axis = {},
                     .value = size,
                     .limit = tolerance});
            }
        }
        if (d.vertex_miss > report_.cover_tolerance + 2.0 / kPmPerMetre) {
            add({.breach = Breach::vertex_skipped,
                 .tick = tick(static_cast<std::ptrdiff_t>(d.miss_sample)),
                 .axis = {},
                 .value = d.vertex_miss,
                 .limit = report_.cover_tolerance});
        }
        if (!d.matched || report_.violations == before) {
            add({.breach = Breach::path_lost,
                 .tick = tick(static_cast<std::ptrdiff_t>(d.lost_sample)),
                 .axis = {},
                 .value = d.lost_distance,
                 .limit = tolerance});
        }
    }

    std::span<const AxisPositions> samples_;
    const MotionLimits& limits_;
    std::ptrdiff_t last_;
    std::int64_t run_end_ = 0;  ///< last tick of the run that was kept last
    MotionReport report_;
};

}  // namespace

double MotionReport::max_limit_ratio() const noexcept {
    double largest = 0.0;
    for (const MotionRow& row : rows) {
        for (const Worst& worst : row.worst) {
            largest = std::max(largest, worst.ratio);
        }
    }
    return largest;
}

MotionReport check_motion(std::span<const AxisPositions> samples, const MotionLimits& limits,
                          std::span<const Vec3> path, double tolerance) {
    check_input(samples, limits, path, tolerance);
    return MotionJudge(samples, limits).run(path, tolerance);
}

MotionLimits default_motion_limits() noexcept {
    const MachineConfig machine = reference_machine();
    MotionLimits limits;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        limits.axis[i].speed = machine.axis[i].speed;
        limits.axis[i].acceleration = machine.axis[i].acceleration;
        limits.axis[i].jerk = machine.axis[i].jerk;
    }
    return limits;
}

}  // namespace sc::host
