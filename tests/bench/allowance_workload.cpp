// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/allowance_workload.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <thread>
#include <unordered_map>

namespace sc::host::test {

namespace {

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
}

struct LongEdge {
    double length;
    std::uint32_t a;
    std::uint32_t b;
    bool operator<(const LongEdge& o) const {
        return length != o.length ? length < o.length : edge_key(a, b) < edge_key(o.a, o.b);
    }
};

class Splitter {
public:
    explicit Splitter(TriangleMesh mesh) : mesh_(std::move(mesh)) {
        mesh_.face.clear();
        for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
            const auto t = mesh_.triangles[i];
            for (std::size_t k = 0; k < 3; ++k) {
                add(t[k], t[(k + 1) % 3], i);
            }
        }
    }
    TriangleMesh split(std::size_t triangles) {
        while (mesh_.triangles.size() < triangles) {
            const LongEdge edge = queue_.top();
            queue_.pop();
            const auto found = users_.find(edge_key(edge.a, edge.b));
            if (found == users_.end()) {
                continue;
            }
            const std::vector<std::uint32_t> users = found->second;
            users_.erase(found);
            const auto middle = static_cast<std::uint32_t>(mesh_.vertices.size());
            mesh_.vertices.push_back(0.5 * (mesh_.vertices[edge.a] + mesh_.vertices[edge.b]));
            for (const std::uint32_t i : users) {
                halve(i, edge, middle);
            }
        }
        return mesh_;
    }

private:
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t triangle) {
        auto& users = users_[edge_key(a, b)];
        if (users.empty()) {
            queue_.push({norm(mesh_.vertices[a] - mesh_.vertices[b]), a, b});
        }
        users.push_back(triangle);
    }
    void halve(std::uint32_t i, const LongEdge& edge, std::uint32_t middle) {
        const auto t = mesh_.triangles[i];
        std::size_t k = 0;
        while (edge_key(t[k], t[(k + 1) % 3]) != edge_key(edge.a, edge.b)) {
            ++k;
        }
        const std::uint32_t from = t[k];
        const std::uint32_t to = t[(k + 1) % 3];
        const std::uint32_t apex = t[(k + 2) % 3];
        const auto second = static_cast<std::uint32_t>(mesh_.triangles.size());
        mesh_.triangles[i] = {from, middle, apex};
        mesh_.triangles.push_back({middle, to, apex});
        auto& moved = users_[edge_key(to, apex)];
        std::replace(moved.begin(), moved.end(), i, second);
        add(from, middle, i);
        add(middle, to, second);
        add(middle, apex, i);
        add(middle, apex, second);
    }

    TriangleMesh mesh_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> users_;
    std::priority_queue<LongEdge> queue_;
};

double squared_to(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const Vec3 ap = p - a;
    const auto from = [&p](const Vec3& q) { return dot(p - q, p - q); };
    const double d1 = dot(ab, ap);
    const double d2 = dot(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) {
        return from(a);
    }
    const double d3 = dot(ab, p - b);
    const double d4 = dot(ac, p - b);
    if (d3 >= 0.0 && d4 <= d3) {
        return from(b);
    }
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        return from(a + (d1 / (d1 - d3)) * ab);
    }
    const double d5 = dot(ab, p - c);
    const double d6 = dot(ac, p - c);
    if (d6 >= 0.0 && d5 <= d6) {
        return from(c);
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        return from(a + (d2 / (d2 - d6)) * ac);
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        return from(b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b));
    }
    const double all = va + vb + vc;
    return from(a + (vb / all) * ab + (vc / all) * ac);
}

}  // namespace

TriangleMesh split_to(TriangleMesh mesh, std::size_t triangles) { return Splitter(std::move(mesh)).split(triangles); }

TriangleMesh scaled(TriangleMesh mesh, double factor) {
    for (Vec3& v : mesh.vertices) {
        v = factor * v;
    }
    return mesh;
}

std::vector<Vec3> places_off(const TriangleMesh& mesh, std::size_t count, double least, double most, double noise,
                             std::uint64_t seed) {
    std::vector<double> area;
    double sum = 0.0;
    for (const auto& t : mesh.triangles) {
        const Vec3& a = mesh.vertices[t[0]];
        sum += norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
        area.push_back(sum);
    }
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    std::normal_distribution<double> white(0.0, 1.0);
    std::vector<Vec3> out;
    out.reserve(count);
    while (out.size() < count) {
        const auto found = std::upper_bound(area.begin(), area.end(), share(random) * sum);
        const auto index = static_cast<std::size_t>(std::min(found, area.end() - 1) - area.begin());
        const auto& t = mesh.triangles[index];
        const Vec3& a = mesh.vertices[t[0]];
        const Vec3 ab = mesh.vertices[t[1]] - a;
        const Vec3 ac = mesh.vertices[t[2]] - a;
        const double root = std::sqrt(share(random));
        const double v = share(random);
        const Vec3 n = cross(ab, ac);
        const double offset = least + (most - least) * share(random);
        out.push_back(a + root * (1.0 - v) * ab + root * v * ac + (offset / norm(n)) * n +
                      noise * Vec3{white(random), white(random), white(random)});
    }
    return out;
}

std::vector<Vec3> places_at_edges(const TriangleMesh& mesh, std::size_t count, double reach, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    std::normal_distribution<double> white(0.0, 1.0);
    std::vector<Vec3> out;
    out.reserve(count);
    while (out.size() < count) {
        const auto& t = mesh.triangles[random() % mesh.triangles.size()];
        const std::size_t k = random() % 3;
        const Vec3& a = mesh.vertices[t[k]];
        const Vec3& b = mesh.vertices[t[(k + 1) % 3]];
        const double along = out.size() % 2 == 0 ? share(random) : 0.0;
        const Vec3 way{white(random), white(random), white(random)};
        out.push_back(a + along * (b - a) + (reach * share(random) / norm(way)) * way);
    }
    return out;
}

std::vector<double> brute_distances(const TriangleMesh& mesh, const std::vector<Vec3>& places) {
    std::vector<std::array<double, 4>> balls;
    for (const auto& t : mesh.triangles) {
        const Vec3 middle = (1.0 / 3.0) * (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]);
        double radius = 0.0;
        for (const std::uint32_t corner : t) {
            radius = std::max(radius, norm(mesh.vertices[corner] - middle));
        }
        balls.push_back({middle.x, middle.y, middle.z, radius * (1.0 + 1e-12)});
    }
    std::vector<double> out(places.size());
    const auto work = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            double best = 1e300;
            double length = 1e150;
            for (std::size_t k = 0; k < balls.size(); ++k) {
                const Vec3 off = places[i] - Vec3{balls[k][0], balls[k][1], balls[k][2]};
                const double reach = length + balls[k][3];
                if (dot(off, off) > reach * reach) {
                    continue;
                }
                const auto& t = mesh.triangles[k];
                const double squared =
                    squared_to(places[i], mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
                if (squared < best) {
                    best = squared;
                    length = std::sqrt(best);
                }
            }
            out[i] = length;
        }
    };
    std::thread other(work, places.size() / 2, places.size());
    work(0, places.size() / 2);
    other.join();
    return out;
}

}  // namespace sc::host::test
