// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/sensors/reading.hpp"
#include "shared/geometry/vec.hpp"

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

/// Depth of the surface as the Y sensor has seen it, kept for when the beam comes there. Each new reading belongs to
/// the place where the axes were when it was taken (depth y1 + a1 − a2 of design.md); the median of three goes into a
/// strip of places already seen. Servo context; a tick costs some 60 instructions, a reading 300, a look-up 1500 (every
/// fourth tick).
class Surface {
public:
    /// Following goes through three low-passes of this time constant, so that its speed, acceleration and jerk stay
    /// below 2, 4 and 8 times bound / kTime, / kTime², / kTime³ whatever the sensor says.
    static constexpr double kTime = 0.060;
    static constexpr double kMostBound = 2e-3;  ///< m
    /// Without a depth for so long there is none.
    static constexpr std::int64_t kPatienceNs = 100'000'000;
    /// Look-ups in a row that must lie outside the window.
    static constexpr std::uint32_t kOutside = 3;

    enum class Verdict : std::uint8_t { waiting, fine, not_seen, off };

    /// `latency_ns`: from a set-point's tick to the axis being there.
    Surface(std::int64_t period_ns, std::int64_t latency_ns) noexcept;

    /// Only while nothing moves: the shift jumps to 0. False, with nothing changed, for numbers out of their range.
    [[nodiscard]] bool set(const SurfaceSettings& settings) noexcept;
    [[nodiscard]] const SurfaceSettings& settings() const noexcept { return settings_; }
    [[nodiscard]] bool on() const noexcept { return settings_.mode != SurfaceMode::off; }

    /// Once a tick while `on`: the reading, and the commanded place of the focus in h for this tick without the shift.
    /// `near`: the beam is on a path or about to be, so that the shift may follow; else it returns to 0. `steady`: the
    /// axes stand while mirrors mark, and the shift stays.
    void step(std::int64_t now_ns, const Sample& sample, const Vec3& place, bool near, bool steady) noexcept;
    /// The axes are elsewhere than commanded: the shift is 0 from now on.
    void rest() noexcept;
    /// Forgets what was seen (another face, another workpiece).
    void forget() noexcept;

    /// Of the present place.
    [[nodiscard]] Verdict verdict() const noexcept { return verdict_; }
    /// Depth (y in h) that the verdict is about, m.
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
        std::uint16_t count = 0;
    };
    static constexpr std::size_t kPast = 64;    ///< ticks
    static constexpr std::size_t kStrip = 128;  ///< places
    static constexpr float kSpacing = 0.25e-3F;
    static constexpr float kReach = 1.0e-3F;

    void take(const Sample& sample) noexcept;
    void keep(float x, float z, float y) noexcept;
    [[nodiscard]] const Seen* find(double x, double z) const noexcept;
    void judge(std::int64_t now_ns, const Vec3& place) noexcept;
    void aim(const Vec3& place) noexcept;

    std::int64_t period_ns_;
    std::int64_t lag_ticks_;
    SurfaceSettings settings_;
    std::array<Vec3, kPast> past_{};  ///< places with the shift, by tick
    std::int64_t tick_ = 0;
    std::int64_t past_ticks_ = 0;  ///< how many of them are true
    std::array<Vec3, 3> last_{};   ///< the last three points of the surface
    std::size_t readings_ = 0;
    std::uint32_t count_ = 0;  ///< of the sensor's measurements, as last seen
    std::array<Seen, kStrip> strip_{};
    std::size_t strip_size_ = 0;
    std::size_t strip_next_ = 0;
    std::int64_t seen_ns_ = 0;  ///< when a depth was last known
    std::uint32_t outside_ = 0;
    bool usable_now_ = false;
    bool waits_ = true;  ///< for its first look-up
    Verdict verdict_ = Verdict::waiting;
    double depth_ = 0.0;
    double target_ = 0.0;
    std::array<double, 3> pole_{};
};

}  // namespace sc::sensors
