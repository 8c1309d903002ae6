// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_set>

#include <Eigen/Dense>

#include "host/inspection/alignment.hpp"
#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kCells = 40;  ///< of the coarse grid along the longest side
constexpr std::size_t kTurns = 2400;
constexpr std::size_t kSettled = 128;  ///< points that settle each turn
constexpr int kSettling = 8;           ///< steps
constexpr std::size_t kFinalists = 12;

/// Distance to the surface on a grid, interpolated. Unsigned: a scan may lie inside or outside.
class Grid {
public:
    Grid(const DistanceField& field, unsigned threads) {
        const Vec3 size = field.high() - field.low();
        const double longest = std::max({size.x, size.y, size.z});
        cell_ = 1.6 * longest / kCells;
        const double margin = 0.3 * longest;
        low_ = field.low() - Vec3{margin, margin, margin};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            n_[axis] = static_cast<int>((size[axis] + 2.0 * margin) / cell_) + 2;
        }
        std::vector<Vec3> places;
        for (int z = 0; z < n_[2]; ++z) {
            for (int y = 0; y < n_[1]; ++y) {
                for (int x = 0; x < n_[0]; ++x) {
                    places.push_back(
                        low_ + cell_ * Vec3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
                }
            }
        }
        std::vector<Distance> distances(places.size());
        field.measure(places, distances, {.threads = threads});
        for (const Distance& d : distances) {
            value_.push_back(static_cast<float>(std::abs(d.value)));
        }
    }

    /// Distance and its gradient.
    double at(const Vec3& p, Vec3& gradient) const {
        const Vec3 q = (1.0 / cell_) * (p - low_);
        std::array<int, 3> i{};
        std::array<double, 3> f{};
        double outside = 0.0;
        Vec3 beyond{};
        std::array<double, 3> off{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double most = static_cast<double>(n_[axis] - 1) - 1e-6;
            const double inside = std::clamp(q[axis], 0.0, most);
            off[axis] = q[axis] - inside;
            i[axis] = static_cast<int>(inside);
            f[axis] = inside - static_cast<double>(i[axis]);
        }
        beyond = cell_ * Vec3{off[0], off[1], off[2]};
        outside = norm(beyond);
        std::array<double, 8> v{};
        for (std::size_t k = 0; k < 8; ++k) {
            const int x = i[0] + static_cast<int>(k & 1U);
            const int y = i[1] + static_cast<int>((k >> 1U) & 1U);
            const int z = i[2] + static_cast<int>(k >> 2U);
            const int cell = (z * n_[1] + y) * n_[0] + x;
            v[k] = static_cast<double>(value_[static_cast<std::size_t>(cell)]);
        }
        const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
        const double y00 = mix(v[0], v[1], f[0]);
        const double y10 = mix(v[2], v[3], f[0]);
        const double y01 = mix(v[4], v[5], f[0]);
        const double y11 = mix(v[6], v[7], f[0]);
        const double z0 = mix(y00, y10, f[1]);
        const double z1 = mix(y01, y11, f[1]);
        gradient =
            (1.0 / cell_) * Vec3{mix(mix(v[1] - v[0], v[3] - v[2], f[1]), mix(v[5] - v[4], v[7] - v[6], f[1]), f[2]),
                                 mix(y10 - y00, y11 - y01, f[2]), z1 - z0};
        if (outside > 0.0) {
            gradient = (1.0 / outside) * beyond;
        }
        return mix(z0, z1, f[2]) + outside;
    }

private:
    Vec3 low_;
    double cell_ = 0.0;
    std::array<int, 3> n_{};
    std::vector<float> value_;
};

