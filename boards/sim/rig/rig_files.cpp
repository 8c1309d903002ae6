// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/rig_files.hpp"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace sc::sim {

double normal_draw(Random& random) {
    std::normal_distribution<double> normal;
    return normal(random);
}

double even_draw(Random& random, double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
}

Vec3 normal_place(Random& random, const Vec3& sigma) {
    Vec3 out;
    out.x = sigma.x * normal_draw(random);
    out.y = sigma.y * normal_draw(random);
    out.z = sigma.z * normal_draw(random);
    return out;
}

Vec3 any_direction(Random& random) {
    for (;;) {
        const Vec3 v = normal_place(random, {1.0, 1.0, 1.0});
        if (norm(v) > 1e-3) {
            return (1.0 / norm(v)) * v;
        }
    }
}

Mat3 turn_about(const Vec3& w) {
    const double angle = norm(w);
    if (!(angle > 0.0)) {
        return Mat3::identity();
    }
    const Vec3 u = (1.0 / angle) * w;
    const double half = std::sin(0.5 * angle);
    const double less = 2.0 * half * half;  // 1 − cos, exact for small angles
    const auto column = [&](const Vec3& e) { return e + std::sin(angle) * cross(u, e) + less * cross(u, cross(u, e)); };
    return Mat3{{column({1.0, 0.0, 0.0}), column({0.0, 1.0, 0.0}), column({0.0, 0.0, 1.0})}}.transposed();
}

Pose Pose::inverse() const {
    const Mat3 back = rotation.transposed();
    return {back, -(back * place)};
}

Pose Pose::operator*(const Pose& b) const { return {rotation * b.rotation, rotation * b.place + place}; }

// NOLINTNEXTLINE(cert-dcl50-cpp): a printf of the project, checked by the compiler.
std::string text_of(const char* format, ...) {
    std::array<char, 512> line{};
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(line.data(), line.size(), format, arguments);
    va_end(arguments);
    return line.data();
}

std::string text_of(const Mat3& m) {
    std::string out;
    for (const Vec3& row : m.row) {
        out += text_of("%s%.13f,%.13f,%.13f", out.empty() ? "" : ",", row.x, row.y, row.z);
    }
    return out;
}

std::string text_mm(const Vec3& v) { return text_of("%.8f,%.8f,%.8f", v.x * 1e3, v.y * 1e3, v.z * 1e3); }

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    out << text;
    out.close();
    if (!out) {
        throw std::runtime_error(file.string() + " cannot be written");
    }
}

}  // namespace sc::sim
