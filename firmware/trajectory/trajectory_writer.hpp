// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/trajectory/line.hpp"
#include "firmware/trajectory/piece.hpp"
#include "firmware/trajectory/ring.hpp"
#include "firmware/trajectory/timing.hpp"

namespace sc::trajectory {

/// A ramp of constant jerk from rest at a corner (or, seen backward, to rest there).
struct Ramp {
    Place corner{};
    Place direction{};  ///< of the path
    double jerk = 0.0;
    double duration = 0.0;
    std::uint32_t item = 0;
};

/// A cell with its states at both ends, as quintics over time.
struct CellMotion {
    double duration = 0.0;
    std::array<Quintic, kAxisCount> axis{};  ///< scaled
};
/// From state (b0, c0) at `from` to (b1, c1) at `to`. A state at rest has b = c = 0; the other end must then lie on a
/// ramp of constant jerk.
[[nodiscard]] CellMotion cell_motion(const Node& from, const Node& to, double b0, double c0, double b1,
                                     double c1) noexcept;
/// How far the worst axis is beyond its limits; 1 is at the limit.
struct Excess {
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
};
[[nodiscard]] Excess excess(const Limits& limits, const CellMotion& motion) noexcept;

/// Puts pieces end to end: joins the ramp that ends at a corner with the one that begins there, and keeps time and
/// true distance.
class TrajectoryWriter {
public:
    explicit TrajectoryWriter(std::span<Piece> memory) noexcept : pieces_(memory) {}

    void open(const Limits& limits) noexcept;
    [[nodiscard]] Ring<Piece>& pieces() noexcept { return pieces_; }
    [[nodiscard]] const Ring<Piece>& pieces() const noexcept { return pieces_; }

    /// Begins a run; overlaps the ramp left by the last end() for up to `overlap`. At most 4 pieces.
    void begin(const Ramp& ramp, double overlap) noexcept;
    /// Ends a run; its pieces come with the next begin() or with flush().
    void end(const Ramp& ramp) noexcept;
    /// Writes the ramp that waits, to rest.
    void flush() noexcept;
    /// A stretch of constant jerk along the line place = origin + s · direction.
    void line(const Place& origin, const Place& direction, const Phase& phase, std::uint32_t item,
              LimitedBy limited) noexcept;
    /// A cell. Rest at an end: state (0, 0).
    void cell(const Node& from, const Node& to, double b0, double c0, double b1, double c1) noexcept;

    /// Straight from rest to rest.
    void straight(const Place& from, const Place& to, double duration, std::uint32_t item) noexcept;

    [[nodiscard]] double time() const noexcept { return time_; }

private:
    void ramp_piece(const Ramp& ramp, double from, double to, bool to_rest) noexcept;
    Piece& open_piece(double duration, std::uint32_t item, LimitedBy limited) noexcept;
    void close_piece(Piece& piece) noexcept;

    Ring<Piece> pieces_;
    Limits limits_;
    Ramp waiting_;
    bool has_waiting_ = false;
    double time_ = 0.0;
    double distance_ = 0.0;
    std::uint32_t item_ = 0;
};

}  // namespace sc::trajectory
