// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/space_order.hpp"

#include <algorithm>
#include <array>

#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

struct Keyed {
    std::uint32_t key;
    std::uint32_t index;
};

constexpr unsigned kDigit = 12;
constexpr std::size_t kDigits = std::size_t{1} << kDigit;

/// The low ten bits of a number, two zeros between each.
std::uint32_t spread(std::uint32_t v) noexcept {
    v = (v | (v << 16U)) & 0x030000ffU;
    v = (v | (v << 8U)) & 0x0300f00fU;
    v = (v | (v << 4U)) & 0x030c30c3U;
    return (v | (v << 2U)) & 0x09249249U;
}

struct Bounds {
    Vec3 low{1e300, 1e300, 1e300};
    Vec3 high{-1e300, -1e300, -1e300};
    void add(const Vec3& v) noexcept {
        low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
        high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    }
};

/// One pass of a stable counting sort, the list cut into one stretch a thread.
void pass(const std::vector<Keyed>& from, std::vector<Keyed>& to, unsigned shift, unsigned threads) {
    const std::size_t stretch = (from.size() + threads - 1) / threads;
    std::vector<std::array<std::uint32_t, kDigits>> next(threads);
    parallel_pieces(threads, 1, threads, [&](std::size_t t, std::size_t, unsigned) {
        auto& counts = next[t];
        counts.fill(0);
        for (std::size_t i = t * stretch; i < std::min((t + 1) * stretch, from.size()); ++i) {
            ++counts[(from[i].key >> shift) & (kDigits - 1)];
        }
    });
    std::uint32_t start = 0;
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
        for (auto& counts : next) {
            const std::uint32_t count = counts[digit];
            counts[digit] = start;
            start += count;
        }
    }
    parallel_pieces(threads, 1, threads, [&](std::size_t t, std::size_t, unsigned) {
        auto& places = next[t];
        for (std::size_t i = t * stretch; i < std::min((t + 1) * stretch, from.size()); ++i) {
            to[places[(from[i].key >> shift) & (kDigits - 1)]++] = from[i];
        }
    });
}

}  // namespace

std::vector<std::uint32_t> space_order(std::span<const Vec3> places, unsigned threads) {
    threads = std::min(threads, 16U);
    constexpr std::size_t kPiece = 1U << 16U;
    std::vector<Bounds> bounds(threads);
    parallel_pieces(places.size(), kPiece, threads, [&](std::size_t begin, std::size_t end, unsigned worker) {
        for (std::size_t i = begin; i < end; ++i) {
            bounds[worker].add(places[i]);
        }
    });
    for (const Bounds& other : bounds) {
        if (other.low.x <= other.high.x) {  // this worker has seen a place
            bounds[0].add(other.low);
            bounds[0].add(other.high);
        }
    }
    // Eight bits an axis sort in two passes; ten for clouds that would crowd those cells.
    const unsigned bits = places.size() > (std::size_t{1} << 22U) ? 10 : 8;
    const Vec3 low = bounds[0].low;
    const Vec3 size = bounds[0].high - low;
    const double cells = static_cast<double>(1U << bits) / std::max({size.x, size.y, size.z, 1e-300});
    const auto most = static_cast<double>((1U << bits) - 1);
    std::vector<Keyed> items(places.size());
    parallel_pieces(places.size(), kPiece, threads, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 v = cells * (places[i] - low);
            const std::uint32_t key = spread(static_cast<std::uint32_t>(std::min(v.x, most))) |
                                      spread(static_cast<std::uint32_t>(std::min(v.y, most))) << 1U |
                                      spread(static_cast<std::uint32_t>(std::min(v.z, most))) << 2U;
            items[i] = {key, static_cast<std::uint32_t>(i)};
        }
    });
    std::vector<Keyed> other(places.size());
    for (unsigned shift = 0; shift < 3 * bits; shift += kDigit) {
        pass(items, other, shift, threads);
        items.swap(other);
    }
    std::vector<std::uint32_t> order(places.size());
    std::ranges::transform(items, order.begin(), [](const Keyed& item) { return item.index; });
    return order;
}

}  // namespace sc::host
