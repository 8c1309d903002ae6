// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/marker_check.hpp"
#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"
#include "host/formats/poses.hpp"

/// Registration view by view: each is brought to what the views before it agree on, by a rigid fit to the markers in
/// common (four or five suffice; with three none can be found wrong). Closed form: where the joint fit starts, and what
/// it is compared with. For chain.cpp.

namespace sc::host {

/// A marker's sighting by its view and place in that view's list.
struct SightName {
    std::size_t view = 0;
    std::size_t marker = 0;
    auto operator<=>(const SightName&) const noexcept = default;
};
struct StartAxis {
    Eigen::Vector3d point;
    Eigen::Vector3d direction;
};
struct ViewGraph {
    std::vector<Motion> pose;              ///< c_from_view; c is the frame of the known places, else of the first view
    std::map<int, Eigen::Vector3d> place;  ///< markers in c, table at C = 0
    std::set<SightName> wrong;             ///< match no other sighting of their marker
    std::optional<StartAxis> axis;
    std::set<std::string> wrong_turn;  ///< views whose angle fits no axis
};
/// One view alone is at fault.
class BadView : public InputError {
public:
    BadView(InputProblem problem, std::size_t view) : InputError(std::move(problem)), view_(view) {}
    [[nodiscard]] std::size_t view() const noexcept { return view_; }

private:
    std::size_t view_;
};

struct ViewGraphOptions {
    double sigma = 7.5e-6;  ///< metres, of a coordinate that states none
    bool find_wrong = true;
    std::optional<StartAxis> axis;  ///< in c, where it is known
};

/// `still`: ids that do not turn with the table; `known`: places of some of them in c. Throws BadView for a view that
/// has fewer than three markers in common with the others, most of them elsewhere, or on a line; InputError for clouds
/// in other units or mirrored, and turning markers whose axis the angles do not show.
[[nodiscard]] ViewGraph build_view_graph(const std::filesystem::path& file, const std::vector<MarkerView>& views,
                                         const std::set<int>& still, const std::vector<SeenMarker>& known,
                                         const ViewGraphOptions& options);

}  // namespace sc::host
