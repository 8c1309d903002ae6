// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <expected>
#include <string>
#include <vector>

#include "host/formats/poses.hpp"

/// Which marker of one cloud is which of another, without numbers: by the distances between them, which no motion
/// changes. Also: why two clouds that should match do not. Host only.

namespace sc::host {

struct MarkerMatch {
    std::size_t a = 0;  ///< index in the first cloud
    std::size_t b = 0;
    bool operator==(const MarkerMatch&) const noexcept = default;
};

/// The largest set of pairs that one motion brings together to `tolerance` (metres); ids are not looked at. At least
/// four: three fix a motion, the fourth confirms it. Refused, with the reason: fewer than that, and clouds so regular
/// that another numbering fits as many. Some milliseconds for 24 by 12 markers, a second for 100 by 100.
[[nodiscard]] std::expected<std::vector<MarkerMatch>, std::string> match_by_distances(const std::vector<SeenMarker>& a,
                                                                                      const std::vector<SeenMarker>& b,
                                                                                      double tolerance);

/// What two clouds with the same ids have that no rigid motion mends: another unit ("inch"), a mirrored frame. Empty if
/// neither is it. `a` and `b` need four markers in common, not in a plane for the mirror.
[[nodiscard]] std::string misfit_reason(const std::vector<SeenMarker>& a, const std::vector<SeenMarker>& b);

}  // namespace sc::host
