// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/inspection/allowance.hpp"

namespace sc::host {

/// Allowance over one face at a motion that is being tried; metres.
struct TriedFace {
    std::size_t count = 0;
    double least = 0.0;
    double mean = 0.0;
    std::array<std::size_t, kHistogram> histogram{};  ///< the bins of the report at the base
};

/// "What if the part lay there?", fast enough to drag. Heights are measured once, at a base; a frame takes each point
/// to move off the place of the face that it was over then. Over planes that is exact to 0.1 µm; over bores a point
/// that passes to another flat strip is off by less than the strips' sagitta until the next base. Not for several
/// threads at once.
class WhatIf {
public:
    /// As `evaluate` takes them; `points`, `groups` and `gauge` must outlive it. Sets the base at no motion.
    WhatIf(const FaceGauge& gauge, std::span<const BorrowPoint> points, std::span<const BorrowGroup> groups,
           unsigned threads = 0);

    /// On release: everything measured there, exactly; the frames that follow start from it. Some 30 ns a point and
    /// thread.
    const AllowanceReport& base(const Rigid<frame::W, frame::W>& motion);
    /// While dragging. Some 4 ns a point and thread.
    [[nodiscard]] std::span<const TriedFace> frame(const Rigid<frame::W, frame::W>& motion);
    /// Of the last frame, one a point in the order given: allowance less what is asked, metres. For a map.
    [[nodiscard]] std::vector<float> margins() const;

private:
    /// Points of one face, one array a coordinate.
    struct Face {
        std::vector<std::uint32_t> index;
        std::array<std::vector<float>, 3> place;   ///< at the base, from `centre_`
        std::array<std::vector<float>, 3> growth;  ///< of the height there
        std::vector<float> height;                 ///< at the base
        std::vector<float> now;                    ///< at the last frame
    };
    struct Piece {
        double least = 0.0;
        double sum = 0.0;
        std::array<std::uint32_t, kHistogram> histogram{};
    };
    void try_piece(Face& face, const FaceAllowance& bins, const Mat3& turn, const Vec3& shift, std::size_t begin,
                   std::size_t end, Piece& piece) const;

    const FaceGauge* gauge_;
    std::span<const BorrowPoint> points_;
    std::span<const BorrowGroup> groups_;
    unsigned threads_;
    Vec3 centre_;
    Rigid<frame::W, frame::W> base_;
    AllowanceReport report_;
    std::vector<Face> faces_;
    std::vector<TriedFace> tried_;
};

}  // namespace sc::host
