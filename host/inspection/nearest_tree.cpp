// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/nearest_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sc::host {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kWidth = 8;
constexpr std::size_t kBins = 16;
constexpr int kDeepest = 24;              ///< below it ranges are halved, so that the walk's stack has a bound
constexpr std::size_t kSweepBelow = 192;  ///< triangles: small ranges are sorted, large ones binned

struct Box {
    std::array<double, 3> low{kInfinity, kInfinity, kInfinity};
    std::array<double, 3> high{-kInfinity, -kInfinity, -kInfinity};

    void add(const Box& b) noexcept {
        for (std::size_t i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], b.low[i]);
            high[i] = std::max(high[i], b.high[i]);
        }
    }
    [[nodiscard]] double area() const noexcept {
        const double x = high[0] - low[0];
        const double y = high[1] - low[1];
        const double z = high[2] - low[2];
        return x < 0.0 ? 0.0 : x * y + y * z + z * x;
    }
};

struct Item {
    Box box;
    std::uint32_t triangle = 0;
    [[nodiscard]] double middle(std::size_t axis) const noexcept { return box.low[axis] + box.high[axis]; }
};

struct Range {
    std::size_t begin = 0;
    std::size_t end = 0;
    Box box;
    [[nodiscard]] std::size_t size() const noexcept { return end - begin; }
};

double leaves_for(std::size_t items) {
    const std::size_t leaves = (items + kWidth - 1) / kWidth;
    return static_cast<double>(leaves);
}

class Builder {
public:
    Builder(const TriangleMesh& mesh, NearestTree& tree) : mesh_(&mesh), tree_(&tree) {
        Range all{0, mesh.triangles.size(), {}};
        items_.resize(all.end);
        for (std::uint32_t i = 0; i < all.end; ++i) {
            items_[i].triangle = i;
            for (const std::uint32_t corner : mesh.triangles[i]) {
                const Vec3& v = mesh.vertices[corner];
                items_[i].box.add({{v.x, v.y, v.z}, {v.x, v.y, v.z}});
            }
            all.box.add(items_[i].box);
        }
        const auto& [low, high] = all.box;
        tree.centre = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])};
        const double size = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
        pad_ = size * 0x1p-22;
        tree.nodes.reserve(all.end / 30 + 2);
        tree.leaves.reserve(all.end / 7 + 2);
        build(all, 0);
    }

