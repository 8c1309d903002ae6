// SPDX-License-Identifier: Apache-2.0
#include "host/verification/accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "host/path/face_places.hpp"
#include "host/path/plane.hpp"

namespace sc::host {

namespace {

Vec3 magnitudes(const Vec3& v) noexcept { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
Vec3 larger(const Vec3& a, const Vec3& b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
double largest(const Vec3& v) noexcept { return std::max({v.x, v.y, v.z}); }
double apart(const Vec3& a, const Vec3& b) noexcept { return std::hypot(a.x - b.x, a.z - b.z); }

/// Figures over the points that `value` has something for.
template <class Value>
AxisFigures figures(const std::vector<PointAccuracy>& points, Value value) {
    AxisFigures out;
    Vec3 squares;
    double count = 0.0;
    for (const PointAccuracy& point : points) {
        if (const std::optional<Vec3> v = value(point)) {
            out.max = larger(out.max, magnitudes(*v));
            squares = squares + Vec3{v->x * v->x, v->y * v->y, v->z * v->z};
            count += 1.0;
        }
    }
    if (count > 0.0) {
        out.rms = {std::sqrt(squares.x / count), std::sqrt(squares.y / count), std::sqrt(squares.z / count)};
    }
    return out;
}

/// Rows and crosses of one face, and who is near whom.
struct FaceMatch {
    std::vector<const TableRow*> rows;
    std::vector<const FoundCross*> crosses;
    std::vector<std::vector<std::size_t>> near;  ///< per row: crosses within the radius
    std::vector<std::size_t> rows_near;          ///< per cross: how many rows
};

FaceMatch match_face(double face_deg, const BurnFindings& found, const VerificationTable& table, double radius) {
    FaceMatch match;
    for (const TableRow& row : table.rows) {
        if (same_face(row.face_deg, face_deg)) {
            match.rows.push_back(&row);
        }
    }
    for (const FoundCross& cross : found.crosses) {
        if (same_face(cross.face_deg, face_deg)) {
            match.crosses.push_back(&cross);
        }
    }
    match.near.resize(match.rows.size());
    match.rows_near.assign(match.crosses.size(), 0);
    for (std::size_t r = 0; r < match.rows.size(); ++r) {
        for (std::size_t c = 0; c < match.crosses.size(); ++c) {
            if (apart(match.rows[r]->truth.v, match.crosses[c]->place.v) <= radius) {
                match.near[r].push_back(c);
                ++match.rows_near[c];
            }
        }
    }
    return match;
}

/// The plan's cross next to where one was found.
const PlannedPath* planned_cross(const JobPlan& plan, const FoundCross& cross, double radius) {
    const PlannedPath* best = nullptr;
    double least = radius;
    for (const PlannedPath& path : plan.paths) {
        const bool is_cross = path.kind == PathKind::cross_horizontal || path.kind == PathKind::cross_vertical;
        if (is_cross && same_face(path.face_deg, cross.face_deg)) {
            const double distance = apart(path.centre.v, cross.place.v);
            if (distance < least) {
                least = distance;
                best = &path;
            }
        }
    }
    return best;
}

class Assessor {
public:
    Assessor(const BurnFindings& found, const VerificationTable& table, const JobPlan& plan, const TraceHeader& header,
             const CalibrationSet& calibration, double radius)
        : found_(found),
          table_(table),
          plan_(plan),
          truth_(machine_truth(header.errors)),
          compensation_(compensation_of(calibration)),
          lists_errors_(!header.errors.empty()),
          radius_(radius) {
        report_.known = balance(header.errors, calibration);
    }

    AccuracyReport run() {
        for (const double face_deg : plan_.faces) {
            report_.faces.push_back(judge_face(face_deg));
        }
        report_.crosses_elsewhere = static_cast<std::size_t>(
            std::ranges::count_if(found_.crosses, [&](const FoundCross& c) { return !is_planned(c.face_deg); }));
        judge_lines();
        report_.common = fit_errors(samples_);
        report_.complete = is_complete();
        return std::move(report_);
    }

private:
    FaceAccuracy judge_face(double face_deg) {
        FaceAccuracy face;
        face.face_deg = face_deg;
        const FaceMatch match = match_face(face_deg, found_, table_, radius_);
        for (std::size_t r = 0; r < match.rows.size(); ++r) {
            const TableRow& row = *match.rows[r];
            if (match.near[r].empty()) {
                face.not_found.push_back(row.no);
            } else if (match.near[r].size() > 1 || match.rows_near[match.near[r].front()] > 1) {
                face.ambiguous.push_back(row.no);
            } else {
                face.points.push_back(judge_point(row, *match.crosses[match.near[r].front()]));
            }
        }
        for (std::size_t c = 0; c < match.crosses.size(); ++c) {
            if (match.rows_near[c] == 0) {
                face.unmatched.push_back(match.crosses[c]->place);
            }
        }
        summarise(face);
        return face;
    }

    PointAccuracy judge_point(const TableRow& row, const FoundCross& cross) {
        PointAccuracy point;
        point.no = row.no;
        point.measured = row.measured;
        point.truth = row.truth;
        point.found = cross.place;
        point.surface_y = cross.surface_y;
        point.sigma = cross.sigma;
        point.deviation = cross.place.v - row.truth.v;
        point.csv_deviation = row.measured.v - row.truth.v;
        if (const PlannedPath* const path = planned_cross(plan_, cross, radius_)) {
            const Vec3 commanded = path->centre.v;
            point.commanded = commanded;
            point.command_error = cross.place.v - commanded;
            if (lists_errors_) {
                const Vec3 lands = foretell(truth_, compensation_, commanded, path->settings.actuator, commanded);
                point.foretold = point.csv_deviation + (lands - commanded);
            }
            samples_.push_back({commanded, cross.place.v});
            report_.max_command_error = std::max(report_.max_command_error, norm(*point.command_error));
            report_.max_command_error_axes = larger(report_.max_command_error_axes, magnitudes(*point.command_error));
        }
        return point;
    }

    void summarise(FaceAccuracy& face) const {
        face.found = figures(face.points, [](const PointAccuracy& p) { return std::optional(p.deviation); });
        face.csv = figures(face.points, [](const PointAccuracy& p) { return std::optional(p.csv_deviation); });
        if (lists_errors_) {
            const AxisFigures expected = figures(face.points, [](const PointAccuracy& p) { return p.foretold; });
            face.foretold = expected;
            face.difference = std::max(largest(magnitudes(face.found.max - expected.max)),
                                       largest(magnitudes(face.found.rms - expected.rms)));
        }
    }

    void judge_lines() {
        std::vector<bool> used(found_.lines.size(), false);
        for (const PlannedPath& path : plan_.paths) {
            if (path.kind == PathKind::datum_line) {
                const std::optional<std::size_t> i = line_near(path, used);
                if (i) {
                    used[*i] = true;
                    report_.lines.push_back(judge_line(found_.lines[*i], &path));
                } else {
                    ++report_.lines_missing;
                }
            }
        }
        for (std::size_t i = 0; i < used.size(); ++i) {
            if (!used[i]) {
                report_.lines.push_back(judge_line(found_.lines[i], nullptr));
                ++report_.lines_extra;
            }
        }
    }

    [[nodiscard]] std::optional<std::size_t> line_near(const PlannedPath& path, const std::vector<bool>& used) const {
        std::optional<std::size_t> best;
        double least = radius_;
        for (std::size_t i = 0; i < found_.lines.size(); ++i) {
            const FoundLine& line = found_.lines[i];
            const double distance = apart(0.5 * (line.from.v + line.to.v), path.centre.v);
            if (!used[i] && same_face(line.face_deg, path.face_deg) && distance <= least) {
                least = distance;
                best = i;
            }
        }
        return best;
    }

    LineAccuracy judge_line(const FoundLine& line, const PlannedPath* path) const {
        LineAccuracy out;
        out.found = line;
        std::vector<Vec3> measured;
        for (const TableRow& row : table_.rows) {
            if (same_face(row.face_deg, line.face_deg)) {
                measured.push_back(row.measured.v);
            }
        }
        if (!measured.empty()) {
            const FacePlane plane = fit_plane(measured);
            for (const Vec3& end : {line.from.v, line.to.v}) {
                out.plane_distance = std::max(out.plane_distance, std::abs(end.y - plane.depth(end.x, end.z)));
            }
        }
        if (path != nullptr) {
            out.command_error = distance_from(*path, line);
        }
        return out;
    }

    static double distance_from(const PlannedPath& path, const FoundLine& line) {
        const Vec3 way = path.to.v - path.from.v;
        const Vec3 direction = (1.0 / norm(way)) * way;
        double worst = 0.0;
        for (const Vec3& end : {line.from.v, line.to.v}) {
            const Vec3 off = end - path.from.v;
            worst = std::max(worst, norm(off - dot(off, direction) * direction));
        }
        return worst;
    }

    [[nodiscard]] bool is_planned(double face_deg) const {
        return std::ranges::any_of(plan_.faces, [&](double planned) { return same_face(planned, face_deg); });
    }

    [[nodiscard]] bool is_complete() const {
        bool complete = report_.crosses_elsewhere == 0 && report_.lines_missing == 0 && report_.lines_extra == 0 &&
                        found_.alone.empty();
        for (const FaceAccuracy& face : report_.faces) {
            const auto planned = static_cast<std::size_t>(std::ranges::count_if(plan_.paths, [&](const PlannedPath& p) {
                return p.kind == PathKind::cross_horizontal && same_face(p.face_deg, face.face_deg);
            }));
            complete = complete && face.points.size() == planned && face.unmatched.empty() && face.ambiguous.empty();
        }
        return complete;
    }

    const BurnFindings& found_;
    const VerificationTable& table_;
    const JobPlan& plan_;
    const MachineTruth truth_;
    const Compensation compensation_;
    const bool lists_errors_;
    const double radius_;
    std::vector<ErrorSample> samples_;
    AccuracyReport report_;
};

}  // namespace

AccuracyReport assess(const BurnFindings& found, const VerificationTable& table, const JobPlan& plan,
                      const TraceHeader& header, const CalibrationSet& calibration, double match_radius) {
    return Assessor(found, table, plan, header, calibration, match_radius).run();
}

std::vector<double> face_angles(const VerificationTable& table) {
    std::vector<double> angles;
    for (const TableRow& row : table.rows) {
        if (std::ranges::none_of(angles, [&](double a) { return same_face(a, row.face_deg); })) {
            angles.push_back(row.face_deg);
        }
    }
    return angles;
}

}  // namespace sc::host
