// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "shared/machine/machine.hpp"
#include "shared/trace/trace.hpp"

/// Judges motion by the emitted samples alone: speed, acceleration and jerk are the differences of set-points as they
/// left the controller, whatever the planner believed. Shares no code with the control path.

namespace sc::host {

/// A rule that an emitted sample broke.
enum class Breach : std::uint8_t {
    missing_tick,  ///< ticks do not follow one another; nothing can be said of the gap
    travel,        ///< set-point of an axis
    speed,         ///< of an axis or a mirror
    acceleration,
    jerk,
    galvo_field,           ///< a mirror beyond its field
    keep_out,              ///< the focus in a keep-out volume
    turn_not_retracted,    ///< C moves while y is not retracted
    gate_outside_marking,  ///< pulses in another state than marking
    not_at_rest,           ///< at the first or last sample of a motion
    path_end,              ///< the motion does not start or end where its path does
    deviation,             ///< a sample is too far from its place on the path
    vertex_skipped,        ///< a point of the path was passed too far off
    path_lost,             ///< the motion does not follow the path to its end in order
};
[[nodiscard]] std::string_view name_of(Breach breach) noexcept;

struct Violation {
    Breach breach = Breach::missing_tick;
    std::int64_t tick = 0;
    int frame = -1;         ///< galvo frame within the tick; −1 = the axes' set-point
    std::string_view axis;  ///< "x", "y", "z", "c", "galvo x", "galvo z"; empty if of none
    double value = 0.0;     ///< base units: m, m/s, ..., degrees for C
    double limit = 0.0;     ///< what it had to stay within, tolerance left out
};

/// Largest magnitudes met, base units.
struct MotionPeak {
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
    std::array<std::int64_t, 3> tick{};  ///< of each
};

struct SampleReport {
    std::uint64_t limit_violations = 0;  ///< all of them
    std::vector<Violation> first;        ///< the first kKeptViolations
    std::array<MotionPeak, kAxisCount> axis_peak{};
    std::array<MotionPeak, 2> galvo_peak{};  ///< x, z
    std::int64_t ticks = 0;
    std::int64_t galvo_frames = 0;
    double cell_seconds = 0.0;
};
inline constexpr std::size_t kKeptViolations = 100;

/// Differences may exceed a limit by this factor: a compensated set-point is a place times a matrix near one.
inline constexpr double kLimitTolerance = 1.005;
/// Compensated set-points may leave travel, or enter a keep-out volume, by this much (metres; degrees / 1000 for C).
inline constexpr double kPlaceTolerance = 0.1e-3;

/// Streaming: a few hundred operations a tick, some 20 per galvo frame.
///
/// Differences count in the states in which the controller moves powered axes by its own set-points; each such stretch
/// must begin at rest. In boot, disabled, enabling, homing, disabling and fault the drives lead and set-points follow.
/// Travel and keep-out count in states that need homed axes. Mirrors are judged in every state; a tick without frames
/// means that they stand at zero.
class SampleChecker {
public:
    /// `allow`: differences may exceed a limit by this factor.
    explicit SampleChecker(const MachineConfig& machine, double allow = kLimitTolerance);

    void add(const trace::SampleRecord& record, std::span<const trace::GalvoSample> frames);
    /// For a trace that is whole: notes each axis that was still moving by the controller's set-points at the end.
    void end();
    [[nodiscard]] const SampleReport& report() const noexcept { return report_; }

private:
    /// Last three samples of one signal; differences are exact integers.
    struct History {
        std::array<std::int64_t, 3> last{};
        void rest_at(std::int64_t sample) noexcept;
        [[nodiscard]] std::array<std::int64_t, 3> push(std::int64_t sample) noexcept;
    };
    /// What one signal's differences are held against, base units.
    struct Bounds {
        double speed = 0.0;
        double acceleration = 0.0;
        double jerk = 0.0;
        double units_per_base = 1.0;  ///< integer units of a base unit
        double period = 1.0;          ///< seconds
        std::string_view name;
    };

    void check_axes(const trace::SampleRecord& record);
    void check_places(const trace::SampleRecord& record);
    void check_turn(const trace::SampleRecord& record, std::int64_t c_step);
    void check_mirrors(const trace::SampleRecord& record, std::span<const trace::GalvoSample> frames);
    void check_mirror_frame(std::int64_t tick, int frame, const trace::GalvoSample& sample);
    void check_focus(const trace::SampleRecord& record, int frame, const trace::GalvoSample& sample);
    void check_differences(const Bounds& bounds, const std::array<std::int64_t, 3>& differences, std::int64_t tick,
                           int frame, MotionPeak& peak);
    void add_violation(const Violation& violation);

    MachineConfig machine_;
    double allow_;
    std::array<Bounds, kAxisCount> axis_bounds_{};
    std::array<Bounds, 2> galvo_bounds_{};
    std::array<History, kAxisCount> axis_{};
    std::array<History, 2> galvo_{};
    bool moving_ = false;  ///< the last record's state was one whose differences count
    std::int64_t next_tick_ = 0;
    SampleReport report_;
};

/// The controller moves powered axes by its own set-points in this state (shared/codes/state.hpp); a number that names
/// no state counts as one.
[[nodiscard]] bool leads_axes(std::uint8_t state) noexcept;

/// Reads a whole sample trace. Throws InputError for a file that is none.
[[nodiscard]] SampleReport check_samples(const std::filesystem::path& path, const MachineConfig& machine);

}  // namespace sc::host
