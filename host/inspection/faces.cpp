// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include <Eigen/Dense>

namespace sc::host {

namespace {

constexpr double kOnSurface = 5e-6;     ///< of the part's size
constexpr double kLoose = 8.0;          ///< times that: corners where two cylinders meet lie a little off both
constexpr double kSmoothCosine = 0.94;  ///< 20 degrees
constexpr double kStripCosine = 0.78;   ///< 39 degrees: neighbours on a coarse cylinder
constexpr std::size_t kFewestStrips = 4;
constexpr std::uint32_t kNoFace = 0xffffffffU;

Vec3 unit(const Vec3& v) {
    const double length = norm(v);
    return length > 0.0 ? (1.0 / length) * v : Vec3{};
}

struct Cylinder {
    Vec3 point;
    Vec3 axis;
    double radius = 0.0;
    bool hollow = false;

    /// From the axis to a place, square to it.
    [[nodiscard]] Vec3 radial(const Vec3& p) const {
        const Vec3 r = p - point;
        return r - dot(r, axis) * axis;
    }
};

class Segmenter {
public:
    Segmenter(const TriangleMesh& mesh, const Topology& topology) : mesh_(&mesh), topology_(&topology) {
        const std::size_t n = mesh.triangles.size();
        out_.face_of.assign(n, kNoFace);
        Vec3 low = mesh.vertices.front();
        Vec3 high = low;
        for (const Vec3& v : mesh.vertices) {
            low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
            high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
        }
        near_ = kOnSurface * norm(high - low);
        for (std::uint32_t i = 0; i < n; ++i) {
            const auto& t = mesh.triangles[i];
            const Vec3 n2 = cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[1]]);
            area_.push_back(0.5 * norm(n2));
            normal_.push_back(unit(n2));
        }
        by_area_.resize(n);
        std::iota(by_area_.begin(), by_area_.end(), 0U);
        std::ranges::sort(by_area_, [this](std::uint32_t a, std::uint32_t b) {
            return area_[a] != area_[b] ? area_[a] > area_[b] : a < b;
        });
    }

