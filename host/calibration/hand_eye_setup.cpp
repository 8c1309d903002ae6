// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/hand_eye_setup.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kLeastViews = 3;
constexpr double kAlike = 0.05 * kDegree;  ///< views that turn by less show nothing new
constexpr double kInverted = 5.0;          ///< times less scatter the other way round

template <class To, class From>
Motion motion_of(const Rigid<To, From>& x) {
    return {to_eigen(x.rotation), to_eigen(x.translation)};
}

/// A target's pose as markers: six on its axes, so far out and so noisy that they say just what the pose says.
std::vector<SeenMarker> markers_of_pose(const Motion& c_from_g, int line, const HandEyeNoise& noise) {
    const double lever = std::sqrt(6.0) * noise.marker / (2.0 * noise.pose_turn);
    const double sigma = std::sqrt(6.0) * noise.marker;
    std::vector<SeenMarker> out;
    for (int i = 0; i < 6; ++i) {
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
        place[i / 2] = i % 2 == 0 ? lever : -lever;
        out.push_back({line, i + 1, to_vec(c_from_g * place), {sigma, sigma, sigma}});
    }
    return out;
}

class Setup {
public:
    Setup(const std::filesystem::path& file, std::vector<HandEyeView> views, const HandEyeOptions& options)
        : file_(file), views_(std::move(views)), options_(options), noise_(options.noise) {
        poses_given_ = !views_.empty() && views_.front().c_from_g.has_value();
    }

    HandEyeSetup run() {
        prepare();
        place_target();
        check_order();
        choose_convention();
        note_alike();
        return {.views = std::move(views_),
                .entries = std::move(entries_),
                .start = start_,
                .found = std::move(result_),
                .poses_given = poses_given_};
    }

private:
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

    void prepare() {
        if (poses_given_) {
            for (HandEyeView& view : views_) {
                view.markers = markers_of_pose(motion_of(*view.c_from_g), view.line, noise_);
            }
        } else {
            std::vector<MarkerView> seen;
            for (const HandEyeView& view : views_) {
                seen.push_back({.line = view.line, .view = view.name, .time = {}, .turn = {}, .markers = view.markers});
            }
            if (options_.find_wrong) {
                result_.markers = check_markers(seen, noise_.marker);
            }
            for (std::size_t i = 0; i < views_.size(); ++i) {
                views_[i].markers = seen[i].markers;
            }
        }
        std::string few;
        for (const HandEyeView& view : views_) {
            if (view.markers.size() >= 3) {
                entries_.push_back({&view, motion_of(view.b_from_f), {}, true});
            } else {
                few += (few.empty() ? "" : ", ") + view.name;
            }
        }
        if (!few.empty()) {
            result_.notes.push_back("left out, with fewer than three markers: view " + few);
        }
        enough(entries_.size());
    }

    void enough(std::size_t views) const {
        if (views < kLeastViews) {
            refuse("has too few views with three markers or more", std::to_string(views),
                   "give three at the very least, better 15, tilted about two axes and rolled");
        }
    }

    /// Where each view sees the target, whose frame is that of the view with most markers.
    void place_target() {
        if (poses_given_) {
            for (HandEyeEntry& entry : entries_) {
                entry.c = motion_of(*entry.view->c_from_g);
            }
            return;
        }
        const auto most = std::ranges::max_element(
            entries_, {}, [](const HandEyeEntry& entry) { return entry.view->markers.size(); });
        const std::vector<SeenMarker>& reference = most->view->markers;
        refuse_line(reference);
        std::string apart;
        std::vector<HandEyeEntry> kept;
        for (HandEyeEntry& entry : entries_) {
            std::vector<PlacePair> pairs;
            for (const SeenMarker& m : entry.view->markers) {
                const auto same = std::ranges::find(reference, m.id, &SeenMarker::id);
                if (same != reference.end()) {
                    pairs.push_back({to_eigen(m.place), to_eigen(same->place), 1.0});
                }
            }
            if (pairs.size() < 3) {
                apart += (apart.empty() ? "" : ", ") + entry.view->name;
                continue;
            }
            entry.c = fit_motion(pairs);
            kept.push_back(entry);
        }
        if (!apart.empty()) {
            result_.notes.push_back("left out, with fewer than three markers in common with view " + most->view->name +
                                    ": view " + apart);
        }
        entries_ = std::move(kept);
        enough(entries_.size());
    }

    void refuse_line(const std::vector<SeenMarker>& markers) const {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (const SeenMarker& m : markers) {
            mean += to_eigen(m.place) / static_cast<double>(markers.size());
        }
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        for (const SeenMarker& m : markers) {
            spread += (to_eigen(m.place) - mean) * (to_eigen(m.place) - mean).transpose();
        }
        const Eigen::Vector3d size = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues().cwiseSqrt();
        if (size[1] < 0.01 * size[2]) {
            refuse("the target's markers lie on a line; across it they spread, in mm",
                   fmt::format("{:.2f}", size[1] * 1e3),
                   "turns about the line are not seen: use a target whose markers fill an area");
        }
    }

