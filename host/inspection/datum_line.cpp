// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/datum_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "host/formats/text.hpp"
#include "host/inspection/alignment.hpp"
#include "host/inspection/line_chain.hpp"
#include "host/inspection/neighbours.hpp"
#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

constexpr std::size_t kMost = 96;    ///< neighbours looked at
constexpr std::size_t kWanted = 30;  ///< neighbours that `reach` is chosen for
constexpr std::size_t kFewest = 6;   ///< fewer make no surface
constexpr std::size_t kSparse = 12;  ///< with fewer a wider reach is taken
constexpr double kSparser = 2.0;     ///< that many times as wide
constexpr double kDepth = 2.75;      ///< reaches from the plane: neighbours of neighbours of the band
constexpr double kSure = 0.5;        ///< cosine: `outwards` says which side of a patch is out
constexpr double kBand = 0.75;       ///< of the reach: points this near to the plane give places of the line
constexpr double kAlike = 0.9;       ///< cosine: normals of one face
constexpr double kBeyond = 0.45;     ///< of the reach: how far the points' middle is off at a straight edge, and some
constexpr double kThick = 0.12;      ///< of the reach: what is farther off its neighbours' plane is no surface
constexpr double kGrazing = 0.97;    ///< cosine of normal and plane's normal: the plane all but lies in the surface
constexpr double kSpacing = 0.22;    ///< of the reach: between places before they are thinned
constexpr double kLeastSeen = 0.1;   ///< of the line through the CAD model
constexpr double kMostlySeen = 0.5;  ///< the same: less is worth a note

/// A plane through the neighbours of a point.
struct Patch {
    Vec3 centre;
    Vec3 normal;
    double thickness = -1.0;  ///< rms, metres; negative: too few neighbours
};

/// A place of the line and the surface about it.
struct Seed {
    Vec3 place;
    Vec3 normal;
};

class Cutter {
public:
    Cutter(std::span<const Vec3> cloud, const std::function<Vec3(std::uint32_t)>& outwards, const Plane& plane,
           const CutOptions& options)
        : cloud_(cloud), outwards_(&outwards), plane_(plane), options_(&options) {}

    CutLine run() {
        CutLine out;
        reach_ = options_->reach > 0.0 ? options_->reach : found_reach();
        out.reach = reach_;
        const double spacing = kSpacing * reach_;
        take(kSparser * kDepth * reach_);
        if (near_.empty()) {
            return out;
        }
        std::vector<std::uint32_t> sparse;
        std::vector<LinePlace> places = level(&sparse, out);
        // Deep in bores a scan is thin: there the same again, over a wider reach.
        const double dense = reach_;
        reach_ *= kSparser;
        keep_only(sparse);
        for (LinePlace& place : level(nullptr, out)) {
            if (alone(place, places, dense)) {
                // What a quadratic surface cannot follow grows with the square of the reach and is not in the scatter.
                place.sigma *= kSparser * kSparser;
                places.push_back(place);
            }
        }
        chain(std::move(places), plane_, *options_, spacing, out);
        return out;
    }

private:
    /// Points within `height` of the plane.
    void take(double height) {
        near_.clear();
        index_.clear();
        for (std::uint32_t i = 0; i < cloud_.size(); ++i) {
            if (std::abs(plane_.height(cloud_[i])) <= height) {
                near_.push_back(cloud_[i]);
                index_.push_back(i);
            }
        }
    }

    void keep_only(const std::vector<std::uint32_t>& wanted) {
        std::vector<Vec3> near;
        std::vector<std::uint32_t> index;
        for (const std::uint32_t i : wanted) {
            near.push_back(near_[i]);
            index.push_back(index_[i]);
        }
        near_ = std::move(near);
        index_ = std::move(index);
    }

    /// Places of the line from the points at hand. `sparse` gets those with few neighbours.
    std::vector<LinePlace> level(std::vector<std::uint32_t>* sparse, CutLine& out) {
        const Neighbours neighbours(near_, reach_);
        if (sparse != nullptr) {
            *sparse = thinly_seen(neighbours);
        }
        make_patches(neighbours);
        const std::vector<Seed> seeds = slid(neighbours, out);
        out.points += seeds.size();
        return refined(neighbours, thinned(seeds, kSpacing * reach_));
    }

    [[nodiscard]] std::vector<std::uint32_t> thinly_seen(const Neighbours& neighbours) const {
        std::vector<std::uint8_t> few(near_.size(), 0);
        each(near_.size(), [&](std::size_t i) {
            std::array<std::uint32_t, kSparse> about{};
            few[i] = neighbours.about(static_cast<std::uint32_t>(i), about) < kSparse ? 1 : 0;
        });
        std::vector<std::uint32_t> out;
        for (std::uint32_t i = 0; i < few.size(); ++i) {
            if (few[i] != 0) {
                out.push_back(i);
            }
        }
        return out;
    }

