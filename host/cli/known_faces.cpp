// SPDX-License-Identifier: Apache-2.0
#include "host/cli/known_faces.hpp"

#include <stdexcept>

#include <fmt/format.h>

#include "host/calibration/transforms.hpp"
#include "host/cli/all_steps.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {

KnownFaces::KnownFaces(const CalibrationSet& set, const std::filesystem::path& file, const CFromView& c_from_view)
    : file_(file), set_(&set) {
    const CsvTable csv = CsvTable::read(file);
    const bool turns = csv.has("c_deg");
    if (turns && !set.turntable) {
        throw InputError({.file = file.string(),
                          .problem = "faces on the table need its axis",
                          .value = "c_deg",
                          .action = "name a calibration set that has [turntable]"});
    }
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const auto mm = [&](const char* name) { return csv.number(i, csv.column(name)) * 1e-3; };
        const int facet = csv.integer(i, csv.column("facet"));
        const double c_deg = turns ? csv.number(i, csv.column("c_deg")) : 0.0;
        const std::string view = csv.has("view") ? std::string(csv.text(i, csv.column("view"))) : std::string();
        const auto [face, added] = faces_.try_emplace(facet, Face{turns, c_deg, {}});
        if (!added && face->second.seen_deg != c_deg) {
            throw InputError({.file = file.string(),
                              .line = csv.line(i),
                              .problem = "a facet was seen at two angles of the table",
                              .value = fmt::format("facet {}: {} and {} deg", facet, face->second.seen_deg, c_deg),
                              .action = "give each view of a facet a number of its own"});
        }
        const Point<frame::C> seen{{mm("x_mm"), mm("y_mm"), mm("z_mm")}};
        face->second.points.push_back((h_from_c(set) * (c_from_view(view) * seen)).v);
        sigma_ = csv.has("sigma_um") ? csv.number(i, csv.column("sigma_um")) * 1e-6 : sigma_;
    }
}

std::vector<Vec3> KnownFaces::points(int facet, double c_deg) const {
    const auto found = faces_.find(facet);
    if (found == faces_.end()) {
        throw InputError({.file = file_.string(),
                          .problem = "has no such facet",
                          .value = std::to_string(facet),
                          .action = "measure it, or leave its readings out"});
    }
    const Face& face = found->second;
    std::vector<Vec3> out;
    for (const Vec3& p : face.points) {
        out.push_back(face.turns ? (h_from_t(set_->turntable->line, c_deg) *
                                    (h_from_t(set_->turntable->line, face.seen_deg).inverse() * Point<frame::H>{p}))
                                       .v
                                 : p);
    }
    return out;
}

KnownPlane KnownFaces::plane(int facet, double c_deg, const Vec3& towards) const {
    try {
        return fit_known_plane(facet, points(facet, c_deg), sigma_, towards);
    } catch (const std::domain_error& error) {
        throw InputError({.file = file_.string(),
                          .problem = "a facet is no plane",
                          .value = std::to_string(facet),
                          .action = error.what()});
    }
}

Vec3 KnownFaces::middle(int facet, double c_deg) const {
    const std::vector<Vec3> all = points(facet, c_deg);
    Vec3 out;
    for (const Vec3& p : all) {
        out = out + (1.0 / static_cast<double>(all.size())) * p;
    }
    return out;
}

std::vector<int> KnownFaces::facets() const {
    std::vector<int> out;
    for (const auto& [facet, face] : faces_) {
        out.push_back(facet);
    }
    return out;
}

}  // namespace sc::host::cli
