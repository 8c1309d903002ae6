// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"

/// Cameras and stereo pairs as they were calibrated. File: format = "scribecell-cameras", version = 1
/// (docs/formats.md).

namespace sc::host {

/// Pinhole with Brown and Conrady's distortion, as OpenCV, ROS and MATLAB write it. Camera frame: x right, y down, z
/// along the view. With x = X/Z, y = Y/Z, r² = x² + y², s = 1 + k1 r² + k2 r⁴ + k3 r⁶:
///   u = fx (x s + 2 p1 x y + p2 (r² + 2 x²)) + cx,  v = fy (y s + p1 (r² + 2 y²) + 2 p2 x y) + cy.
/// Pixel (0, 0) is the middle of the first pixel.
struct CameraModel {
    static constexpr std::size_t kParameters = 9;
    double focal_x = 0.0;  ///< px
    double focal_y = 0.0;  ///< px
    double middle_x = 0.0;
    double middle_y = 0.0;
    std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3
    bool operator==(const CameraModel&) const noexcept = default;
};
/// Names of the parameters in the order of covariances: fx, fy, cx, cy, k1, k2, p1, p2, k3.
inline constexpr std::array<std::string_view, CameraModel::kParameters> kCameraParameters{"fx", "fy", "cx", "cy", "k1",
                                                                                          "k2", "p1", "p2", "k3"};

struct CameraRecord {
    std::string id;  ///< of a pair: "left", "right"
    int width = 0;   ///< px
    int height = 0;
    CameraModel model;
    std::vector<std::string> fixed;  ///< parameters that the data could not tell, or that were given
    double rms = 0.0;                ///< px, of a coordinate
    double reach = 0.0;              ///< largest r, undistorted, that was calibrated
    bool operator==(const CameraRecord&) const = default;
};

struct CameraSet {
    std::string id;
    std::string time;                   ///< ISO 8601
    std::vector<std::string> parents;   ///< files it was made of
    double noise = 0.0;                 ///< px: 1 sigma of a coordinate, as the residuals say
    std::vector<CameraRecord> cameras;  ///< one, or left and right
    /// right_from_left of a pair, metres.
    struct Pose {
        Mat3 rotation;
        Vec3 translation;
        bool operator==(const Pose&) const noexcept = default;
    };
    std::optional<Pose> right_from_left;
    /// Of each camera's nine, then of a pair's pose: a turn on the left (radians), then the place (metres). Rows of
    /// fixed parameters are 0.
    std::vector<std::vector<double>> covariance;
    bool operator==(const CameraSet&) const = default;
};

/// Both throw InputError (file, line, value, what to do).
[[nodiscard]] CameraSet read_cameras(const std::filesystem::path& path);
void write_cameras(const std::filesystem::path& path, const CameraSet& set);

}  // namespace sc::host
