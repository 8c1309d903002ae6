// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/stereo_sets.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "boards/sim/rig/bound.hpp"
#include "boards/sim/rig/rig_files.hpp"

namespace sc::sim {
namespace {

constexpr int kColumns = 9;
constexpr int kRows = 6;
constexpr double kPitch = 0.025;  ///< metres
constexpr int kWidth = 1280;
constexpr int kHeight = 960;
constexpr std::size_t kSights = 4;
constexpr std::size_t kNine = 9;
constexpr double kWorst = 1e-3;  ///< of the third number of a sight, which is always 0

/// fx, fy, cx, cy, k1, k2, p1, p2, k3.
using Camera = std::array<double, kNine>;

struct StereoTruth {
    std::array<Camera, 2> cameras{};
    Pose right_from_left;
    std::vector<Pose> boards;  ///< left_from_board
    std::vector<Vec3> places;  ///< in the left camera
};

/// Column, row, 0.
Vec3 seen(const Camera& c, const Vec3& p) {
    const double x = p.x / p.z;
    const double y = p.y / p.z;
    const double q = x * x + y * y;
    const double radial = 1.0 + c[4] * q + c[5] * q * q + c[8] * q * q * q;
    return {c[0] * (x * radial + 2.0 * c[6] * x * y + c[7] * (q + 2.0 * x * x)) + c[2],
            c[1] * (y * radial + c[6] * (q + 2.0 * y * y) + 2.0 * c[7] * x * y) + c[3], 0.0};
}

bool inside(const Vec3& at) { return at.x > 5.0 && at.y > 5.0 && at.x < kWidth - 6.0 && at.y < kHeight - 6.0; }

Vec3 corner(int column, int row) { return {kPitch * column, kPitch * row, 0.0}; }

Camera draw_camera(Random& random) {
    return {1100.0 + even_draw(random, -50.0, 50.0), 1100.0 + even_draw(random, -50.0, 50.0),
            639.5 + even_draw(random, -20.0, 20.0),  479.5 + even_draw(random, -20.0, 20.0),
            even_draw(random, -0.25, -0.1),          even_draw(random, 0.05, 0.15),
            even_draw(random, -1e-3, 1e-3),          even_draw(random, -1e-3, 1e-3),
            even_draw(random, -0.05, 0.05)};
}

Pose stepped(const Pose& pose, const double* s) {
    return {turn_about({s[0], s[1], s[2]}) * pose.rotation, pose.place + Vec3{s[3], s[4], s[5]}};
}

/// All corners in both pictures.
bool whole(const StereoTruth& truth, const Pose& board) {
    for (const int column : {0, kColumns - 1}) {
        for (const int row : {0, kRows - 1}) {
            const Vec3 p = board * corner(column, row);
            if (!inside(seen(truth.cameras[0], p)) || !inside(seen(truth.cameras[1], truth.right_from_left * p))) {
                return false;
            }
        }
    }
    return true;
}

StereoTruth draw_truth(const StereoSetOptions& options, Random& random) {
    StereoTruth truth;
    truth.cameras = {draw_camera(random), draw_camera(random)};
    const double toe = even_draw(random, 0.1, 0.2);
    truth.right_from_left = {turn_about({even_draw(random, -0.02, 0.02), toe, even_draw(random, -0.02, 0.02)}),
                             {-0.12 + even_draw(random, -0.01, 0.01), even_draw(random, -5e-3, 5e-3),
                              0.01 + even_draw(random, -5e-3, 5e-3)}};
    while (truth.boards.size() < static_cast<std::size_t>(options.views)) {
        const Mat3 turn = turn_about({even_draw(random, -options.tilt, options.tilt),
                                      even_draw(random, -options.tilt, options.tilt), even_draw(random, -0.5, 0.5)});
        const Vec3 middle = 0.5 * corner(kColumns - 1, kRows - 1);
        const double z = even_draw(random, 0.35, 0.6);
        const Vec3 at{even_draw(random, -0.35, 0.35) * z, even_draw(random, -0.3, 0.3) * z, z};
        const Pose board{turn, at - turn * middle};
        if (whole(truth, board)) {
            truth.boards.push_back(board);
        }
    }
    while (truth.places.size() < kSights) {
        const double z = even_draw(random, 0.4, 0.55);
        const Vec3 at{even_draw(random, -0.25, 0.25) * z, even_draw(random, -0.2, 0.2) * z, z};
        if (inside(seen(truth.cameras[0], at)) && inside(seen(truth.cameras[1], truth.right_from_left * at))) {
            truth.places.push_back(at);
        }
    }
    return truth;
}

/// Places first, then cameras, the pair's pose, and the boards.
struct Layout {
    static constexpr std::size_t kCameras = 3 * kSights;
    static constexpr std::size_t kPose = kCameras + 2 * kNine;
    static constexpr std::size_t kBoards = kPose + 6;
};

void add_range(std::vector<std::size_t>& on, std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        on.push_back(first + i);
    }
}

/// One camera's sight of what lies at `left` after `own` steps of its own parameters; the camera's nine steps come
/// first, for the right one six of the pair's pose, then its own.
void observe(Fisher& fisher, const StereoTruth& truth, std::size_t camera, double noise, std::size_t own,
             std::size_t own_count, const std::function<Vec3(const double* own)>& left) {
    std::vector<std::size_t> on;
    add_range(on, Layout::kCameras + kNine * camera, kNine);
    if (camera == 1) {
        add_range(on, Layout::kPose, 6);
    }
    add_range(on, own, own_count);
    fisher.observe(on, {noise, noise, kWorst}, [&](const std::vector<double>& s) {
        Camera moved = truth.cameras[camera];
        for (std::size_t k = 0; k < kNine; ++k) {
            moved[k] += s[k];
        }
        if (camera == 0) {
            return seen(moved, left(s.data() + kNine));
        }
        return seen(moved, stepped(truth.right_from_left, s.data() + kNine) * left(s.data() + kNine + 6));
    });
}

/// Rms of a coordinate of the sights' places, metres.
double bound_of(const StereoTruth& truth, double noise) {
    std::vector<double> size(Layout::kCameras, 1e-5);
    for (int c = 0; c < 2; ++c) {
        size.insert(size.end(), {1e-2, 1e-2, 1e-2, 1e-2, 1e-4, 1e-4, 1e-5, 1e-5, 1e-4});
    }
    size.insert(size.end(), 6 + 6 * truth.boards.size(), 1e-5);
    Fisher fisher(size);
    for (std::size_t camera = 0; camera < 2; ++camera) {
        for (std::size_t i = 0; i < truth.boards.size(); ++i) {
            for (int k = 0; k < kColumns * kRows; ++k) {
                const Vec3 at = corner(k % kColumns, k / kColumns);
                observe(fisher, truth, camera, noise, Layout::kBoards + 6 * i, 6,
                        [&](const double* s) { return stepped(truth.boards[i], s) * at; });
            }
        }
        for (std::size_t k = 0; k < kSights; ++k) {
            observe(fisher, truth, camera, noise, 3 * k, 3,
                    [&](const double* s) { return truth.places[k] + Vec3{s[0], s[1], s[2]}; });
        }
    }
    const auto bound = fisher.bound(3 * kSights);
    double sum = 0.0;
    for (std::size_t i = 0; i < 3 * kSights; ++i) {
        sum += bound[i][i];
    }
    return std::sqrt(sum / (3.0 * kSights));
}

std::string noisy(const Vec3& at, double noise, Random& random) {
    // To 1/1024 px: the same number in single precision, which other programs read.
    const auto draw = [&](double value) { return std::round(1024.0 * (value + noise * normal_draw(random))) / 1024.0; };
    const double u = draw(at.x);
    const double v = draw(at.y);
    return text_of("%.10f,%.10f", u, v);
}

struct SetRows {
    std::string truth;
    std::string places;
};

SetRows write_set(const std::filesystem::path& folder, const std::string& name, const StereoSetOptions& options,
                  Random& random) {
    std::filesystem::create_directories(folder);
    const StereoTruth truth = draw_truth(options, random);
    std::array<std::string, 2> csv;
    std::string swaps;
    for (std::size_t camera = 0; camera < 2; ++camera) {
        csv[camera] = "view,row,col,X_mm,Y_mm,u_px,v_px\n";
        for (std::size_t i = 0; i < truth.boards.size(); ++i) {
            const bool swapped = camera == 0 && static_cast<int>(i) < options.swapped_views;
            const int a = swapped ? static_cast<int>(even_draw(random, 0.0, kColumns * kRows - 1.0)) : -1;
            if (swapped) {
                swaps += text_of("%s%zu:%d:%d", swaps.empty() ? "" : " ", i + 1, a, a + 1);
            }
            for (int k = 0; k < kColumns * kRows; ++k) {
                const int named = k == a ? a + 1 : swapped && k == a + 1 ? a : k;
                const Vec3 left = truth.boards[i] * corner(k % kColumns, k / kColumns);
                const Vec3 at = seen(truth.cameras[camera], camera == 0 ? left : truth.right_from_left * left);
                const Vec3 place = corner(named % kColumns, named / kColumns);
                csv[camera] += text_of("%zu,%d,%d,%.4f,%.4f,", i + 1, named / kColumns, named % kColumns, place.x * 1e3,
                                       place.y * 1e3) +
                               noisy(at, options.noise_px, random) + "\n";
            }
        }
    }
    write_text(folder / "left.csv", csv[0]);
    write_text(folder / "right.csv", csv[1]);
    std::string sights = "id,left_u_px,left_v_px,right_u_px,right_v_px\n";
    SetRows out;
    for (std::size_t k = 0; k < truth.places.size(); ++k) {
        const Vec3& p = truth.places[k];
        sights += text_of("%zu,", k + 1) + noisy(seen(truth.cameras[0], p), options.noise_px, random) + "," +
                  noisy(seen(truth.cameras[1], truth.right_from_left * p), options.noise_px, random) + "\n";
        out.places += name + text_of(",%zu,", k + 1) + text_mm(p) + "\n";
    }
    write_text(folder / "sights.csv", sights);
    out.truth = name;
    for (const Camera& camera : truth.cameras) {
        for (const double value : camera) {
            out.truth += text_of(",%.10f", value);
        }
    }
    out.truth += "," + text_mm(truth.right_from_left.place) + "," + text_of(truth.right_from_left.rotation) +
                 text_of(",%.6f,", bound_of(truth, options.noise_px) * 1e6) + swaps + "\n";
    return out;
}

}  // namespace

void write_stereo_sets(const std::filesystem::path& folder, const StereoSetOptions& options) {
    std::filesystem::create_directories(folder);
    std::string truth = "set";
    for (const char* side : {"l", "r"}) {
        for (const char* name : {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}) {
            truth += text_of(",%s_%s", name, side);
        }
    }
    truth += ",x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,bound_place_um,swapped\n";
    std::string places = "set,id,x_mm,y_mm,z_mm\n";
    for (int i = 0; i < options.sets; ++i) {
        Random random(options.seed * 1'000'003U + static_cast<std::uint64_t>(i));
        const std::string name = text_of("set_%04d", i + 1);
        const SetRows rows = write_set(folder / name, name, options, random);
        truth += rows.truth;
        places += rows.places;
    }
    write_text(folder / "truth.csv", truth);
    write_text(folder / "places.csv", places);
}

}  // namespace sc::sim
