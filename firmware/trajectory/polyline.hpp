// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/trajectory/line.hpp"
#include "firmware/trajectory/ring.hpp"
#include "firmware/trajectory/spec.hpp"

namespace sc::trajectory {

/// A kept point of the input.
struct Vertex {
    Place p{};             ///< scaled
    double s = 0.0;        ///< length of the polyline up to here
    double spacing = 0.0;  ///< of knots, as the curve's deviation here allows
    std::uint32_t item = 0;
    bool corner = false;  ///< runs begin and end here
};

/// The input as a polyline: points nearer than Limits::merge to the last kept one are dropped, and vertices that turn
/// by more than Limits::corner_cosine are corners, as are both ends. Points are final one point later.
class Polyline {
public:
    explicit Polyline(std::span<Vertex> memory) noexcept : points_(memory) {}

    void open(const Limits& limits) noexcept;
    /// Scaled place. Needs room.
    void add(const Place& place, std::uint32_t item) noexcept;
    void close() noexcept;
    [[nodiscard]] bool closed() const noexcept { return closed_; }

    /// Points below are final, with their corner flag.
    [[nodiscard]] std::uint32_t known() const noexcept {
        return closed_ || points_.size() == 0 ? points_.end() : points_.end() - 1;
    }
    [[nodiscard]] const Vertex& operator[](std::uint32_t number) const noexcept { return points_[number]; }
    [[nodiscard]] Vertex& operator[](std::uint32_t number) noexcept { return points_[number]; }
    [[nodiscard]] std::uint32_t first() const noexcept { return points_.first(); }
    [[nodiscard]] std::uint32_t end() const noexcept { return points_.end(); }
    [[nodiscard]] std::uint32_t free() const noexcept { return points_.free(); }
    void forget_before(std::uint32_t number) noexcept { points_.forget_before(number); }

    /// Straight stretch behind corner `at` (`forward`) or before it. False while more points are needed. Cost: bounded
    /// by kStubPoints²/2 distances; two where the first segment is long.
    [[nodiscard]] bool stub(std::uint32_t at, bool forward, const Limits& limits, Stub& found) const noexcept;
    /// Puts the points between the ends of a stub onto its chord (they are within a twentieth of the tolerance).
    void absorb(std::uint32_t at, const Stub& stub, bool forward) noexcept;

    /// Place at s on the polyline from point `low` to `high`, straight on beyond them; `hint` is a point nearby and is
    /// left at the one before s.
    [[nodiscard]] Place at(double s, std::uint32_t low, std::uint32_t high, std::uint32_t& hint) const noexcept;

    static constexpr std::uint32_t kStubPoints = 64;

private:
    [[nodiscard]] bool straight(std::uint32_t from, std::uint32_t to, double most) const noexcept;

    Ring<Vertex> points_;
    double merge_ = 0.0;
    double corner_cosine_ = 0.0;
    bool closed_ = false;
};

}  // namespace sc::trajectory
