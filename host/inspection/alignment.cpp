// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include <Eigen/Dense>

#include "host/inspection/parallel.hpp"
#include "host/inspection/space_order.hpp"

namespace sc::host {

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kTukey = 4.685;
constexpr double kFinest = 1e-6;  ///< metres: the gate never closes more

/// The sums of one pass. Rotation is about `centre` and scaled by `length`, so that all six unknowns are lengths.
struct Sums {
    Matrix6 normal = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    std::size_t counted = 0;
    std::size_t rejected = 0;
};

struct Frame {
    Vec3 centre;
    double length = 1.0;
};

Vector6 row_of(const Frame& frame, const Vec3& place, const Vec3& direction) {
    const Vec3 turn = (1.0 / frame.length) * cross(place - frame.centre, direction);
    Vector6 row;
    row << direction.x, direction.y, direction.z, turn.x, turn.y, turn.z;
    return row;
}

double stiffness_of(const Matrix6& normal) {
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(normal);
    const double most = eigen.eigenvalues()[5];
    return most > 0.0 ? std::max(eigen.eigenvalues()[0], 0.0) / most : 0.0;
}

Placement moved(const Placement& placement, const Frame& frame, const Vector6& step) {
    const Mat3 turn = turn_by((1.0 / frame.length) * Vec3{step[3], step[4], step[5]});
    const Vec3 shift{step[0], step[1], step[2]};
    return {turn * placement.rotation, turn * (placement.translation - frame.centre) + frame.centre + shift};
}

class Fitter {
public:
    Fitter(const DistanceField& field, const FitOptions& options)
        : field_(&field), options_(&options), frame_{0.5 * (field.low() + field.high()), 0.5 * field.diagonal()} {}

    /// One Gauss-Newton step on `points`; returns how far the part moved at its rim.
    double step(std::span<const Vec3> points, Placement& placement, double gate, Fit& fit) {
        if (gate <= 0.0) {
            gate = gate_of(points, placement, fit);
        }
        std::vector<Sums> sums((points.size() + kPiece - 1) / kPiece);
        parallel_pieces(points.size(), kPiece, thread_count(options_->threads),
                        [&](std::size_t begin, std::size_t end, unsigned) {
                            add(points.subspan(begin, end - begin), placement, gate, sums[begin / kPiece]);
                        });
        Sums all;
        for (const Sums& s : sums) {  // in order: the same sum whatever the threads
            all.normal += s.normal;
            all.right += s.right;
            all.counted += s.counted;
            all.rejected += s.rejected;
        }
        fit.used = all.counted;
        fit.rejected = all.rejected;
        if (all.counted < 12) {
            throw InspectionError("only " + std::to_string(all.counted) +
                                  " points of the scan lie near the CAD model: "
                                  "is this a scan of another part, or of too little of it?");
        }
        fit.stiffness = stiffness_of(all.normal);
        // A motion that the surfaces leave free (a round part about its axis) stays where it is.
        const Matrix6 held = all.normal + 1e-12 * all.normal.trace() * Matrix6::Identity();
        const Vector6 x = held.ldlt().solve(-all.right);
        placement = moved(placement, frame_, x);
        return x.head<3>().norm() + x.tail<3>().norm();
    }

private:
    static constexpr std::size_t kPiece = 4096;

    [[nodiscard]] bool counts(const Distance& d) const { return options_->use.empty() || options_->use[d.triangle]; }

    /// Distances of a few thousand points, places first.
    void measure(std::span<const Vec3> points, const Placement& placement, std::vector<Vec3>& places,
                 std::vector<Distance>& distances) const {
        places.resize(points.size());
        distances.resize(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            places[i] = placement.rotation * points[i] + placement.translation;
        }
        field_->measure(places, distances, {.threads = 1, .simd = Simd::best, .sorted = true});
    }

    /// From the median of the distances that count, of a sample: robust against outliers and stock.
    double gate_of(std::span<const Vec3> points, const Placement& placement, Fit& fit) const {
        std::vector<Vec3> sample;
        const std::size_t stride = std::max<std::size_t>(1, points.size() / 20000);
        for (std::size_t i = 0; i < points.size(); i += stride) {
            sample.push_back(points[i]);
        }
        std::vector<Vec3> places;
        std::vector<Distance> distances;
        measure(sample, placement, places, distances);
        std::vector<double> off;
        for (const Distance& d : distances) {
            if (counts(d)) {
                off.push_back(std::abs(d.value));
            }
        }
        if (off.empty()) {
            return kFinest;
        }
        const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
        std::nth_element(off.begin(), middle, off.end());
        fit.sigma = 1.4826 * *middle;
        return std::max(kTukey * fit.sigma, kFinest);
    }

