// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/survey/workpiece.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "boards/sim/world/world.hpp"

namespace sc::sim {
namespace {

constexpr Vec3 kMiddle{-0.25, -0.47, -0.36};  ///< of the box, on the table's axis but for millimetres
constexpr double kHalf = 0.15;
constexpr double kUp = 0.08;
constexpr int kFaces = 4;
constexpr int kMarkers = 9;

/// By k quarter turns, counter-clockwise seen from above.
Vec3 turned(const Vec3& v, int quarters) {
    switch (quarters & 3) {
        case 1: return {-v.y, v.x, v.z};
        case 2: return {-v.x, -v.y, v.z};
        case 3: return {v.y, -v.x, v.z};
        default: return v;
    }
}

/// Corners of the box, a little out of square.
std::string box_text(Random& random) {
    std::array<Vec3, 8> corner;
    std::string text = "# A box on the table, a little out of square.\n";
    for (std::size_t i = 0; i < corner.size(); ++i) {
        const auto k = static_cast<int>(i % 4);
        corner[i] = kMiddle + turned({kHalf, kHalf, 0.0}, k) + Vec3{0.0, 0.0, i < 4 ? -kUp : kUp} +
                    normal_place(random, {0.3e-3, 0.3e-3, 0.3e-3});
        const Vec3 mm = 1e3 * corner[i];
        text += text_of("v %.9f %.9f %.9f\n", mm.x, mm.y, mm.z);
    }
    for (int k = 0; k < 4; ++k) {
        const int a = k + 1;
        const int b = (k + 1) % 4 + 1;
        text += text_of("f %d %d %d\nf %d %d %d\n", a, b, b + 4, a, b + 4, a + 4);
    }
    return text;
}

/// Places on the faces, in t: drawn, then brought onto the mesh.
std::vector<std::array<Vec3, kMarkers>> markers_on(const World& world, const CellTruth& truth) {
    Random random = truth.random(42);
    std::vector<std::array<Vec3, kMarkers>> out(kFaces);
    for (int face = 0; face < kFaces; ++face) {
        for (int k = 0; k < kMarkers; ++k) {
            const int row = k / 3;
            const Vec3 ahead{(static_cast<double>(k % 3) - 1.0) * 0.075 + even_draw(random, -0.02, 0.02), 1.0,
                             (static_cast<double>(row) - 1.0) * 0.045 + even_draw(random, -0.012, 0.012)};
            // Face k stands before the laser at C = −k: on the table it looks along +y turned by +k.
            const Vec3 from = kMiddle + turned(ahead, face);
            const auto hit = world.hit({from, turned({0.0, -1.0, 0.0}, face)}, 0.0);
            if (!hit) {
                throw std::runtime_error("a marker misses the box");
            }
            out[static_cast<std::size_t>(face)][static_cast<std::size_t>(k)] = hit->point;
        }
    }
    return out;
}

}  // namespace

void write_workpiece(const CellTruth& truth, const std::filesystem::path& base, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    Random random = truth.random(41);
    write_text(folder / "box.obj", box_text(random));
    write_text(folder / "world.toml", "# The cell with a box, made by scribecell-survey.\nbase = \"" +
                                          std::filesystem::absolute(base).string() +
                                          "\"\n[[mesh]]\nname = \"box\"\nfile = \"box.obj\"\nunit = \"mm\"\n");
    const World world(folder / "world.toml");
    const auto places = markers_on(world, truth);
    ViewFiles files(truth, true);
    for (int face = 0; face < kFaces; ++face) {
        // The robot stands at -x: a face looks there a quarter turn after it has looked at the laser.
        const double reading = 90.0 - 90.0 * face;
        std::vector<CellTruth::Reference> seen;
        for (std::size_t k = 0; k < kMarkers; ++k) {
            seen.push_back({100 * face + static_cast<int>(k) + 1,
                            (world.h_from_t(reading) * Point<frame::T>{places[static_cast<std::size_t>(face)][k]}).v});
        }
        const Pose pose = truth.look(kMiddle + Vec3{-kHalf, 0.0, 0.0}, {-1.0, 0.1, 0.5}, 0.5);
        files.add(text_of("face%d", 90 * face), pose, reading, seen, random);
    }
    files.write(folder);
}

void write_judged(const CellTruth& truth, const std::filesystem::path& world_file,
                  const std::filesystem::path& measured, const std::filesystem::path& file) {
    const World world(world_file);
    const auto places = markers_on(world, truth);
    std::ifstream in(measured);
    std::string line;
    std::string text = "face_deg,no,mx,my,mz,tx,ty,tz\n";
    if (!in || !std::getline(in, line) || line != "face_deg,no,mx,my,mz") {
        throw std::runtime_error(measured.string() + " has not the header face_deg,no,mx,my,mz");
    }
    while (std::getline(in, line)) {
        double face = 0.0;
        int number = 0;
        Vec3 m;
        if (std::sscanf(line.c_str(), "%lf,%d,%lf,%lf,%lf", &face, &number, &m.x, &m.y, &m.z) != 5) {
            throw std::runtime_error(measured.string() + ": not a row of measured places: " + line);
        }
        const auto index = static_cast<std::size_t>(std::lround(face / 90.0));
        if (index >= kFaces || number < 1 || number > kMarkers) {
            throw std::runtime_error(measured.string() + ": no such marker: " + line);
        }
        const double turn = face > 180.0 ? 360.0 - face : -face;
        const Vec3 t =
            1e3 * (world.h_from_t(turn) * Point<frame::T>{places[index][static_cast<std::size_t>(number - 1)]}).v;
        text += text_of("%g,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", face, number, m.x, m.y, m.z, t.x, t.y, t.z);
    }
    write_text(file, text);
}

}  // namespace sc::sim
