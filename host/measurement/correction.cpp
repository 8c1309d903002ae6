// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/correction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kHalfPi = 0.5 * std::numbers::pi;

double middle(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// x of the plane through (distance, at) with this normal, over (y, z).
double face_x(const Vec3& normal, double distance, const std::array<double, 2>& at, const std::array<double, 2>& yz) {
    return distance - (normal.y * (yz[0] - at[0]) + normal.z * (yz[1] - at[1])) / normal.x;
}

Verdict verdict_of(double off, double reach, double tolerance) {
    if (off + reach <= tolerance) {
        return Verdict::good;
    }
    return off - reach > tolerance ? Verdict::adjust : Verdict::too_near_to_tell;
}

}  // namespace

Vec3 normal_of(double angle, double yaw) noexcept {
    const double up = angle - kHalfPi;
    return {-std::cos(up) * std::cos(yaw), -std::cos(up) * std::sin(yaw), std::sin(up)};
}

StationTarget median_target(std::span<const StationResult> results) {
    std::array<std::vector<double>, 3> all;
    for (const StationResult& result : results) {
        all[0].push_back(result.angle);
        all[1].push_back(result.about_z);
        all[2].push_back(result.distance);
    }
    return {.same = true, .angle = middle(all[0]), .yaw = middle(all[1]), .distance = middle(all[2])};
}

Correction correction_of(const StationResult& result, const StationTarget& target, const StationJob& job) {
    Correction out;
    out.turn_z = target.yaw - result.about_z;
    out.turn_y = target.angle - result.angle;
    out.shift_x = target.distance - result.distance;
    const Vec3 wanted = normal_of(target.angle, target.yaw);
    out.off_angle = std::atan2(norm(cross(result.normal, wanted)), dot(result.normal, wanted));
    for (const StationScrew& screw : job.screws) {
        // The screw stands behind the face: its travel is what brings the face over (y, z) to the target.
        const double travel = face_x(result.normal, result.distance, result.at, screw.place) -
                              face_x(wanted, target.distance, result.at, screw.place);
        out.screws.push_back({screw.id, travel, travel / screw.pitch});
    }
    if (job.angle_tolerance > 0.0) {
        const double angle_reach = kCoverage95 * std::max(result.angle_sigma.total(), result.about_z_sigma.total());
        const Verdict angle = verdict_of(out.off_angle, angle_reach, job.angle_tolerance);
        const Verdict distance =
            verdict_of(std::abs(out.shift_x), kCoverage95 * result.distance_sigma.total(), job.distance_tolerance);
        if (angle == Verdict::adjust || distance == Verdict::adjust) {
            out.verdict = Verdict::adjust;
        } else {
            out.verdict =
                angle == Verdict::good && distance == Verdict::good ? Verdict::good : Verdict::too_near_to_tell;
        }
    }
    return out;
}

std::string correction_text(const Correction& correction) {
    if (correction.verdict == Verdict::good) {
        return "sits well";
    }
    std::string text = "turn " + fixed(correction.turn_z / kDegree, 3) + " deg about z, then " +
                       fixed(correction.turn_y / kDegree, 3) + " deg about y, shift " +
                       fixed(correction.shift_x * 1e3, 3) + " mm along x";
    for (const ScrewTurn& screw : correction.screws) {
        text += "; screw " + screw.id + " " + fixed(std::abs(screw.turns), 2) +
                (screw.turns >= 0.0 ? " turns clockwise" : " turns counter-clockwise");
    }
    if (correction.verdict == Verdict::too_near_to_tell) {
        text += " (within the measurement's uncertainty of the tolerance)";
    }
    return text;
}

}  // namespace sc::host