    void add(std::span<const Vec3> points, const Placement& placement, double gate, Sums& sums) const {
        // Few enough at a time to stay in the cache.
        thread_local std::vector<Vec3> places;
        thread_local std::vector<Distance> distances;
        measure(points, placement, places, distances);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Distance& d = distances[i];
            if (!counts(d)) {
                continue;
            }
            if (std::abs(d.value) >= gate) {
                ++sums.rejected;
                continue;
            }
            ++sums.counted;
            const double u = d.value / gate;
            const double weight = (1.0 - u * u) * (1.0 - u * u);
            const Vector6 row = row_of(frame_, places[i], field_->growth(places[i], d));
            sums.normal.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
            sums.right += (weight * d.value) * row;
        }
        sums.normal.triangularView<Eigen::StrictlyUpper>() = sums.normal.transpose();
    }

    const DistanceField* field_;
    const FitOptions* options_;
    Frame frame_;
};

std::vector<Vec3> gathered(std::span<const Vec3> points, std::span<const std::uint32_t> order, std::size_t stride,
                           unsigned threads) {
    std::vector<Vec3> out((order.size() + stride - 1 - stride / 2) / stride);
    parallel_pieces(out.size(), 16384, thread_count(threads), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            out[i] = points[order[stride / 2 + i * stride]];
        }
    });
    return out;
}

}  // namespace

Mat3 turn_by(const Vec3& vector) {
    const double angle = norm(vector);
    // sin(a)/a and (1 − cos a)/a², by their series where a is small
    const double s = angle > 1e-4 ? std::sin(angle) / angle : 1.0 - angle * angle / 6.0;
    const double half = std::sin(0.5 * angle);
    const double c = angle > 1e-4 ? 2.0 * half * half / (angle * angle) : 0.5 - angle * angle / 24.0;
    const Vec3& v = vector;
    return {{Vec3{1.0 - c * (v.y * v.y + v.z * v.z), c * v.x * v.y - s * v.z, c * v.x * v.z + s * v.y},
             Vec3{c * v.x * v.y + s * v.z, 1.0 - c * (v.x * v.x + v.z * v.z), c * v.y * v.z - s * v.x},
             Vec3{c * v.x * v.z - s * v.y, c * v.y * v.z + s * v.x, 1.0 - c * (v.x * v.x + v.y * v.y)}}};
}

std::vector<Vec3> placed(const Placement& w_from_c, std::span<const Vec3> points) {
    std::vector<Vec3> out(points.size());
    std::ranges::transform(points, out.begin(),
                           [&](const Vec3& p) { return w_from_c.rotation * p + w_from_c.translation; });
    return out;
}

Extent extent_of(std::span<const Vec3> points) {
    Extent out{points.empty() ? Vec3{} : points.front(), points.empty() ? Vec3{} : points.front()};
    for (const Vec3& v : points) {
        out.low = {std::min(out.low.x, v.x), std::min(out.low.y, v.y), std::min(out.low.z, v.z)};
        out.high = {std::max(out.high.x, v.x), std::max(out.high.y, v.y), std::max(out.high.z, v.z)};
    }
    return out;
}

std::vector<std::uint32_t> spread_sample(std::span<const Vec3> points, std::size_t count) {
    const Extent extent = extent_of(points);
    const std::vector<std::uint32_t> order = space_order(points, 1);
    std::vector<std::uint32_t> out;
    // A surface of that size has some 2 s²/h² cells; the cell shrinks until there are enough.
    double cell = extent.diagonal() / std::sqrt(0.7 * static_cast<double>(count));
    for (int round = 0; round < 12; ++round, cell *= 0.8) {
        out.clear();
        std::unordered_map<std::uint64_t, std::uint32_t> cells;
        const std::size_t stride = std::max<std::size_t>(1, points.size() / (40 * count));
        for (std::size_t i = 0; i < order.size(); i += stride) {
            const Vec3 q = (1.0 / cell) * (points[order[i]] - extent.low);
            const std::uint64_t key = static_cast<std::uint64_t>(q.x) << 42U | static_cast<std::uint64_t>(q.y) << 21U |
                                      static_cast<std::uint64_t>(q.z);
            if (cells.emplace(key, order[i]).second) {
                out.push_back(order[i]);
            }
        }
        if (out.size() >= count || out.size() * 2 > points.size()) {
            break;
        }
    }
    std::ranges::sort(out);
    return out;
}

