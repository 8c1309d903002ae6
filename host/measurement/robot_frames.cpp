// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/robot_frames.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/measurement/correction.hpp"
#include "host/measurement/head_model.hpp"

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Frame on a face: x into the face, turned from r by the least turn that brings x of r there.
Mat3 face_rotation(const Vec3& normal) {
    const Vec3 x{1.0, 0.0, 0.0};
    const Vec3 into = -normal;
    const Vec3 axis = cross(x, into);
    const double sine = norm(axis);
    if (sine < 1e-15) {
        return Mat3::identity();
    }
    return rotation_exp((std::atan2(sine, dot(x, into)) / sine) * axis);
}

double plus_zero(double value) { return value == 0.0 ? 0.0 : value; }

/// A name that every controller takes: letters, digits, underscores.
std::string plain_name(const std::string& station) {
    std::string out;
    for (const char c : station) {
        out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    }
    return out;
}

}  // namespace

std::array<double, 3> abc_of(const Mat3& rotation) noexcept {
    const double sine = std::clamp(-rotation.row[2].x, -1.0, 1.0);
    const double flat = std::hypot(rotation.row[0].x, rotation.row[1].x);
    const double b = std::atan2(sine, flat);
    if (flat < 1e-12) {
        return {std::atan2(-rotation.row[0].y, rotation.row[1].y), b, 0.0};
    }
    return {std::atan2(rotation.row[1].x, rotation.row[0].x), b, std::atan2(rotation.row[2].y, rotation.row[2].z)};
}

std::array<double, 4> quaternion_of(const Mat3& m) noexcept {
    // The largest of the four is found first, so that nothing is divided by a small number.
    const double trace = m.row[0].x + m.row[1].y + m.row[2].z;
    std::array<double, 4> q{};
    if (trace > 0.0) {
        const double s = 2.0 * std::sqrt(1.0 + trace);
        q = {0.25 * s, (m.row[2].y - m.row[1].z) / s, (m.row[0].z - m.row[2].x) / s, (m.row[1].x - m.row[0].y) / s};
    } else if (m.row[0].x > m.row[1].y && m.row[0].x > m.row[2].z) {
        const double s = 2.0 * std::sqrt(1.0 + m.row[0].x - m.row[1].y - m.row[2].z);
        q = {(m.row[2].y - m.row[1].z) / s, 0.25 * s, (m.row[0].y + m.row[1].x) / s, (m.row[0].z + m.row[2].x) / s};
    } else if (m.row[1].y > m.row[2].z) {
        const double s = 2.0 * std::sqrt(1.0 + m.row[1].y - m.row[0].x - m.row[2].z);
        q = {(m.row[0].z - m.row[2].x) / s, (m.row[0].y + m.row[1].x) / s, 0.25 * s, (m.row[1].z + m.row[2].y) / s};
    } else {
        const double s = 2.0 * std::sqrt(1.0 + m.row[2].z - m.row[0].x - m.row[1].y);
        q = {(m.row[1].x - m.row[0].y) / s, (m.row[0].z + m.row[2].x) / s, (m.row[1].z + m.row[2].y) / s, 0.25 * s};
    }
    if (q[0] < 0.0) {
        for (double& v : q) {
            v = -v;
        }
    }
    return q;
}

StationFrame frame_of(const StationResult& result, const StationTarget& target, const StationRobot& robot, int number) {
    StationFrame out;
    out.station = result.id;
    out.number = number;
    const Vec3 seat = robot.translation + result.rail.value_or(0.0) * robot.rail;
    out.rotation = robot.rotation * face_rotation(result.normal);
    out.translation = robot.rotation * Vec3{result.distance, result.at[0], result.at[1]} + seat;
    out.nominal_rotation = robot.rotation * face_rotation(normal_of(target.angle, target.yaw));
    out.nominal_translation = robot.rotation * Vec3{target.distance, result.at[0], result.at[1]} + seat;
    return out;
}

std::string frames_csv(std::span<const StationFrame> frames) {
    std::string out = "station,number,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,q1,q2,q3,q4,dx_mm,dy_mm,dz_mm,turn_deg\n";
    for (const StationFrame& f : frames) {
        const auto abc = abc_of(f.rotation);
        const auto q = quaternion_of(f.rotation);
        const Vec3 t = 1e3 * f.translation;
        const Vec3 d = 1e3 * (f.translation - f.nominal_translation);
        const auto turn = quaternion_of(f.rotation * f.nominal_rotation.transposed());
        const double angle = 2.0 * std::atan2(std::hypot(turn[1], turn[2], turn[3]), turn[0]);
        out += fmt::format(
            "{},{},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.8f},{:.8f},{:.8f},{:.8f},{:.4f},{:.4f},"
            "{:.4f},{:.5f}\n",
            f.station, f.number, t.x, t.y, t.z, plus_zero(abc[0] / kDegree), plus_zero(abc[1] / kDegree),
            plus_zero(abc[2] / kDegree), q[0], q[1], q[2], q[3], d.x, d.y, d.z, angle / kDegree);
    }
    return out;
}

std::string frames_kuka(std::span<const StationFrame> frames) {
    std::string out = "DEF STATIONS()\n;workpieces as they were measured; mm and degrees\n";
    for (const StationFrame& f : frames) {
        const auto abc = abc_of(f.rotation);
        const Vec3 t = 1e3 * f.translation;
        out += fmt::format(";{}\nBASE_DATA[{}]={{X {:.4f},Y {:.4f},Z {:.4f},A {:.5f},B {:.5f},C {:.5f}}}\n", f.station,
                           f.number, t.x, t.y, t.z, abc[0] / kDegree, abc[1] / kDegree, abc[2] / kDegree);
    }
    return out + "END\n";
}

std::string frames_abb(std::span<const StationFrame> frames) {
    std::string out = "MODULE Stations\n  ! workpieces as they were measured; mm and quaternions\n";
    for (const StationFrame& f : frames) {
        const auto q = quaternion_of(f.rotation);
        const Vec3 t = 1e3 * f.translation;
        out += fmt::format(
            "  PERS wobjdata wobj_{}:=[FALSE,TRUE,\"\",[[{:.4f},{:.4f},{:.4f}],[{:.8f},{:.8f},{:.8f},"
            "{:.8f}]],[[0,0,0],[1,0,0,0]]];\n",
            plain_name(f.station), t.x, t.y, t.z, q[0], q[1], q[2], q[3]);
    }
    return out + "ENDMODULE\n";
}

std::string frames_fanuc(std::span<const StationFrame> frames) {
    std::string out = "/PROG STATIONS\n/ATTR\nCOMMENT = \"measured frames\";\n/MN\n";
    int line = 1;
    for (const StationFrame& f : frames) {
        const auto abc = abc_of(f.rotation);
        const Vec3 t = 1e3 * f.translation;
        out += fmt::format("{:4}:  ! {} ;\n", line++, f.station);
        const std::array values{t.x,
                                t.y,
                                t.z,
                                abc[2] / kDegree,   // W about x
                                abc[1] / kDegree,   // P about y
                                abc[0] / kDegree};  // R about z
        for (std::size_t i = 0; i < values.size(); ++i) {
            out += fmt::format("{:4}:  PR[{},{}]={:.5f} ;\n", line++, f.number, i + 1, values[i]);
        }
        out += fmt::format("{:4}:  UFRAME[{}]=PR[{}] ;\n", line++, f.number, f.number);
    }
    return out + "/POS\n/END\n";
}

}  // namespace sc::host