    [[nodiscard]] std::vector<Motion> motions(bool robot, const std::vector<bool>& skip = {}) const {
        std::vector<Motion> out;
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            if (skip.empty() || !skip[i]) {
                const Motion& m = robot ? entries_[i].f : entries_[i].c;
                const bool inverted = robot ? result_.robot_inverted : result_.target_inverted;
                out.push_back(inverted ? m.inverse() : m);
            }
        }
        return out;
    }

    /// A picture that failed shifts every later pose: that is seen by the angles between views.
    void check_order() {
        const std::vector<Motion> f = motions(true);
        const std::vector<Motion> c = motions(false);
        const double as_given = angle_mismatch(f, c, 0);
        const double limit = std::max(0.2 * kDegree, 6.0 * (noise_.robot_turn + noise_.pose_turn));
        if (as_given > limit && f.size() >= 5) {
            for (const int shift : {-1, 1, -2, 2}) {
                if (angle_mismatch(f, c, shift) < 0.2 * as_given) {
                    refuse(fmt::format("the views of the target fit the robot poses {} row{} {}", std::abs(shift),
                                       std::abs(shift) == 1 ? "" : "s", shift > 0 ? "before them" : "after them"),
                           fmt::format("angles between views differ by {:.2f} deg rms as paired", as_given / kDegree),
                           "pair the files anew: a view is missing in one of them");
                }
            }
        }
        skip_ = out_of_step(f, c, limit);
    }

    void choose_convention() {
        start_ = start_hand_eye(motions(true, skip_), motions(false, skip_));
        if (!options_.try_conventions || entries_.size() < 5) {
            return;
        }
        const double as_given = start_.scatter;
        HandEyeStart best = start_;
        std::array<bool, 2> choice{false, false};
        for (const std::array<bool, 2> way : {std::array{true, false}, {false, true}, {true, true}}) {
            if (way[1] && !poses_given_) {
                continue;
            }
            result_.robot_inverted = way[0];
            result_.target_inverted = way[1];
            const HandEyeStart start = start_hand_eye(motions(true, skip_), motions(false, skip_));
            if (start.scatter < best.scatter) {
                best = start;
                choice = way;
            }
        }
        const bool clear = best.scatter * kInverted < as_given;
        result_.robot_inverted = clear && choice[0];
        result_.target_inverted = clear && choice[1];
        if (!clear) {
            return;
        }
        start_ = best;
        const std::string scatter =
            fmt::format("the target scatters by {:.3g} mm in place of {:.3g} mm", best.scatter * 1e3, as_given * 1e3);
        if (result_.target_inverted) {
            result_.notes.push_back(
                "the target's poses are inverted: they fit as g_from_c (the sensor in the target) alone; " + scatter);
        }
        if (result_.robot_inverted) {
            result_.notes.push_back(
                "the robot's poses are inverted: they fit as f_from_b alone, or the sensor stands still and the robot "
                "carries the target; " +
                scatter);
        }
        if (result_.target_inverted) {
            for (HandEyeView& view : views_) {
                view.markers = markers_of_pose(motion_of(*view.c_from_g).inverse(), view.line, noise_);
            }
        }
    }

    void note_alike() {
        const std::vector<Motion> f = motions(true);
        std::string names;
        int pairs = 0;
        for (std::size_t i = 0; i < f.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                if (log_turn(f[j].r.transpose() * f[i].r).norm() < kAlike && ++pairs <= 5) {
                    names += (names.empty() ? "" : "; ") + entries_[j].view->name + ", " + entries_[i].view->name;
                }
            }
        }
        if (pairs > 0) {
            result_.notes.push_back(fmt::format("{} pair{} of views turned by under 0.05 deg, which says little: {}{}",
                                                pairs, pairs == 1 ? "" : "s", names, pairs > 5 ? "; ..." : ""));
        }
    }

    std::filesystem::path file_;
    std::vector<HandEyeView> views_;
    HandEyeOptions options_;
    HandEyeNoise noise_;
    bool poses_given_ = false;
    HandEyeResult result_;
    std::vector<HandEyeEntry> entries_;
    std::vector<bool> skip_;
    HandEyeStart start_;
};

}  // namespace

HandEyeSetup set_up_hand_eye(const std::filesystem::path& file, std::vector<HandEyeView> views,
                             const HandEyeOptions& options) {
    return Setup(file, std::move(views), options).run();
}

}  // namespace sc::host
