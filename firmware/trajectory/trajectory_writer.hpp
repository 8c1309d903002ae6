// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/trajectory/line.hpp"
#include "firmware/trajectory/piece.hpp"
#include "firmware/trajectory/ring.hpp"
#include "firmware/trajectory/timing.hpp"

namespace sc::trajectory {

/// Free pieces that a step of the planner needs: a corner, and the first of what is behind it.
inline constexpr std::uint32_t kPiecesAtOnce = 40;

/// Phases of constant jerk along a line, place = origin + s · direction. A whole straight run, or the ramp that a curve
/// begins or ends with.
struct Stretch {
    Place origin{};
    Place direction{};
    std::array<Phase, LinePlan::kCapacity> phase{};
    std::array<std::uint32_t, LinePlan::kCapacity> item{};
    std::uint32_t count = 0;

    void add(const Phase& added, std::uint32_t its_item) noexcept {
        phase[count] = added;
        item[count] = its_item;
        ++count;
    }
};
/// A ramp of constant jerk from rest at a corner, or to rest there.
[[nodiscard]] Stretch ramp_from(const Place& corner, const Place& direction, double jerk, double duration,
                                std::uint32_t item) noexcept;
[[nodiscard]] Stretch ramp_to(const Place& corner, const Place& direction, double jerk, double duration,
                              std::uint32_t item) noexcept;

/// A cell with its states at both ends, as quintics over time.
struct CellMotion {
    double duration = 0.0;
    std::array<Quintic, kAxisCount> axis{};  ///< scaled
};
/// From state (b0, c0) at `from` to (b1, c1) at `to`. A state at rest has b = c = 0; the other end must then lie on a
/// ramp of constant jerk.
[[nodiscard]] CellMotion cell_motion(const Node& from, const Node& to, double b0, double c0, double b1,
                                     double c1) noexcept;
/// How far the motion leaves the curve of the cell between its ends: a cell in which the speed changes many times over
/// is not followed exactly by quintics.
[[nodiscard]] double off_curve(const Node& from, const CellMotion& motion, double b0, double c0, double b1,
                               double c1) noexcept;
/// How far the worst axis is beyond its limits; 1 is at the limit.
struct Excess {
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
};
/// `speed` is that allowed along the path, m/s.
[[nodiscard]] Excess excess(const Limits& limits, double speed, const CellMotion& motion) noexcept;

/// Puts pieces end to end: joins the ramp that ends at a corner with the one that begins there, and keeps time and
/// true distance.
class TrajectoryWriter {
public:
    explicit TrajectoryWriter(std::span<Piece> memory) noexcept : pieces_(memory) {}

    void open(const Limits& limits) noexcept;
    [[nodiscard]] Ring<Piece>& pieces() noexcept { return pieces_; }
    [[nodiscard]] const Ring<Piece>& pieces() const noexcept { return pieces_; }

    /// Begins a run at a corner, overlapping what waits by `overlap`; the rest of `stretch` waits in its turn. At most
    /// 28 pieces.
    void join(const Stretch& stretch, double overlap) noexcept;
    /// What is to be overlapped by the next join(): the end of a curve.
    void wait(const Stretch& stretch) noexcept { waiting_ = stretch; }
    /// Writes what waits.
    void flush() noexcept;
    /// A cell. Rest at an end: state (0, 0).
    void cell(const Node& from, const Node& to, double b0, double c0, double b1, double c1) noexcept;

    /// Straight from rest to rest.
    void straight(const Place& from, const Place& to, double duration, std::uint32_t item) noexcept;

    [[nodiscard]] double time() const noexcept { return time_; }

private:
    void write_waiting(double duration) noexcept;
    void write_phase(const Stretch& stretch, const Phase& phase, std::uint32_t item) noexcept;
    void write_both(const Stretch& last, const Phase& a, const Stretch& next, const Phase& b, double duration,
                    std::uint32_t item) noexcept;
    void write_corner(const Stretch& last, Phase a, const Stretch& next, Phase b, double duration,
                      std::uint32_t item) noexcept;
    Piece& open_piece(double duration, std::uint32_t item, LimitedBy limited) noexcept;
    void close_piece(Piece& piece) noexcept;

    Ring<Piece> pieces_;
    Limits limits_;
    Stretch waiting_;
    double time_ = 0.0;
    double distance_ = 0.0;
    std::uint32_t item_ = 0;
};

}  // namespace sc::trajectory
