// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/trajectory/spec.hpp"
#include "shared/path/item.hpp"

/// Where the stage (X, Y, Z) is while the mirrors follow a path: a curve over path distance that the host sends, gone
/// through by the path's own progress, made smooth.
///
/// The mirrors stop and turn within a millisecond, a stage does not; so the stage does not see the path's distance d
/// but its mean σ over the last 2 · kSmoothing ticks, by two boxes of kSmoothing each. For any motion with 0 ≤ d' ≤ v,
/// holds and resumes included, then 0 ≤ σ' ≤ v, |σ''| ≤ v/T, |σ'''| ≤ 2v/T² and 0 ≤ d − σ ≤ v T, T = kSmoothing ticks.
/// So what the stage does at most is known from the curve alone, before it moves:
///
///     speed V = |Q'| v    acceleration |Q''| v² + V/T    jerk |Q'''| v³ + 3 |Q''| v² /T + 2 V/T²
///
/// Q'', and Q''' too, at the programmed speed v and the speed V are held to half of each axis' limits, the sums to all
/// of them.

namespace sc::motion {

inline constexpr std::uint32_t kStageSmoothing = 64;  ///< ticks of one box
/// Mirrors' places keep this far inside the field where they are foretold, m. What a curve at half of the acceleration
/// of the reference cell bends away from its chord over the stage's lag is 1.45 mm.
inline constexpr double kFieldMargin = 1.5e-3;
/// Spacing of knots, m.
inline constexpr double kLeastKnotSpacing = 1e-3;
inline constexpr double kMostKnotSpacing = 1.0;

/// Uniform cubic B-spline over path distance; knot i at i · spacing. X, Y, Z in metres. Servo context.
class StageCurve {
public:
    static constexpr std::uint32_t kCapacity = 256;  ///< control points that are known and still needed
    using Point = std::array<double, 3>;
    /// Why a control point is not taken.
    struct Breach {
        bool broken = false;
        std::size_t axis = 0;
        double value = 0.0;  ///< of the limit
    };

    void open() noexcept { first_ = end_ = 0, spacing_ = 0.0; }
    /// False: a spacing that is out of range.
    [[nodiscard]] bool begin(double spacing) noexcept;
    [[nodiscard]] bool begun() const noexcept { return spacing_ > 0.0; }
    [[nodiscard]] double spacing() const noexcept { return spacing_; }
    [[nodiscard]] std::uint32_t size() const noexcept { return end_; }
    [[nodiscard]] bool room() const noexcept { return end_ - first_ < kCapacity; }
    /// Only while room().
    void push(const StageKnot& knot) noexcept;
    /// Whether the stage keeps its limits on the newest interval at this path speed. `tick` in seconds. Some 200
    /// operations.
    [[nodiscard]] Breach check(double speed, double tick, const trajectory::AxisLimits& limits) const noexcept;
    /// The newest control point but `ago`.
    [[nodiscard]] Point knot(std::uint32_t ago = 0) const noexcept { return number(end_ - 1 - ago); }
    /// Control points up to this distance are there.
    [[nodiscard]] bool reaches(double distance) const noexcept;
    /// Place at a distance, held to what is known. At least four control points. Some 90 operations.
    [[nodiscard]] Point at(double distance) const noexcept;
    void forget_before(double distance) noexcept;

private:
    [[nodiscard]] const Point& number(std::uint32_t i) const noexcept { return knots_[i % kCapacity]; }
    [[nodiscard]] std::uint32_t interval(double distance) const noexcept;

    std::array<Point, kCapacity> knots_{};
    std::uint32_t first_ = 0;
    std::uint32_t end_ = 0;
    double spacing_ = 0.0;
    double per_spacing_ = 0.0;
};

/// σ of the path's progress, tick by tick. Exact integers: nothing accumulates.
class StageFollower {
public:
    void open() noexcept { *this = StageFollower{}; }
    /// Progress of this tick in picometres, below 2e15; going back counts as standing. Returns σ in metres.
    double push(std::int64_t distance_pm) noexcept;
    /// σ has come to the path's progress.
    [[nodiscard]] bool settled() const noexcept { return still_ > 2 * kStageSmoothing; }

private:
    std::array<std::int64_t, kStageSmoothing> distance_{};
    std::array<std::int64_t, kStageSmoothing> mean_{};  ///< of the first box, times its length
    std::int64_t first_sum_ = 0;
    std::int64_t second_sum_ = 0;
    std::int64_t most_ = 0;
    std::uint32_t at_ = 0;
    std::uint32_t still_ = 0;  ///< ticks since the progress last changed
};

/// Where the stage was commanded to be in the last ticks, so that the mirrors can take what is left of the path at the
/// moment at which the stage really gets there.
class StageHistory {
public:
    static constexpr std::uint32_t kTicks = 16;
    /// Over x = time since the tick's begin in ticks: c[0] + c[1] x + c[2] x² + c[3] x³.
    using Cubic = std::array<double, 4>;

    /// The stage stands at `place`.
    void fill(const StageCurve::Point& place) noexcept { places_.fill(place), controls_.fill(place); }
    void push(const StageCurve::Point& place) noexcept;
    /// Ticks by which a law may be read late.
    [[nodiscard]] static constexpr bool readable(double late) noexcept {
        return late >= 3.0 && late <= static_cast<double>(kTicks) - 4.0;
    }
    /// The commanded place of an axis `late` ticks before the present tick and on, readable(late): a cubic B-spline
    /// through the set-points. Its piece changes once within the tick, at next_begins(): `next` is the one behind that.
    [[nodiscard]] Cubic law(std::size_t axis, double late, bool next) const noexcept;
    /// In ticks, (0, 1].
    [[nodiscard]] static double next_begins(double late) noexcept;
    /// The stage has not moved for so long as it is remembered.
    [[nodiscard]] bool stands() const noexcept;

private:
    [[nodiscard]] double past(std::size_t axis, std::uint32_t ago) const noexcept {
        return places_[(at_ + kTicks - ago) % kTicks][axis];
    }
    /// Control points of the spline through the set-points, known one tick late.
    [[nodiscard]] double control(std::size_t axis, std::uint32_t ago) const noexcept {
        return controls_[(at_ + kTicks - ago) % kTicks][axis];
    }
    std::array<StageCurve::Point, kTicks> places_{};
    std::array<StageCurve::Point, kTicks> controls_{};
    std::uint32_t at_ = 0;
};

}  // namespace sc::motion
