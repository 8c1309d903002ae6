// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// When the beam is where along a path: pieces of constant jerk in tau over path time. Hold, resume and abort change
/// only this.

namespace sc::motion {

/// tau(t) = tau0 + v0 dt + a0 dt²/2 + j dt³/6 with dt = t − t0. Moving backward, v0 is negative.
struct Piece {
    double t0 = 0.0;  ///< s since the path's start
    double duration = 0.0;
    double tau0 = 0.0;
    double v0 = 0.0;
    double a0 = 0.0;
    double j = 0.0;
    std::uint32_t element = 0;  ///< number of the element, which the whole piece lies on

    [[nodiscard]] double end() const noexcept { return t0 + duration; }
    [[nodiscard]] double tau(double t) const noexcept {
        const double dt = t - t0;
        return tau0 + dt * (v0 + dt * (0.5 * a0 + dt * ((1.0 / 6.0) * j)));
    }
    [[nodiscard]] double speed(double t) const noexcept {
        const double dt = t - t0;
        return v0 + dt * (a0 + dt * (0.5 * j));
    }
    [[nodiscard]] double acceleration(double t) const noexcept { return a0 + (t - t0) * j; }
};

/// Ring of pieces with consecutive numbers. The planner appends behind `published`; readers see pieces below it. Pieces
/// are kept until the slowest reader has passed them.
class TimeLaw {
public:
    static constexpr std::size_t kCapacity = 2048;

    void clear() noexcept { first_ = published_ = end_ = 0; }
    [[nodiscard]] std::uint32_t first() const noexcept { return first_; }
    [[nodiscard]] std::uint32_t published() const noexcept { return published_; }
    [[nodiscard]] std::uint32_t end() const noexcept { return end_; }
    [[nodiscard]] std::size_t free() const noexcept { return kCapacity - (end_ - first_); }
    [[nodiscard]] const Piece& at(std::uint32_t number) const noexcept { return ring_[number % kCapacity]; }
    [[nodiscard]] Piece& at(std::uint32_t number) noexcept { return ring_[number % kCapacity]; }
    [[nodiscard]] bool empty() const noexcept { return published_ == first_; }
    /// Path time up to which the published pieces reach; 0 before the first.
    [[nodiscard]] double end_time() const noexcept { return empty() ? 0.0 : at(published_ - 1).end(); }

    /// False when full: the piece is not taken.
    bool append(const Piece& piece) noexcept {
        if (free() == 0) {
            return false;
        }
        ring_[end_ % kCapacity] = piece;
        ++end_;
        return true;
    }
    void publish() noexcept { published_ = end_; }
    void drop_unpublished() noexcept { end_ = published_; }
    /// Forgets what comes at or after time t: the piece that contains it is cut there.
    void cut(double t) noexcept {
        while (end_ > first_ && at(end_ - 1).t0 >= t) {
            --end_;
        }
        if (end_ > first_ && at(end_ - 1).end() > t) {
            at(end_ - 1).duration = t - at(end_ - 1).t0;
        }
        published_ = end_;
    }
    /// Forgets pieces that end before time t, but keeps the last one.
    void forget_before(double t) noexcept {
        while (first_ + 1 < published_ && at(first_).end() < t) {
            ++first_;
        }
    }
    /// Number of the published piece that holds time t (the last one beyond its end); `hint` is where to look first.
    [[nodiscard]] std::uint32_t find(double t, std::uint32_t hint) const noexcept {
        std::uint32_t k = hint < first_ ? first_ : (hint >= published_ ? published_ - 1 : hint);
        while (k > first_ && at(k).t0 > t) {
            --k;
        }
        while (k + 1 < published_ && at(k).end() <= t) {
            ++k;
        }
        return k;
    }

private:
    std::array<Piece, kCapacity> ring_{};
    std::uint32_t first_ = 0;
    std::uint32_t published_ = 0;
    std::uint32_t end_ = 0;
};

}  // namespace sc::motion
