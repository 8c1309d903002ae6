// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/allowance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Dense>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"
#include "host/inspection/neighbours.hpp"
#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

constexpr double kOnFace = 5e-5;      ///< metres: a feature's point lies on its face
constexpr double kAlongCosine = 0.8;  ///< the scanned surface looks the face's way
constexpr double kRim = 0.03;         ///< of the neighbours' spread: more thickness than that is no surface but a rim
constexpr double kSideCosine = 0.94;  ///< a side looks along an axis
constexpr double kOffNeighbours = 2e-4;  ///< metres: what is farther off its neighbours' plane is no surface
constexpr std::size_t kFewestNeighbours = 5;
constexpr double kApart = 5e-3;  ///< metres between worst places

std::string place_text(const Vec3& v) {
    return "(" + fixed(1e3 * v.x, 3) + " " + fixed(1e3 * v.y, 3) + " " + fixed(1e3 * v.z, 3) + ") mm";
}

[[noreturn]] void refuse(const MachinedFeature& feature, const std::string& problem, const std::string& value,
                         const std::string& action) {
    throw InputError(
        {.file = {}, .problem = "feature " + feature.id + " " + problem, .value = value, .action = action});
}

void check_face(const MachinedFeature& feature, const CadFace& face) {
    if (feature.kind == FeatureKind::plane) {
        const double cosine = dot(face.direction, feature.direction.v);
        if (face.kind != FaceKind::plane || cosine < 0.999) {
            refuse(feature, "is no plane of that normal in the CAD model",
                   "a " + std::string(name_of(face.kind)) + " lies at its point", "check its point and normal");
        }
        return;
    }
    if (face.kind != FaceKind::cylinder || !face.hollow) {
        refuse(feature, "is no bore in the CAD model", "a " + std::string(name_of(face.kind)) + " lies at its point",
               "give a point on the wall of the bore");
    }
    if (std::abs(2.0 * face.radius - feature.diameter) > 2e-4 ||
        std::abs(dot(face.direction, feature.direction.v)) < 0.999) {
        refuse(
            feature, "has another diameter or axis in the CAD model",
            "diameter " + fixed(2e3 * face.radius, 3) + " mm there, " + fixed(1e3 * feature.diameter, 3) + " mm asked",
            "check its diameter, axis and point");
    }
}

enum class Over : std::uint8_t { nothing, face, edge, across, outlier };

/// Whether a foot is on the face itself, or on an edge that it shares with another.
bool on_edge_of_face(const DistanceField& field, const FaceMap& map, const Distance& d) {
    if (d.feature == Feature::face) {
        return false;
    }
    const auto kind = static_cast<unsigned>(d.feature);
    const std::uint32_t face = map.face_of[d.triangle];
    if (kind < 4) {
        const std::uint32_t other = field.topology().neighbour[d.triangle][kind - 1];
        return other == kNoTriangle || map.face_of[other] != face;
    }
    // A corner: both edges that meet in it must be inside the face; a fan that leaves it elsewhere is rare and
    // harmless.
    for (const unsigned edge : {kind - 4, (kind - 4 + 2) % 3}) {
        const std::uint32_t other = field.topology().neighbour[d.triangle][edge];
        if (other == kNoTriangle || map.face_of[other] != face) {
            return true;
        }
    }
    return false;
}

Over judged(std::span<const Vec3> places, const Neighbours& neighbours, std::uint32_t i, const Vec3& direction) {
    std::array<std::uint32_t, 48> about{};
    const std::size_t count = neighbours.about(i, about);
    if (count < kFewestNeighbours) {
        return Over::outlier;
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 r = places[about[k]] - places[i];
        mean += Eigen::Vector3d(r.x, r.y, r.z) / static_cast<double>(count);
    }
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 r = places[about[k]] - places[i];
        const Eigen::Vector3d v = Eigen::Vector3d(r.x, r.y, r.z) - mean;
        spread += v * v.transpose() / static_cast<double>(count);
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(spread);
    const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    const double thickness = std::sqrt(std::max(eigen.eigenvalues()[0], 0.0));
    if (std::abs(normal.dot(mean)) > std::max(kOffNeighbours, 4.0 * thickness)) {
        return Over::outlier;
    }
    if (eigen.eigenvalues()[0] > kRim * eigen.eigenvalues()[1]) {
        return Over::edge;
    }
    const double cosine = normal.dot(Eigen::Vector3d(direction.x, direction.y, direction.z));
    return std::abs(cosine) < kAlongCosine ? Over::across : Over::face;
}