Fit fit_to_mesh(const DistanceField& field, std::span<const Vec3> points, const Placement& start,
                const FitOptions& options) {
    Fit fit;
    fit.w_from_c = start;
    Fitter fitter(field, options);
    const std::vector<std::uint32_t> order = space_order(points, thread_count(options.threads));
    // Few points, every so many along the curve through space: the gate closes from the whole reach.
    constexpr std::size_t kFew = 6000;
    const std::vector<Vec3> few =
        gathered(points, order, std::max<std::size_t>(1, points.size() / kFew), options.threads);
    double gate = options.reach > 0.0 ? options.reach : 0.1 * field.diagonal();
    for (int i = 0; i < 60; ++i) {
        const double motion = fitter.step(few, fit.w_from_c, gate, fit);
        const bool closed = gate < 0.0;
        gate = closed || gate * 0.6 < 0.002 * field.diagonal() ? -1.0 : gate * 0.6;
        if (closed && motion < 1e-7) {
            break;
        }
    }
    const std::vector<Vec3> all = gathered(points, order, 1, options.threads);
    // The few have found the triangles: what is left of a step so short is far below a micrometre.
    for (int i = 0; i < 8; ++i) {
        ++fit.passes;
        if (fitter.step(all, fit.w_from_c, -1.0, fit) < 2e-5) {
            break;
        }
    }
    return fit;
}

ReferenceAlignment align_by_references(std::span<const ReferencePoint> references, std::span<const Vec3> points,
                                       const Placement& start, double radius, double depth) {
    if (references.size() < 6) {
        throw InspectionError("a 3-2-1 alignment needs six reference points, the part has " +
                              std::to_string(references.size()) +
                              ": add [[reference_point]] entries, or align by best fit");
    }
    ReferenceAlignment out{.w_from_c = start, .references = {}, .stiffness = 0.0};
    Vec3 centre{};
    for (const ReferencePoint& r : references) {
        centre = centre + (1.0 / static_cast<double>(references.size())) * r.point.v;
    }
    double length = 0.0;
    for (const ReferencePoint& r : references) {
        length = std::max(length, norm(r.point.v - centre));
    }
    const Frame frame{centre, std::max(length, 1e-6)};
    for (int round = 0; round < 30; ++round) {
        out.references.clear();
        Matrix6 normal = Matrix6::Zero();
        Vector6 right = Vector6::Zero();
        std::vector<std::vector<double>> heights(references.size());
        for (const Vec3& p : points) {
            const Vec3 q = out.w_from_c.rotation * p + out.w_from_c.translation;
            for (std::size_t i = 0; i < references.size(); ++i) {
                const Vec3 r = q - references[i].point.v;
                const double height = dot(r, references[i].normal.v);
                if (std::abs(height) < depth && dot(r, r) - height * height < radius * radius) {
                    heights[i].push_back(height);
                }
            }
        }
        for (std::size_t i = 0; i < references.size(); ++i) {
            if (heights[i].size() < 3) {
                throw InspectionError("reference point " + references[i].id + " has " +
                                      std::to_string(heights[i].size()) +
                                      " scanned points about it: scan that place, or choose another");
            }
            // The median, then the mean of what is near it: an outlier or the far side of a wall has no say.
            auto& h = heights[i];
            const auto middle = h.begin() + static_cast<std::ptrdiff_t>(h.size() / 2);
            std::nth_element(h.begin(), middle, h.end());
            const double median = *middle;
            double sum = 0.0;
            std::size_t count = 0;
            for (const double v : h) {
                if (std::abs(v - median) < 3e-4) {
                    sum += v;
                    ++count;
                }
            }
            const double offset = sum / static_cast<double>(count);
            out.references.push_back({references[i].id, count, offset});
            const Vector6 row = row_of(frame, references[i].point.v, references[i].normal.v);
            normal += row * row.transpose();
            right += offset * row;
        }
        out.stiffness = stiffness_of(normal);
        if (out.stiffness < 1e-6) {
            throw InspectionError(
                "the reference points leave a motion of the part free: spread them over three directions, "
                "3 + 2 + 1");
        }
        const Vector6 x = normal.ldlt().solve(-right);
        if (x.norm() < 1e-10) {
            break;
        }
        out.w_from_c = moved(out.w_from_c, frame, x);
        if (x.norm() < 1e-7 && round > 12) {
            break;  // the set of points about a reference may flip by one, for ever
        }
    }
    return out;
}

}  // namespace sc::host