private:
    /// Writes the node of a range and all below it; returns its index.
    std::uint32_t build(const Range& range, int depth) {
        std::vector<Range> children{range};
        while (children.size() < kWidth) {
            double widest = -1.0;
            std::size_t chosen = 0;
            for (std::size_t i = 0; i < children.size(); ++i) {
                if (children[i].size() > kWidth && children[i].box.area() > widest) {
                    widest = children[i].box.area();
                    chosen = i;
                }
            }
            if (widest < 0.0) {
                break;
            }
            children.push_back(split(children[chosen], depth));
        }
        const auto index = static_cast<std::uint32_t>(tree_->nodes.size());
        tree_->nodes.push_back(empty_node());
        for (std::size_t i = 0; i < children.size(); ++i) {
            const bool leaf = children[i].size() <= kWidth;
            const std::uint32_t child = leaf ? add_leaf(children[i]) | kLeafBit : build(children[i], depth + 1);
            write(tree_->nodes[index], i, children[i].box, child);
        }
        return index;
    }

    /// Cuts a range in two; the second is returned.
    Range split(Range& range, int depth) {
        if (depth > kDeepest) {
            return cut(range, range.begin + range.size() / 2);
        }
        return range.size() <= kSweepBelow ? swept(range) : binned(range);
    }

    Range cut(Range& range, std::size_t at) {
        Range second{at, range.end, {}};
        range.end = at;
        range.box = {};
        for (std::size_t i = range.begin; i < at; ++i) {
            range.box.add(items_[i].box);
        }
        for (std::size_t i = at; i < second.end; ++i) {
            second.box.add(items_[i].box);
        }
        return second;
    }

    void sort(const Range& range, std::size_t axis) {
        std::sort(items_.begin() + static_cast<std::ptrdiff_t>(range.begin),
                  items_.begin() + static_cast<std::ptrdiff_t>(range.end), [axis](const Item& a, const Item& b) {
                      return a.middle(axis) != b.middle(axis) ? a.middle(axis) < b.middle(axis)
                                                              : a.triangle < b.triangle;
                  });
    }

    /// Looks at every cut after a whole number of leaves, along each axis.
    Range swept(Range& range) {
        const std::size_t n = range.size();
        double best = kInfinity;
        std::size_t best_axis = 0;
        std::size_t best_count = kWidth;
        std::array<double, kSweepBelow + 1> right{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sort(range, axis);
            Box box;
            for (std::size_t i = n; i > 0; --i) {
                box.add(items_[range.begin + i - 1].box);
                right[i - 1] = box.area();
            }
            box = {};
            for (std::size_t i = 1; i < n; ++i) {
                box.add(items_[range.begin + i - 1].box);
                const double cost = box.area() * leaves_for(i) + right[i] * leaves_for(n - i);
                if ((i % kWidth == 0 || (n - i) % kWidth == 0) && cost < best) {
                    best = cost;
                    best_axis = axis;
                    best_count = i;
                }
            }
        }
        if (best_axis != 2) {
            sort(range, best_axis);
        }
        return cut(range, range.begin + best_count);
    }

    Range binned(Range& range) {
        Box middles;
        for (std::size_t i = range.begin; i < range.end; ++i) {
            const Item& item = items_[i];
            const std::array<double, 3> m{item.middle(0), item.middle(1), item.middle(2)};
            middles.add({m, m});
        }
        double best = kInfinity;
        std::size_t best_axis = 0;
        std::size_t best_bin = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = middles.low[axis];
            const double width = middles.high[axis] - low;
            if (!(width > 0.0)) {
                continue;
            }
            std::array<Box, kBins> boxes{};
            std::array<std::size_t, kBins> counts{};
            for (std::size_t i = range.begin; i < range.end; ++i) {
                const std::size_t b = bin(items_[i], axis, low, width);
                boxes[b].add(items_[i].box);
                ++counts[b];
            }
            std::array<double, kBins> right{};
            Box box;
            std::size_t count = 0;
            for (std::size_t b = kBins - 1; b > 0; --b) {
                box.add(boxes[b]);
                count += counts[b];
                right[b] = box.area() * leaves_for(count);
            }
            box = {};
            count = 0;
            for (std::size_t b = 1; b < kBins; ++b) {
                box.add(boxes[b - 1]);
                count += counts[b - 1];
                const double cost = box.area() * leaves_for(count) + right[b];
                if (count > 0 && count < range.size() && cost < best) {
                    best = cost;
                    best_axis = axis;
                    best_bin = b;
                }
            }
        }
        if (best_bin == 0) {  // all in one place
            return cut(range, range.begin + range.size() / 2);
        }
        const double low = middles.low[best_axis];
        const double width = middles.high[best_axis] - low;
        const auto middle =
            std::partition(items_.begin() + static_cast<std::ptrdiff_t>(range.begin),
                           items_.begin() + static_cast<std::ptrdiff_t>(range.end),
                           [&](const Item& item) { return bin(item, best_axis, low, width) < best_bin; });
        return cut(range, static_cast<std::size_t>(middle - items_.begin()));
    }

    static std::size_t bin(const Item& item, std::size_t axis, double low, double width) {
        const double place = static_cast<double>(kBins) * ((item.middle(axis) - low) / width);
        return std::min(static_cast<std::size_t>(std::max(place, 0.0)), kBins - 1);
    }

    std::uint32_t add_leaf(const Range& range) {
        TreeLeaf leaf{};
        order_halves(range);
        for (std::size_t lane = 0; lane < kWidth; ++lane) {
            const std::uint32_t triangle = items_[range.begin + (lane < range.size() ? lane : 0)].triangle;
            leaf.triangle[lane] = triangle;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 v = mesh_->vertices[mesh_->triangles[triangle][k]] - tree_->centre;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    leaf.corner[k][axis][lane] = v[axis];
                }
            }
        }
        for (std::size_t half = 0; half < 2; ++half) {
            Box box;
            for (std::size_t lane = 4 * half; lane < 4 * half + 4; ++lane) {
                box.add(items_[range.begin + (lane < range.size() ? lane : 0)].box);
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                leaf.half[half][0][axis] = rounded_down(box.low[axis] - tree_->centre[axis]);
                leaf.half[half][1][axis] = rounded_up(box.high[axis] - tree_->centre[axis]);
            }
        }
        tree_->leaves.push_back(leaf);
        return static_cast<std::uint32_t>(tree_->leaves.size() - 1);
    }

    /// Four neighbours first, four after, so that the boxes of both halves are small.
    void order_halves(const Range& range) {
        if (range.size() <= 4) {
            return;
        }
        double best = kInfinity;
        std::size_t best_axis = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sort(range, axis);
            std::array<Box, 2> boxes{};
            for (std::size_t i = 0; i < range.size(); ++i) {
                boxes[i / 4].add(items_[range.begin + i].box);
            }
            if (const double cost = boxes[0].area() + boxes[1].area(); cost < best) {
                best = cost;
                best_axis = axis;
            }
        }
        sort(range, best_axis);
    }

    [[nodiscard]] float rounded_down(double v) const {
        return std::nextafter(static_cast<float>(v - pad_), -std::numeric_limits<float>::infinity());
    }
    [[nodiscard]] float rounded_up(double v) const {
        return std::nextafter(static_cast<float>(v + pad_), std::numeric_limits<float>::infinity());
    }

    static TreeNode empty_node() {
        TreeNode node{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            node.low[axis].fill(std::numeric_limits<float>::infinity());
            node.high[axis].fill(-std::numeric_limits<float>::infinity());
        }
        return node;
    }

    void write(TreeNode& node, std::size_t lane, const Box& box, std::uint32_t child) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double centre = tree_->centre[axis];
            node.low[axis][lane] = rounded_down(box.low[axis] - centre);
            node.high[axis][lane] = rounded_up(box.high[axis] - centre);
        }
        node.child[lane] = child;
    }

    const TriangleMesh* mesh_;
    NearestTree* tree_;
    std::vector<Item> items_;
    double pad_ = 0.0;
};

}  // namespace

NearestTree build_nearest_tree(const TriangleMesh& mesh) {
    NearestTree tree;
    const Builder builder(mesh, tree);
    return tree;
}

}  // namespace sc::host
