// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/chain_sets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "boards/sim/rig/arm.hpp"
#include "boards/sim/rig/rig_files.hpp"

namespace sc::sim {
namespace {

constexpr int kRing = 24;
constexpr std::size_t kRingSeen = 12;
constexpr double kRingRadius = 0.40;
constexpr double kCorner = 0.08;  ///< edge of the corner target
constexpr int kBoard = 10;
constexpr int kOfFace = 9;
constexpr double kHalf = 0.2;              ///< of the workpiece, from the axis to a face
constexpr double kHeight = 0.3;            ///< of the workpiece
constexpr double kReach = 0.55;            ///< of the sensor from what it looks at
constexpr double kSwing = 50.0 * kDegree;  ///< of its azimuth, either way
constexpr int kTries = 60;
constexpr double kRobotAway = 1.30;
constexpr int kCloud = 400;

struct Mark {
    int id = 0;
    Vec3 place;  ///< in h, with the table at C = 0
    bool turns = false;
    double azimuth = 0.0;  ///< about the axis, of what stands still
};
struct Sighting {
    int id = 0;
    Vec3 place;
};
struct View {
    double c_deg = 0.0;
    Pose read;  ///< b_from_f
    std::vector<Sighting> seen;
    std::string cloud;
};

class Cell {
public:
    Cell(const ChainSetOptions& options, Random& random) : options_(options), random_(random) {
        draw_table();
        draw_robot();
        draw_references();
        draw_mobile();
        draw_board();
        draw_workpiece();
        look();
    }

    std::string write(const std::filesystem::path& folder) {
        std::filesystem::create_directories(folder);
        spoil();
        write_text(folder / "scan_set.toml", scan_set());
        write_text(folder / "references.toml", references());
        write_text(folder / "mobile.toml", mobile());
        write_text(folder / "pointing.csv", pointing());
        write_text(folder / "marks.csv", marks());
        write_text(folder / "wrong.csv", wrong_);
        for (std::size_t i = 0; i < views_.size(); ++i) {
            if (!views_[i].cloud.empty()) {
                write_text(folder / (name_of(i) + ".xyz"), views_[i].cloud);
            }
        }
        return text_mm(first_.place) + "," + text_of(first_.rotation) + "," + text_mm(axis_at_) +
               text_of(",%.12f,%.12f,%.12f\n", axis_.x, axis_.y, axis_.z);
    }

private:
    [[nodiscard]] double even(double least, double most) { return even_draw(random_, least, most); }
    [[nodiscard]] Vec3 normal(const Vec3& sigma) { return normal_place(random_, sigma); }
    [[nodiscard]] Vec3 turned(const Vec3& p, double angle) const {
        return axis_at_ + turn_about(angle * axis_) * (p - axis_at_);
    }

    void draw_table() {
        const Vec3 tilt{even(-2e-3, 2e-3), even(-2e-3, 2e-3), 1.0};
        axis_ = (1.0 / norm(tilt)) * tilt;
        axis_at_ = {-0.25 + even(-0.02, 0.02), -0.52 + even(-0.02, 0.02), -0.45 + even(-0.02, 0.02)};
    }

    void draw_robot() {
        // Beside the table, so that the laser head is free: it looks at the side of the head and at its own.
        side_ = even(30.0, 60.0) * kDegree;
        const Vec3 base = axis_at_ + kRobotAway * Vec3{std::cos(side_), std::sin(side_), 0.0} + Vec3{0.0, 0.0, -0.2};
        h_from_b_ = {turn_about({0.0, 0.0, side_ + 180.0 * kDegree}) * turn_about(normal({1e-2, 1e-2, 1e-2})), base};
        f_from_s_ = {turn_about(normal({0.1, 0.1, 0.5})), {even(-0.05, 0.05), even(-0.05, 0.05), even(0.08, 0.12)}};
        truth_ = options_.dh_length > 0.0 || options_.dh_angle > 0.0
                     ? with_errors(nominal_, options_.dh_length, options_.dh_angle, random_)
                     : nominal_;
    }

