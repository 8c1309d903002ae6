// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/hand_eye.hpp"
#include "host/calibration/rigid_fit.hpp"
#include "host/calibration/turntable_fit.hpp"
#include "host/cli/bench_chain.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/paper_methods.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kMdeg = std::numbers::pi / 180.0 * 1e-3;
constexpr double kRegion95 = 12.5916;  ///< chi-squared, 6 degrees of freedom
constexpr double kNormal95 = 1.96;
constexpr std::array kMethods{"tsai", "park", "horaud", "andreff", "daniilidis"};

void make(const std::vector<std::string>& arguments) {
    if (stop_requested()) {
        throw Interrupted();
    }
    if (run_program(required_program("scribecell-rig"), arguments).exit_code != 0) {
        throw CellError("scribecell-rig made no data");
    }
}

/// Rows of truth.csv.
class Truth {
public:
    explicit Truth(const fs::path& folder) : folder_(folder), csv_(CsvTable::read(folder / "truth.csv")) {}
    [[nodiscard]] std::size_t size() const { return csv_.size(); }
    [[nodiscard]] std::string text(std::size_t row, const char* column) const {
        return csv_.text(row, csv_.column(column));
    }
    [[nodiscard]] fs::path set(std::size_t row) const { return folder_ / text(row, "set"); }
    [[nodiscard]] double number(std::size_t row, const char* column) const {
        return csv_.number(row, csv_.column(column));
    }
    [[nodiscard]] Vec3 place(std::size_t row) const {
        return {number(row, "x_mm") * 1e-3, number(row, "y_mm") * 1e-3, number(row, "z_mm") * 1e-3};
    }
    [[nodiscard]] Mat3 rotation(std::size_t row) const { return rotation_of(csv_, row); }
    static Mat3 rotation_of(const CsvTable& csv, std::size_t row) {
        const std::size_t first = csv.column("r11");
        Mat3 m;
        for (std::size_t r = 0; r < 3; ++r) {
            const std::size_t at = first + 3 * r;
            m.row[r] = {csv.number(row, at), csv.number(row, at + 1), csv.number(row, at + 2)};
        }
        return m;
    }

private:
    fs::path folder_;
    CsvTable csv_;
};

/// Small rotation from b to a, as a vector: exact to third order, and errors are millidegrees.
Vec3 turn_between(const Mat3& a, const Mat3& b) {
    const Mat3 d = a * b.transposed();
    Vec3 axial{d.row[2].y - d.row[1].z, d.row[0].z - d.row[2].x, d.row[1].x - d.row[0].y};
    axial = 0.5 * axial;
    const double sine = norm(axial);
    const double angle = std::atan2(sine, 0.5 * (d.row[0].x + d.row[1].y + d.row[2].z - 1.0));
    return sine > 1e-9 ? (angle / sine) * axial : axial;
}

/// Squared errors over squared bounds, and how sure their ratio is.
struct Ratio {
    std::vector<double> errors;  ///< squared
    std::vector<double> bounds;  ///< squared

    void add(double error, double bound) {
        errors.push_back(error * error);
        bounds.push_back(bound * bound);
    }
    [[nodiscard]] static double sum(const std::vector<double>& v) {
        double s = 0.0;
        for (const double x : v) {
            s += x;
        }
        return s;
    }
    /// Rms error over rms bound.
    [[nodiscard]] double value() const { return std::sqrt(sum(errors) / sum(bounds)); }
    /// Half of the 95 % confidence interval, from the scatter of the sets.
    [[nodiscard]] double half_interval() const {
        const double square = sum(errors) / sum(bounds);
        double scatter = 0.0;
        for (std::size_t i = 0; i < errors.size(); ++i) {
            scatter += std::pow(errors[i] - square * bounds[i], 2);
        }
        return kNormal95 * std::sqrt(scatter) / sum(bounds) / (2.0 * std::sqrt(square));
    }
};

struct HandEyeScore {
    Ratio turn;
    Ratio place;
    double inside = 0.0;  ///< sets whose truth lies in the stated 95 % region
    double sets = 0.0;
    double seconds = 0.0;
    std::map<std::string, std::array<double, 2>> peers;  ///< squared errors by method: turn, place
    std::string rows = "set,turn_error_mdeg,turn_bound_mdeg,place_error_um,place_bound_um,chi_squared_of_6,ms\n";
};