    FaceMap run() {
        if (mesh_->face.size() == mesh_->triangles.size()) {
            take_named();
        } else {
            find_flats();
            find_cylinders();
            find_rest();
        }
        for (std::uint32_t i = 0; i < mesh_->triangles.size(); ++i) {
            CadFace& face = out_.faces[out_.face_of[i]];
            face.triangles.push_back(i);
            face.area += area_[i];
        }
        return std::move(out_);
    }

private:
    [[nodiscard]] const Vec3& corner(std::uint32_t triangle, std::size_t k) const {
        return mesh_->vertices[mesh_->triangles[triangle][k]];
    }
    [[nodiscard]] bool lies_in(std::uint32_t triangle, const Vec3& point, const Vec3& normal) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::abs(dot(corner(triangle, k) - point, normal)) > near_) {
                return false;
            }
        }
        return true;
    }

    /// Pieces that are flat: each triangle with its neighbours in the same plane, the largest first.
    void find_flats() {
        flat_of_.assign(mesh_->triangles.size(), kNoFace);
        for (const std::uint32_t seed : by_area_) {
            if (flat_of_[seed] != kNoFace) {
                continue;
            }
            const auto flat = static_cast<std::uint32_t>(flats_.size());
            std::vector<std::uint32_t>& members = flats_.emplace_back();
            members.push_back(seed);
            flat_of_[seed] = flat;
            for (std::size_t i = 0; i < members.size(); ++i) {
                for (const std::uint32_t next : topology_->neighbour[members[i]]) {
                    if (next != kNoTriangle && flat_of_[next] == kNoFace &&
                        lies_in(next, corner(seed, 0), normal_[seed]) &&
                        (area_[next] < near_ * near_ || dot(normal_[next], normal_[seed]) > 0.9)) {
                        flat_of_[next] = flat;
                        members.push_back(next);
                    }
                }
            }
        }
    }

    [[nodiscard]] Vec3 flat_normal(std::uint32_t flat) const { return normal_[flats_[flat].front()]; }

    /// Flat pieces about two that meet along an edge: smooth neighbours that all stand along it, at most `count`.
    [[nodiscard]] std::vector<std::uint32_t> strips_about(std::uint32_t a, std::uint32_t b, const Vec3& axis,
                                                          std::size_t count) {
        std::vector<std::uint32_t> members{a, b};
        ++look_;
        seen_.resize(flats_.size(), 0);
        seen_[a] = seen_[b] = look_;
        for (std::size_t i = 0; i < members.size() && members.size() < count; ++i) {
            for (const std::uint32_t t : flats_[members[i]]) {
                for (const std::uint32_t next : topology_->neighbour[t]) {
                    const std::uint32_t flat = next == kNoTriangle ? kNoFace : flat_of_[next];
                    if (flat == kNoFace || seen_[flat] == look_ || out_.face_of[next] != kNoFace) {
                        continue;
                    }
                    seen_[flat] = look_;
                    const Vec3 normal = flat_normal(flat);
                    if (std::abs(dot(normal, axis)) < 0.01 && dot(normal, flat_normal(members[i])) > kStripCosine) {
                        members.push_back(flat);
                    }
                }
            }
        }
        return members;
    }

    /// The cylinder that fits the corners of flat pieces best, if all lie on it: its axis is square to their normals.
    [[nodiscard]] std::optional<Cylinder> fitted(const std::vector<std::uint32_t>& members) const {
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        for (const std::uint32_t flat : members) {
            const Vec3 n = flat_normal(flat);
            const Eigen::Vector3d v(n.x, n.y, n.z);
            spread += v * v.transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
        const Eigen::Matrix3d& basis = eigen.eigenvectors();  // the axis first
        if (eigen.eigenvalues()[1] < 1e-6 * eigen.eigenvalues()[2]) {
            return std::nullopt;
        }
        const Vec3 origin = corner(flats_[members.front()].front(), 0);
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        for (const std::uint32_t flat : members) {
            for (const std::uint32_t t : flats_[flat]) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const Vec3 p = corner(t, k) - origin;
                    const Eigen::Vector3d v(p.x, p.y, p.z);
                    const Eigen::Vector3d row(basis.col(1).dot(v), basis.col(2).dot(v), near_ * 1e5);
                    normal += row * row.transpose();
                    right += row * (row.x() * row.x() + row.y() * row.y());
                }
            }
        }
        const Eigen::Vector3d solved = normal.ldlt().solve(right);
        const double u = 0.5 * solved.x();
        const double v = 0.5 * solved.y();
        const double squared = solved.z() * near_ * 1e5 + u * u + v * v;
        if (!(squared > 0.0) || !std::isfinite(squared)) {
            return std::nullopt;
        }
        const Eigen::Vector3d centre = u * basis.col(1) + v * basis.col(2);
        Cylinder out{origin + Vec3{centre.x(), centre.y(), centre.z()},
                     {basis(0, 0), basis(1, 0), basis(2, 0)},
                     std::sqrt(squared),
                     false};
        out.hollow = dot(out.radial(origin), flat_normal(members.front())) < 0.0;
        const bool on_it =
            std::ranges::all_of(members, [&](std::uint32_t flat) { return flat_lies_on(flat, out, kLoose); });
        return on_it ? std::optional<Cylinder>(out) : std::nullopt;
    }

    /// The cylinder about two flat pieces that meet along an edge, if they are strips of one. Many strips give the
    /// sharper fit, a few stay on one cylinder where another joins it.
    [[nodiscard]] std::optional<Cylinder> through(std::uint32_t a, std::uint32_t b, const Vec3& from, const Vec3& to) {
        const Vec3 axis = unit(to - from);
        const Vec3 na = flat_normal(a);
        const Vec3 nb = flat_normal(b);
        const double cosine = dot(na, nb);
        if (cosine < kStripCosine || cosine > 0.9999999 || std::abs(dot(na, axis)) > 0.01 ||
            std::abs(dot(nb, axis)) > 0.01) {
            return std::nullopt;
        }
        for (const std::size_t count : {64U, 16U, 8U, 4U}) {
            const std::vector<std::uint32_t> members = strips_about(a, b, axis, count);
            if (members.size() >= kFewestStrips) {
                if (const auto cylinder = fitted(members)) {
                    return cylinder;
                }
            }
        }
        return std::nullopt;
    }

    [[nodiscard]] bool lies_on(std::uint32_t triangle, const Cylinder& cylinder, double reach) const {
        Vec3 middle{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::abs(norm(cylinder.radial(corner(triangle, k))) - cylinder.radius) > reach * near_) {
                return false;
            }
            middle = middle + (1.0 / 3.0) * corner(triangle, k);
        }
        const double side = dot(normal_[triangle], unit(cylinder.radial(middle))) * (cylinder.hollow ? -1.0 : 1.0);
        return area_[triangle] < near_ * near_ || side > kStripCosine;
    }

    [[nodiscard]] bool flat_lies_on(std::uint32_t flat, const Cylinder& cylinder, double reach) const {
        return std::ranges::all_of(flats_[flat], [&](std::uint32_t t) { return lies_on(t, cylinder, reach); });
    }

    /// Flat pieces on a cylinder that hang together with the first.
    [[nodiscard]] std::vector<std::uint32_t> grown(std::uint32_t first, const Cylinder& cylinder, double reach) {
        std::vector<std::uint32_t> members{first};
        seen_.resize(flats_.size(), 0);
        ++look_;
        seen_[first] = look_;
        for (std::size_t i = 0; i < members.size(); ++i) {
            for (const std::uint32_t t : flats_[members[i]]) {
                for (const std::uint32_t next : topology_->neighbour[t]) {
                    const std::uint32_t flat = next == kNoTriangle ? kNoFace : flat_of_[next];
                    if (flat == kNoFace || seen_[flat] == look_ || out_.face_of[next] != kNoFace) {
                        continue;
                    }
                    seen_[flat] = look_;
                    if (flat_lies_on(flat, cylinder, reach)) {
                        members.push_back(flat);
                    }
                }
            }
        }
        return members;
    }

    void find_cylinders() {
        for (const std::uint32_t t : by_area_) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t other = topology_->neighbour[t][k];
                if (other == kNoTriangle || out_.face_of[t] != kNoFace || out_.face_of[other] != kNoFace ||
                    flat_of_[t] == flat_of_[other]) {
                    continue;
                }
                auto cylinder = through(flat_of_[t], flat_of_[other], corner(t, k), corner(t, (k + 1) % 3));
                if (!cylinder) {
                    continue;
                }
                std::vector<std::uint32_t> members = grown(flat_of_[t], *cylinder, kLoose);
                // All of what was found gives the sharper cylinder, and that may find more.
                for (const double reach : {64.0, 16.0, kLoose}) {
                    if (const auto sharper = fitted(grown(flat_of_[t], *cylinder, reach))) {
                        cylinder = sharper;
                        members = grown(flat_of_[t], *cylinder, kLoose);
                    }
                }
                if (members.size() >= kFewestStrips) {
                    add_cylinder(*cylinder, members);
                }
            }
        }
    }

    void add_cylinder(const Cylinder& cylinder, const std::vector<std::uint32_t>& members) {
        std::uint32_t index = kNoFace;
        for (std::uint32_t i = 0; i < out_.faces.size(); ++i) {
            const CadFace& face = out_.faces[i];
            const Cylinder old{face.point, face.direction, face.radius, face.hollow};
            const bool same = face.kind == FaceKind::cylinder && face.hollow == cylinder.hollow &&
                              std::abs(face.radius - cylinder.radius) < 4.0 * near_ &&
                              norm(cross(face.direction, cylinder.axis)) < 1e-3 &&
                              norm(old.radial(cylinder.point)) < 20.0 * near_;
            index = same ? i : index;
        }
        if (index == kNoFace) {
            index = static_cast<std::uint32_t>(out_.faces.size());
            out_.faces.push_back({.kind = FaceKind::cylinder,
                                  .point = cylinder.point,
                                  .direction = cylinder.axis,
                                  .radius = cylinder.radius,
                                  .hollow = cylinder.hollow});
        }
        for (const std::uint32_t flat : members) {
            for (const std::uint32_t t : flats_[flat]) {
                out_.face_of[t] = index;
            }
        }
    }

    /// What is left: flat pieces that nothing joins smoothly are planes; smooth neighbours are one face.
    void find_rest() {
        for (const std::uint32_t seed : by_area_) {
            if (out_.face_of[seed] != kNoFace) {
                continue;
            }
            const auto index = static_cast<std::uint32_t>(out_.faces.size());
            std::vector<std::uint32_t> members{seed};
            out_.face_of[seed] = index;
            const bool large = area_of_flat(flat_of_[seed]) > 4e-4 * total_area();
            for (std::size_t i = 0; i < members.size(); ++i) {
                for (const std::uint32_t next : topology_->neighbour[members[i]]) {
                    if (next == kNoTriangle || out_.face_of[next] != kNoFace) {
                        continue;
                    }
                    const bool same = flat_of_[next] == flat_of_[members[i]];
                    const bool smooth = !large && dot(normal_[next], normal_[members[i]]) > kSmoothCosine &&
                                        area_of_flat(flat_of_[next]) <= 4e-4 * total_area();
                    if (same || smooth) {
                        out_.face_of[next] = index;
                        members.push_back(next);
                    }
                }
            }
            out_.faces.push_back(described(members));
        }
    }

    [[nodiscard]] double total_area() {
        if (total_ == 0.0) {
            total_ = std::accumulate(area_.begin(), area_.end(), 0.0);
        }
        return total_;
    }
    [[nodiscard]] double area_of_flat(std::uint32_t flat) const {
        double sum = 0.0;
        for (const std::uint32_t t : flats_[flat]) {
            sum += area_[t];
        }
        return sum;
    }

    /// Plane or other; `members` has the largest triangle first.
    [[nodiscard]] CadFace described(const std::vector<std::uint32_t>& members) const {
        const std::uint32_t first = members.front();
        Vec3 mean{};
        bool flat = true;
        for (const std::uint32_t t : members) {
            mean = mean + area_[t] * normal_[t];
            flat = flat && lies_in(t, corner(first, 0), normal_[first]);
        }
        return {.kind = flat ? FaceKind::plane : FaceKind::other,
                .point = corner(first, 0),
                .direction = flat ? normal_[first] : unit(mean)};
    }

    void take_named() {
        std::map<std::uint32_t, std::vector<std::uint32_t>> members;
        for (const std::uint32_t t : by_area_) {
            members[mesh_->face[t]].push_back(t);
        }
        find_flats();
        find_cylinders();
        const FaceMap found = std::move(out_);
        out_ = {};
        out_.face_of.assign(mesh_->triangles.size(), kNoFace);
        for (const auto& [name, triangles] : members) {
            CadFace face = described(triangles);
            const std::uint32_t round = found.face_of[triangles.front()];
            const bool whole = round != kNoFace && std::ranges::all_of(triangles, [&](std::uint32_t t) {
                                   return found.face_of[t] == round;
                               });
            if (whole) {
                const CadFace& cylinder = found.faces[round];
                face.kind = cylinder.kind;
                face.point = cylinder.point;
                face.direction = cylinder.direction;
                face.radius = cylinder.radius;
                face.hollow = cylinder.hollow;
            }
            for (const std::uint32_t t : triangles) {
                out_.face_of[t] = static_cast<std::uint32_t>(out_.faces.size());
            }
            out_.faces.push_back(face);
        }
    }

    const TriangleMesh* mesh_;
    const Topology* topology_;
    FaceMap out_;
    double near_ = 0.0;
    double total_ = 0.0;
    std::vector<double> area_;
    std::vector<Vec3> normal_;
    std::vector<std::uint32_t> by_area_;
    std::vector<std::uint32_t> flat_of_;
    std::vector<std::vector<std::uint32_t>> flats_;
    std::vector<std::uint32_t> seen_;  ///< one a flat piece: the search that saw it last
    std::uint32_t look_ = 0;
};

}  // namespace

std::string_view name_of(FaceKind kind) noexcept {
    switch (kind) {
        case FaceKind::plane: return "plane";
        case FaceKind::cylinder: return "cylinder";
        case FaceKind::other: return "other";
    }
    return "?";
}

FaceMap segmented(const TriangleMesh& mesh, const Topology& topology) { return Segmenter(mesh, topology).run(); }

}  // namespace sc::host