    void draw_references() {
        if (options_.references == ChainSetOptions::References::ring) {
            for (int k = 0; k < kRing; ++k) {
                const double azimuth = (k + even(-0.2, 0.2)) * 360.0 * kDegree / kRing;
                const double radius = kRingRadius + even(-0.02, 0.02);
                const Vec3 place =
                    axis_at_ + Vec3{radius * std::cos(azimuth), radius * std::sin(azimuth), even(0.0, 0.12)};
                references_.push_back({101 + k, place, false, azimuth});
            }
            return;
        }
        // On three faces of a block that stands at the table's rim, towards robot and head.
        const Pose block{turn_about({0.0, 0.0, side_}),
                         axis_at_ + kRingRadius * Vec3{std::cos(side_), std::sin(side_), 0.0}};
        const auto u = [this] { return even(0.1 * kCorner, 0.9 * kCorner); };
        const std::array places{Vec3{kCorner, u(), u()}, Vec3{kCorner, u(), u()}, Vec3{u(), kCorner, u()},
                                Vec3{u(), kCorner, u()}, Vec3{u(), u(), kCorner}};
        for (std::size_t k = 0; k < places.size(); ++k) {
            references_.push_back({201 + static_cast<int>(k), block * places[k], false, 0.0});
        }
    }

    /// 200 by 150 mm, before the head where the faces will be.
    void draw_mobile() {
        constexpr std::array kSteps{0.0, 5.01e-3, 15.02e-3};
        const Pose h_from_m{turn_about(normal({5e-3, 5e-3, 5e-3})), axis_at_ + Vec3{0.0, kHalf, 0.5 * kHeight}};
        for (int k = 0; k < options_.mobile; ++k) {
            const Vec3 in_m{even(-0.1, 0.1), kSteps[static_cast<std::size_t>(k) % 3], even(-0.075, 0.075)};
            nominal_mobile_.push_back(in_m);
            mobile_.push_back({301 + k, h_from_m * (in_m + normal({1e-5, 2e-6, 1e-5})), false, 0.0});
        }
    }

    void draw_board() {
        const Pose board{turn_about({60.0 * kDegree, 0.0, 0.0}), axis_at_ + Vec3{0.0, 0.0, 0.15}};
        for (int k = 0; k < kBoard; ++k) {
            board_.push_back({401 + k, board * Vec3{even(-0.15, 0.15), even(-0.1, 0.1), 0.0}, true, 0.0});
        }
    }

    void draw_workpiece() {
        for (int face = 0; face < 4; ++face) {
            for (int k = 0; k < kOfFace; ++k) {
                const Vec3 on_face =
                    axis_at_ + Vec3{even(-kHalf, kHalf), kHalf + even(-5e-3, 5e-3), even(0.0, kHeight)};
                workpiece_.push_back({face * kOfFace + k + 1, turned(on_face, 90.0 * face * kDegree), true, 0.0});
            }
        }
    }

    /// The table drives to an angle; as long as it stands there, it stands where it is.
    double stop_at(double c_deg) {
        if (!stands_at_ || *stands_at_ != c_deg) {
            stands_at_ = c_deg;
            stands_truly_ = c_deg * kDegree + options_.table * normal_draw(random_);
        }
        return stands_truly_;
    }

