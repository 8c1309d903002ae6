// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/shutter.hpp"

#include <algorithm>

namespace sc::sim {

void ShutterPlant::step_to(std::int64_t t_ns) noexcept {
    const double way = static_cast<double>(t_ns - t_ns_) / kTravelNs;
    t_ns_ = t_ns;
    if (!stuck_) {
        const bool open = wanted_ && allowed_ && !dropped_;
        place_ = std::clamp(place_ + (open ? way : -way), 0.0, 1.0);
    }
}

}  // namespace sc::sim