bool inside_region(const HandEyeResult& result, const Vec3& turn, const Vec3& place, double& square) {
    Eigen::Matrix<double, 6, 6> covariance;
    for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) {
            covariance(r, c) = result.by_value.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
        }
    }
    Eigen::Matrix<double, 6, 1> error;
    error << turn.x, turn.y, turn.z, place.x, place.y, place.z;
    square = error.dot(covariance.llt().solve(error));
    return square <= kRegion95;
}

HandEyeScore score_hand_eye(const fs::path& folder) {
    const Truth truth(folder);
    HandEyeScore score;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const fs::path set = truth.set(i);
        const auto views = pair_views(read_poses(set / "robot.csv"), read_marker_views(set / "target.csv"));
        const auto begin = std::chrono::steady_clock::now();
        const HandEyeResult result = calibrate_hand_eye(set / "robot.csv", views);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        const Vec3 turn = turn_between(truth.rotation(i), result.f_from_c.rotation);
        const Vec3 place = truth.place(i) - result.f_from_c.translation;
        score.turn.add(norm(turn) / kMdeg, truth.number(i, "bound_turn_mdeg"));
        score.place.add(norm(place) * 1e6, truth.number(i, "bound_place_um"));
        double square = 0.0;
        score.inside += inside_region(result, turn, place, square) ? 1.0 : 0.0;
        score.sets += 1.0;
        score.seconds += seconds;
        score.rows += fmt::format("{},{:.5f},{:.5f},{:.4f},{:.4f},{:.4f},{:.4f}\n", truth.text(i, "set"),
                                  norm(turn) / kMdeg, truth.number(i, "bound_turn_mdeg"), norm(place) * 1e6,
                                  truth.number(i, "bound_place_um"), square, seconds * 1e3);
    }
    return score;
}

/// OpenCV on the same files; false where it was not there at build time.
bool score_peers(const fs::path& folder, HandEyeScore& score) {
    const auto program = find_program("scribecell-hand-eye-peer");
    if (!program) {
        std::fprintf(stderr,
                     "handeye_over_best_opencv is left out: OpenCV's calib3d was not there at build time "
                     "(./run bench calibration installs it)\n");
        return false;
    }
    if (run_program(*program, {folder.string()}, ProgramErrors::dropped).exit_code != 0) {
        throw CellError("scribecell-hand-eye-peer failed");
    }
    const Truth truth(folder);
    const CsvTable csv = CsvTable::read(folder / "opencv.csv");
    if (csv.size() != truth.size() * kMethods.size()) {
        throw CellError("scribecell-hand-eye-peer left sets out");
    }
    for (std::size_t row = 0; row < csv.size(); ++row) {
        const std::size_t set = row / kMethods.size();
        auto& sums = score.peers[csv.text(row, csv.column("method"))];
        const Vec3 place{csv.number(row, csv.column("x_mm")), csv.number(row, csv.column("y_mm")),
                         csv.number(row, csv.column("z_mm"))};
        sums[0] += std::pow(norm(turn_between(truth.rotation(set), Truth::rotation_of(csv, row))) / kMdeg, 2);
        sums[1] += std::pow(norm(truth.place(set) - 1e-3 * place) * 1e6, 2);
    }
    return true;
}

/// The larger of both ratios of rms errors, each against the method that is best at it.
double over_best(const HandEyeScore& score) {
    std::array<double, 2> best{1e300, 1e300};
    for (const auto& [name, sums] : score.peers) {
        best[0] = std::min(best[0], sums[0]);
        best[1] = std::min(best[1], sums[1]);
    }
    return std::sqrt(std::max(Ratio::sum(score.turn.errors) / best[0], Ratio::sum(score.place.errors) / best[1]));
}

/// Share of sets in which just what is wrong is named.
struct Named {
    double poses = 0.0;
    double swaps = 0.0;
    double result_ratio = 0.0;  ///< rms place error over the bound of the sound set
};

std::string swaps_of(const HandEyeResult& result) {
    std::vector<std::string> names;
    for (const MarkerFinding& m : result.markers) {
        names.push_back(fmt::format("{}:{}:{}", m.view, std::min(m.id, m.other), std::max(m.id, m.other)));
    }
    std::string out;
    for (const std::string& name : names) {
        out += (out.empty() ? "" : " ") + name;
    }
    return out;
}

