// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/piece.hpp"
#include "firmware/trajectory/ring.hpp"

namespace sc::motion {

/// A marked part of a path, as true distances from the start of the run-in, metres.
struct Stretch {
    double begin = 0.0;
    double end = 0.0;        ///< up to which it goes for certain
    bool end_known = false;  ///< and no further
    bool more = false;       ///< another one follows for certain
};

/// Where the light of a path ends and begins again between its points. A boundary lies where the planned path crosses
/// the plane through its point, square to the way that the path arrives there; so corners that are cut before it shift
/// no pulse. Bounded: some 500 instructions a boundary, 6 a piece.
class MarkStretches {
public:
    static constexpr std::uint32_t kCapacity = 128;  ///< boundaries that are known and still needed; a power of two

    void open() noexcept { first_ = end_ = found_ = scanned_ = 0; }
    [[nodiscard]] bool room() const noexcept { return end_ - first_ < kCapacity; }
    /// The light changes at `place`, the point of `item`, at which the path arrives in `direction`. Only while room().
    void add(const trajectory::Place& place, const trajectory::Place& direction, std::uint32_t item) noexcept;
    /// The boundaries that are known; the first ends the first stretch.
    [[nodiscard]] std::uint32_t known() const noexcept { return end_; }
    /// … of which this is the first that is kept.
    [[nodiscard]] std::uint32_t oldest() const noexcept { return first_; }
    /// Finds boundaries on the pieces up to number `end`, which are final.
    void find(const trajectory::Ring<trajectory::Piece>& pieces, std::uint32_t end) noexcept;

    [[nodiscard]] bool found(std::uint32_t boundary) const noexcept {
        return static_cast<std::int32_t>(found_ - boundary) > 0;
    }
    /// Distance of a boundary that was found and is still kept.
    [[nodiscard]] double distance(std::uint32_t boundary) const noexcept {
        return boundaries_[boundary % kCapacity].place[0];
    }
    /// Of stretches that end before this distance nothing more is asked. Stretches are numbered from 0.
    void forget_before(double distance) noexcept;

private:
    struct Boundary {
        std::array<double, 3> place{};  ///< the first is the distance, once found
        std::array<float, 3> direction{};
        std::uint32_t item = 0;
    };
    [[nodiscard]] static double crossing(const Boundary& boundary, const trajectory::Ring<trajectory::Piece>& pieces,
                                         std::uint32_t behind) noexcept;

    std::array<Boundary, kCapacity> boundaries_{};
    std::uint32_t first_ = 0;
    std::uint32_t end_ = 0;
    std::uint32_t found_ = 0;    ///< boundaries before this one are found
    std::uint32_t scanned_ = 0;  ///< pieces before this one were looked at
};

}  // namespace sc::motion
