// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/vision/marker.hpp"
#include "host/vision/triangulation.hpp"

/// Circular markers seen by a calibrated pair: which is which, and where their middles lie.

namespace sc::host {

struct StereoMarker {
    std::size_t left = 0;  ///< of the markers given
    std::size_t right = 0;
    Triangulated at;      ///< the circle's middle, perspective taken out
    Vec3 normal;          ///< of the circle, in c, towards the cameras
    double radius = 0.0;  ///< metres
};

struct StereoSettings {
    double nearest = 0.05;            ///< metres from the left camera
    double farthest = 20.0;           ///< metres
    double radius = 0.0;              ///< metres; 0: the one that most markers agree on
    double radius_tolerance = 0.05;   ///< of the radius
    double epipolar_px = 1.0;         ///< besides four sigma
    bool correct_perspective = true;  ///< off: the middles of the ellipses (to compare)
};

struct StereoMarkers {
    std::vector<StereoMarker> markers;  ///< in the order of the left ones
    std::vector<std::string> refused;   ///< sentences: left markers with no partner, or with several
    double epipolar_rms = 0.0;          ///< px
    double radius = 0.0;                ///< metres
};

/// Left and right markers belong together if they are on one epipolar line, in front of both cameras, equally dark or
/// bright, and if the circle has the size that the others have at their distances: what neighbours on one line have
/// not. A marker with two partners left is refused. The middle of each ellipse is then moved to where the circle's own
/// is seen (circle_pose.hpp); the plane is the one of the four solutions that left and right agree on, averaged over
/// markers that agree. Some ms for 50 markers.
[[nodiscard]] StereoMarkers match_markers(const CameraSet& pair, std::span<const Marker> left,
                                          std::span<const Marker> right, const StereoSettings& settings = {});

}  // namespace sc::host