/// Turns spread evenly over all of them (Alexa 2022, super-Fibonacci spirals).
Mat3 turn_of(std::size_t i, std::size_t count) {
    const double s = static_cast<double>(i) + 0.5;
    const double r = std::sqrt(s / static_cast<double>(count));
    const double big = std::sqrt(1.0 - s / static_cast<double>(count));
    const double a = 2.0 * std::numbers::pi * s / std::numbers::sqrt2;
    const double b = 2.0 * std::numbers::pi * s / 1.533751168755204288118041;
    const double x = r * std::sin(a);
    const double y = r * std::cos(a);
    const double z = big * std::sin(b);
    const double w = big * std::cos(b);
    return {{Vec3{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
             Vec3{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
             Vec3{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
}

struct Candidate {
    Placement w_from_c;
    double score = 0.0;
};

Vec3 middle_of(std::span<const Vec3> points) {
    Vec3 sum{};
    for (const Vec3& p : points) {
        sum = sum + p;
    }
    return (1.0 / static_cast<double>(points.size())) * sum;
}

/// Centre of the surface's area: what the mean of an evenly spread, whole scan is near to.
Vec3 middle_of(const TriangleMesh& mesh) {
    Vec3 sum{};
    double area = 0.0;
    for (const auto& t : mesh.triangles) {
        const Vec3& a = mesh.vertices[t[0]];
        const Vec3& b = mesh.vertices[t[1]];
        const Vec3& c = mesh.vertices[t[2]];
        const double twice = norm(cross(b - a, c - a));
        sum = sum + twice * (1.0 / 3.0) * (a + b + c);
        area += twice;
    }
    return (1.0 / area) * sum;
}

Candidate settled(const Grid& grid, std::span<const Vec3> points, const Placement& start, const Vec3& centre,
                  double length) {
    Candidate out{start, 0.0};
    double cut = 0.15 * length;
    for (int round = 0; round <= kSettling; ++round) {
        Matrix6 normal = Matrix6::Zero();
        Vector6 right = Vector6::Zero();
        out.score = 0.0;
        for (const Vec3& point : points) {
            const Vec3 p = out.w_from_c.rotation * point + out.w_from_c.translation;
            Vec3 n;
            const double d = grid.at(p, n);
            out.score += std::min(d, cut);
            const double weight = cut * cut / (cut * cut + d * d);
            const Vec3 m = (1.0 / length) * cross(p - centre, n);
            Vector6 row;
            row << n.x, n.y, n.z, m.x, m.y, m.z;
            normal += weight * weight * row * row.transpose();
            right += weight * weight * d * row;
        }
        out.score /= static_cast<double>(points.size());
        if (round == kSettling) {
            break;
        }
        const Vector6 x = (normal + 1e-3 * normal.trace() / 6.0 * Matrix6::Identity()).ldlt().solve(-right);
        const Mat3 turn = turn_by((1.0 / length) * Vec3{x[3], x[4], x[5]});
        out.w_from_c = {turn * out.w_from_c.rotation,
                        turn * (out.w_from_c.translation - centre) + centre + Vec3{x[0], x[1], x[2]}};
        cut = std::max(cut * 0.8, 0.03 * length);
    }
    return out;
}

bool alike(const Placement& a, const Placement& b, const Vec3& at, double size) {
    const Mat3 turn = a.rotation * b.rotation.transposed();
    const double trace = turn.row[0].x + turn.row[1].y + turn.row[2].z;
    const Vec3 apart = (a.rotation * at + a.translation) - (b.rotation * at + b.translation);
    return trace > 1.0 + 2.0 * std::cos(15.0 * std::numbers::pi / 180.0) && norm(apart) < 0.1 * size;
}

}  // namespace

GlobalStart global_start(const DistanceField& field, std::span<const Vec3> points, unsigned threads) {
    threads = thread_count(threads);
    const Grid grid(field, threads);
    std::vector<Vec3> spread;
    for (const std::uint32_t i : spread_sample(points, 1000)) {
        spread.push_back(points[i]);
    }
    std::vector<Vec3> few;
    const std::size_t stride = std::max<std::size_t>(1, spread.size() / kSettled);
    for (std::size_t i = 0; i < spread.size(); i += stride) {
        few.push_back(spread[i]);
    }
    const Vec3 scan_middle = middle_of(spread);
    const Vec3 cad_middle = middle_of(field.mesh());
    const double size = field.diagonal();
    std::vector<Candidate> candidates(kTurns);
    parallel_pieces(kTurns, 32, threads, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const Mat3 turn = turn_of(i, kTurns);
            candidates[i] = settled(grid, few, {turn, cad_middle - turn * scan_middle}, cad_middle, 0.5 * size);
        }
    });
    std::ranges::sort(candidates, {}, &Candidate::score);
    std::vector<Candidate> finalists;
    for (const Candidate& candidate : candidates) {
        const bool seen = std::ranges::any_of(finalists, [&](const Candidate& other) {
            return alike(candidate.w_from_c, other.w_from_c, scan_middle, size);
        });
        if (!seen && finalists.size() < kFinalists) {
            finalists.push_back(candidate);
        }
    }
    std::vector<Distance> distances(spread.size());
    for (Candidate& finalist : finalists) {
        try {
            finalist.w_from_c =
                fit_to_mesh(field, spread, finalist.w_from_c, {.threads = threads, .reach = 0.03 * size}).w_from_c;
        } catch (const InspectionError&) {
            finalist.score = size;  // it settled where nothing is near
            continue;
        }
        field.measure(placed(finalist.w_from_c, spread), distances, {.threads = threads});
        finalist.score = 0.0;
        for (const Distance& d : distances) {
            finalist.score += std::min(std::abs(d.value), 0.01 * size) / static_cast<double>(spread.size());
        }
    }
    std::ranges::sort(finalists, {}, &Candidate::score);
    GlobalStart out{finalists.front().w_from_c, finalists.front().score, size};
    for (const Candidate& other : finalists) {
        if (!alike(other.w_from_c, out.w_from_c, scan_middle, size)) {
            out.second = std::min(out.second, other.score);
        }
    }
    return out;
}

double coverage(const DistanceField& field, std::span<const Vec3> points, const Placement& w_from_c, double reach) {
    const auto key = [reach](const Vec3& p, int dx, int dy, int dz) {
        const auto cell = [reach](double v, int d) {
            return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v / reach)) + d + (1 << 20)) &
                   0x1fffffU;
        };
        return cell(p.x, dx) << 42U | cell(p.y, dy) << 21U | cell(p.z, dz);
    };
    std::unordered_set<std::uint64_t> cells;
    for (const Vec3& p : points) {
        cells.insert(key(w_from_c.rotation * p + w_from_c.translation, 0, 0, 0));
    }
    const TriangleMesh& mesh = field.mesh();
    double seen = 0.0;
    double all = 0.0;
    const double area_each = 0.25 * reach * reach;
    for (const auto& t : mesh.triangles) {
        const Vec3& a = mesh.vertices[t[0]];
        const Vec3 ab = mesh.vertices[t[1]] - a;
        const Vec3 ac = mesh.vertices[t[2]] - a;
        const double area = 0.5 * norm(cross(ab, ac));
        const int n = std::clamp(static_cast<int>(std::sqrt(area / area_each)), 1, 200);
        for (int i = 0; i < n; ++i) {
            for (int k = 0; k < n - i; ++k) {
                const Vec3 p = a + ((i + 1.0 / 3.0) / n) * ab + ((k + 1.0 / 3.0) / n) * ac;
                bool near = false;
                for (int c = 0; c < 27 && !near; ++c) {
                    near = cells.contains(key(p, c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1));
                }
                const double share = area / (0.5 * n * (n + 1));
                all += share;
                seen += near ? share : 0.0;
            }
        }
    }
    return all > 0.0 ? seen / all : 0.0;
}

}  // namespace sc::host