    /// Sensor towards `middle` from an azimuth about it, with the robot where it can reach.
    Pose robot_view(const Vec3& middle, double azimuth, View& view) {
        for (int attempt = 0; attempt < kTries; ++attempt) {
            const double away = side_ + azimuth + even(-0.1, 0.1);
            const double up = even(25.0, 45.0) * kDegree;
            const Vec3 back{std::cos(up) * std::cos(away), std::cos(up) * std::sin(away), std::sin(up)};
            const Vec3 x0 = cross(back, Vec3{0.0, 0.0, 1.0});
            const Vec3 x = (1.0 / norm(x0)) * x0;
            const Vec3 z = -back;
            const Mat3 facing = Mat3{{x, cross(z, x), z}}.transposed();
            const Pose h_from_s{
                turn_about(normal({0.05, 0.05, 0.05})) * facing * turn_about({0.0, 0.0, even(-0.3, 0.3)}),
                middle + (kReach + even(-0.03, 0.03)) * back};
            if (attempt % 2 == 1) {  // another way to fold the arm
                home_ = {even(-0.6, 0.6), even(-0.8, 0.8), even(-1.0, 1.0),
                         even(-0.5, 0.5), even(-1.2, 1.2), even(-3.1, 3.1)};
            }
            const auto joints = nominal_.reach(h_from_b_.inverse() * h_from_s * f_from_s_.inverse(), home_);
            if (!joints) {
                continue;
            }
            home_ = *joints;
            view.read = nominal_.at(*joints);
            const Pose stands = truth_.at(*joints);
            const double turn = options_.robot_turn;
            const double place = options_.robot_place;
            const Pose b_from_f{turn_about(normal({turn, turn, turn})) * stands.rotation,
                                stands.place + normal({place, place, place})};
            return h_from_b_ * b_from_f * f_from_s_;
        }
        throw std::runtime_error("the robot reaches no view");
    }

    void see(const std::vector<Mark>& marks, const Pose& s_from_h, double angle, View& view) {
        for (const Mark& m : marks) {
            const Vec3 place = m.turns ? turned(m.place, angle) : m.place;
            view.seen.push_back({m.id, s_from_h * place + normal({options_.sensor, options_.sensor, options_.sensor})});
        }
    }

    Pose take(const Vec3& middle, double azimuth, double c_deg, const std::vector<Mark>& marks) {
        View view;
        view.c_deg = c_deg;
        const double angle = stop_at(c_deg);
        const Pose h_from_s = robot_view(middle, azimuth, view);
        const Pose s_from_h = h_from_s.inverse();
        std::vector<Mark> near = references_;
        if (near.size() > kRingSeen) {
            const Vec3 from = h_from_s.place - axis_at_;
            const double here = std::atan2(from.y, from.x);
            std::ranges::sort(near, {}, [here](const Mark& m) {
                return std::abs(std::remainder(m.azimuth - here, 360.0 * kDegree));
            });
            near.resize(kRingSeen);
        }
        see(near, s_from_h, angle, view);
        see(marks, s_from_h, angle, view);
        if (options_.clouds && !marks.empty() && marks.front().id <= 4 * kOfFace) {
            for (int k = 0; k < kCloud; ++k) {
                const int face = (marks.front().id - 1) / kOfFace;
                const Vec3 on_face = axis_at_ + Vec3{even(-kHalf, kHalf), kHalf, even(0.0, kHeight)};
                const Vec3 place = turned(turned(on_face, 90.0 * face * kDegree), angle);
                view.cloud += text_mm(s_from_h * place + normal({2e-5, 2e-5, 2e-5})) + "\n";
            }
        }
        views_.push_back(std::move(view));
        return h_from_s;
    }

    void look() {
        const Vec3 table = axis_at_ + Vec3{0.0, 0.0, 0.1};
        const Vec3 front = axis_at_ + Vec3{0.0, 0.5 * kHalf, 0.5 * kHeight};
        first_ = take(front, 0.6, 0.0, mobile_);
        take(front, -0.2, 0.0, mobile_);
        for (int k = 0; k < options_.angles; ++k) {
            take(table, even(-kSwing, kSwing), 360.0 * k / options_.angles, board_);
        }
        for (int face = 0; face < 4; ++face) {
            const auto begin = workpiece_.begin() + static_cast<std::ptrdiff_t>(face) * kOfFace;
            // The face turns to the sensor, not to the head: the axis has to bring it there.
            const double c_deg = std::round(side_ / kDegree - 90.0) - 90.0 * face;
            const Vec3 middle = axis_at_ + 0.5 * kHalf * Vec3{std::cos(side_), std::sin(side_), 0.0};
            take(middle + Vec3{0.0, 0.0, 0.5 * kHeight}, even(-0.3, 0.3), c_deg, {begin, begin + kOfFace});
        }
    }

