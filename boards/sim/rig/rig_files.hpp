// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <random>
#include <string>

#include "shared/geometry/vec.hpp"

/// What all sets share: draws, turns, and rows of files. Metres, radians.

namespace sc::sim {

using Random = std::mt19937_64;

constexpr double kDegree = 0.017453292519943295;

[[nodiscard]] double normal_draw(Random& random);
[[nodiscard]] double even_draw(Random& random, double least, double most);
/// Each coordinate with its own sigma.
[[nodiscard]] Vec3 normal_place(Random& random, const Vec3& sigma);
/// Even over the sphere.
[[nodiscard]] Vec3 any_direction(Random& random);
/// Rotation by |w| about w.
[[nodiscard]] Mat3 turn_about(const Vec3& w);

/// p_to = rotation p_from + place.
struct Pose {
    Mat3 rotation;
    Vec3 place;
    [[nodiscard]] Pose inverse() const;
    [[nodiscard]] Pose operator*(const Pose& b) const;
    [[nodiscard]] Vec3 operator*(const Vec3& p) const { return rotation * p + place; }
};

[[nodiscard]] std::string text_of(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// r11 to r33, with commas, 12 digits.
[[nodiscard]] std::string text_of(const Mat3& m);
/// x,y,z in millimetres to 0.01 nm.
[[nodiscard]] std::string text_mm(const Vec3& v);
/// Throws std::runtime_error.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace sc::sim
