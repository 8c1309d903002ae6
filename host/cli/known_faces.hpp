// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/calibration/sensor_ray_fit.hpp"
#include "host/formats/calibration_set.hpp"

/// Flat faces that the 3-D sensor has measured, as planes in h at any reading of the turntable.

namespace sc::host::cli {

/// Brings a view's points into the set's c; views are named as the file names them.
using CFromView = std::function<Rigid<frame::C, frame::C>(const std::string& view)>;

class KnownFaces {
public:
    /// Reads facet,x_mm,y_mm,z_mm[,sigma_um][,c_deg][,view], places in c; with c_deg a face was seen with the table
    /// there, and turns with it. Throws InputError for a facet that is no plane or was seen at two angles, and c_deg
    /// without a turntable in the set.
    KnownFaces(
        const CalibrationSet& set, const std::filesystem::path& file,
        const CFromView& c_from_view = [](const std::string&) { return Rigid<frame::C, frame::C>{}; });

    /// A face with the table at that reading, its normal against `towards` in h. Throws InputError for no such face.
    [[nodiscard]] KnownPlane plane(int facet, double c_deg, const Vec3& towards) const;
    /// Middle of its points then, h.
    [[nodiscard]] Vec3 middle(int facet, double c_deg) const;
    [[nodiscard]] std::vector<int> facets() const;

private:
    struct Face {
        bool turns = false;
        double seen_deg = 0.0;
        std::vector<Vec3> points;  ///< h, as seen
    };
    [[nodiscard]] std::vector<Vec3> points(int facet, double c_deg) const;

    std::filesystem::path file_;
    const CalibrationSet* set_;
    std::map<int, Face> faces_;
    double sigma_ = 7.5e-6;
};

}  // namespace sc::host::cli
