// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/hand_eye.hpp"
#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kLongestGap = 0.2;  ///< seconds between poses that are interpolated

Motion motion_of(const NamedPose& pose) { return {to_eigen(pose.rotation), to_eigen(pose.translation)}; }

Rigid<frame::B, frame::F> robot_of(const NamedPose& pose) { return {pose.rotation, pose.translation}; }

/// Throws for the names that only one file has.
template <class Names>
void refuse_lone(const std::filesystem::path& file, const Names& lone, const std::string& other) {
    if (!lone.empty()) {
        std::string names;
        for (std::size_t i = 0; i < std::min<std::size_t>(lone.size(), 5); ++i) {
            names += (i == 0 ? "" : ", ") + lone[i];
        }
        throw InputError(
            {.file = file.string(),
             .problem = fmt::format("{} view{} not in {}", lone.size(), lone.size() == 1 ? " is" : "s are", other),
             .value = names + (lone.size() > 5 ? ", ..." : ""),
             .action = "give both files the same views"});
    }
}

template <class Views, class Make>
std::vector<HandEyeView> by_name(const PoseFile& robot, const std::filesystem::path& target_file, const Views& views,
                                 const Make& make) {
    std::map<std::string, const NamedPose*> poses;
    for (const NamedPose& pose : robot.poses) {
        poses[pose.view] = &pose;
    }
    std::vector<HandEyeView> out;
    std::vector<std::string> lone;
    for (const auto& view : views) {
        const auto at = poses.find(view.view);
        if (at == poses.end()) {
            lone.push_back(view.view);
            continue;
        }
        HandEyeView pair{.name = view.view,
                         .line = at->second->line,
                         .b_from_f = robot_of(*at->second),
                         .markers = {},
                         .c_from_g = {}};
        make(pair, view);
        out.push_back(std::move(pair));
        poses.erase(at);
    }
    refuse_lone(target_file, lone, robot.file.string());
    for (const auto& [name, pose] : poses) {
        lone.push_back(name);
    }
    refuse_lone(robot.file, lone, target_file.string());
    return out;
}

/// A stream of robot poses, read between its samples.
class Stream {
public:
    explicit Stream(const PoseFile& file) {
        for (const NamedPose& pose : file.poses) {
            samples_.emplace_back(*pose.time, &pose);
        }
        std::ranges::sort(samples_, {}, &std::pair<double, const NamedPose*>::first);
    }
    struct Sample {
        const NamedPose* before = nullptr;
        Motion pose;
        double turn_rate = 0.0;  ///< rad/s
        double speed = 0.0;      ///< m/s
    };
    [[nodiscard]] std::optional<Sample> at(double time) const {
        const auto after = std::ranges::upper_bound(samples_, time, {}, &std::pair<double, const NamedPose*>::first);
        if (after == samples_.begin() || after == samples_.end()) {
            return std::nullopt;
        }
        const auto before = std::prev(after);
        const double span = after->first - before->first;
        if (span > kLongestGap || span <= 0.0) {
            return std::nullopt;
        }
        const Motion a = motion_of(*before->second);
        const Motion b = motion_of(*after->second);
        const Eigen::Vector3d turn = log_turn(a.r.transpose() * b.r);
        const double part = (time - before->first) / span;
        return Sample{before->second,
                      {a.r * exp_turn(part * turn), a.t + part * (b.t - a.t)},
                      turn.norm() / span,
                      (b.t - a.t).norm() / span};
    }

private:
    std::vector<std::pair<double, const NamedPose*>> samples_;
};

struct Candidate {
    HandEyeView view;
    Eigen::Matrix3d turn;
    double haste = 0.0;  ///< of robot and target there
};

/// Slow ones first: of the slower half, each time the one that is turned furthest from all taken.
std::vector<HandEyeView> pick(std::vector<Candidate> all, std::size_t count) {
    std::ranges::sort(all, {}, &Candidate::haste);
    all.resize(std::max(std::min(all.size(), count), all.size() / 4));
    std::vector<double> nearest(all.size(), 1e9);
    std::vector<HandEyeView> out;
    std::size_t next = 0;
    while (out.size() < std::min(count, all.size())) {
        out.push_back(all[next].view);
        const Eigen::Matrix3d taken = all[next].turn;
        std::size_t furthest = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            nearest[i] = std::min(nearest[i], log_turn(taken.transpose() * all[i].turn).norm());
            furthest = nearest[i] > nearest[furthest] ? i : furthest;
        }
        next = furthest;
    }
    return out;
}

bool has_times(const PoseFile& file) {
    return std::ranges::all_of(file.poses, [](const NamedPose& pose) { return pose.time.has_value(); });
}

}  // namespace

std::vector<HandEyeView> pair_views(const PoseFile& robot, const MarkerFile& target) {
    return by_name(robot, target.file, target.views,
                   [](HandEyeView& pair, const MarkerView& view) { pair.markers = view.markers; });
}

std::vector<HandEyeView> pair_views(const PoseFile& robot, const PoseFile& target, const PairingOptions& options) {
    if (has_times(robot) != has_times(target)) {
        throw InputError({.file = target.file.string(),
                          .problem = "one file has times and the other has names of views",
                          .value = "time_s",
                          .action = "give both of them time_s, or both of them view"});
    }
    if (!has_times(robot)) {
        return by_name(robot, target.file, target.poses, [](HandEyeView& pair, const NamedPose& pose) {
            pair.c_from_g = Rigid<frame::C, frame::G>{pose.rotation, pose.translation};
        });
    }
    const Stream stream(robot);
    const Stream seen(target);
    std::vector<Candidate> candidates;
    for (const NamedPose& pose : target.poses) {
        const auto sample = stream.at(*pose.time + options.time_offset);
        const auto motion = seen.at(*pose.time);
        if (sample && motion) {
            HandEyeView view{.name = pose.view,
                             .line = sample->before->line,
                             .b_from_f = {to_mat(sample->pose.r), to_vec(sample->pose.t)},
                             .markers = {},
                             .c_from_g = Rigid<frame::C, frame::G>{pose.rotation, pose.translation}};
            candidates.push_back({std::move(view), sample->pose.r,
                                  sample->turn_rate + sample->speed + 0.2 * (motion->turn_rate + motion->speed)});
        }
    }
    if (candidates.size() < 3) {
        throw InputError({.file = target.file.string(),
                          .problem = "times do not overlap with those of " + robot.file.string(),
                          .value = fmt::format("{} views in common", candidates.size()),
                          .action = "check both clocks, or say --time-offset-s"});
    }
    return pick(std::move(candidates), options.views);
}

}  // namespace sc::host
