// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/hand_eye_sets.hpp"

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "boards/sim/rig/bound.hpp"
#include "boards/sim/rig/rig_files.hpp"

namespace sc::sim {
namespace {

constexpr double kDistance = 0.43;  ///< metres, sensor to target

struct HandEyeTruth {
    Pose f_from_c;
    std::vector<Pose> b_from_f;
    std::vector<Vec3> markers;  ///< in b
};

Pose stepped(const Pose& pose, const double* turn_place) {
    return {turn_about({turn_place[0], turn_place[1], turn_place[2]}) * pose.rotation,
            pose.place + Vec3{turn_place[3], turn_place[4], turn_place[5]}};
}

HandEyeTruth draw_truth(const HandEyeSetOptions& options, Random& random) {
    HandEyeTruth truth;
    const double half_turn = even_draw(random, 0.0, 180.0 * kDegree);
    truth.f_from_c.rotation = turn_about(half_turn * any_direction(random));
    truth.f_from_c.place = {even_draw(random, -0.1, 0.1), even_draw(random, -0.1, 0.1), even_draw(random, 0.05, 0.15)};
    const Pose b_from_g{turn_about(even_draw(random, 0.0, 3.0) * any_direction(random)),
                        {even_draw(random, 0.6, 1.0), even_draw(random, -0.3, 0.3), even_draw(random, 0.1, 0.5)}};
    constexpr std::array kSteps{0.0, 5.01e-3, 15.02e-3};
    for (int k = 0; k < options.markers; ++k) {
        const Vec3 in_g{even_draw(random, -0.1, 0.1), even_draw(random, -0.075, 0.075),
                        kSteps[static_cast<std::size_t>(k) % 3]};
        truth.markers.push_back(b_from_g * in_g);
    }
    const Mat3 facing = turn_about({180.0 * kDegree, 0.0, 0.0});  // z of c down on the target
    for (int i = 0; i < options.views; ++i) {
        const Vec3 tilt{even_draw(random, -options.tilt, options.tilt), even_draw(random, -options.tilt, options.tilt),
                        0.0};
        const Mat3 turn = turn_about(tilt) * turn_about({0.0, 0.0, even_draw(random, -options.roll, options.roll)});
        Pose g_from_c{turn * facing, {}};
        const Vec3 aside{even_draw(random, -0.03, 0.03), even_draw(random, -0.03, 0.03), 0.0};
        const double distance = kDistance + even_draw(random, -0.03, 0.03);
        g_from_c.place = aside - distance * (g_from_c.rotation * Vec3{0.0, 0.0, 1.0});
        truth.b_from_f.push_back(b_from_g * g_from_c * truth.f_from_c.inverse());
    }
    return truth;
}

Vec3 marker_sigma(const HandEyeSetOptions& options) {
    return {options.marker_sigma, options.marker_sigma, options.marker_sigma * options.depth_factor};
}

/// Rms bounds of the rotation vector (radians) and of the place (metres) of f_from_c.
std::pair<double, double> bound_of(const HandEyeTruth& truth, const HandEyeSetOptions& options) {
    const std::size_t views = truth.b_from_f.size();
    std::vector<double> size;
    for (std::size_t i = 0; i < 1 + views; ++i) {
        size.insert(size.end(), {1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5});
    }
    size.insert(size.end(), 3 * truth.markers.size(), 1e-5);
    Fisher fisher(size);
    for (std::size_t i = 0; i < views; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            fisher.know(6 + 6 * i + axis, options.robot_turn);
            fisher.know(6 + 6 * i + 3 + axis, options.robot_place);
        }
        for (std::size_t k = 0; k < truth.markers.size(); ++k) {
            std::vector<std::size_t> on;
            for (std::size_t p = 0; p < 6; ++p) {
                on.push_back(p);
            }
            for (std::size_t p = 0; p < 6; ++p) {
                on.push_back(6 + 6 * i + p);
            }
            for (std::size_t p = 0; p < 3; ++p) {
                on.push_back(6 + 6 * views + 3 * k + p);
            }
            fisher.observe(on, marker_sigma(options), [&](const std::vector<double>& s) {
                const Pose x = stepped(truth.f_from_c, s.data());
                const Pose robot = stepped(truth.b_from_f[i], s.data() + 6);
                return (robot * x).inverse() * (truth.markers[k] + Vec3{s[12], s[13], s[14]});
            });
        }
    }
    const auto bound = fisher.bound(6);
    return {std::sqrt(bound[0][0] + bound[1][1] + bound[2][2]), std::sqrt(bound[3][3] + bound[4][4] + bound[5][5])};
}

std::string write_set(const std::filesystem::path& folder, const HandEyeSetOptions& options, Random& random) {
    std::filesystem::create_directories(folder);
    const HandEyeTruth truth = draw_truth(options, random);
    const auto some_view = [&] {
        return static_cast<int>(std::uniform_int_distribution<>(0, options.views - 1)(random));
    };
    const int bad = options.bad_place > 0.0 || options.bad_turn > 0.0 ? some_view() : -1;
    std::vector<bool> swapped(static_cast<std::size_t>(options.views), false);
    for (int left = options.swapped_views; left > 0;) {
        const auto i = static_cast<std::size_t>(some_view());
        left -= swapped[i] ? 0 : 1;
        swapped[i] = true;
    }
    std::string robot = "view,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\n";
    std::string target = "view,id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
    std::string swaps;
    const Vec3 sigma = marker_sigma(options);
    for (std::size_t i = 0; i < truth.b_from_f.size(); ++i) {
        const Vec3 turn = normal_place(random, {options.robot_turn, options.robot_turn, options.robot_turn});
        const Vec3 shift = normal_place(random, {options.robot_place, options.robot_place, options.robot_place});
        Pose read{turn_about(turn) * truth.b_from_f[i].rotation, truth.b_from_f[i].place + shift};
        if (static_cast<int>(i) == bad) {
            read.rotation = turn_about(options.bad_turn * any_direction(random)) * read.rotation;
            read.place = read.place + options.bad_place * any_direction(random);
        }
        robot += text_of("%zu,", i + 1) + text_mm(read.place) + "," + text_of(read.rotation) + "\n";
        std::vector<std::size_t> id;
        for (std::size_t k = 0; k < truth.markers.size(); ++k) {
            id.push_back(k + 1);
        }
        if (swapped[i]) {
            std::uniform_int_distribution<std::size_t> any(0, id.size() - 1);
            const std::size_t a = any(random);
            std::size_t b = any(random);
            while (b == a) {
                b = any(random);
            }
            std::swap(id[a], id[b]);
            swaps += text_of("%s%zu:%zu:%zu", swaps.empty() ? "" : " ", i + 1, std::min(a, b) + 1, std::max(a, b) + 1);
        }
        const Pose c_from_b = (truth.b_from_f[i] * truth.f_from_c).inverse();
        for (std::size_t k = 0; k < truth.markers.size(); ++k) {
            const Vec3 seen = c_from_b * truth.markers[k] + normal_place(random, sigma);
            target += text_of("%zu,%zu,", i + 1, id[k]) + text_mm(seen) +
                      text_of(",%.6g,%.6g,%.6g\n", sigma.x * 1e6, sigma.y * 1e6, sigma.z * 1e6);
        }
    }
    write_text(folder / "robot.csv", robot);
    write_text(folder / "target.csv", target);
    const auto [turn, place] = bound_of(truth, options);
    return text_mm(truth.f_from_c.place) + "," + text_of(truth.f_from_c.rotation) +
           text_of(",%.6f,%.6f,%d,", turn / kDegree * 1e3, place * 1e6, bad + 1) + swaps + "\n";
}

}  // namespace

void write_hand_eye_sets(const std::filesystem::path& folder, const HandEyeSetOptions& options) {
    std::filesystem::create_directories(folder);
    std::string truth =
        "set,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,bound_turn_mdeg,bound_place_um,bad_view,swapped\n";
    for (int i = 0; i < options.sets; ++i) {
        Random random(options.seed * 1'000'003U + static_cast<std::uint64_t>(i));
        const std::string name = text_of("set_%04d", i + 1);
        truth += name + "," + write_set(folder / name, options, random);
    }
    write_text(folder / "truth.csv", truth);
}

}  // namespace sc::sim