Named score_named(const fs::path& folder) {
    const Truth truth(folder);
    Named named;
    Ratio place;
    const double n = static_cast<double>(truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const fs::path set = truth.set(i);
        const HandEyeResult result = calibrate_hand_eye(
            set / "robot.csv", pair_views(read_poses(set / "robot.csv"), read_marker_views(set / "target.csv")));
        named.poses += result.bad_poses == std::vector<std::string>{truth.text(i, "bad_view")} ? 100.0 / n : 0.0;
        named.swaps += swaps_of(result) == truth.text(i, "swapped") ? 100.0 / n : 0.0;
        place.add(norm(truth.place(i) - result.f_from_c.translation) * 1e6, truth.number(i, "bound_place_um"));
    }
    named.result_ratio = place.value();
    return named;
}

Ratio score_rigid(const fs::path& folder) {
    const Truth truth(folder);
    Ratio ratio;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const fs::path set = truth.set(i);
        const RigidFit fit = fit_rigid(set / "h.csv", read_marker_views(set / "h.csv").views.front().markers,
                                       read_marker_views(set / "c.csv").views.front().markers);
        double sum = 0.0;
        for (const double x : {-0.2, 0.2}) {
            for (const double z : {-0.15, 0.15}) {
                const Vec3 at{x, 0.0, z};
                const Vec3 in_c = truth.rotation(i).transposed() * (at - truth.place(i));
                const Vec3 off = fit.rotation * in_c + fit.translation - at;
                sum += dot(off, off) / 4.0;
            }
        }
        ratio.add(std::sqrt(sum) * 1e6, truth.number(i, "bound_um"));
    }
    return ratio;
}

struct AxisScore {
    Ratio fit;
    Ratio circles;
};

AxisScore score_axis(const fs::path& folder) {
    const Truth truth(folder);
    AxisScore score;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const MarkerFile file = read_marker_views(truth.set(i) / "markers.csv");
        const TurntableFit fit = fit_turntable(file.file, file.views);
        const Vec3 axis{truth.number(i, "dir_x"), truth.number(i, "dir_y"), truth.number(i, "dir_z")};
        const Vec3 at = truth.place(i) + (truth.number(i, "height_mm") * 1e-3) * axis;
        // Where the line passes the plane across the axis at that height.
        const auto distance = [&](const AxisByCircles& line) {
            const Vec3 there = line.point + (dot(at - line.point, axis) / dot(line.direction, axis)) * line.direction;
            return norm(there - at) * 1e6;
        };
        score.fit.add(distance({fit.point, fit.direction}), truth.number(i, "bound_um"));
        score.circles.add(distance(mean_of_circles(file.views)), truth.number(i, "bound_um"));
    }
    return score;
}

struct Arc {
    const char* name;
    const char* angles;
    const char* arc_deg;
    bool part;  ///< of a turn: counts for the gain over circles
};
constexpr std::array kArcs{Arc{"axis_360", "12", "360", false}, Arc{"axis_90_8", "8", "90", true},
                           Arc{"axis_90_24", "24", "90", true}, Arc{"axis_120", "12", "120", true}};
struct Pointing {
    const char* name;
    const char* markers;
    const char* um;
};
constexpr std::array kPointings{Pointing{"rigid_12", "12", "10"}, Pointing{"rigid_5", "5", "50"},
                                Pointing{"rigid_30", "30", "50"}};

class Calibrations {
public:
    explicit Calibrations(const BenchOptions& options) : options_(options), folder_(options.raw) {}

    std::vector<Figure> run() {
        hand_eye();
        named();
        rigid();
        axis();
        for (Figure& figure : bench_chain(options_, folder_.path(), raw_)) {
            figures_.push_back(std::move(figure));
        }
        for (Figure& figure : bench_centres({options_.seed, centres_folder(), options_.sets})) {
            if (figure.name.starts_with("centre_") || figure.name.starts_with("perspective_")) {
                figures_.push_back(std::move(figure));
            }
        }
        if (folder_.named()) {
            write_text_file(folder_.path() / "figures.csv", raw_);
        }
        return figures_;
    }

private:
    /// A folder of sets, all with seeds of their own.
    fs::path make_sets(const std::string& name, std::vector<std::string> arguments) {
        std::fprintf(stderr, "%s\n", name.c_str());
        const fs::path out = folder_.path() / name;
        arguments.insert(arguments.end(), {"--out", out.string(), "--sets", std::to_string(options_.sets), "--seed",
                                           std::to_string(options_.seed * 100 + ++kinds_)});
        make(arguments);
        return out;
    }

