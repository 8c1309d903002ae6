// SPDX-License-Identifier: Apache-2.0
#include "host/vision/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace sc::host {
namespace {

using Point = std::array<double, 2>;
using Cell = std::pair<int, int>;
using Cells = std::map<Cell, std::size_t>;

constexpr double kReach = 0.35;       ///< of a step, from where a point should be
constexpr double kLeastSine = 0.35;   ///< between the two steps
constexpr double kMostStretch = 3.0;  ///< of one step over the other
constexpr double kMostMissing = 0.2;
constexpr std::size_t kSeeds = 40;

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1]}; }
Point plus(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1]}; }
double length(const Point& a) { return std::hypot(a[0], a[1]); }
double across(const Point& a, const Point& b) { return a[0] * b[1] - a[1] * b[0]; }

class Grower {
public:
    explicit Grower(std::span<const Point> points) : points_(points) {}

    /// The cells that grow from a point.
    Cells from(std::size_t seed, std::size_t most) {
        cells_.clear();
        taken_.clear();
        const auto steps = first_steps(seed);
        if (!steps) {
            return {};
        }
        put({0, 0}, seed);
        std::deque<std::pair<Cell, std::array<Point, 2>>> open{{{0, 0}, *steps}};
        while (!open.empty() && cells_.size() <= most) {
            const auto [cell, known] = open.front();
            open.pop_front();
            const std::array<Point, 2> step{local_step(cell, 0, known[0]), local_step(cell, 1, known[1])};
            for (const int along : {0, 1}) {
                for (const int sign : {1, -1}) {
                    const Cell next =
                        along == 0 ? Cell{cell.first + sign, cell.second} : Cell{cell.first, cell.second + sign};
                    const Point& s = step[static_cast<std::size_t>(along)];
                    if (!cells_.contains(next) && look(cell, next, {sign * s[0], sign * s[1]})) {
                        open.push_back({next, step});
                    }
                }
            }
        }
        return cells_;
    }

private:
    void put(const Cell& cell, std::size_t index) {
        cells_[cell] = index;
        taken_.insert(index);
    }

    [[nodiscard]] std::optional<Point> at(const Cell& cell) const {
        const auto found = cells_.find(cell);
        return found != cells_.end() ? std::optional(points_[found->second]) : std::nullopt;
    }

    /// To the nearest neighbour, and to the nearest well aside of it.
    [[nodiscard]] std::optional<std::array<Point, 2>> first_steps(std::size_t seed) const {
        std::vector<Point> ways;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            if (i != seed) {
                ways.push_back(minus(points_[i], points_[seed]));
            }
        }
        std::ranges::sort(ways, {}, length);
        for (const Point& way : ways) {
            const double sine = across(ways.front(), way) / (length(ways.front()) * length(way));
            if (std::abs(sine) > kLeastSine) {
                if (length(way) > kMostStretch * length(ways.front())) {
                    return std::nullopt;
                }
                return sine > 0.0 ? std::array{ways.front(), way} : std::array{way, ways.front()};
            }
        }
        return std::nullopt;
    }

    /// As the neighbours on both sides say; else the step that led here.
    [[nodiscard]] Point local_step(const Cell& cell, int along, const Point& otherwise) const {
        const Cell ahead = along == 0 ? Cell{cell.first + 1, cell.second} : Cell{cell.first, cell.second + 1};
        const Cell behind = along == 0 ? Cell{cell.first - 1, cell.second} : Cell{cell.first, cell.second - 1};
        const auto a = at(ahead);
        const auto b = at(behind);
        const auto here = at(cell);
        if (a && b) {
            const Point whole = minus(*a, *b);
            return {0.5 * whole[0], 0.5 * whole[1]};
        }
        return a ? minus(*a, *here) : b ? minus(*here, *b) : otherwise;
    }

    bool look(const Cell& from, const Cell& to, const Point& step) {
        const Point guess = plus(*at(from), step);
        std::size_t best = points_.size();
        double least = kReach * length(step);
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const double far = length(minus(points_[i], guess));
            if (far < least && !taken_.contains(i)) {
                least = far;
                best = i;
            }
        }
        if (best == points_.size()) {
            return false;
        }
        put(to, best);
        return true;
    }

    std::span<const Point> points_;
    Cells cells_;
    std::set<std::size_t> taken_;
};

