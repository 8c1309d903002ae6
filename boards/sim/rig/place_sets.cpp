// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/place_sets.hpp"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "boards/sim/rig/bound.hpp"
#include "boards/sim/rig/rig_files.hpp"

namespace sc::sim {
namespace {

constexpr double kAxes = 2.5e-6;
constexpr std::array kFace{Vec3{-0.2, 0.0, -0.15}, Vec3{0.2, 0.0, -0.15}, Vec3{-0.2, 0.0, 0.15}, Vec3{0.2, 0.0, 0.15}};
constexpr double kAbove = 0.2;

std::string marker_row(const std::string& head, std::size_t id, const Vec3& place, const Vec3& sigma) {
    return head + text_of("%zu,", id) + text_mm(place) +
           text_of(",%.6g,%.6g,%.6g\n", sigma.x * 1e6, sigma.y * 1e6, sigma.z * 1e6);
}

Vec3 root_sum(const Vec3& a, const Vec3& b) {
    return {std::hypot(a.x, b.x), std::hypot(a.y, b.y), std::hypot(a.z, b.z)};
}

std::string write_rigid_set(const std::filesystem::path& folder, const RigidSetOptions& options, Random& random) {
    std::filesystem::create_directories(folder);
    const Pose h_from_c{turn_about(even_draw(random, 0.0, 3.1) * any_direction(random)),
                        {even_draw(random, -0.5, 0.5), even_draw(random, -0.5, 0.5), even_draw(random, 0.5, 1.0)}};
    const Vec3 in_c{options.sensor, options.sensor, 2.0 * options.sensor};
    const Vec3 in_h = root_sum({kAxes, kAxes, kAxes}, {options.pointing, 0.0, options.pointing});
    constexpr std::array kSteps{0.0, 5.01e-3, 15.02e-3};
    std::vector<Vec3> markers;
    for (int k = 0; k < options.markers; ++k) {
        markers.push_back(
            {even_draw(random, -0.1, 0.1), kSteps[static_cast<std::size_t>(k) % 3], even_draw(random, -0.075, 0.075)});
    }
    std::string c = "id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
    std::string h = c;
    const std::vector<double> size(6 + 3 * markers.size(), 1e-5);
    Fisher fisher(size);
    const auto back = [&](const std::vector<double>& s) {
        return Pose{turn_about({s[0], s[1], s[2]}) * h_from_c.rotation, h_from_c.place + Vec3{s[3], s[4], s[5]}};
    };
    for (std::size_t k = 0; k < markers.size(); ++k) {
        Vec3 seen = h_from_c.inverse() * markers[k] + normal_place(random, in_c);
        if (static_cast<int>(k) < options.wrong) {
            seen = seen + even_draw(random, 1e-3, 5e-3) * any_direction(random);
        }
        c += marker_row("", k + 1, seen, in_c);
        h += marker_row("", k + 1, markers[k] + normal_place(random, in_h), in_h);
        const std::size_t own = 6 + 3 * k;
        fisher.observe({own, own + 1, own + 2}, in_h,
                       [&](const std::vector<double>& s) { return markers[k] + Vec3{s[0], s[1], s[2]}; });
        fisher.observe({0, 1, 2, 3, 4, 5, own, own + 1, own + 2}, in_c, [&](const std::vector<double>& s) {
            return back(s).inverse() * (markers[k] + Vec3{s[6], s[7], s[8]});
        });
    }
    write_text(folder / "c.csv", c);
    write_text(folder / "h.csv", h);
    const auto bound = fisher.bound(6);
    double sum = 0.0;
    for (const Vec3& place : kFace) {
        const Vec3 place_c = h_from_c.inverse() * place;
        sum += bound_of_place(bound, {1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5},
                              [&](const std::vector<double>& s) { return back(s) * place_c; });
    }
    return text_mm(h_from_c.place) + "," + text_of(h_from_c.rotation) +
           text_of(",%.6f\n", std::sqrt(sum / kFace.size()) * 1e6);
}

/// Two directions across the axis.
std::array<Vec3, 2> across(const Vec3& axis) {
    const Vec3 other = std::abs(axis.x) < 0.6 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    const Vec3 first = cross(axis, other);
    const Vec3 u = (1.0 / norm(first)) * first;
    return {u, cross(axis, u)};
}

std::string write_axis_set(const std::filesystem::path& folder, const AxisSetOptions& options, Random& random) {
    std::filesystem::create_directories(folder);
    const Pose c_from_t{turn_about(even_draw(random, 0.0, 3.1) * any_direction(random)),
                        {even_draw(random, -0.2, 0.2), even_draw(random, -0.2, 0.2), even_draw(random, 0.4, 0.6)}};
    const Vec3 direction = c_from_t.rotation * Vec3{0.0, 0.0, 1.0};
    const Mat3 board = turn_about({0.0, 60.0 * kDegree, 0.0});
    std::vector<Vec3> markers;  // on the table, in c at angle 0
    for (int k = 0; k < options.markers; ++k) {
        const Vec3 on_board{even_draw(random, -0.1, 0.1), even_draw(random, -0.075, 0.075), 0.0};
        markers.push_back(c_from_t * (board * on_board + Vec3{0.06, 0.0, 0.08}));
    }
    const Vec3 sigma{options.sensor, options.sensor, options.sensor};
    const auto angles = static_cast<std::size_t>(options.angles);
    const std::vector<double> size(4 + angles + 3 * markers.size(), 1e-5);
    Fisher fisher(size);
    const std::array<Vec3, 2> side = across(direction);
    const auto about = [&](double s0, double s1) {
        const Vec3 d = direction + s0 * side[0] + s1 * side[1];
        return (1.0 / norm(d)) * d;
    };
    const auto on_axis = [&](double s2, double s3) { return c_from_t.place + s2 * side[0] + s3 * side[1]; };
    std::string rows = "view,turn_deg,id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
    const bool whole = options.arc > 6.28;
    for (std::size_t i = 0; i < angles; ++i) {
        const double step = options.arc / static_cast<double>(whole ? angles : angles - 1);
        const double reading = static_cast<double>(i) * step;
        const double true_angle = reading + options.table * normal_draw(random);
        fisher.know(4 + i, options.table);
        for (std::size_t k = 0; k < markers.size(); ++k) {
            const Vec3 seen = c_from_t.place + turn_about(true_angle * direction) * (markers[k] - c_from_t.place) +
                              normal_place(random, sigma);
            rows += marker_row(text_of("%zu,%.9f,", i + 1, reading / kDegree), k + 1, seen, sigma);
            const std::size_t own = 4 + angles + 3 * k;
            fisher.observe({0, 1, 2, 3, 4 + i, own, own + 1, own + 2}, sigma, [&](const std::vector<double>& s) {
                const Vec3 p = on_axis(s[2], s[3]);
                return p + turn_about((reading + s[4]) * about(s[0], s[1])) * (markers[k] + Vec3{s[5], s[6], s[7]} - p);
            });
        }
    }
    write_text(folder / "markers.csv", rows);
    const double height = 0.08 + kAbove;
    const double square = bound_of_place(fisher.bound(4), {1e-5, 1e-5, 1e-5, 1e-5}, [&](const std::vector<double>& s) {
        const Vec3 d = about(s[0], s[1]);
        return on_axis(s[2], s[3]) + (height / dot(d, direction)) * d;
    });
    return text_mm(c_from_t.place) + text_of(",%.15f,%.15f,%.15f,%.3f,%.6f\n", direction.x, direction.y, direction.z,
                                             height * 1e3, std::sqrt(square) * 1e6);
}

template <class Write>
void write_sets(const std::filesystem::path& folder, std::uint64_t seed, int sets, std::string truth,
                const Write& write) {
    std::filesystem::create_directories(folder);
    for (int i = 0; i < sets; ++i) {
        Random random(seed * 1'000'003U + static_cast<std::uint64_t>(i));
        const std::string name = text_of("set_%04d", i + 1);
        truth += name + "," + write(folder / name, random);
    }
    write_text(folder / "truth.csv", truth);
}

}  // namespace

void write_rigid_sets(const std::filesystem::path& folder, const RigidSetOptions& options) {
    write_sets(folder, options.seed, options.sets, "set,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,bound_um\n",
               [&](const std::filesystem::path& set, Random& random) { return write_rigid_set(set, options, random); });
}

void write_axis_sets(const std::filesystem::path& folder, const AxisSetOptions& options) {
    write_sets(folder, options.seed, options.sets, "set,x_mm,y_mm,z_mm,dir_x,dir_y,dir_z,height_mm,bound_um\n",
               [&](const std::filesystem::path& set, Random& random) { return write_axis_set(set, options, random); });
}

}  // namespace sc::sim
