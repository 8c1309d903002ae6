// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/survey/targets.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace sc::sim {
namespace {

constexpr std::array kSteps{0.0, 5.01e-3, 15.02e-3};
constexpr int kViews = 15;
constexpr int kRingViews = 12;
constexpr int kFixedMarkers = 12;
constexpr int kTableMarkers = 10;
constexpr int kMobileMarkers = 30;
constexpr double kInstrument = 0.5e-6;
constexpr double kCertificate = 1e-6;
constexpr double kHalfWidth = 0.1;    ///< metres, of the mobile target
constexpr double kStepHeight = 0.05;  ///< of each step's face, upwards

}  // namespace

void write_fixed_target(const CellTruth& truth, const std::filesystem::path& folder) {
    Random random = truth.random(21);
    const Vec3 corner{-0.62, -0.86, -0.50};
    const Mat3 askew = turn_about(normal_place(random, {0.05, 0.05, 0.5}));
    std::vector<CellTruth::Reference> markers;
    for (int k = 0; k < kFixedMarkers; ++k) {
        const Vec3 in_g{even_draw(random, -0.1, 0.1), even_draw(random, -0.075, 0.075),
                        kSteps[static_cast<std::size_t>(k) % 3]};
        markers.push_back({k + 1, corner + askew * in_g});
    }
    ViewFiles files(truth, false);
    for (int i = 0; i < kViews; ++i) {
        const double lean = even_draw(random, -25.0, 25.0) * kDegree;
        const double aside = even_draw(random, -25.0, 25.0) * kDegree;
        const double roll = even_draw(random, -60.0, 60.0) * kDegree;
        const Pose pose = truth.look(corner, {std::sin(lean) + 0.02, std::sin(aside), 1.0},
                                     0.43 + even_draw(random, -0.03, 0.03), roll);
        files.add(text_of("%d", i + 1), pose, 0.0, markers, random);
    }
    files.write(folder);
}

void write_ring(const CellTruth& truth, const std::filesystem::path& folder) {
    Random random = truth.random(24);
    ViewFiles files(truth, false);
    for (int i = 0; i < kRingViews; ++i) {
        const double angle = 360.0 * kDegree * i / kRingViews;
        const Vec3 out{std::cos(angle), std::sin(angle), 0.0};
        files.add(text_of("ring%d", i + 1),
                  truth.look(Vec3{-0.25, -0.47, -0.44} + 0.2 * out, out + Vec3{0.0, 0.0, 1.2}, 0.5), 0.0, {}, random);
    }
    files.write(folder);
}

void write_table_markers(const CellTruth& truth, const World& world, int angles, double arc_deg,
                         const std::filesystem::path& folder) {
    Random random = truth.random(22);
    const Mat3 leaning = turn_about({30.0 * kDegree, 0.0, 0.0});
    std::vector<Vec3> on_table;
    for (int k = 0; k < kTableMarkers; ++k) {
        const Vec3 on_board{even_draw(random, -0.14, 0.14), 0.05, even_draw(random, -0.12, 0.12)};
        on_table.push_back(Vec3{-0.25, -0.47, -0.36} + leaning * on_board);
    }
    ViewFiles files(truth, true);
    const Pose pose = truth.look({-0.25, -0.47, -0.40}, {-0.8, -0.15, 0.6}, 0.55);
    for (int i = 0; i < angles; ++i) {
        const double share =
            arc_deg >= 359.9 ? static_cast<double>(i) / angles : static_cast<double>(i) / std::max(1, angles - 1);
        const double turn = arc_deg * share - 0.5 * arc_deg;
        std::vector<CellTruth::Reference> markers;
        for (std::size_t k = 0; k < on_table.size(); ++k) {
            markers.push_back({static_cast<int>(k) + 1, (world.h_from_t(turn) * Point<frame::T>{on_table[k]}).v});
        }
        files.add(text_of("turn%d", i + 1), pose, turn, markers, random);
    }
    files.write(folder);
}

void write_axes(const CellTruth& truth, const World& world, const std::filesystem::path& file) {
    Random random = truth.random(23);
    constexpr std::array kFrom{-0.450, -0.400, -0.500};
    constexpr double kPitch = 9.1e-3;
    const std::array<std::array<double, 4>, 3> levels{
        {{-0.44, -0.30, -0.15, 0.0}, {-0.39, -0.26, -0.13, 0.0}, {-0.49, -0.33, -0.16, 0.0}}};
    std::string text = "x,y,z,dir_x,dir_y,dir_z,true_x,true_y,true_z\n";
    for (std::size_t along = 0; along < 3; ++along) {
        const std::size_t b = (along + 1) % 3;
        const std::size_t c = (along + 2) % 3;
        for (const double level_b : levels[b]) {
            for (const double level_c : levels[c]) {
                const int steps = static_cast<int>((0.005 - kFrom[along]) / kPitch);
                for (int step = 0; step <= steps; ++step) {
                    std::array<double, 3> reading{};
                    reading[along] = kFrom[along] + step * kPitch;
                    reading[b] = level_b;
                    reading[c] = level_c;
                    std::array<int, 3> way{};
                    std::array<double, 3> load{};
                    for (std::size_t i = 0; i < 3; ++i) {
                        way[i] = random() % 2 == 0 ? 1 : -1;
                        load[i] = reading[i] - 0.5 * way[i] * world.spec().drives.backlash[i];
                    }
                    const Vec3 place = true_focus(world.spec().axes, {load[0], load[1], load[2]}) +
                                       normal_place(random, {kInstrument, kInstrument, kInstrument});
                    text += text_of("%.6f,%.6f,%.6f,%d,%d,%d,", reading[0] * 1e3, reading[1] * 1e3, reading[2] * 1e3,
                                    way[0], way[1], way[2]) +
                            text_mm(place) + "\n";
                }
            }
        }
    }
    write_text(file, text);
}