void add_worst(FaceAllowance& face, std::vector<std::pair<double, Vec3>>& least) {
    std::ranges::sort(least, [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [allowance, place] : least) {
        const bool near = std::ranges::any_of(
            face.worst, [&at = place](const WorstPlace& other) { return norm(other.place - at) < kApart; });
        if (!near && face.worst.size() < 3) {
            face.worst.push_back({place, allowance});
        }
    }
}

}  // namespace

AllowancePlan plan_from(const Part& part, const DistanceField& field, const FaceMap& map) {
    AllowancePlan plan;
    plan.group_of_face.assign(map.faces.size(), kNoGroup);
    for (const MachinedFeature& feature : part.machined) {
        const Distance at = field.at(feature.point.v);
        if (std::abs(at.value) > kOnFace) {
            refuse(feature, "has a point that is not on the CAD model",
                   place_text(feature.point.v) + " lies " + fixed(1e3 * at.value, 3) + " mm off",
                   "check the point, the unit and the CAD file");
        }
        const std::uint32_t index = map.face_of[at.triangle];
        check_face(feature, map.faces[index]);
        std::uint32_t& group = plan.group_of_face[index];
        if (group == kNoGroup) {
            group = static_cast<std::uint32_t>(plan.groups.size());
            plan.groups.push_back({.id = feature.id, .face = index, .least = feature.min_allowance});
        } else {
            BorrowGroup& shared = plan.groups[group];
            plan.notes.push_back(feature.id + " and " + shared.id + " are one face");
            shared.id += "+" + feature.id;
            shared.least = std::max(shared.least, feature.min_allowance);
        }
    }
    if (plan.groups.empty()) {
        throw InputError({.file = {},
                          .problem = "the part names no machined face",
                          .value = part.id,
                          .action = "add [[machined]] entries, or leave --part out to ask the same of every face"});
    }
    return plan;
}

AllowancePlan plan_for_all(const FaceMap& map, double least) {
    AllowancePlan plan;
    plan.group_of_face.assign(map.faces.size(), kNoGroup);
    const double area = std::accumulate(map.faces.begin(), map.faces.end(), 0.0,
                                        [](double sum, const CadFace& face) { return sum + face.area; });
    for (std::size_t i = 0; i < map.faces.size(); ++i) {
        const CadFace& face = map.faces[i];
        if (face.area > 1e-3 * area) {
            plan.group_of_face[i] = static_cast<std::uint32_t>(plan.groups.size());
            plan.groups.push_back(
                {.id = std::string(name_of(face.kind)) + " " + std::to_string(i + 1) + " at " + place_text(face.point),
                 .face = static_cast<std::uint32_t>(i),
                 .least = least});
        }
    }
    return plan;
}

OverFaces points_over(const DistanceField& field, const FaceMap& map, const AllowancePlan& plan,
                      std::span<const Vec3> places, std::span<const Distance> distances, unsigned threads) {
    const double area = std::accumulate(map.faces.begin(), map.faces.end(), 0.0,
                                        [](double sum, const CadFace& face) { return sum + face.area; });
    const double spacing = std::sqrt(area / static_cast<double>(std::max<std::size_t>(places.size(), 1)));
    const Neighbours neighbours(places, 3.0 * spacing);
    std::vector<Over> over(places.size(), Over::nothing);
    parallel_pieces(places.size(), 4096, thread_count(threads), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const Distance& d = distances[i];
            if (plan.group_of_face[map.face_of[d.triangle]] == kNoGroup) {
                continue;
            }
            over[i] = on_edge_of_face(field, map, d) ? Over::edge
                                                     : judged(places, neighbours, static_cast<std::uint32_t>(i),
                                                              field.foot(places[i], d).direction);
        }
    });
    OverFaces out;
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        out.left_out.at_edges += over[i] == Over::edge ? 1U : 0U;
        out.left_out.other_way += over[i] == Over::across ? 1U : 0U;
        out.left_out.outliers += over[i] == Over::outlier ? 1U : 0U;
        if (over[i] == Over::face) {
            out.points.push_back({places[i], plan.group_of_face[map.face_of[distances[i].triangle]]});
            out.index.push_back(i);
        }
    }
    return out;
}

