// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

/// Small fixed-size vectors with a written-out order of every sum. The control path must give the same bits on every
/// compiler and core, so it does not use a library that may vectorise or reorder additions (Eigen's SSE2, AVX2 and
/// scalar sums differ); the host's estimators use Eigen. No heap, no libm, callable from any context.

namespace sc {

/// Three numbers in metres unless the name says otherwise; the frame is in the name or in `Point<Frame>`.
struct Vec3 {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;

    constexpr bool operator==(const Vec3&) const noexcept = default;
    [[nodiscard]] constexpr double operator[](std::size_t i) const noexcept { return i == 0 ? x : (i == 1 ? y : z); }
};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double s, const Vec3& a) noexcept { return {s * a.x, s * a.y, s * a.z}; }
constexpr Vec3 operator*(const Vec3& a, double s) noexcept { return s * a; }
constexpr double dot(const Vec3& a, const Vec3& b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) noexcept { return __builtin_sqrt(dot(a, a)); }

/// Row-major 3×3 matrix.
struct Mat3 {
    std::array<Vec3, 3> row{Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}};

    constexpr bool operator==(const Mat3&) const noexcept = default;
    [[nodiscard]] static constexpr Mat3 identity() noexcept { return {}; }
    [[nodiscard]] constexpr Mat3 transposed() const noexcept {
        return {{Vec3{row[0].x, row[1].x, row[2].x}, Vec3{row[0].y, row[1].y, row[2].y},
                 Vec3{row[0].z, row[1].z, row[2].z}}};
    }
    [[nodiscard]] constexpr double determinant() const noexcept { return dot(row[0], cross(row[1], row[2])); }
};

constexpr Vec3 operator*(const Mat3& m, const Vec3& v) noexcept {
    return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)};
}
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) noexcept {
    const Mat3 bt = b.transposed();
    Mat3 out;
    for (std::size_t i = 0; i < 3; ++i) {
        out.row[i] = {dot(a.row[i], bt.row[0]), dot(a.row[i], bt.row[1]), dot(a.row[i], bt.row[2])};
    }
    return out;
}

/// Largest |m·mᵀ − 1| entry: 0 for an exact rotation. The determinant must be tested besides (a mirror passes this).
constexpr double orthogonality_error(const Mat3& m) noexcept {
    const Mat3 p = m * m.transposed();
    double worst = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            const double d = p.row[i][j] - (i == j ? 1.0 : 0.0);
            const double magnitude = d < 0.0 ? -d : d;
            worst = magnitude > worst ? magnitude : worst;
        }
    }
    return worst;
}

}  // namespace sc