MobileTarget::MobileTarget(const CellTruth& truth) {
    Random random = truth.random(31);
    h_from_m.rotation = turn_about(normal_place(random, {1.5e-3, 1.0e-3, 1.5e-3}));
    h_from_m.place = Vec3{-0.24, -0.25, -0.26} + normal_place(random, {1e-3, 1e-3, 1e-3});
    for (std::size_t k = 0; k < kSteps.size(); ++k) {
        height[k] = kSteps[k] + (k > 0 ? 4e-6 * normal_draw(random) : 0.0);
        certified[k] = height[k] + (k > 0 ? kCertificate * normal_draw(random) : 0.0);
    }
    for (int k = 0; k < kMobileMarkers; ++k) {
        const auto step = static_cast<std::size_t>(k) % kSteps.size();
        const double up = kStepHeight * (static_cast<double>(step) - 1.0) + even_draw(random, -0.02, 0.02);
        const Vec3 in_m{even_draw(random, -0.095, 0.095), height[step], up};
        markers.push_back({k + 1, step, h_from_m * in_m});
    }
}

double MobileTarget::surface_y(double x, double z) const {
    // The target's faces are y = height in m; two rounds reach a nanometre for a target askew by mrad.
    double y = h_from_m.place.y;
    for (int round = 0; round < 4; ++round) {
        const Vec3 in_m = h_from_m.inverse() * Vec3{x, y, z};
        const double step = std::floor(in_m.z / kStepHeight + 1.5);
        if (!(step >= 0.0 && step <= 2.0 && std::abs(in_m.x) <= kHalfWidth + 0.05)) {
            throw std::runtime_error("the beam misses the target");
        }
        y += height[static_cast<std::size_t>(step)] - in_m.y;
    }
    return y;
}

void write_mobile_target(const CellTruth& truth, const std::filesystem::path& base,
                         const std::filesystem::path& folder) {
    const MobileTarget target(truth);
    Random random = truth.random(32);
    std::string toml = "format = \"scribecell-target\"\nversion = 1\nid = \"mobile\"\nkind = \"mobile\"\n";
    std::array<std::string, 3> on_step;
    std::vector<CellTruth::Reference> markers;
    for (const MobileTarget::Marker& marker : target.markers) {
        const Vec3 in_m = 1e3 * (target.h_from_m.inverse() * marker.place);
        toml += text_of("\n[[marker]]\nid = %d\nplace_mm = [%.3f, %.3f, %.3f]\nsigma_um = 0.0\n", marker.id, in_m.x,
                        kSteps[marker.step] * 1e3, in_m.z);
        on_step[marker.step] += text_of("%s%d", on_step[marker.step].empty() ? "" : ", ", marker.id);
        markers.push_back({marker.id, marker.place});
    }
    for (std::size_t k = 0; k < kSteps.size(); ++k) {
        toml += text_of("\n[[step]]\nid = %zu\nheight_mm = %.6f\nuncertainty_um = %.3f\nmarkers = [", k + 1,
                        target.certified[k] * 1e3, k > 0 ? kCertificate * 1e6 : 0.0) +
                on_step[k] + "]\n";
    }
    ViewFiles files(truth, false);
    files.add("mobile", truth.look(target.h_from_m.place, {0.25, 1.0, 0.35}, 0.5), 0.0, markers, random);
    files.write(folder);
    write_text(folder / "target.toml", toml);
    std::string obj = "# The mobile target: three faces that face the head.\n";
    std::string faces;
    int corner = 1;
    for (std::size_t k = 0; k < kSteps.size(); ++k) {
        const double low = kStepHeight * (static_cast<double>(k) - 1.5);
        for (const auto& [x, z] : {std::pair{-1.0, low}, std::pair{1.0, low}, std::pair{1.0, low + kStepHeight},
                                   std::pair{-1.0, low + kStepHeight}}) {
            const Vec3 p = 1e3 * (target.h_from_m * Vec3{x * (kHalfWidth + 0.05), target.height[k], z});
            obj += text_of("v %.9f %.9f %.9f\n", p.x, p.y, p.z);
        }
        faces += text_of("f %d %d %d\nf %d %d %d\n", corner, corner + 2, corner + 1, corner, corner + 3, corner + 2);
        corner += 4;
    }
    write_text(folder / "target.obj", obj + faces);
    write_text(folder / "world.toml", "# The cell with the mobile target, made by scribecell-survey.\nbase = \"" +
                                          std::filesystem::absolute(base).string() +
                                          "\"\n[[mesh]]\nname = \"mobile target\"\nfile = \"target.obj\"\nunit = "
                                          "\"mm\"\n");
}