    void spoil() {
        const auto any = [this](std::size_t count) {
            return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
        };
        for (int k = 0; k < options_.wrong;) {
            const std::size_t v = any(views_.size());
            Sighting& s = views_[v].seen[any(views_[v].seen.size())];
            if (times_seen(s.id) < 3) {
                continue;  // nobody could tell
            }
            ++k;
            s.place = s.place + even(1e-3, 5e-3) * any_direction(random_);
            wrong_ += text_of("%s,%d,moved\n", name_of(v).c_str(), s.id);
        }
        const std::size_t still = std::min(references_.size(), kRingSeen);
        for (int k = 0; k < options_.swapped; ++k) {
            const std::size_t v = any(views_.size());
            const std::size_t a = any(still);
            const std::size_t b = (a + 1 + any(still - 1)) % still;
            std::swap(views_[v].seen[a].id, views_[v].seen[b].id);
            wrong_ +=
                text_of("%s,%d,swapped\n", name_of(v).c_str(), std::min(views_[v].seen[a].id, views_[v].seen[b].id));
        }
        if (options_.wrong_angle != 0.0) {
            const std::size_t v = 3 + any(static_cast<std::size_t>(options_.angles) - 2);
            views_[v].c_deg += options_.wrong_angle / kDegree;
            wrong_ += text_of("%s,0,angle\n", name_of(v).c_str());
        }
    }

    [[nodiscard]] std::ptrdiff_t times_seen(int id) const {
        return std::ranges::count_if(views_, [id](const View& view) {
            return std::ranges::find(view.seen, id, &Sighting::id) != view.seen.end();
        });
    }
    [[nodiscard]] static std::string name_of(std::size_t view) { return text_of("view_%02zu", view + 1); }

    static std::string row_of(const Vec3& v) { return text_of("[%.13f, %.13f, %.13f]", v.x, v.y, v.z); }
    static std::string mm_of(const Vec3& v) { return text_of("[%.8f, %.8f, %.8f]", v.x * 1e3, v.y * 1e3, v.z * 1e3); }

