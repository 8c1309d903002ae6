// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/survey/cell_truth.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace sc::sim {
namespace {

constexpr Vec3 kTable{-0.250, -0.470, -0.44};
constexpr double kRing = 0.285;  ///< metres
constexpr int kReferences = 24;
constexpr int kFirstReference = 1001;
constexpr std::size_t kSeen = 12;
constexpr int kWaves = 6;

std::string marker_row(const std::string& head, int id, const Vec3& seen, double sigma) {
    return head + text_of("%d,", id) + text_mm(seen) + text_of(",%.6g\n", std::max(sigma, 1e-8) * 1e6);
}

}  // namespace

CellTruth::CellTruth(std::uint64_t seed, const SurveyNoise& noise) : seed_(seed), noise_(noise) {
    Random draw = random(1);
    h_from_b_.rotation = turn_about(normal_place(draw, {0.02, 0.02, 0.5}));
    h_from_b_.place = Vec3{-1.25, -0.55, -0.62} + normal_place(draw, {0.03, 0.03, 0.03});
    f_from_c_.rotation = turn_about(even_draw(draw, 0.0, 3.0) * any_direction(draw));
    f_from_c_.place = Vec3{0.05, -0.03, 0.11} + normal_place(draw, {0.02, 0.02, 0.02});
    for (int k = 0; k < kReferences; ++k) {
        const double angle = 360.0 * kDegree * (k + even_draw(draw, -0.25, 0.25)) / kReferences;
        const double radius = kRing + even_draw(draw, -0.02, 0.02);
        references_.push_back({kFirstReference + k, kTable + Vec3{radius * std::cos(angle), radius * std::sin(angle),
                                                                  even_draw(draw, -0.04, 0.04)}});
    }
    for (int k = 0; k < kWaves; ++k) {
        wave_.push_back(even_draw(draw, 2.5, 5.0) * any_direction(draw));
        const double size = noise.robot_bias * std::sqrt(2.0 / kWaves);
        shift_.push_back(size * any_direction(draw));
        turn_.push_back(size * 2.0 * any_direction(draw));  // 0.35 mm at half a metre of arm
        phase_.push_back(even_draw(draw, 0.0, 360.0 * kDegree));
    }
}

Random CellTruth::random(std::uint64_t purpose) const { return Random(seed_ * 1'000'003U + purpose); }

Pose CellTruth::look(const Vec3& centre, const Vec3& from, double distance, double roll) const {
    const Vec3 z = (-1.0 / norm(from)) * from;  // of c, towards the target
    const Vec3 aside = cross(Vec3{0.0, 0.0, 1.0}, z);
    const Vec3 x = (1.0 / norm(aside)) * aside;
    const Vec3 y = cross(z, x);
    const Mat3 facing = Mat3{{x, y, z}}.transposed();
    return {facing * turn_about({0.0, 0.0, roll}), centre - distance * z};
}

Pose CellTruth::robot_reading(const Pose& h_from_c, Random& random) const {
    const Pose truly = h_from_b_.inverse() * h_from_c * f_from_c_.inverse();
    Vec3 shift = normal_place(random, {noise_.robot_place, noise_.robot_place, noise_.robot_place});
    Vec3 turn = normal_place(random, {noise_.robot_turn, noise_.robot_turn, noise_.robot_turn});
    // Errors of the arms follow place and pointing.
    const Vec3 at = truly.place + 0.3 * (truly.rotation * Vec3{0.0, 0.0, 1.0});
    for (std::size_t k = 0; k < wave_.size(); ++k) {
        const double swing = std::sin(dot(wave_[k], at) + phase_[k]);
        shift = shift + swing * shift_[k];
        turn = turn + swing * turn_[k];
    }
    return {turn_about(turn) * truly.rotation, truly.place + shift};
}

std::vector<CellTruth::Reference> CellTruth::references(const Pose& h_from_c) const {
    std::vector<Reference> out = references_;
    std::ranges::sort(out, {}, [&h_from_c](const Reference& r) { return norm(r.place - h_from_c.place); });
    out.resize(kSeen);
    std::ranges::sort(out, {}, &Reference::id);
    return out;
}

ViewFiles::ViewFiles(const CellTruth& truth, bool turns)
    : truth_(&truth),
      turns_(turns),
      markers_(turns ? "view,turn_deg,id,x_mm,y_mm,z_mm,sigma_um\n" : "view,id,x_mm,y_mm,z_mm,sigma_um\n"),
      references_("view,id,x_mm,y_mm,z_mm,sigma_um\n"),
      robot_("view,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\n") {}

void ViewFiles::add(const std::string& view, const Pose& h_from_c, double turn_deg,
                    const std::vector<CellTruth::Reference>& markers, Random& random) {
    const Pose c_from_h = h_from_c.inverse();
    const double sigma = truth_->noise().marker;
    const auto seen = [&](const Vec3& place) { return c_from_h * place + normal_place(random, {sigma, sigma, sigma}); };
    const std::string head = turns_ ? view + text_of(",%.6f,", turn_deg) : view + ",";
    for (const CellTruth::Reference& marker : markers) {
        markers_ += marker_row(head, marker.id, seen(marker.place), sigma);
    }
    for (const CellTruth::Reference& reference : truth_->references(h_from_c)) {
        references_ += marker_row(view + ",", reference.id, seen(reference.place), sigma);
    }
    const Pose reading = truth_->robot_reading(h_from_c, random);
    robot_ += view + "," + text_mm(reading.place) + "," + text_of(reading.rotation) + "\n";
}

void ViewFiles::write(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    write_text(folder / "markers.csv", markers_);
    write_text(folder / "references.csv", references_);
    write_text(folder / "robot.csv", robot_);
}

}  // namespace sc::sim
