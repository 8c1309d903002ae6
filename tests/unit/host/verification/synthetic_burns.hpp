// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/trace/trace.hpp"

/// Makes pulse records as a cell would, by its own few formulas: the turntable's axis is vertical through (kAxisX,
/// kAxisY), so a place in h and its spot in t differ by a plane rotation.

namespace sc::host::synthetic {

inline constexpr double kAxisX = -0.250;
inline constexpr double kAxisY = -0.470;

inline std::int64_t pm(double metres) { return std::llround(metres * 1e12); }

/// Spot in t of a place in h at angle C.
inline Vec3 to_table(const Vec3& h, double c_deg) {
    const double c = c_deg * 3.14159265358979323846 / 180.0;
    const double x = h.x - kAxisX;
    const double y = h.y - kAxisY;
    return {kAxisX + x * std::cos(c) + y * std::sin(c), kAxisY - x * std::sin(c) + y * std::cos(c), h.z};
}

class Burner {
public:
    std::vector<trace::PulseRecord> pulses;

    double c_deg = 0.0;                            ///< true angle
    double pitch = 20e-6;                          ///< metres
    double speed = 0.25;                           ///< metres / s
    double noise = 0.0;                            ///< metres, standard deviation in x and z
    std::function<Vec3(const Vec3&)> error;        ///< added to every place of the focus
    std::function<double(const Vec3&)> roughness;  ///< surface above the focus, metres along y
    std::function<bool(std::size_t)> lit;          ///< by pulse number in the stroke; unset = all

    explicit Burner(unsigned seed = 1) : random_(seed) {}

    void stroke(const Vec3& from, const Vec3& to) {
        t_ns_ += 200'000'000;
        const double length = norm(to - from);
        const auto count = static_cast<std::size_t>(std::floor(length / pitch + 1e-9)) + 1;
        for (std::size_t i = 0; i < count; ++i) {
            t_ns_ += std::llround(pitch / speed * 1e9);
            if (!lit || lit(i)) {
                pulse(from + (pitch * static_cast<double>(i) / length) * (to - from));
            }
        }
    }
    void cross(const Vec3& centre, double size = 4e-3) {
        const double half = 0.5 * size;
        stroke(centre + Vec3{-half, 0.0, 0.0}, centre + Vec3{half, 0.0, 0.0});
        stroke(centre + Vec3{0.0, 0.0, half}, centre + Vec3{0.0, 0.0, -half});
    }
    void pulse(const Vec3& aim) {
        Vec3 focus = error ? aim + error(aim) : aim;
        focus = focus + Vec3{noise * normal_(random_), 0.0, noise * normal_(random_)};
        const double rise = roughness ? roughness(focus) : 0.0;
        const Vec3 place{focus.x, focus.y + rise, focus.z};
        const Vec3 table = to_table(place, c_deg);
        trace::PulseRecord record;
        record.t_ns = t_ns_;
        record.place_pm = {pm(place.x), pm(place.y), pm(place.z)};
        record.table_pm = {pm(table.x), pm(table.y), pm(table.z)};
        record.defocus_pm = pm(-rise);
        record.c_ndeg = std::llround(c_deg * 1e9);
        record.energy_nj = 300'000;
        record.hit = 1;
        pulses.push_back(record);
    }
    void wait(std::int64_t ns) { t_ns_ += ns; }

private:
    std::int64_t t_ns_ = 0;
    std::mt19937 random_;
    std::normal_distribution<double> normal_{0.0, 1.0};
};

}  // namespace sc::host::synthetic
