// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/motion/error_predictor.hpp"
#include "shared/machine/machine.hpp"

namespace sc {

/// Where the axes were measured, and when.
struct AxisSample {
    std::int64_t t_ns = 0;  ///< control time of the measurement, not of its arrival
    AxisPositions place{};  ///< pm / ndeg, as the encoders have it
};

/// What the mirrors add to their place during a tick so that the beam stands where the path says although the axes do
/// not: (asked of the axes − measured), predicted to when the mirrors will stand, of X and Z as they are and of C by
/// the surface's distance from the turntable's axis. Metres at the surface.
///
/// An axis is where its set-point was its latency ago; an encoder's sample of time t belongs to the set-point of
/// t − latency. The frames of tick n leave from t_n+1 on, and the mirrors stand there the galvo's latency later: the
/// place at the end of each tick is predicted to t_n+2 + latency, and the frames before go there by a cubic that begins
/// with the place and speed of the tick before. Within ± kBound, no faster than the mirrors' jerk allows a cubic to
/// turn within a tick; dark, or without samples for kStaleNs, back to zero.
class AxisFollower {
public:
    explicit AxisFollower(const MachineConfig& machine) noexcept;

    /// The error that predictors are laid out for.
    static constexpr double kDesignAmplitude = 50e-6;
    static constexpr double kDesignBandwidthHz = 20.0;
    static constexpr double kBound = 200e-6;
    static constexpr std::int64_t kStaleNs = 12'000'000;

    /// The mirrors stand so long behind their frames.
    void set_mirror_latency(std::int64_t ns) noexcept { mirror_latency_ns_ = ns; }

    /// Set-points of a tick, in each tick.
    void note(std::int64_t tick, const AxisPositions& set_point) noexcept;
    /// A measurement, in order of time. 80 operations.
    void take(const AxisSample& sample) noexcept;

    /// One mirror over a tick: the values at its frames are place + u (speed + u (bend + u · twist)), u from 0 to 1.
    struct Cubic {
        double place = 0.0;
        double speed = 0.0;
        double bend = 0.0;
        double twist = 0.0;
    };
    struct Shift {
        Cubic x;
        Cubic z;
    };
    /// For the frames of this tick; none while the mirrors have nothing to take up. `from_table`: how far the surface
    /// lies from the turntable's axis along y, metres. 100 operations.
    [[nodiscard]] std::optional<Shift> step(std::int64_t tick, bool marking, double from_table) noexcept;

    /// Jumps to nothing: other moves of the mirrors begin.
    void drop() noexcept { x_ = z_ = {}; }
    [[nodiscard]] double x() const noexcept { return x_.place; }
    [[nodiscard]] double z() const noexcept { return z_.place; }

private:
    static constexpr std::size_t kHistory = 32;
    struct Mirror {
        double place = 0.0;
        double speed = 0.0;  ///< per tick
    };
    [[nodiscard]] double asked(std::size_t axis, std::int64_t t_ns) const noexcept;
    [[nodiscard]] Cubic go(Mirror& mirror, double place, double speed) const noexcept;

    MachineConfig machine_;
    double period_s_;
    double most_step_;  ///< metres a tick
    std::int64_t mirror_latency_ns_;
    std::array<std::array<std::int64_t, kAxisCount>, kHistory> history_{};
    std::int64_t newest_ = 0;  ///< tick
    std::int64_t oldest_ = 0;
    bool sampled_ = false;
    std::int64_t sample_ns_ = 0;
    motion::ErrorPredictor x_error_;  ///< m
    motion::ErrorPredictor z_error_;
    motion::ErrorPredictor c_error_;  ///< degrees
    Mirror x_;
    Mirror z_;
};

}  // namespace sc