    /// Whether no other place of the same face is near.
    static bool alone(const LinePlace& place, const std::vector<LinePlace>& others, double apart) {
        return std::ranges::none_of(others, [&](const LinePlace& other) {
            return norm(other.place - place.place) < apart && dot(other.normal, place.normal) > 0.5;
        });
    }

    /// From the number of neighbours in a sample, which grows with the square of the reach.
    double found_reach() {
        const Extent extent = extent_of(cloud_);
        double reach =
            4.0 * extent.diagonal() / std::sqrt(static_cast<double>(std::max<std::size_t>(cloud_.size(), 1)));
        for (int round = 0; round < 3; ++round) {
            take(reach);
            if (near_.empty()) {
                return reach;
            }
            const Neighbours neighbours(near_, reach);
            std::vector<std::size_t> counts;
            std::array<std::uint32_t, 4 * kMost> about{};
            const std::size_t stride = std::max<std::size_t>(1, near_.size() / 400);
            for (std::uint32_t i = 0; i < near_.size(); i += static_cast<std::uint32_t>(stride)) {
                if (std::abs(plane_.height(near_[i])) < 0.3 * reach) {
                    counts.push_back(neighbours.about(i, about));
                }
            }
            if (counts.empty()) {
                return reach;
            }
            const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
            std::nth_element(counts.begin(), middle, counts.end());
            const double ratio = static_cast<double>(kWanted) / static_cast<double>(std::max<std::size_t>(*middle, 1));
            reach *= std::clamp(std::sqrt(ratio), 0.4, 2.5);
        }
        return reach;
    }

    [[nodiscard]] Patch patch_of(const Neighbours& neighbours, std::uint32_t i) const {
        std::array<std::uint32_t, kMost> about{};
        const std::size_t count = neighbours.about(i, about);
        if (count < kFewest) {
            return {};
        }
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
        for (std::size_t k = 0; k < count; ++k) {
            const Vec3 r = near_[about[k]] - near_[i];
            const Eigen::Vector3d v(r.x, r.y, r.z);
            sum += v;
            products += v * v.transpose();
        }
        const auto n = static_cast<double>(count + 1);
        const Eigen::Vector3d mean = sum / n;
        const Eigen::Matrix3d spread = products / n - mean * mean.transpose();
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
        eigen.computeDirect(spread);
        const Eigen::Vector3d normal = eigen.eigenvectors().col(0).normalized();
        return {near_[i] + Vec3{mean.x(), mean.y(), mean.z()},
                {normal.x(), normal.y(), normal.z()},
                std::sqrt(std::max(eigen.eigenvalues()[0], 0.0))};
    }

    void make_patches(const Neighbours& neighbours) {
        patches_.assign(near_.size(), {});
        each(near_.size(), [&](std::size_t i) {
            if (std::abs(plane_.height(near_[i])) <= (1.0 + kBand) * reach_) {
                patches_[i] = patch_of(neighbours, static_cast<std::uint32_t>(i));
            }
        });
    }

    /// Of the patches about a point the one that it fits best: near an edge that is one from beside the edge.
    [[nodiscard]] Patch best_patch(const Neighbours& neighbours, std::uint32_t i) const {
        std::array<std::uint32_t, kMost> about{};
        const std::size_t count = neighbours.about(i, about);
        const auto cost = [&](const Patch& patch) {
            return patch.thickness < 0.0 ? 1.0 : patch.thickness + std::abs(dot(near_[i] - patch.centre, patch.normal));
        };
        Patch best = patches_[i];
        double least = cost(best);
        for (std::size_t k = 0; k < count; ++k) {
            const double c = cost(patches_[about[k]]);
            if (c < least) {
                least = c;
                best = patches_[about[k]];
            }
        }
        if (least > kThick * reach_) {
            best.thickness = -1.0;
        }
        return best;
    }

