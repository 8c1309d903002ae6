// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/neighbours.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "host/inspection/alignment.hpp"
#include "host/inspection/parallel.hpp"

namespace sc::host {

Neighbours::Neighbours(std::span<const Vec3> places, double reach)
    : places_(places), reach_(reach), low_(extent_of(places).low) {
    // Sorted in stretches on all cores, then merged: the same list whatever their number.
    cells_.resize(places.size());
    const std::size_t stretch = std::max<std::size_t>(places.size() / 8 + 1, 4096);
    parallel_pieces(places.size(), stretch, thread_count(0), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            cells_[i] = {key(places[i], 0, 0, 0), static_cast<std::uint32_t>(i)};
        }
        std::sort(cells_.begin() + static_cast<std::ptrdiff_t>(begin),
                  cells_.begin() + static_cast<std::ptrdiff_t>(end));
    });
    std::vector<std::pair<std::uint64_t, std::uint32_t>> merged(stretch < cells_.size() ? cells_.size() : 0);
    for (std::size_t width = stretch; width < places.size(); width *= 2) {
        parallel_pieces(places.size(), 2 * width, thread_count(0), [&](std::size_t begin, std::size_t end, unsigned) {
            const auto at = [&](std::size_t i) { return cells_.begin() + static_cast<std::ptrdiff_t>(i); };
            const auto middle = at(std::min(begin + width, end));
            std::merge(at(begin), middle, middle, at(end), merged.begin() + static_cast<std::ptrdiff_t>(begin));
        });
        cells_.swap(merged);
    }
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