    [[nodiscard]] std::optional<fs::path> centres_folder() const {
        return folder_.named() ? std::optional(folder_.path() / "centres") : std::nullopt;
    }

    void hand_eye() {
        const fs::path out = make_sets("hand_eye", {"hand-eye"});
        HandEyeScore score = score_hand_eye(out);
        const double coverage = 100.0 * score.inside / score.sets;
        figures_.push_back({"handeye_rot_over_crlb", score.turn.value(), ""});
        figures_.push_back({"handeye_rot_half_interval", score.turn.half_interval(), ""});
        figures_.push_back({"handeye_trans_over_crlb", score.place.value(), ""});
        figures_.push_back({"handeye_trans_half_interval", score.place.half_interval(), ""});
        if (score_peers(out, score)) {
            figures_.push_back({"handeye_over_best_opencv", over_best(score), ""});
            for (const auto& [name, sums] : score.peers) {
                raw_ += fmt::format("opencv_{}_turn_mdeg,{:.5f}\nopencv_{}_place_um,{:.4f}\n", name,
                                    std::sqrt(sums[0] / score.sets), name, std::sqrt(sums[1] / score.sets));
            }
        }
        raw_ += fmt::format("handeye_turn_mdeg,{:.5f}\nhandeye_place_um,{:.4f}\n",
                            std::sqrt(Ratio::sum(score.turn.errors) / score.sets),
                            std::sqrt(Ratio::sum(score.place.errors) / score.sets));
        figures_.push_back({"handeye_ms", 1e3 * score.seconds / score.sets, "ms"});
        figures_.push_back({"coverage_pct", coverage, "%"});
        figures_.push_back({"coverage_over_pct", coverage, "%"});
        write_text_file(out / "errors.csv", score.rows);
    }

    void named() {
        const fs::path bad = make_sets("bad_pose", {"hand-eye", "--bad-mm", "1", "--bad-deg", "0.2"});
        const Named poses = score_named(bad);
        const fs::path swapped = make_sets("swapped", {"hand-eye", "--swapped-views", "5"});
        const Named swaps = score_named(swapped);
        figures_.push_back({"bad_pose_named_pct", poses.poses, "%"});
        figures_.push_back({"swapped_named_pct", swaps.swaps, "%"});
        figures_.push_back({"bad_pose_trans_over_crlb", poses.result_ratio, ""});
        figures_.push_back({"swapped_trans_over_crlb", swaps.result_ratio, ""});
    }

    void rigid() {
        Ratio worst;
        for (const Pointing& p : kPointings) {
            const Ratio ratio =
                score_rigid(make_sets(p.name, {"rigid", "--markers", p.markers, "--pointing-um", p.um}));
            note(p.name, ratio);
            if (worst.errors.empty() || ratio.value() > worst.value()) {
                worst = ratio;
            }
        }
        figures_.push_back({"rigid_over_crlb", worst.value(), ""});
        figures_.push_back({"rigid_half_interval", worst.half_interval(), ""});
    }

    void axis() {
        Ratio worst;
        double gain = 1e300;
        for (const Arc& arc : kArcs) {
            const AxisScore score =
                score_axis(make_sets(arc.name, {"axis", "--angles", arc.angles, "--arc-deg", arc.arc_deg}));
            note(arc.name, score.fit);
            note(std::string(arc.name) + "_circles", score.circles);
            if (worst.errors.empty() || score.fit.value() > worst.value()) {
                worst = score.fit;
            }
            if (arc.part) {
                gain = std::min(gain, score.circles.value() / score.fit.value());
            }
        }
        figures_.push_back({"axis_over_crlb", worst.value(), ""});
        figures_.push_back({"axis_half_interval", worst.half_interval(), ""});
        figures_.push_back({"axis_arc_gain", gain, ""});
    }

    void note(const std::string& name, const Ratio& ratio) {
        raw_ += fmt::format("{}_over_bound,{:.5f}\n{}_half_interval,{:.5f}\n", name, ratio.value(), name,
                            ratio.half_interval());
    }

    BenchOptions options_;
    RunFolder folder_;
    std::uint64_t kinds_ = 0;
    std::vector<Figure> figures_;
    std::string raw_ = "figure,value\n";
};

}  // namespace

std::vector<Figure> bench_calibration(const BenchOptions& options) { return Calibrations(options).run(); }

}  // namespace sc::host::cli