    /// Points of the band, slid along their surfaces into the plane.
    std::vector<Seed> slid(const Neighbours& neighbours, CutLine& out) {
        std::vector<Seed> all(near_.size());
        std::vector<std::uint8_t> state(near_.size(), 0);  // 1: a place, 2: no surface
        std::vector<std::uint8_t> sure(near_.size(), 0);   // which side is out
        each(near_.size(), [&](std::size_t i) {
            const double height = plane_.height(near_[i]);
            if (std::abs(height) > kBand * reach_) {
                return;
            }
            const Patch patch = best_patch(neighbours, static_cast<std::uint32_t>(i));
            const double along = dot(patch.normal, plane_.normal);
            if (patch.thickness < 0.0 || std::abs(along) > kGrazing) {
                state[i] = 2;
                return;
            }
            const Vec3 way = plane_.normal - along * patch.normal;
            const Vec3 place = near_[i] - (height / (1.0 - along * along)) * way;
            if (norm(place - near_[i]) > 2.0 * reach_) {
                state[i] = 2;
                return;
            }
            const double side = dot((*outwards_)(index_[i]), patch.normal);
            all[i] = {place, side < 0.0 ? -patch.normal : patch.normal};
            sure[i] = std::abs(side) > kSure ? 1 : 0;
            state[i] = 1;
        });
        agree(neighbours, all, state, sure);
        std::vector<Seed> seeds;
        face_.assign(near_.size(), Vec3{});
        for (std::size_t i = 0; i < all.size(); ++i) {
            out.left_out += state[i] == 2 ? 1U : 0U;
            if (state[i] == 1) {
                seeds.push_back(all[i]);
            }
        }
        each(near_.size(), [&](std::size_t i) {
            if (std::abs(plane_.height(near_[i])) <= (1.0 + kBand) * reach_) {
                face_[i] = state[i] == 1 ? all[i].normal : best_patch(neighbours, static_cast<std::uint32_t>(i)).normal;
            }
        });
        return seeds;
    }

    /// Over a bore the CAD model says nothing of the blank's face there; the face beside it does. It spreads from those
    /// that are sure.
    void agree(const Neighbours& neighbours, std::vector<Seed>& all, const std::vector<std::uint8_t>& state,
               std::vector<std::uint8_t>& sure) const {
        std::vector<std::uint32_t> unsure;
        for (std::uint32_t i = 0; i < all.size(); ++i) {
            if (state[i] == 1 && sure[i] == 0) {
                unsure.push_back(i);
            }
        }
        std::array<std::uint32_t, kMost> about{};
        for (bool changed = true; changed && !unsure.empty();) {
            std::vector<std::pair<std::uint32_t, double>> settled;
            for (const std::uint32_t i : unsure) {
                const std::size_t count = neighbours.about(i, about);
                double votes = 0.0;
                for (std::size_t k = 0; k < count; ++k) {
                    const double alike = dot(all[about[k]].normal, all[i].normal);
                    votes += sure[about[k]] != 0 && std::abs(alike) > kAlike ? alike : 0.0;
                }
                if (std::abs(votes) > 1.5) {
                    settled.push_back({i, votes});
                }
            }
            for (const auto& [i, votes] : settled) {
                sure[i] = 1;
                all[i].normal = votes < 0.0 ? -all[i].normal : all[i].normal;
            }
            changed = !settled.empty();
            std::erase_if(unsure, [&](std::uint32_t i) { return sure[i] != 0; });
        }
    }

    /// At most one of each face within `apart`.
    static std::vector<Seed> thinned(const std::vector<Seed>& seeds, double apart) {
        std::vector<Vec3> places;
        for (const Seed& seed : seeds) {
            places.push_back(seed.place);
        }
        const Neighbours neighbours(places, apart);
        std::vector<std::uint8_t> dropped(seeds.size(), 0);
        std::vector<Seed> out;
        std::array<std::uint32_t, 4 * kMost> about{};
        for (std::uint32_t i = 0; i < seeds.size(); ++i) {
            if (dropped[i] != 0) {
                continue;
            }
            out.push_back(seeds[i]);
            const std::size_t count = neighbours.about(i, about);
            for (std::size_t k = 0; k < count; ++k) {
                if (dot(seeds[about[k]].normal, seeds[i].normal) > 0.5) {
                    dropped[about[k]] = 1;
                }
            }
        }
        return out;
    }

    /// The height of a quadratic surface, fitted to the points of the same face, over each place within the plane.
    std::vector<LinePlace> refined(const Neighbours& neighbours, const std::vector<Seed>& seeds) const {
        std::vector<LinePlace> out(seeds.size());
        each(seeds.size(), [&](std::size_t i) { out[i] = refined(neighbours, seeds[i]); });
        std::erase_if(out, [](const LinePlace& place) { return dot(place.normal, place.normal) < 0.5; });
        return out;
    }