    [[nodiscard]] std::string scan_set() const {
        std::string out =
            "format = \"scribecell-scan-set\"\nversion = 1\nid = \"cell\"\ntime = \"2026-01-31T12:00:00Z\"\n";
        for (std::size_t i = 0; i < views_.size(); ++i) {
            const View& v = views_[i];
            out += "\n[[view]]\nid = \"" + name_of(i) + text_of("\"\nc_deg = %.9g\n", v.c_deg);
            out += v.cloud.empty() ? "" : "cloud = \"" + name_of(i) + ".xyz\"\n";
            out += "[view.robot_pose]\nconvention = \"b_from_f\"\nrotation = [" + row_of(v.read.rotation.row[0]) +
                   ", " + row_of(v.read.rotation.row[1]) + ", " + row_of(v.read.rotation.row[2]) +
                   "]\ntranslation_mm = " + mm_of(v.read.place) + "\n";
            for (const Sighting& s : v.seen) {
                out += text_of("[[view.marker]]\nid = %d\nplace_mm = ", s.id) + mm_of(s.place) +
                       text_of("\nsigma_um = %.6g\n", options_.sensor * 1e6);
            }
        }
        return out;
    }
    [[nodiscard]] std::string references() const {
        std::string out = "format = \"scribecell-target\"\nversion = 1\nid = \"references\"\nkind = \"fixed\"\n";
        for (const Mark& m : references_) {  // by the drawing
            const Vec3 nominal = {std::round(m.place.x * 1e3) * 1e-3, std::round(m.place.y * 1e3) * 1e-3,
                                  std::round(m.place.z * 1e3) * 1e-3};
            out += text_of("\n[[marker]]\nid = %d\nplace_mm = ", m.id) + mm_of(nominal) + "\nsigma_um = 0\n";
        }
        return out;
    }
    [[nodiscard]] std::string mobile() const {
        std::string out = "format = \"scribecell-target\"\nversion = 1\nid = \"mobile\"\nkind = \"mobile\"\n";
        std::array<std::string, 3> ids;
        for (std::size_t k = 0; k < mobile_.size(); ++k) {
            out += text_of("\n[[marker]]\nid = %d\nplace_mm = ", mobile_[k].id) + mm_of(nominal_mobile_[k]) +
                   "\nsigma_um = 0\n";
            ids[k % 3] += text_of("%s%d", ids[k % 3].empty() ? "" : ", ", mobile_[k].id);
        }
        constexpr std::array kStepMm{0.0, 5.01, 15.02};
        for (std::size_t s = 0; s < 3 && !ids[s].empty(); ++s) {
            out +=
                text_of("\n[[step]]\nid = %zu\nheight_mm = %.2f\nuncertainty_um = 2\nmarkers = [", s + 1, kStepMm[s]) +
                ids[s] + "]\n";
        }
        return out;
    }
    [[nodiscard]] std::string pointing() {
        const Vec3 sigma = eye();
        std::string out = "id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
        for (const Mark& m : mobile_) {
            out += text_of("%d,", m.id) + text_mm(m.place + normal(sigma)) +
                   text_of(",%.6g,%.6g,%.6g\n", sigma.x * 1e6, sigma.y * 1e6, sigma.z * 1e6);
        }
        return out;
    }
    [[nodiscard]] Vec3 eye() const {
        const double across = std::hypot(options_.axes, options_.pointing);
        return {across, options_.axes, across};
    }
    [[nodiscard]] std::string marks() {
        std::string out = "id,face_deg,x_mm,y_mm,z_mm,pointed_x_mm,pointed_y_mm,pointed_z_mm\n";
        for (int face = 0; face < 4; ++face) {
            const double angle = -90.0 * face * kDegree + options_.table * normal_draw(random_);
            for (int k = 0; k < kOfFace; ++k) {
                const Mark& m =
                    workpiece_[static_cast<std::size_t>(face) * std::size_t{kOfFace} + static_cast<std::size_t>(k)];
                const Vec3 place = turned(m.place, angle);
                const Vec3 met = place + normal({options_.axes, options_.axes, options_.axes});
                out += text_of("%d,%d,", m.id, 90 * face) + text_mm(met) + "," + text_mm(place + normal(eye())) + "\n";
            }
        }
        return out;
    }

    const ChainSetOptions& options_;
    Random& random_;
    Vec3 axis_at_;
    Vec3 axis_;
    double side_ = 0.0;
    Arm nominal_ = nominal_arm();
    Arm truth_;
    Joints home_{0.0, -0.3, 0.6, 0.0, 0.8, 0.0};
    Pose h_from_b_;
    Pose f_from_s_;
    Pose first_;
    std::vector<Mark> references_;
    std::vector<Mark> mobile_;
    std::vector<Vec3> nominal_mobile_;
    std::vector<Mark> board_;
    std::vector<Mark> workpiece_;
    std::optional<double> stands_at_;
    double stands_truly_ = 0.0;
    std::vector<View> views_;
    std::string wrong_ = "view,id,what\n";
};

}  // namespace

void write_chain_sets(const std::filesystem::path& folder, const ChainSetOptions& options) {
    std::filesystem::create_directories(folder);
    std::string truth =
        "set,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,axis_x_mm,axis_y_mm,axis_z_mm,dir_x,dir_y,dir_z\n";
    for (int i = 0; i < options.sets; ++i) {
        Random random(options.seed * 1'000'003U + static_cast<std::uint64_t>(i));
        const std::string name = text_of("set_%04d", i + 1);
        truth += name + "," + Cell(options, random).write(folder / name);
    }
    write_text(folder / "truth.csv", truth);
}

}  // namespace sc::sim
