// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/sensors/reading.hpp"
#include "shared/geometry/vec.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::sensors {

enum class SurfaceMode : std::uint8_t {
    off = 0,
    check = 1,   ///< refuse, or stop, where the surface is not where it should be
    follow = 2,  ///< and shift y, so that the focus stays on it
};

/// What the Y sensor is used for in a job, and where its beam is: with the axes at q (h, metres), reading r says that
/// the surface is at q + origin + (r − zero) · direction (the host's calibration, `[y_sensor]`).
struct SurfaceSettings {
    SurfaceMode mode = SurfaceMode::off;
    Vec3 origin;
    Vec3 direction{0.0, -1.0, 0.0};
    double zero = 0.0;
    double window = 0.0;  ///< m: the surface may be so far from the commanded focus along y
    double bound = 0.0;   ///< m: following never shifts y by more
};

/// Depth of the surface as the Y sensor has seen it in looks, remembered for when the beam comes there. A reading
/// belongs to the place where the axes were when it was taken (depth y1 + a1 − a2 of design.md); the median of three
/// goes into the memory, a bin of a millimetre each, the oldest forgotten. A look goes along the line that is to be
/// burnt at such a place of the axes that a surface where it should be reads zero. Servo context; besides a few
/// multiplications a tick, each reading takes a median and each fourth tick on a path a look-up, at most one walk over
/// the memory.
class Surface {
public:
    /// Following goes through three low-passes of this time constant, so that its speed, acceleration and jerk stay
    /// below 2, 4 and 8 times bound / kTime, / kTime², / kTime³ whatever the sensor says.
    static constexpr double kTime = 0.060;
    static constexpr double kMostBound = 2e-3;  ///< m
    /// Standing for so long without enough readings, the sensor sees nothing.
    static constexpr std::int64_t kPatienceNs = 300'000'000;
    /// Readings, or look-ups, in a row that must lie outside the window.
    static constexpr std::uint32_t kOutside = 3;

    enum class Verdict : std::uint8_t { waiting, fine, not_seen, off };

    /// `latency_ns`: from a set-point's tick to the axis being there.
    Surface(std::int64_t period_ns, std::int64_t latency_ns) noexcept;

    /// Only while nothing moves: the shift jumps to 0. False, with nothing changed, for numbers out of their range.
    [[nodiscard]] bool set(const SurfaceSettings& settings) noexcept;
    [[nodiscard]] const SurfaceSettings& settings() const noexcept { return settings_; }
    [[nodiscard]] bool on() const noexcept { return settings_.mode != SurfaceMode::off; }

    /// Once a tick while `on`: the reading, and the commanded place of the axes in h for this tick without the shift.
    /// `looking`: what is read is of the line.
    void step(std::int64_t now_ns, const Sample& sample, const Vec3& axes, bool looking) noexcept;

    /// The axes have come, and stand without a shift, where a look begins (`begins`) or where a piece of it ends.
    void stand(bool begins) noexcept;
    /// Of the look up to where they stand; waiting until enough has been read there. not_seen: the sensor has seen
    /// nothing there, or for kSurfaceGap on the way. `depth()` tells what was off.
    [[nodiscard]] Verdict look() const noexcept;

    /// Once a tick while the beam is on a path or about to be, before `step`: its commanded place (h, without the
    /// shift), where a pulse may leave (`lit`), and whether the shift stays (`steady`: mirrors mark). The shift
    /// follows.
    void expect(const Vec3& beam, bool lit, bool steady) noexcept;
    /// Else: the shift returns to 0.
    void release() noexcept;
    /// Where the beam last was lit.
    [[nodiscard]] Verdict verdict() const noexcept { return verdict_; }
    /// Of a place that the beam is to come to.
    [[nodiscard]] Verdict verdict_at(const Vec3& place) noexcept;

    /// The axes are elsewhere than commanded: the shift is 0 from now on.
    void rest() noexcept;
    /// Forgets what was seen (another face, another workpiece).
    void forget() noexcept;

    /// Depth (y in h) that the last verdict was about, m.
    [[nodiscard]] double depth() const noexcept { return depth_; }
    /// What is added to y, m.
    [[nodiscard]] double shift() const noexcept { return pole_[2]; }
    /// The shift has come to rest (to 2 µm) where it should be.
    [[nodiscard]] bool settled() const noexcept;
    /// Largest shift, m.
    [[nodiscard]] double reach() const noexcept {
        return settings_.mode == SurfaceMode::follow ? settings_.bound : 0.0;
    }
    /// Share of the limits of y that following may take: speed, acceleration, jerk.
    [[nodiscard]] std::array<double, 3> cost() const noexcept;

private:
    struct Seen {
        float x = 0.0F;
        float z = 0.0F;
        float y = 0.0F;
    };
    static constexpr std::size_t kPast = 64;  ///< ticks

    void take(const Sample& sample) noexcept;
    void judge_reading(const Vec3& at, double off) noexcept;
    void keep(const Vec3& at) noexcept;
    [[nodiscard]] const Seen* find(double x, double z) noexcept;
    void aim(const Vec3& beam) noexcept;

    std::int64_t period_ns_;
    std::int64_t lag_ticks_;
    SurfaceSettings settings_;
    std::array<Vec3, kPast> past_{};  ///< places of the axes without the shift, by tick
    std::int64_t tick_ = 0;
    std::int64_t past_ticks_ = 0;  ///< how many of them are true
    std::uint32_t count_ = 0;      ///< of the sensor's measurements, as last seen
    std::array<Vec3, 3> last_{};   ///< the last three points of the surface
    std::array<double, 3> off_{};  ///< and how far each was from its place along y
    std::size_t readings_ = 0;
    // The look.
    std::int64_t begun_ = 0;      ///< tick from which readings count
    std::int64_t stood_ = 0;      ///< tick since which the axes stand
    std::uint32_t at_stand_ = 0;  ///< readings since then
    bool stands_ = false;
    bool has_good_ = false;
    Vec3 good_;                  ///< the last place that was seen well
    std::uint32_t outside_ = 0;  ///< in a row
    Verdict look_ = Verdict::fine;
    // The memory.
    std::array<Seen, kSurfacePlaces> seen_{};
    std::size_t seen_size_ = 0;
    std::size_t seen_next_ = 0;
    std::size_t hint_ = 0;  ///< where the last look-up found something
    float bin_x_ = 0.0F;    ///< where the newest bin begins
    float bin_z_ = 0.0F;
    std::uint32_t bin_count_ = 0;  ///< readings in it; 0: the next begins a new one
    // The beam.
    Verdict verdict_ = Verdict::waiting;
    std::uint32_t beam_outside_ = 0;
    double depth_ = 0.0;
    double target_ = 0.0;
    std::array<double, 3> pole_{};
};

}  // namespace sc::sensors
