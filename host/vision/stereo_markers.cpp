// SPDX-License-Identifier: Apache-2.0
#include "host/vision/stereo_markers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/formats/text.hpp"
#include "host/vision/circle_pose.hpp"
#include "host/vision/dual_conic.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kOutline = 16;              ///< places of an outline that are undistorted
constexpr double kAgree = 8.0 * kDegree;  ///< normals of one plane
constexpr double kSigmas = 4.0;
constexpr double kFewestAgree = 0.5;  ///< of the markers, for a common plane

Pinhole pinhole_of(const CameraModel& m) {
    return {.focal_x = m.focal_x, .focal_y = m.focal_y, .middle_x = m.middle_x, .middle_y = m.middle_y};
}

/// As a camera without distortion would see it: from places of its outline.
std::optional<Ellipse> straight(const CameraModel& camera, const Ellipse& e) {
    std::array<Pixel, kOutline> outline{};
    double x = 0.0;
    double y = 0.0;
    for (int k = 0; k < kOutline; ++k) {
        const double turn = 2.0 * std::numbers::pi * k / kOutline;
        const double u = e.major * std::cos(turn);
        const double v = e.minor * std::sin(turn);
        const auto ray = undistorted(camera, {e.x + u * std::cos(e.angle) - v * std::sin(e.angle),
                                              e.y + u * std::sin(e.angle) + v * std::cos(e.angle)});
        if (!ray) {
            return std::nullopt;
        }
        auto& p = outline[static_cast<std::size_t>(k)];
        p = {camera.focal_x * ray->x + camera.middle_x, camera.focal_y * ray->y + camera.middle_y};
        x += p[0] / kOutline;
        y += p[1] / kOutline;
    }
    EllipseShape shape{};
    for (const Pixel& p : outline) {
        shape[0] += 2.0 * (p[0] - x) * (p[0] - x) / kOutline;
        shape[1] += 2.0 * (p[0] - x) * (p[1] - y) / kOutline;
        shape[2] += 2.0 * (p[1] - y) * (p[1] - y) / kOutline;
    }
    return ellipse_of(x, y, shape);
}

