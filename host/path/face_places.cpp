// SPDX-License-Identifier: Apache-2.0
#include "host/path/face_places.hpp"

#include <cmath>

#include <fmt/format.h>

#include "host/calibration/transforms.hpp"
#include "host/formats/error.hpp"
#include "host/formats/points.hpp"
#include "host/formats/unit_guess.hpp"

namespace sc::host {

namespace {

/// A face's own frame seen from h at its angle, and back.
class FaceFrame {
public:
    FaceFrame(const Job& job, const CalibrationSet& calibration, PlaceFrame frame, double face_deg)
        : job_(job), calibration_(calibration), frame_(frame), face_deg_(face_deg) {}

    [[nodiscard]] Point<frame::H> to_h(const Vec3& place) const {
        switch (frame_) {
            case PlaceFrame::h: return {place};
            case PlaceFrame::c: return to_face(calibration_, Point<frame::C>{place}, face_deg_);
            case PlaceFrame::w: return to_face(calibration_, alignment(), Point<frame::W>{place}, face_deg_);
        }
        return {place};
    }
    [[nodiscard]] Vec3 from_h(const Point<frame::H>& place) const {
        switch (frame_) {
            case PlaceFrame::h: return place.v;
            case PlaceFrame::c: return from_face(calibration_, place, face_deg_).v;
            case PlaceFrame::w: return (alignment().inverse() * from_face(calibration_, place, face_deg_)).v;
        }
        return place.v;
    }

private:
    [[nodiscard]] const Rigid<frame::C, frame::W>& alignment() const {
        if (!job_.c_from_w) {
            throw InputError({.file = job_.file.string(),
                              .problem = "places are given in w, but the job has no alignment c_from_w",
                              .value = {},
                              .action = "add the alignment, or give the places in c or h"});
        }
        return *job_.c_from_w;
    }

    const Job& job_;
    const CalibrationSet& calibration_;
    PlaceFrame frame_;
    double face_deg_;
};

bool within_travel(const Vec3& place, const MachineConfig& machine) {
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
        const AxisConfig& limits = machine.axis[index(axis)];
        const double value = place[index(axis)];
        if (value < limits.travel_min || value > limits.travel_max) {
            return false;
        }
    }
    return true;
}

void refuse_other_units(const std::filesystem::path& file, int line, const std::vector<Vec3>& places,
                        const FaceFrame& frame, const MachineConfig& machine) {
    std::vector<Vec3> millimetres;
    for (const Vec3& place : places) {
        millimetres.push_back(1e3 * place);
    }
    // The origin of c or w may lie among the points: small numbers prove nothing there. Nor do large ones prove
    // micrometres, which shrink any points to that origin.
    const auto guess =
        guess_unit(millimetres, 0.0, [&](const Vec3& metres) { return within_travel(frame.to_h(metres).v, machine); });
    if (guess && guess->millimetres > 1.0) {
        throw InputError({.file = file.string(),
                          .line = line,
                          .problem = fmt::format("the points look like {}, not millimetres", guess->name),
                          .value = fmt::format("{:.6g}", millimetres.front().x),
                          .action = fmt::format("multiply all coordinates by {:.6g}", guess->millimetres)});
    }
}

std::vector<MarkerPlace> from_points_file(const JobFace& face, const FaceFrame& frame, const MachineConfig& machine) {
    const FacePoints points = read_points(face.points);
    std::vector<Vec3> places;
    for (const FacePoint& point : points.points) {
        places.push_back(point.place);
    }
    refuse_other_units(points.file, points.points.front().line, places, frame, machine);
    std::vector<MarkerPlace> markers;
    for (const FacePoint& point : points.points) {
        markers.push_back({point.no, frame.to_h(point.place), {points.file, point.line}});
    }
    return markers;
}

std::vector<MarkerPlace> from_table_rows(const JobFace& face, const FaceFrame& frame, const VerificationTable& table) {
    std::vector<MarkerPlace> markers;
    for (const TableRow& row : table.rows) {
        if (same_face(row.face_deg, face.angle_deg)) {
            markers.push_back({row.no, frame.to_h(frame.from_h(row.measured)), {table.file, row.line}});
        }
    }
    return markers;
}

}  // namespace

bool same_face(double a_deg, double b_deg) noexcept { return std::abs(a_deg - b_deg) < 1e-6; }

FacePlaces face_places(const Job& job, const JobFace& face, const VerificationTable& table,
                       const CalibrationSet& calibration, const MachineConfig& machine, bool from_table) {
    const FaceFrame frame(job, calibration, face.frame, face.angle_deg);
    FacePlaces places;
    places.markers = face.points.empty() || from_table ? from_table_rows(face, frame, table)
                                                       : from_points_file(face, frame, machine);
    if (places.markers.empty()) {
        throw InputError({.file = job.file.string(),
                          .line = face.line,
                          .problem = fmt::format("no points for this face in {}", table.file.string()),
                          .value = fmt::format("{}", face.angle_deg),
                          .action = "give the face a points file, add rows with this face_deg, or take the face out"});
    }
    if (face.datum_line) {
        const FaceFrame line_frame(job, calibration, face.datum_line->frame, face.angle_deg);
        places.line = LineEnds{line_frame.to_h(face.datum_line->from),
                               line_frame.to_h(face.datum_line->to),
                               {job.file, face.datum_line->line}};
    }
    return places;
}

std::vector<PathStep> path_places(const Job& job, const JobPath& path, const CalibrationSet& calibration,
                                  const MachineConfig& machine) {
    std::vector<PathStep> steps = path.steps;
    if (!path.file.empty()) {
        steps.clear();
        for (const RoutePoint& point : read_route(path.file)) {
            steps.push_back({point.line, std::nullopt, point.place});
        }
    }
    std::vector<Vec3> places;
    for (const PathStep& step : steps) {
        places.push_back(step.to);
    }
    const FaceFrame frame(job, calibration, path.frame, path.face_deg);
    refuse_other_units(path.file.empty() ? job.file : path.file, steps.front().line, places, frame, machine);
    for (PathStep& step : steps) {
        step.to = frame.to_h(step.to).v;
        if (step.via) {
            step.via = frame.to_h(*step.via).v;
        }
    }
    return steps;
}

}  // namespace sc::host