bool AllowanceReport::enough() const noexcept {
    return std::ranges::all_of(faces, [](const FaceAllowance& face) { return face.enough(); });
}

const FaceAllowance* AllowanceReport::worst() const noexcept {
    const FaceAllowance* out = nullptr;
    for (const FaceAllowance& face : faces) {
        if (face.count > 0 && (out == nullptr || face.margin() < out->margin())) {
            out = &face;
        }
    }
    return out;
}

AllowanceReport evaluate(const FaceGauge& gauge, std::span<const BorrowPoint> points,
                         std::span<const BorrowGroup> groups, const Rigid<frame::W, frame::W>& motion,
                         unsigned threads) {
    std::vector<Vec3> places(points.size());
    std::vector<Reading> readings(points.size());
    parallel_pieces(points.size(), 4096, thread_count(threads), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            places[i] = motion.rotation * points[i].place + motion.translation;
            readings[i] = gauge.at(places[i], groups[points[i].group].face);
        }
    });

    AllowanceReport out;
    std::vector<double> squares(groups.size(), 0.0);
    for (const BorrowGroup& group : groups) {
        FaceAllowance& face = out.faces.emplace_back();
        face.id = group.id;
        face.least_asked = group.least;
        face.least = 1e300;
        face.most = -1e300;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        FaceAllowance& face = out.faces[points[i].group];
        const double d = readings[i].value;
        ++face.count;
        face.least = std::min(face.least, d);
        face.most = std::max(face.most, d);
        face.mean += d;
        const Vec3 direction = readings[i].direction;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (std::abs(direction[axis]) > kSideCosine) {
                Side& side = out.sides[axis][direction[axis] > 0.0 ? 0 : 1];
                side.least = side.count == 0 ? d : std::min(side.least, d);
                side.mean += d;
                ++side.count;
            }
        }
    }
    for (auto& pair : out.sides) {
        for (Side& side : pair) {
            side.mean /= static_cast<double>(std::max<std::size_t>(side.count, 1));
        }
    }
    for (FaceAllowance& face : out.faces) {
        if (face.count == 0) {
            face.least = face.most = 0.0;
            continue;
        }
        face.mean /= static_cast<double>(face.count);
        face.histogram_low = face.least;
        face.histogram_width = std::max((face.most - face.least) / static_cast<double>(kHistogram), 1e-9);
    }
    std::vector<std::vector<std::pair<double, Vec3>>> least(groups.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::uint32_t group = points[i].group;
        FaceAllowance& face = out.faces[group];
        const double d = readings[i].value;
        squares[group] += (d - face.mean) * (d - face.mean);
        const double bin = (d - face.histogram_low) / face.histogram_width;
        ++face.histogram[std::min(static_cast<std::size_t>(std::max(bin, 0.0)), kHistogram - 1)];
        if (d <= face.least + 0.25 * (face.mean - face.least)) {
            least[group].emplace_back(d, places[i]);
        }
    }
    out.least_margin = 1e300;
    for (std::size_t i = 0; i < groups.size(); ++i) {
        FaceAllowance& face = out.faces[i];
        if (face.count > 0) {
            face.sigma = std::sqrt(squares[i] / static_cast<double>(face.count));
            out.least_margin = std::min(out.least_margin, face.margin());
            add_worst(face, least[i]);
        }
    }
    return out;
}

AsCast as_cast(const FaceMap& map, const AllowancePlan& plan, std::span<const Distance> distances) {
    std::vector<double> values;
    for (const Distance& d : distances) {
        if (plan.group_of_face[map.face_of[d.triangle]] == kNoGroup) {
            values.push_back(d.value);
        }
    }
    AsCast out;
    out.count = values.size();
    if (values.empty()) {
        return out;
    }
    std::ranges::sort(values);
    out.least = values[values.size() / 1000];
    out.most = values[values.size() - 1 - values.size() / 1000];
    double squares = 0.0;
    std::size_t count = 0;
    for (std::size_t i = values.size() / 1000; i < values.size() - values.size() / 1000; ++i, ++count) {
        out.mean += values[i];
        squares += values[i] * values[i];
    }
    out.mean /= static_cast<double>(count);
    out.sigma = std::sqrt(std::max(squares / static_cast<double>(count) - out.mean * out.mean, 0.0));
    return out;
}

}  // namespace sc::host
