// SPDX-License-Identifier: Apache-2.0
// scribecell-scanner: puts a casting into the true world at a random pose and scans it there, as a 3-D sensor on a
// robot would, with the turntable. Writes the world with the casting (for the cell), the scan (for the host) and the
// truth (for whoever checks at the end).
#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "boards/sim/world/world.hpp"
#include "boards/sim/world/world_error.hpp"
#include "shared/geometry/frames.hpp"

namespace sc::sim {
namespace {

constexpr double kRadian = std::numbers::pi / 180.0;
constexpr double kStandOff = 0.6;             ///< metres, sensor to casting
constexpr double kBaseline = 15.0 * kRadian;  ///< between camera and projector, seen from the casting
constexpr double kLeastCosine = 0.26;         ///< steeper than 75 degrees: no point
constexpr double kNoise = 12e-6;              ///< metres along the ray, over the root of the cosine
constexpr double kViewShift = 6e-6;           ///< metres: how well a view is registered, 1 sigma
constexpr double kViewTurn = 0.003 * kRadian;
constexpr double kOutliers = 6e-4;          ///< share of the points
constexpr double kOutlier = 4e-3;           ///< metres
constexpr double kCalibrationShift = 6e-6;  ///< metres: what the host's h_from_c is off, 1 sigma, at the casting
constexpr double kCalibrationTurn = 10e-6;  ///< radians
constexpr double kPixel = 0.45e-3;          ///< metres at the casting
constexpr std::array<double, 4> kElevations{-30.0, 8.0, 35.0, 62.0};  ///< the casting stands on pins
constexpr int kTurns = 6;

struct Arguments {
    std::string base;
    std::string casting;
    std::string out;
    std::vector<double> h_from_c;  ///< the host's: rows of R, then t in mm
    std::vector<double> axis;      ///< the host's: point in mm, direction
    double height_mm = -440.0;     ///< of the lowest corner
    std::uint64_t seed = 1;
};

using Random = std::mt19937_64;
Vec3 gaussian(Random& random, double sigma) {
    std::normal_distribution<double> white(0.0, sigma);
    const double x = white(random);
    const double y = white(random);
    return {x, y, white(random)};
}
/// About a unit vector.
Mat3 turn_about(const Vec3& axis, double angle) {
    return turned({{{0.0, 0.0, 0.0}}, {axis}}, std::sin(angle), std::cos(angle)).rotation;
}
Mat3 small_turn(const Vec3& vector) {
    const double angle = norm(vector);
    return angle > 0.0 ? turn_about((1.0 / angle) * vector, angle) : Mat3::identity();
}

/// Corners of an ASCII STL in millimetres, triangles without area left out.
Mesh read_stl(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) {
        throw WorldError({file.string(), 0, "", "the casting cannot be read", "check the name"});
    }
    Mesh mesh;
    std::vector<Vec3> corners;
    for (std::string word; in >> word;) {
        Vec3 v;
        if (word != "vertex") {
            continue;
        }
        if (!(in >> v.x >> v.y >> v.z)) {
            throw WorldError({file.string(), 0, "", "a corner that is no three numbers", "give an ASCII STL"});
        }
        corners.push_back(1e-3 * v);
        if (corners.size() == 3) {
            if (norm(cross(corners[1] - corners[0], corners[2] - corners[0])) > 1e-14) {
                const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
                mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
                mesh.triangles.push_back({first, first + 1, first + 2});
            }
            corners.clear();
        }
    }
    if (mesh.triangles.empty()) {
        throw WorldError({file.string(), 0, "", "no triangle in it", "give an ASCII STL"});
    }
    return mesh;
}

/// Upright (+y of the drawing up), turned at will, a little askew, near the table's axis, its foot at the given height.
Rigid<frame::T, frame::W> random_pose(Random& random, const Mesh& casting, const AxisLine& axis, double foot) {
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    const Mat3 upright{{Vec3{1, 0, 0}, Vec3{0, 0, -1}, Vec3{0, 1, 0}}};
    const double yaw = 180.0 * kRadian * share(random);
    const Vec3 lean = 2.0 * kRadian * Vec3{share(random), share(random), 0.0};
    Rigid<frame::T, frame::W> pose{turn_about({0, 0, 1}, yaw) * small_turn(lean) * upright, {}};
    Vec3 low{1e9, 1e9, 1e9};
    Vec3 high{-1e9, -1e9, -1e9};
    for (const Vec3& v : casting.vertices) {
        const Vec3 p = pose.rotation * v;
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Vec3 middle = 0.5 * (low + high);
    const Vec3& at = axis.point.v;
    pose.translation = {at.x - middle.x + 8e-3 * share(random), at.y - middle.y + 8e-3 * share(random), foot - low.z};
    return pose;
}

/// One view: what camera and projector both see with the table at an angle, in the host's c at C = 0.
class View {
public:
    View(const World& world, const Rigid<frame::C, frame::H>& c_from_h, double c_deg, double elevation,
         const Vec3& middle)
        : world_(&world), c_from_h_(c_from_h), c_deg_(c_deg), middle_(middle) {
        const double e = elevation * kRadian;
        const Vec3 way{0.0, std::cos(e), std::sin(e)};
        camera_ = middle + kStandOff * way;
        projector_ = middle + kStandOff * (turn_about({0, 0, 1}, kBaseline) * way);
        right_ = {1.0, 0.0, 0.0};
        up_ = cross(way, right_);
    }

    std::vector<Vec3> points(Random& random, const Rigid<frame::C, frame::C>& stitched, double reach) const {
        std::vector<Vec3> out;
        const auto count = static_cast<int>(reach / kPixel);
        std::normal_distribution<double> white(0.0, 1.0);
        std::uniform_real_distribution<double> share(0.0, 1.0);
        const Rigid<frame::C, frame::C> registered{small_turn(gaussian(random, kViewTurn)), {}};
        const Vec3 middle_c = (c_from_h_ * Point<frame::H>{middle_}).v;
        const Vec3 shift = gaussian(random, kViewShift) + middle_c - registered.rotation * middle_c;
        for (int row = -count; row <= count; ++row) {
            for (int column = -count; column <= count; ++column) {
                // One draw a statement: compilers differ in the order within one.
                const double across = column + share(random) - 0.5;
                const double upwards = row + share(random) - 0.5;
                const Vec3 aim = middle_ + kPixel * (across * right_ + upwards * up_);
                const auto seen = look(aim);
                if (!seen) {
                    continue;
                }
                double along = kNoise / std::sqrt(seen->cosine) * white(random);
                if (share(random) < kOutliers) {
                    along += kOutlier * (2.0 * share(random) - 1.0);
                }
                const Vec3 measured = seen->place + along * seen->direction;
                const Vec3 c = registered.rotation * (c_from_h_ * Point<frame::H>{measured}).v + shift;
                out.push_back((stitched * Point<frame::C>{c}).v);
            }
        }
        return out;
    }

private:
    struct Seen {
        Vec3 place;
        Vec3 direction;
        double cosine = 0.0;
    };
    [[nodiscard]] std::optional<Seen> look(const Vec3& aim) const {
        const Vec3 way = (1.0 / norm(aim - camera_)) * (aim - camera_);
        const auto hit = world_->hit({camera_, way}, c_deg_);
        if (!hit) {
            return std::nullopt;
        }
        const Vec3 light = (1.0 / norm(hit->point - projector_)) * (hit->point - projector_);
        const double cosine = std::min(-dot(hit->normal, way), -dot(hit->normal, light));
        if (cosine < kLeastCosine) {
            return std::nullopt;
        }
        const auto lit = world_->hit({projector_, light}, c_deg_);
        if (!lit || norm(lit->point - hit->point) > 5e-5) {
            return std::nullopt;
        }
        return Seen{hit->point, way, cosine};
    }

    const World* world_;
    Rigid<frame::C, frame::H> c_from_h_;
    double c_deg_;
    Vec3 middle_;
    Vec3 camera_;
    Vec3 projector_;
    Vec3 right_;
    Vec3 up_;
};

void write_ply(const std::filesystem::path& file, const std::vector<std::vector<Vec3>>& views) {
    std::size_t count = 0;
    for (const auto& view : views) {
        count += view.size();
    }
    std::ofstream out(file, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\ncomment simulated structured-light scan, millimetres, c\nelement "
           "vertex "
        << count << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar view\nend_header\n";
    for (std::size_t i = 0; i < views.size(); ++i) {
        for (const Vec3& p : views[i]) {
            const std::array<float, 3> mm{static_cast<float>(1e3 * p.x), static_cast<float>(1e3 * p.y),
                                          static_cast<float>(1e3 * p.z)};
            const auto bytes = std::bit_cast<std::array<char, 12>>(mm);
            out.write(bytes.data(), bytes.size());
            out.put(static_cast<char>(i));
        }
    }
    if (!out.flush()) {
        throw WorldError({file.string(), 0, "", "cannot be written", "check the folder and the disk"});
    }
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    if (!(out << text) || !out.flush()) {
        throw WorldError({file.string(), 0, "", "cannot be written", "check the folder and the disk"});
    }
}

nlohmann::ordered_json pose_json(const Mat3& r, const Vec3& t) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Vec3& row : r.row) {
        rows.push_back({row.x, row.y, row.z});
    }
    return {{"rotation", rows}, {"translation_mm", {1e3 * t.x, 1e3 * t.y, 1e3 * t.z}}};
}

int run(const Arguments& a) {
    const std::filesystem::path out = a.out;
    std::filesystem::create_directories(out);
    Random random(a.seed);
    const Mesh drawn = read_stl(a.casting);
    const AxisLine axis{{1e-3 * Vec3{a.axis[0], a.axis[1], a.axis[2]}}, {{a.axis[3], a.axis[4], a.axis[5]}}};
    const auto t_from_w = random_pose(random, drawn, axis, 1e-3 * a.height_mm);
    std::string obj = "# A casting at a random pose, in the table's frame t, mm.\n";
    Vec3 middle{};
    double reach = 0.0;
    Mesh placed = drawn;
    for (Vec3& v : placed.vertices) {
        v = (t_from_w * Point<frame::W>{v}).v;
        obj += fmt::format("v {:.9f} {:.9f} {:.9f}\n", 1e3 * v.x, 1e3 * v.y, 1e3 * v.z);
        middle = middle + (1.0 / static_cast<double>(placed.vertices.size())) * v;
    }
    for (const Vec3& v : placed.vertices) {
        reach = std::max(reach, norm(v - middle));
    }
    for (const auto& t : placed.triangles) {
        obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    write_text(out / "casting.obj", obj);
    write_text(out / "world.toml",
               fmt::format("# The cell with a casting, made by scribecell-scanner with seed {}.\nbase = \"{}\"\n"
                           "[turntable]\naxis_x_mm = {:.6f}\naxis_y_mm = {:.6f}\n[[mesh]]\nname = \"casting\"\n"
                           "file = \"casting.obj\"\nunit = \"mm\"\n",
                           a.seed, std::filesystem::absolute(a.base).string(), a.axis[0] - 0.0007, a.axis[1] + 0.0011));
    const World world(out / "world.toml");
    // The host's h_from_c is an estimate. The truth is off by what its record states.
    const Mat3 nominal{{Vec3{a.h_from_c[0], a.h_from_c[1], a.h_from_c[2]},
                        Vec3{a.h_from_c[3], a.h_from_c[4], a.h_from_c[5]},
                        Vec3{a.h_from_c[6], a.h_from_c[7], a.h_from_c[8]}}};
    const Rigid<frame::H, frame::C> h_from_c{nominal, 1e-3 * Vec3{a.h_from_c[9], a.h_from_c[10], a.h_from_c[11]}};
    const Mat3 turn = small_turn(gaussian(random, kCalibrationTurn));
    const Rigid<frame::H, frame::H> error{turn, middle - turn * middle + gaussian(random, kCalibrationShift)};
    const auto c_from_h = (error * h_from_c).inverse();
    struct Job {
        double c_deg;
        double elevation;
        std::uint64_t seed;
    };
    std::vector<Job> jobs;
    for (int i = 0; i < kTurns; ++i) {
        for (const double elevation : kElevations) {
            jobs.push_back({360.0 / kTurns * i - 180.0, elevation, random()});
        }
    }
    std::vector<std::vector<Vec3>> views(jobs.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t i = next++; i < jobs.size(); i = next++) {
            const Job& job = jobs[i];
            Random own(job.seed);
            const double angle = job.c_deg * kRadian;
            const auto t_from_h = turned(axis, std::sin(angle), std::cos(angle)).inverse();
            const Rigid<frame::C, frame::C> stitched =
                h_from_c.inverse() * Rigid<frame::H, frame::H>{t_from_h.rotation, t_from_h.translation} * h_from_c;
            // The middle, as the table has turned it.
            const Vec3 there = (world.h_from_t(job.c_deg) * Point<frame::T>{middle}).v;
            views[i] = View(world, c_from_h, job.c_deg, job.elevation, there).points(own, stitched, reach);
        }
    };
    std::vector<std::thread> threads;
    for (unsigned i = 1; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
        threads.emplace_back(work);
    }
    work();
    for (std::thread& thread : threads) {
        thread.join();
    }
    write_ply(out / "scan.ply", views);
    std::size_t count = 0;
    for (const auto& view : views) {
        count += view.size();
    }
    const nlohmann::ordered_json truth{{"seed", a.seed},
                                       {"t_from_w", pose_json(t_from_w.rotation, t_from_w.translation)}};
    write_text(out / "truth.json", truth.dump(2) + "\n");
    std::printf("%s\n", nlohmann::ordered_json{{"views", views.size()}, {"points", count}}.dump().c_str());
    return 0;
}

}  // namespace
}  // namespace sc::sim

