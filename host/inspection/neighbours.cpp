// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/neighbours.hpp"

#include <algorithm>

#include "host/inspection/alignment.hpp"

namespace sc::host {

Neighbours::Neighbours(std::span<const Vec3> places, double reach)
    : places_(places), reach_(reach), low_(extent_of(places).low) {
    cells_.reserve(places.size());
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        cells_.push_back({key(places[i], 0, 0, 0), i});
    }
    std::ranges::sort(cells_);
}

std::size_t Neighbours::at(const Vec3& place, std::span<std::uint32_t> out) const {
    return found(place, 0xffffffffU, out);
}

std::size_t Neighbours::about(std::uint32_t i, std::span<std::uint32_t> out) const { return found(places_[i], i, out); }

std::size_t Neighbours::found(const Vec3& place, std::uint32_t but, std::span<std::uint32_t> out) const {
    std::size_t count = 0;
    for (int k = 0; k < 9; ++k) {
        const std::uint64_t first = key(place, -1, k % 3 - 1, k / 3 - 1);
        auto at = std::lower_bound(cells_.begin(), cells_.end(), std::pair<std::uint64_t, std::uint32_t>{first, 0});
        for (; at != cells_.end() && at->first <= first + 2 && count < out.size(); ++at) {
            if (at->second != but && norm(places_[at->second] - place) < reach_) {
                out[count++] = at->second;
            }
        }
    }
    return count;
}

std::uint64_t Neighbours::key(const Vec3& p, int dx, int dy, int dz) const {
    const auto cell = [this](double v, double low, int d) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>((v - low) / reach_) + 1 + d) & 0x1fffffU;
    };
    return cell(p.z, low_.z, dz) << 42U | cell(p.y, low_.y, dy) << 21U | cell(p.x, low_.x, dx);
}

}  // namespace sc::host