/// Where the camera, with its distortion, sees a place of the picture without.
Pixel bent(const CameraModel& camera, const Pixel& at) {
    const auto seen =
        project(camera, {(at[0] - camera.middle_x) / camera.focal_x, (at[1] - camera.middle_y) / camera.focal_y, 1.0});
    return seen.value_or(at);
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

Vec3 unit(const Vec3& v) { return (1.0 / norm(v)) * v; }

struct Candidate {
    std::size_t left = 0;
    std::size_t right = 0;
    Triangulated at;
    double radius = 0.0;
    Vec3 normal;
};

class Matcher {
public:
    Matcher(const CameraSet& pair, std::span<const Marker> left, std::span<const Marker> right,
            const StereoSettings& settings)
        : pair_(pair), left_(left), right_(right), settings_(settings) {
        for (const Marker& m : left) {
            straight_left_.push_back(straight(pair.cameras[0].model, m.ellipse));
        }
        for (const Marker& m : right) {
            straight_right_.push_back(straight(pair.cameras[1].model, m.ellipse));
        }
    }

    StereoMarkers run() {
        find_candidates();
        StereoMarkers out;
        out.radius = settings_.radius > 0.0 ? settings_.radius : usual_radius();
        std::erase_if(candidates_, [&](const Candidate& c) {
            return std::abs(c.radius - out.radius) > settings_.radius_tolerance * out.radius;
        });
        const std::vector<Candidate> kept = unambiguous(out.refused);
        const std::vector<Vec3> normals = common_normals(kept);
        double squares = 0.0;
        for (std::size_t i = 0; i < kept.size(); ++i) {
            const auto at = corrected(kept[i], normals[i]);
            if (at) {
                out.markers.push_back({.left = kept[i].left,
                                       .right = kept[i].right,
                                       .at = *at,
                                       .normal = normals[i],
                                       .radius = kept[i].radius});
                squares += at->epipolar * at->epipolar;
            }
        }
        const double n = static_cast<double>(out.markers.size());
        out.epipolar_rms = n > 0.0 ? std::sqrt(squares / n) : 0.0;
        return out;
    }

private:
    [[nodiscard]] static SeenPoint seen(const Marker& m) {
        return {.at = {m.ellipse.x, m.ellipse.y}, .covariance = m.covariance};
    }

    void find_candidates() {
        for (std::size_t i = 0; i < left_.size(); ++i) {
            for (std::size_t k = 0; k < right_.size(); ++k) {
                if (left_[i].dark == right_[k].dark && straight_left_[i] && straight_right_[k]) {
                    consider(i, k);
                }
            }
        }
    }

    void consider(std::size_t i, std::size_t k) {
        const auto at = triangulate(pair_, seen(left_[i]), seen(right_[k]));
        const double limit = settings_.epipolar_px + kSigmas * std::hypot(left_[i].sigma, right_[k].sigma);
        if (!at || !(std::abs(at->epipolar) < limit) || at->place.z < settings_.nearest ||
            at->place.z > settings_.farthest) {
            return;
        }
        const CameraModel& l = pair_.cameras[0].model;
        const CameraModel& r = pair_.cameras[1].model;
        const auto l_normals = circle_normals(*straight_left_[i], pinhole_of(l));
        const auto r_normals = circle_normals(*straight_right_[k], pinhole_of(r));
        const Mat3 back = pair_.right_from_left->rotation.transposed();
        Candidate best{.left = i, .right = k, .at = *at, .radius = 0.0, .normal = {}};
        double least = 1e9;
        for (const Vec3& a : l_normals) {
            for (const Vec3& b : r_normals) {
                const double apart = angle_between(a, back * b);
                if (apart < least) {
                    least = apart;
                    best.normal = unit(a + back * b);
                }
            }
        }
        const Vec3 unit_l = circle_place(*straight_left_[i], pinhole_of(l), best.normal, 1.0);
        const Vec3 unit_r =
            circle_place(*straight_right_[k], pinhole_of(r), pair_.right_from_left->rotation * best.normal, 1.0);
        const double by_left = at->place.z / unit_l.z;
        const double by_right = in_right(pair_, at->place).z / unit_r.z;
        best.radius = 0.5 * (by_left + by_right);
        if (std::abs(by_left - by_right) < settings_.radius_tolerance * best.radius) {
            candidates_.push_back(best);
        }
    }

    /// The radius that most candidates agree on.
    [[nodiscard]] double usual_radius() const {
        double best = 0.0;
        std::size_t most = 0;
        for (const Candidate& c : candidates_) {
            std::size_t count = 0;
            double sum = 0.0;
            for (const Candidate& o : candidates_) {
                if (std::abs(o.radius - c.radius) < 0.5 * settings_.radius_tolerance * c.radius) {
                    ++count;
                    sum += o.radius;
                }
            }
            if (count > most) {
                most = count;
                best = sum / static_cast<double>(count);
            }
        }
        return best;
    }

    std::vector<Candidate> unambiguous(std::vector<std::string>& refused) const {
        std::vector<Candidate> out;
        for (std::size_t i = 0; i < left_.size(); ++i) {
            std::vector<const Candidate*> mine;
            bool shared = false;
            for (const Candidate& c : candidates_) {
                if (c.left == i) {
                    mine.push_back(&c);
                    shared = shared || std::ranges::count(candidates_, c.right, &Candidate::right) > 1;
                }
            }
            const std::string where =
                "the left marker at (" + fixed(left_[i].ellipse.x, 0) + ", " + fixed(left_[i].ellipse.y, 0) + ") ";
            if (mine.empty()) {
                refused.push_back(where +
                                  "has no partner in the right picture: none on its epipolar line is of its size");
            } else if (mine.size() > 1 || shared) {
                refused.push_back(where +
                                  "may belong to several right ones on one epipolar line, all of its size; turn "
                                  "the target a little about the view, or give the distance (--near-mm, --far-mm)");
            } else {
                out.push_back(*mine.front());
            }
        }
        return out;
    }

    /// The mean of normals that agree, where most do; else each its own.
    [[nodiscard]] static std::vector<Vec3> common_normals(const std::vector<Candidate>& kept) {
        std::vector<Vec3> out;
        for (const Candidate& c : kept) {
            Vec3 sum;
            double count = 0.0;
            for (const Candidate& o : kept) {
                if (angle_between(c.normal, o.normal) < kAgree) {
                    sum = sum + o.normal;
                    count += 1.0;
                }
            }
            out.push_back(count > kFewestAgree * static_cast<double>(kept.size()) ? unit(sum) : c.normal);
        }
        return out;
    }

    [[nodiscard]] std::optional<Triangulated> corrected(const Candidate& c, const Vec3& normal) const {
        SeenPoint l = seen(left_[c.left]);
        SeenPoint r = seen(right_[c.right]);
        if (settings_.correct_perspective) {
            const CameraModel& lm = pair_.cameras[0].model;
            const CameraModel& rm = pair_.cameras[1].model;
            l.at = bent(lm, circle_centre(*straight_left_[c.left], pinhole_of(lm), normal));
            r.at = bent(
                rm, circle_centre(*straight_right_[c.right], pinhole_of(rm), pair_.right_from_left->rotation * normal));
        }
        const auto at = triangulate(pair_, l, r);
        return at ? std::optional(*at) : std::nullopt;
    }

    const CameraSet& pair_;
    std::span<const Marker> left_;
    std::span<const Marker> right_;
    StereoSettings settings_;
    std::vector<std::optional<Ellipse>> straight_left_;
    std::vector<std::optional<Ellipse>> straight_right_;
    std::vector<Candidate> candidates_;
};

}  // namespace

StereoMarkers match_markers(const CameraSet& pair, std::span<const Marker> left, std::span<const Marker> right,
                            const StereoSettings& settings) {
    return Matcher(pair, left, right, settings).run();
}

}  // namespace sc::host
