// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/polyline.hpp"
#include "firmware/trajectory/ring.hpp"
#include "firmware/trajectory/timing.hpp"

namespace sc::trajectory {

/// Makes the smooth curve of one run between corners: a cubic B-spline whose control points lie on the polyline at the
/// Greville abscissae of its knots. The distance of the knots follows the polyline: as far apart as the tolerance
/// allows, changing gently, fine near the run's ends. The deviation of each cell is checked before it is given out;
/// where it is too large the knots are set closer and the last few are made anew.
///
/// What is made depends on the points only, not on when they come: each decision waits for a fixed stretch of points
/// ahead.
class SplineBuilder {
public:
    /// Run from corner `begin`, whose first `ramp` (in s) is left to the ramp from rest.
    void start(const Polyline& points, std::uint32_t begin, double ramp) noexcept;
    /// The run's end, once known, after its stub is absorbed.
    void set_end(std::uint32_t end, double ramp) noexcept;
    /// The next corner is seen at `end_seen()` and set_end() is needed to go on.
    [[nodiscard]] bool wants_end() const noexcept { return end_seen_ && !has_end_; }
    [[nodiscard]] std::uint32_t end_seen() const noexcept { return seen_; }
    [[nodiscard]] std::uint32_t begin() const noexcept { return begin_; }

    /// One step: a vertex, a knot, the check of a cell or the nodes of one. False if it waits for points or room. Needs
    /// free room for kLag nodes.
    [[nodiscard]] bool step(Polyline& points, const Limits& limits, Ring<Node>& nodes) noexcept;
    [[nodiscard]] bool done() const noexcept { return done_; }
    /// Points below are not needed any more.
    [[nodiscard]] std::uint32_t oldest_point() const noexcept;

    static constexpr std::uint32_t kLag = 16;

private:
    static constexpr std::uint32_t kKept = 64;  ///< knots, a power of two

    /// The node's part of a cell that may still change.
    struct Draft {
        Place p{};
        Place d1{};
        Place d2{};
    };

    [[nodiscard]] bool see(const Polyline& points, const Limits& limits) noexcept;
    [[nodiscard]] bool ready_to(const Polyline& points, std::uint32_t from, double s, double distance,
                                std::uint32_t count, std::uint32_t& cursor) const noexcept;
    void space_vertex(Polyline& points, const Limits& limits, std::uint32_t j, std::uint32_t sight) const noexcept;
    [[nodiscard]] double spacing_at(const Polyline& points, const Limits& limits, double s, std::uint32_t i,
                                    bool near_end) const noexcept;
    void smooth_back(Polyline& points, std::uint32_t from) const noexcept;
    [[nodiscard]] double knot(std::int64_t i) const noexcept;
    void make_control(const Polyline& points) noexcept;
    void make_node() noexcept;
    [[nodiscard]] bool fits(const Polyline& points, const Limits& limits, std::int64_t cell) noexcept;
    void set_closer(Polyline& points, std::int64_t cell) noexcept;
    [[nodiscard]] bool is_certain(std::int64_t cell) const noexcept;
    void give_out(const Polyline& points, const Limits& limits, Ring<Node>& nodes) noexcept;
    void give_node(const Limits& limits, const Place& d3, double s, const Draft& at, std::uint32_t item,
                   Ring<Node>& nodes) noexcept;
    [[nodiscard]] const Draft& draft(std::int64_t i) const noexcept {
        return draft_[static_cast<std::size_t>(i) % kKept];
    }
    [[nodiscard]] Draft& draft(std::int64_t i) noexcept { return draft_[static_cast<std::size_t>(i) % kKept]; }
    [[nodiscard]] Place& control(std::int64_t m) noexcept { return control_[static_cast<std::size_t>(m + 1) % kKept]; }

    std::uint32_t begin_ = 0;
    double begin_s_ = 0.0;
    double end_ramp_ = 0.0;  ///< valid with has_end_
    std::uint32_t end_ = 0;
    std::uint32_t seen_ = 0;   ///< points below have been looked at for a corner
    std::uint32_t final_ = 0;  ///< points up to this one will not be absorbed any more
    bool end_seen_ = false;
    bool has_end_ = false;
    bool done_ = false;

    std::uint32_t spaced_ = 0;   ///< vertices below have their spacing
    std::uint32_t sight_ = 0;    ///< cursor: how far the next vertex sees
    std::uint32_t horizon_ = 0;  ///< cursor: how far the next knot sees
    std::uint32_t segment_ = 0;  ///< of the last knot
    std::uint32_t hint_ = 0;
    std::uint32_t checked_hint_ = 0;
    std::uint32_t given_hint_ = 0;

    std::array<double, kKept> knot_{};
    std::array<Place, kKept> control_{};
    std::array<Draft, kKept> draft_{};
    std::int64_t knots_ = 0;     ///< 0 … knots_ − 1 are set
    bool complete_ = false;      ///< the last of them is the run's end
    std::int64_t controls_ = 0;  ///< −1 … controls_ − 2 are made
    std::int64_t drafts_ = 0;
    std::int64_t checked_ = 0;  ///< cells below fit
    std::int64_t given_ = 0;    ///< nodes below are given out
    std::uint32_t tries_ = 0;   ///< to fit the cell that is next to those given out
};

}  // namespace sc::trajectory