    LinePlace refined(const Neighbours& neighbours, const Seed& seed) const {
        std::array<std::uint32_t, kMost> about{};
        const std::size_t count = neighbours.at(seed.place, about);
        const double along = dot(seed.normal, plane_.normal);
        const Vec3 rise = (1.0 / std::sqrt(1.0 - along * along)) * (seed.normal - along * plane_.normal);
        const Vec3 tangent = cross(plane_.normal, rise);
        Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
        Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
        Eigen::Matrix<double, kMost, 8> rows;  // with height and weight
        Eigen::Index used = 0;
        Vec3 middle{};
        for (std::size_t k = 0; k < count; ++k) {
            const Vec3 r = near_[about[k]] - seed.place;
            if (std::abs(dot(face_[about[k]], seed.normal)) < kAlike ||
                std::abs(dot(r, seed.normal)) > 2.0 * kThick * reach_) {
                continue;
            }
            const double s = dot(r, tangent) / reach_;
            const double h = dot(r, plane_.normal) / reach_;
            const double near = 1.0 - dot(r, r) / (reach_ * reach_);
            const double weight = near * near;
            Eigen::Matrix<double, 6, 1> row;
            row << 1.0, s, h, s * s, s * h, h * h;
            normal += weight * row * row.transpose();
            right += weight * dot(r, rise) * row;
            middle = middle + r;
            rows.row(used) << row.transpose(), dot(r, rise), weight;
            ++used;
        }
        // Slid past the edge of its face, a place has the points of that face on one side alone.
        if (used < static_cast<Eigen::Index>(kFewest) || norm(middle) > kBeyond * reach_ * static_cast<double>(used)) {
            return {};
        }
        // A little of its own weight on the curvatures holds them where the points lie on one side alone.
        for (Eigen::Index k = 1; k < 6; ++k) {
            normal(k, k) += (k < 3 ? 1e-4 : 1e-3) * normal(0, 0);
        }
        const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal);
        const Eigen::Matrix<double, 6, 1> x = solver.solve(right);
        // The height is a weighted sum of the points' heights; its variance is the sum of the squares of those weights.
        const auto sheet = rows.topRows(used);
        const Eigen::VectorXd off = sheet.col(6) - sheet.leftCols<6>() * x;
        const Eigen::VectorXd share =
            (sheet.leftCols<6>() * solver.solve(Eigen::Matrix<double, 6, 1>::Unit(0))).cwiseProduct(sheet.col(7));
        const double freedom = std::max(1.0, static_cast<double>(used) - 6.0);
        const double sigma = std::sqrt(off.squaredNorm() / freedom) * share.norm();
        const double offset = std::clamp(x[0], -kThick * reach_, kThick * reach_);
        const Vec3 surface = rise - (x[1] / reach_) * tangent - (x[2] / reach_) * plane_.normal;
        return {seed.place + offset * rise, (1.0 / norm(surface)) * surface, sigma};
    }

    template <class Work>
    void each(std::size_t count, const Work& work) const {
        parallel_pieces(count, 1024, thread_count(options_->threads),
                        [&](std::size_t begin, std::size_t end, unsigned) {
                            for (std::size_t i = begin; i < end; ++i) {
                                work(i);
                            }
                        });
    }

    std::span<const Vec3> cloud_;
    const std::function<Vec3(std::uint32_t)>* outwards_;
    Plane plane_;
    const CutOptions* options_;
    double reach_ = 0.0;
    std::vector<Vec3> near_;            ///< points near the plane
    std::vector<std::uint32_t> index_;  ///< of each in the cloud
    std::vector<Patch> patches_;        ///< one each
    std::vector<Vec3> face_;            ///< normal of the face that each belongs to, either way round
};

}  // namespace

CutLine cut_line(std::span<const Vec3> cloud, const std::function<Vec3(std::uint32_t)>& outwards, const Plane& plane,
                 const CutOptions& options) {
    return cloud.empty() ? CutLine{} : Cutter(cloud, outwards, plane, options).run();
}

DatumLine datum_line(const DistanceField& field, std::span<const Vec3> places, const DatumPlane& datum,
                     const CutOptions& options) {
    DatumLine out{.id = datum.id, .plane = {datum.point.v, datum.normal.v}, .cut = {}, .cad_length = 0.0, .notes = {}};
    out.cad_length = length_of(section(field.mesh(), out.plane));
    if (out.cad_length <= 0.0) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& v : field.mesh().vertices) {
            nearest = std::min(nearest, std::abs(out.plane.height(v)));
        }
        throw InspectionError("datum plane " + datum.id + " misses the part: it passes " + fixed(1e3 * nearest, 2) +
                              " mm from it; check its point and normal");
    }
    const auto outwards = [&](std::uint32_t i) { return field.foot(places[i], field.at(places[i])).direction; };
    out.cut = cut_line(places, outwards, out.plane, options);
    const double seen = out.cut.length / out.cad_length;
    if (seen < kLeastSeen) {
        throw InspectionError("the scan shows " + fixed(1e3 * out.cut.length, 1) +
                              " mm of the line where datum plane " + datum.id + " meets the part, of some " +
                              fixed(1e3 * out.cad_length, 0) + " mm: scan the part there too");
    }
    if (seen < kMostlySeen) {
        out.notes.push_back("the scan shows " + fixed(100.0 * seen, 0) + " % of the line of datum plane " + datum.id +
                            "; the rest cannot be burnt");
    }
    return out;
}

}  // namespace sc::host
