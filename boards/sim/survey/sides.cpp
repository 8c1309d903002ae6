// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/survey/sides.hpp"

#include <array>
#include <string>
#include <utility>

#include "boards/sim/world/world.hpp"

namespace sc::sim {
namespace {

constexpr std::size_t kSides = 4;
constexpr Vec3 kMiddle{-0.25, -0.47, -0.34};
constexpr std::array<double, kSides> kOut{0.11, 0.17, 0.12, 0.175};  ///< metres from the axis
constexpr std::array<double, kSides> kLean{0.30, 0.32, -0.32, -0.30};
constexpr double kHalf = 0.13;
constexpr double kUp = 0.10;
constexpr int kPoints = 80;

/// By k quarter turns, counter-clockwise seen from above.
Vec3 turned(const Vec3& v, std::size_t quarters) {
    Vec3 out = v;
    for (std::size_t k = 0; k < quarters; ++k) {
        out = {-out.y, out.x, out.z};
    }
    return out;
}

}  // namespace

void write_sides(const CellTruth& truth, const std::filesystem::path& base, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    Random random = truth.random(34);
    std::array<std::array<double, 2>, kSides> slope{};
    for (std::size_t k = 0; k < kSides; ++k) {
        slope[k][0] = even_draw(random, -0.01, 0.01);
        slope[k][1] = kLean[k] + even_draw(random, -0.01, 0.01);
    }
    const auto on_side = [&](std::size_t k, double along, double up) {
        return kMiddle + turned({-along, kOut[k] + slope[k][0] * along + slope[k][1] * up, up}, k);
    };
    std::string obj = "# Four sides that lean.\n";
    std::string faces;
    for (std::size_t k = 0; k < kSides; ++k) {
        for (const auto& [a, u] :
             {std::pair{-kHalf, -kUp}, std::pair{kHalf, -kUp}, std::pair{kHalf, kUp}, std::pair{-kHalf, kUp}}) {
            const Vec3 mm = 1e3 * on_side(k, a, u);
            obj += text_of("v %.9f %.9f %.9f\n", mm.x, mm.y, mm.z);
        }
        const auto corner = static_cast<int>(4 * k) + 1;
        faces += text_of("f %d %d %d\nf %d %d %d\n", corner, corner + 1, corner + 2, corner, corner + 2, corner + 3);
    }
    write_text(folder / "sides.obj", obj + faces);
    write_text(folder / "world.toml", "# The cell with four sides on the table, made by scribecell-survey.\nbase = \"" +
                                          std::filesystem::absolute(base).string() +
                                          "\"\n[[mesh]]\nname = \"sides\"\nfile = \"sides.obj\"\nunit = \"mm\"\n");
    const World world(folder / "world.toml");
    const double sigma = truth.noise().marker;
    ViewFiles files(truth, true);
    std::string points = "facet,c_deg,view,x_mm,y_mm,z_mm,sigma_um\n";
    for (std::size_t k = 0; k < kSides; ++k) {
        // The robot stands at -x: a side looks there a quarter turn after it has looked at the laser.
        const double c_deg = 90.0 - 90.0 * static_cast<double>(k);
        const Pose pose = truth.look(kMiddle + Vec3{-kOut[k], 0.0, 0.0}, {-1.0, 0.1, 0.5}, 0.5);
        const std::string view = text_of("side%zu", k + 1);
        files.add(view, pose, c_deg, {}, random);
        const Pose c_from_h = pose.inverse();
        for (int i = 0; i < kPoints; ++i) {
            const double along = even_draw(random, -0.95 * kHalf, 0.95 * kHalf);
            const double up = even_draw(random, -0.95 * kUp, 0.95 * kUp);
            const Vec3 now = (world.h_from_t(c_deg) * Point<frame::T>{on_side(k, along, up)}).v;
            const Vec3 seen = c_from_h * now + normal_place(random, {sigma, sigma, sigma});
            points += text_of("%zu,%g,%s,", k + 1, c_deg, view.c_str()) + text_mm(seen) +
                      text_of(",%.4f\n", std::max(sigma, 1e-8) * 1e6);
        }
    }
    files.write(folder);
    write_text(folder / "points.csv", points);
}

}  // namespace sc::sim
