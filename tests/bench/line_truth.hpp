// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "host/inspection/alignment.hpp"
#include "host/inspection/datum_line.hpp"

/// Lines cut from a cloud, held against the section of the mesh that the cloud was made from.

namespace sc::host::test {

struct LineTruth {
    double off_95 = 0.0;  ///< metres, over the line's length
    double off_max = 0.0;
    double shown = 0.0;  ///< share of the section that has the line within 0.2 mm
};

inline double off(const Vec3& place, const Vec3& from, const Vec3& to) {
    const Vec3 way = to - from;
    const double squared = dot(way, way);
    const double share = squared > 0.0 ? std::clamp(dot(place - from, way) / squared, 0.0, 1.0) : 0.0;
    return norm(place - (from + share * way));
}
inline double off(const Vec3& place, std::span<const SectionPiece> pieces) {
    double least = 1e300;
    for (const SectionPiece& piece : pieces) {
        least = std::min(least, off(place, piece.from, piece.to));
    }
    return least;
}
/// Every 0.1 mm of each.
inline std::vector<Vec3> sampled(std::span<const SectionPiece> pieces) {
    std::vector<Vec3> out;
    double left = 0.0;
    for (const SectionPiece& piece : pieces) {
        const double length = norm(piece.to - piece.from);
        for (; left < length; left += 1e-4) {
            out.push_back(piece.from + (left / length) * (piece.to - piece.from));
        }
        left -= length;
    }
    return out;
}

inline LineTruth compare_line(const CutLine& cut, std::span<const SectionPiece> truth) {
    std::vector<SectionPiece> own;
    for (const LineRun& run : cut.runs) {
        for (std::size_t i = run.closed ? 0 : 1; i < run.places.size(); ++i) {
            own.push_back({run.places[(i == 0 ? run.places.size() : i) - 1].place, run.places[i].place});
        }
    }
    std::vector<double> distances;
    for (const Vec3& place : sampled(own)) {
        distances.push_back(off(place, truth));
    }
    LineTruth out;
    if (distances.empty()) {
        return out;
    }
    std::ranges::sort(distances);
    out.off_95 = distances[distances.size() * 95 / 100];
    out.off_max = distances.back();
    std::size_t shown = 0;
    const std::vector<Vec3> places = sampled(truth);
    for (const Vec3& place : places) {
        shown += off(place, own) < 2e-4 ? 1U : 0U;
    }
    out.shown = static_cast<double>(shown) / static_cast<double>(places.size());
    return out;
}

/// From a file of rows [R|t] in millimetres that gives the scan's frame from the part's.
inline Placement true_placement(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string title;
    std::getline(in, title);
    Rigid<frame::C, frame::W> c_from_w;
    double t[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
        Vec3& row = c_from_w.rotation.row[i];
        in >> row.x >> row.y >> row.z >> t[i];
    }
    c_from_w.translation = 1e-3 * Vec3{t[0], t[1], t[2]};
    return c_from_w.inverse();
}

}  // namespace sc::host::test