void write_roof(const CellTruth& truth, const std::filesystem::path& base, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    Random random = truth.random(33);
    // Slopes dy/dx and dy/dz of faces that stand beside each other in x.
    constexpr std::array<std::array<double, 2>, 5> kSlope{
        {{0.0, 0.0}, {0.5, 0.0}, {-0.5, 0.0}, {0.0, 0.5}, {0.0, -0.5}}};
    constexpr double kHalf = 0.025;
    const Pose h_from_c = truth.look({-0.24, -0.25, -0.26}, {0.25, 1.0, 0.35}, 0.5);
    const Pose c_from_h = h_from_c.inverse();
    const double sigma = truth.noise().marker;
    std::string obj = "# A roof of five faces.\n";
    std::string faces;
    std::string points = "facet,x_mm,y_mm,z_mm,sigma_um\n";
    std::string roughly = "facet,x_mm,y_mm,z_mm\n";
    for (std::size_t k = 0; k < kSlope.size(); ++k) {
        const Vec3 middle{-0.34 + 0.05 * static_cast<double>(k), -0.25, -0.26};
        const double lean_x = kSlope[k][0] + even_draw(random, -0.01, 0.01);
        const double lean_z = kSlope[k][1] + even_draw(random, -0.01, 0.01);
        const auto on_face = [&](double x, double z) { return middle + Vec3{x, lean_x * x + lean_z * z, z}; };
        for (const auto& [x, z] :
             {std::pair{-kHalf, -kHalf}, std::pair{kHalf, -kHalf}, std::pair{kHalf, kHalf}, std::pair{-kHalf, kHalf}}) {
            const Vec3 mm = 1e3 * on_face(x, z);
            obj += text_of("v %.9f %.9f %.9f\n", mm.x, mm.y, mm.z);
        }
        const auto corner = static_cast<int>(4 * k) + 1;
        faces += text_of("f %d %d %d\nf %d %d %d\n", corner, corner + 2, corner + 1, corner, corner + 3, corner + 2);
        for (int i = 0; i < 60; ++i) {
            const double x = even_draw(random, -0.9 * kHalf, 0.9 * kHalf);
            const double z = even_draw(random, -0.9 * kHalf, 0.9 * kHalf);
            const Vec3 seen = c_from_h * on_face(x, z) + normal_place(random, {sigma, sigma, sigma});
            points += text_of("%zu,", k + 1) + text_mm(seen) + text_of(",%.4f\n", std::max(sigma, 1e-8) * 1e6);
        }
        roughly += text_of("%zu,%.0f,%.0f,%.0f\n", k + 1, middle.x * 1e3, middle.y * 1e3, middle.z * 1e3);
    }
    ViewFiles files(truth, false);
    files.add("roof", h_from_c, 0.0, {}, random);
    files.write(folder);
    write_text(folder / "roof.obj", obj + faces);
    write_text(folder / "points.csv", points);
    write_text(folder / "roughly.csv", roughly);
    write_text(folder / "world.toml", "# The cell with a roof, made by scribecell-survey.\nbase = \"" +
                                          std::filesystem::absolute(base).string() +
                                          "\"\n[[mesh]]\nname = \"roof\"\nfile = \"roof.obj\"\nunit = \"mm\"\n");
}

SpotSeen see_spot(const CellTruth& truth, const World& world, int marker, const Vec3& reading, double pointing,
                  double focusing, std::uint64_t look) {
    const MobileTarget target(truth);
    for (const MobileTarget::Marker& m : target.markers) {
        if (m.id != marker) {
            continue;
        }
        Random random = truth.random(1000 + look);
        // The guide beam takes the burning one's way, with the mirrors at their zero.
        const Beam beam = true_beam(world.spec().galvo, true_focus(world.spec().axes, reading), 0.0, 0.0);
        const double on_target = target.surface_y(beam.focus.x, beam.focus.z);
        const double along = (on_target - beam.focus.y) / beam.direction.y;
        const Vec3 spot = beam.focus + along * beam.direction;
        const Vec3 noise = normal_place(random, {pointing, focusing, pointing});
        return {{spot.x - m.place.x + noise.x, beam.focus.y - on_target + noise.y, spot.z - m.place.z + noise.z}};
    }
    throw std::runtime_error("the target has no marker " + std::to_string(marker));
}

}  // namespace sc::sim