int main(int argc, char** argv) {
    CLI::App app("Puts a casting into the simulated cell's world at a random pose, and scans it there.",
                 "scribecell-scanner");
    app.footer(
        "Example:\n  scribecell-scanner --base boards/sim/world/default/world.toml --casting rough.stl --seed 3 --out "
        "run3\n"
        "      --h-from-c 1,0,0,0,1,0,0,0,1,-250,-330,-420 --axis -250,-330,0,0,0,1\n"
        "Writes world.toml, casting.obj, scan.ply and truth.json. Exit codes: 0 done; 2 bad input.");
    sc::sim::Arguments a;
    app.add_option("--base", a.base, "world that it is put into")->required()->type_name("WORLD.toml");
    app.add_option("--casting", a.casting, "ASCII STL, millimetres")->required()->type_name("FILE");
    app.add_option("--out", a.out, "folder")->required()->type_name("DIR");
    app.add_option("--h-from-c", a.h_from_c, "the host's: nine of the rotation, three of the translation (mm)")
        ->required()
        ->delimiter(',')
        ->expected(12);
    app.add_option("--axis", a.axis, "the host's turntable axis: point (mm), direction")
        ->required()
        ->delimiter(',')
        ->expected(6);
    app.add_option("--height-mm", a.height_mm, "of the casting's lowest corner, in h")->capture_default_str();
    app.add_option("--seed", a.seed, "of pose and noise")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        return sc::sim::run(a);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-scanner: %s\n", error.what());
        return 2;
    }
}
