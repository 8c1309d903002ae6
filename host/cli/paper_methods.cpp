// SPDX-License-Identifier: Apache-2.0
#include "host/cli/paper_methods.hpp"

#include <algorithm>
#include <map>
#include <numbers>

#include <Eigen/Dense>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<PlacePair> common(const MarkerView& to, const MarkerView& from, const std::set<int>& still) {
    std::vector<PlacePair> out;
    for (const SeenMarker& m : from.markers) {
        const auto at = std::ranges::find(to.markers, m.id, &SeenMarker::id);
        if (at != to.markers.end() && still.contains(m.id)) {
            out.push_back({to_eigen(at->place), to_eigen(m.place), 1.0});
        }
    }
    return out;
}

struct Mean {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0.0;
};

}  // namespace

AxisByCircles mean_of_circles(const std::vector<MarkerView>& views) {
    std::map<int, std::vector<Eigen::Vector3d>> track;
    for (const MarkerView& view : views) {
        for (const SeenMarker& m : view.markers) {
            track[m.id].emplace_back(m.place.x, m.place.y, m.place.z);
        }
    }
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    for (const auto& [id, places] : track) {
        const auto n = static_cast<Eigen::Index>(places.size());
        Eigen::MatrixXd p(n, 3);
        for (Eigen::Index i = 0; i < n; ++i) {
            p.row(i) = places[static_cast<std::size_t>(i)].transpose();
        }
        const Eigen::RowVector3d mean = p.colwise().mean();
        p.rowwise() -= mean;
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(p, Eigen::ComputeThinV);
        Eigen::Vector3d normal = svd.matrixV().col(2);
        if (normal.dot(Eigen::Vector3d(p.row(0)).cross(Eigen::Vector3d(p.row(1)))) < 0.0) {
            normal = -normal;
        }
        const Eigen::MatrixXd flat = p * svd.matrixV().leftCols<2>();
        Eigen::MatrixXd a(n, 3);
        a << 2.0 * flat, Eigen::VectorXd::Ones(n);
        const Eigen::Vector3d circle = a.colPivHouseholderQr().solve(Eigen::VectorXd(flat.rowwise().squaredNorm()));
        point += mean.transpose() + svd.matrixV().leftCols<2>() * circle.head<2>();
        direction += normal;
    }
    point /= static_cast<double>(track.size());
    direction.normalize();
    return {{point[0], point[1], point[2]}, {direction[0], direction[1], direction[2]}};
}

std::vector<ChainPlace> paper_places(const ChainInput& input, const std::vector<ChainPrediction>& asked) {
    std::vector<Motion> pose{Motion{}};
    for (std::size_t i = 1; i < input.views.size(); ++i) {
        const MarkerView& seen = input.views[i].seen;
        const std::vector<PlacePair> pairs = common(input.views[i - 1].seen, seen, input.still);
        if (pairs.size() < 3) {
            throw InputError({.file = input.file.string(),
                              .line = seen.line,
                              .problem = "view has fewer than three markers in common with the one before it",
                              .value = seen.view,
                              .action = "give more reference markers"});
        }
        pose.push_back(pose.back() * fit_motion(pairs));
    }
    // In c; what turns, as it was seen.
    std::vector<MarkerView> turning;
    std::map<int, std::vector<std::pair<double, Eigen::Vector3d>>> seen_at;
    std::map<int, Mean> still;
    for (std::size_t i = 0; i < input.views.size(); ++i) {
        MarkerView view = input.views[i].seen;
        for (SeenMarker& m : view.markers) {
            const Eigen::Vector3d p = pose[i] * to_eigen(m.place);
            m.place = to_vec(p);
            still[m.id].sum += p;
            still[m.id].count += 1.0;
            seen_at[m.id].emplace_back(view.turn.value_or(0.0), p);
        }
        std::erase_if(view.markers, [&](const SeenMarker& m) { return input.still.contains(m.id); });
        turning.push_back(std::move(view));
    }
    for (MarkerView& view : turning) {  // circles need three places
        std::erase_if(view.markers, [&](const SeenMarker& m) { return seen_at[m.id].size() < 3; });
    }
    std::erase_if(turning, [](const MarkerView& view) { return view.markers.empty(); });
    const AxisByCircles axis = mean_of_circles(turning);
    std::vector<PlacePair> pairs;
    for (const MarkerView& view : input.pointing) {
        for (const SeenMarker& m : view.markers) {
            const Mean& mean = still[m.id];
            pairs.push_back({to_eigen(m.place), mean.sum / mean.count, 1.0});
        }
    }
    const Motion h_from_c = fit_motion(pairs);
    std::vector<ChainPlace> out;
    for (const ChainPrediction& p : asked) {
        const auto& [turn, place] = seen_at.at(p.id).front();
        const double by = -p.face_deg * kDegree - turn;
        const Eigen::Vector3d point = to_eigen(axis.point);
        const Eigen::Vector3d at = point + exp_turn(by * to_eigen(axis.direction)) * (place - point);
        out.push_back({p.id, p.face_deg, to_vec(h_from_c * at), {}});
    }
    return out;
}

}  // namespace sc::host::cli
