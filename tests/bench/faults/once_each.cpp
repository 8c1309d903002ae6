// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/faults/once_each.hpp"

#include <cmath>

namespace sc::faults {
namespace {

/// Noise of what is simulated.
constexpr double kElsewhereMm = 0.02;

}  // namespace

std::string once_each(const Trace& trace, std::size_t from) {
    const std::vector<Burn>& path = *trace.path;
    const std::size_t count = trace.burns.size() - from;
    if (count != path.size()) {
        return std::to_string(count) + " pulses in place of " + std::to_string(path.size());
    }
    for (std::size_t i = 0; i < count; ++i) {
        double sum = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double d = path[i].place.at(axis) - trace.burns[from + i].place.at(axis);
            sum += d * d;
        }
        if (std::sqrt(sum) > kElsewhereMm) {
            return "pulse " + std::to_string(i) + " is elsewhere";
        }
    }
    return {};
}

}  // namespace sc::faults
