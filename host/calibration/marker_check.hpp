// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/poses.hpp"

/// Markers that several views saw of one rigid body: what has the wrong number, and what is wrong altogether, by the
/// distances between markers, which no motion changes.

namespace sc::host {

struct MarkerFinding {
    enum class Kind : std::uint8_t {
        swapped,      ///< `id` and `other` have each other's number; put right
        misnumbered,  ///< the marker called `id` is `other`; put right
        wrong,        ///< fits no marker of the body; left out
    };
    Kind kind = Kind::wrong;
    std::string view;
    int line = 0;  ///< of the file
    int id = 0;
    int other = 0;
    [[nodiscard]] std::string text() const;
};

/// Puts right or leaves out what it finds. Distances are compared with their median over the views, so that a marker is
/// found where most views are right; it needs three views that share four markers. `sigma` (metres) is the noise of a
/// coordinate where a marker states none.
[[nodiscard]] std::vector<MarkerFinding> check_markers(std::vector<MarkerView>& views, double sigma);

}  // namespace sc::host