/// How many cells of a block are there; 0 if an outer row has none.
std::size_t filled(const Cells& cells, const Cell& first, const GridSize& size) {
    std::size_t count = 0;
    std::array<bool, 4> sides{};
    for (int c = 0; c < size.columns; ++c) {
        for (int r = 0; r < size.rows; ++r) {
            if (cells.contains({first.first + c, first.second + r})) {
                ++count;
                sides[0] = sides[0] || c == 0;
                sides[1] = sides[1] || c == size.columns - 1;
                sides[2] = sides[2] || r == 0;
                sides[3] = sides[3] || r == size.rows - 1;
            }
        }
    }
    return std::ranges::all_of(sides, [](bool side) { return side; }) ? count : 0;
}

struct Block {
    Cell first;
    std::size_t count = 0;
    bool unique = false;
};

Block best_block(const Cells& cells, const GridSize& size) {
    std::set<int> columns;
    std::set<int> rows;
    for (const auto& [cell, index] : cells) {
        columns.insert(cell.first);
        rows.insert(cell.second);
    }
    Block best;
    for (const int c : columns) {
        for (const int r : rows) {
            const std::size_t count = filled(cells, {c, r}, size);
            if (count > best.count) {
                best = {.first = {c, r}, .count = count, .unique = true};
            } else if (count == best.count) {
                best.unique = false;
            }
        }
    }
    return best;
}

std::vector<GridPoint> points_of(const Cells& cells, const Cell& first, const GridSize& size) {
    std::vector<GridPoint> out;
    for (int r = 0; r < size.rows; ++r) {
        for (int c = 0; c < size.columns; ++c) {
            const auto found = cells.find({first.first + c, first.second + r});
            if (found != cells.end()) {
                out.push_back({.column = c, .row = r, .index = found->second});
            }
        }
    }
    return out;
}

std::optional<std::vector<GridPoint>> block_of(const Cells& cells, const GridSize& size) {
    const auto all = static_cast<std::size_t>(size.columns) * static_cast<std::size_t>(size.rows);
    const auto least = static_cast<std::size_t>(std::ceil((1.0 - kMostMissing) * static_cast<double>(all)));
    const Block lying = best_block(cells, size);
    if (lying.count >= least && lying.unique) {
        return points_of(cells, lying.first, size);
    }
    const GridSize on_end{.columns = size.rows, .rows = size.columns};
    const Block standing = best_block(cells, on_end);
    if (standing.count >= least && standing.unique) {
        // A quarter turn: what ran down runs to the right.
        std::vector<GridPoint> out;
        for (const GridPoint& p : points_of(cells, standing.first, on_end)) {
            out.push_back({.column = p.row, .row = size.rows - 1 - p.column, .index = p.index});
        }
        return out;
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::vector<GridPoint>> find_grid(std::span<const std::array<double, 2>> points, const GridSize& size) {
    const auto all = static_cast<std::size_t>(size.columns) * static_cast<std::size_t>(size.rows);
    if (points.size() < 4) {
        return std::nullopt;
    }
    Point middle{};
    for (const Point& p : points) {
        middle = plus(middle, {p[0] / static_cast<double>(points.size()), p[1] / static_cast<double>(points.size())});
    }
    std::vector<std::size_t> seeds(points.size());
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        seeds[i] = i;
    }
    std::ranges::sort(seeds, {}, [&](std::size_t i) { return length(minus(points[i], middle)); });
    Grower grower(points);
    std::optional<std::vector<GridPoint>> best;
    for (std::size_t k = 0; k < std::min(seeds.size(), kSeeds); ++k) {
        auto found = block_of(grower.from(seeds[k], 2 * all), size);
        if (found && (!best || found->size() > best->size())) {
            best = std::move(found);
            if (best->size() == all) {
                break;
            }
        }
    }
    return best;
}

std::vector<GridPoint> turned_half(const std::vector<GridPoint>& grid, const GridSize& size) {
    std::vector<GridPoint> out;
    for (const GridPoint& p : grid) {
        out.push_back({.column = size.columns - 1 - p.column, .row = size.rows - 1 - p.row, .index = p.index});
    }
    return out;
}

std::vector<GridPoint> turned_quarter(const std::vector<GridPoint>& grid, const GridSize& size) {
    std::vector<GridPoint> out;
    for (const GridPoint& p : grid) {
        out.push_back({.column = p.row, .row = size.rows - 1 - p.column, .index = p.index});
    }
    return out;
}

double heading_right(const std::vector<GridPoint>& grid, std::span<const std::array<double, 2>> points) {
    Point sum{};
    for (const GridPoint& a : grid) {
        for (const GridPoint& b : grid) {
            if (b.row == a.row && b.column == a.column + 1) {
                sum = plus(sum, minus(points[b.index], points[a.index]));
            }
        }
    }
    const double all = length(sum);
    return all > 0.0 ? sum[0] / all : 0.0;
}

}  // namespace sc::host
