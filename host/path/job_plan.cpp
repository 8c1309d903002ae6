// SPDX-License-Identifier: Apache-2.0
#include "host/path/job_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/calibration/transforms.hpp"
#include "host/formats/error.hpp"
#include "host/path/check.hpp"
#include "host/path/face_places.hpp"
#include "host/path/free_path.hpp"
#include "host/path/line_width.hpp"
#include "host/path/look_plan.hpp"
#include "host/path/plane.hpp"
#include "host/path/profile.hpp"
#include "host/path/route.hpp"
#include "host/path/split_path.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host {

namespace {

constexpr double kShortestDatumLine = 0.060;
constexpr double kLongestArc = 4.0;  ///< rad, of one item

std::int32_t wire(double metres) { return static_cast<std::int32_t>(std::llround(metres * kWireUnitsPerMetre)); }
PathPoint wire_point(const Vec3& place) { return {wire(place.x), wire(place.y), wire(place.z)}; }

MoveLimits limits_of(const AxisConfig& axis) { return {axis.speed, axis.acceleration, axis.jerk}; }

class Planner {
public:
    Planner(const Job& job, const VerificationTable& table, const CalibrationSet& calibration,
            const MachineConfig& machine, const PlanOptions& options)
        : job_(job),
          table_(table),
          calibration_(calibration),
          machine_(machine),
          options_(options),
          compensation_(compensation_of(calibration)) {
        const auto home = [&machine](Axis axis) { return machine.axis[index(axis)].home_position; };
        at_ = {home(Axis::x), home(Axis::y), home(Axis::z)};
        c_ = home(Axis::c);
    }

    JobPlan run() {
        for (const JobFace& face : job_.faces) {
            if (!options_.face || same_face(*options_.face, face.angle_deg)) {
                plan_face(face);
            }
        }
        for (const JobPath& path : job_.paths) {
            const bool planned =
                std::ranges::any_of(plan_.faces, [&](double face) { return same_face(face, path.face_deg); });
            if (!planned && (!options_.face || same_face(*options_.face, path.face_deg))) {
                turn_to(path.face_deg, path.line);
                plan_.faces.push_back(path.face_deg);
                add_free_paths(path.face_deg);
            }
        }
        if (plan_.faces.empty()) {
            refuse_filter();
        }
        flush_split();
        retract();
        plan_.items.emplace_back(JobEnd{});
        plan_.hash = job_hash(plan_.items);
        if (job_.surface && calibration_.y_sensor) {
            add_looks(plan_, *calibration_.y_sensor, job_.surface->look_speed, machine_, compensation_);
        }
        return std::move(plan_);
    }

private:
    [[noreturn]] void refuse_filter() const {
        std::string angles;
        for (const JobFace& face : job_.faces) {
            angles += fmt::format("{}{}", angles.empty() ? "" : ", ", face.angle_deg);
        }
        for (const JobPath& path : job_.paths) {
            angles += fmt::format("{}{}", angles.empty() ? "" : ", ", path.face_deg);
        }
        throw InputError({.file = job_.file.string(),
                          .problem = "the job has no such face",
                          .value = options_.face ? fmt::format("{}", *options_.face) : std::string{},
                          .action = "choose one of: " + angles});
    }

    void plan_face(const JobFace& face) {
        if (!job_.cross && !job_.datum_line) {
            throw InputError({.file = job_.file.string(),
                              .line = face.line,
                              .problem = "nothing is to be burnt on this face",
                              .value = fmt::format("{}", face.angle_deg),
                              .action = "add a [cross] or a [datum_line] to the job"});
        }
        if (face.datum_line && !job_.datum_line) {
            throw InputError({.file = job_.file.string(),
                              .line = face.datum_line->line,
                              .problem = "a line is given, but not how to burn it",
                              .value = {},
                              .action = "add a [datum_line] to the job"});
        }
        const FacePlaces places = face_places(job_, face, table_, calibration_, machine_, options_.points_from_table);
        turn_to(face.angle_deg, face.line);
        plan_.faces.push_back(face.angle_deg);
        std::vector<Vec3> centres;
        for (const MarkerPlace& marker : places.markers) {
            centres.push_back(marker.place.v);
        }
        const FacePlane plane = fit_plane(centres);
        if (job_.cross) {
            refuse_wide_cross();
            for (const std::size_t i : nearest_first(at_, centres)) {
                add_cross(face, places.markers[i], plane);
            }
        }
        if (job_.datum_line) {
            add_datum_line(face, places, plane);
        }
        add_free_paths(face.angle_deg);
    }

    void add_free_paths(double face_deg) {
        for (const JobPath& path : job_.paths) {
            if (same_face(path.face_deg, face_deg)) {
                add_path(free_path(job_, path, path_places(job_, path, calibration_, machine_)));
            }
        }
    }

    void turn_to(double face_deg, int line) {
        flush_split();
        const AxisConfig& axis = machine_.axis[index(Axis::c)];
        double best = std::numeric_limits<double>::infinity();
        for (int turns = -20; turns <= 20; ++turns) {
            const double c = c_of_face(face_deg) + 360.0 * turns;
            if (c >= axis.travel_min && c <= axis.travel_max && std::abs(c - c_) < std::abs(best - c_)) {
                best = c;
            }
        }
        if (!std::isfinite(best)) {
            throw InputError({.file = job_.file.string(),
                              .line = line,
                              .problem = "the turntable cannot reach this face",
                              .value = fmt::format("{}", face_deg),
                              .action = fmt::format("use faces whose C = -angle, give or take whole turns, is within "
                                                    "{} to {} degrees",
                                                    axis.travel_min, axis.travel_max)});
        }
        retract();
        plan_.items.emplace_back(Turn{static_cast<std::int32_t>(std::llround(best * kWireUnitsPerDegree))});
        plan_.expected_seconds_estimate += move_time(best - c_, limits_of(axis));
        c_ = best;
    }

    void retract() {
        const double up = machine_.y_retracted.si();
        if (at_.y < up) {
            plan_.expected_seconds_estimate += move_time(up - at_.y, limits_of(machine_.axis[index(Axis::y)]));
            at_.y = up;
        }
    }

    void refuse_wide_cross() const {
        if (job_.cross->settings.width.si() > 0.0) {
            throw InputError({.file = job_.file.string(),
                              .problem = "a cross is measured, so it has one stroke each way",
                              .value = fmt::format("width {:.6g} um", 1e6 * job_.cross->settings.width.si()),
                              .action = "take width_um out of [cross]"});
        }
    }

    void add_cross(const JobFace& face, const MarkerPlace& marker, const FacePlane& plane) {
        const double half = 0.5 * job_.cross->size.si();
        const Vec3 c = marker.place.v;
        const Vec3 along_x{half, half * plane.slope_x, 0.0};
        const Vec3 along_z{0.0, half * plane.slope_z, half};
        const StrokeOrder order = order_pair(at_, {c - along_x, c + along_x}, {c - along_z, c + along_z});
        PlannedPath path{.face_deg = face.angle_deg,
                         .kind = order.swapped ? PathKind::cross_vertical : PathKind::cross_horizontal,
                         .marker = marker.no,
                         .centre = marker.place,
                         .from = {order.first.from},
                         .to = {order.first.to},
                         .settings = job_.cross->settings,
                         .source = marker.source};
        add_path(path);
        path.kind = order.swapped ? PathKind::cross_horizontal : PathKind::cross_vertical;
        path.from = {order.second.from};
        path.to = {order.second.to};
        add_path(path);
    }

    void add_datum_line(const JobFace& face, const FacePlaces& places, const FacePlane& plane) {
        const bool given = places.line.has_value();
        const Source source = given ? places.line->source : Source{job_.file, face.line};
        const Stroke line = given ? Stroke{places.line->from.v, places.line->to.v} : fitted_line(source, plane);
        const double length = norm(line.to - line.from);
        if (length < kShortestDatumLine - 1e-9) {
            throw InputError({.file = source.file.string(),
                              .line = source.line,
                              .problem = "the datum line is too short to align a workpiece by",
                              .value = fmt::format("{:.3f} mm", 1e3 * length),
                              .action = fmt::format("make it {:.6g} mm or longer", 1e3 * kShortestDatumLine)});
        }
        const Stroke ordered = nearer_end_first(at_, line);
        const bool wide = job_.datum_line->settings.width.si() > 0.0;
        add_path({.face_deg = face.angle_deg,
                  .kind = wide ? PathKind::free_path : PathKind::datum_line,
                  .marker = 0,
                  .centre = {0.5 * (line.from + line.to)},
                  .from = {ordered.from},
                  .to = {ordered.to},
                  .settings = job_.datum_line->settings,
                  .source = source,
                  .name = wide ? fmt::format("datum line of face {}", face.angle_deg) : std::string{}});
    }

    /// On the plane, at the centroid's z, centred there, but moved along x so that it and its run-in stay in travel.
    Stroke fitted_line(const Source& source, const FacePlane& plane) const {
        const AxisConfig& x = machine_.axis[index(Axis::x)];
        const double half = 0.5 * job_.datum_line->length.si();
        const MarkSettings& settings = job_.datum_line->settings;
        // Compensation may move a set-point a little: keep that much more.
        const double spare =
            settings.actuator == Actuator::axes ? run_in_length({1.0, 0.0, 0.0}, settings, machine_) + 0.5e-3 : 0.0;
        const double first = x.travel_min + half + spare;
        const double last = x.travel_max - half - spare;
        if (first > last) {
            throw InputError({.file = source.file.string(),
                              .line = source.line,
                              .problem = "the datum line with its run-in is longer than the travel of x",
                              .value = fmt::format("{:.6g} mm", 2e3 * half),
                              .action = fmt::format("make it {:.3f} mm or shorter",
                                                    1e3 * (x.travel_max - x.travel_min - 2.0 * spare))});
        }
        const double middle = std::min(std::max(plane.centroid.x, first), last);
        const auto end = [&plane](double at_x) {
            return Vec3{at_x, plane.depth(at_x, plane.centroid.z), plane.centroid.z};
        };
        return {end(middle - half), end(middle + half)};
    }

    void add_path(PlannedPath path) {
        path.id = static_cast<std::uint32_t>(plan_.paths.size());
        widen(path);
        const std::vector<std::vector<Piece>> strokes = strokes_of(path);
        for (const std::vector<Piece>& stroke : strokes) {
            const PlannedPath one = stroke_of(path, stroke);
            check_places(one, machine_, compensation_);
            path.pick = check_settings(one, job_, machine_);
        }
        if (calibration_.beam) {
            check_depth(path, *calibration_.beam);
        }
        take_pulse_width(path);
        if (!split_.empty() && !(split_.front().settings == path.settings)) {
            flush_split();
        }
        if (path.settings.actuator == Actuator::split) {
            plan_.paths.push_back(path);
            split_.push_back(std::move(path));
            return;
        }
        path.first_item = plan_.items.size();
        std::uint8_t number = 0;
        for (std::uint8_t pass = 0; pass < path.settings.passes; ++pass) {
            for (const std::vector<Piece>& stroke : strokes) {
                add_pass(path, stroke, number++);
                count(path, stroke);
            }
        }
        path.item_count = plan_.items.size() - path.first_item;
        plan_.paths.push_back(std::move(path));
    }

    /// The strokes of a wide line.
    void widen(PlannedPath& path) const {
        if (!(path.settings.width.si() > 0.0)) {
            return;
        }
        try {
            Strokes strokes = strokes_of(pieces_of(path), path.settings);
            path.strokes = std::move(strokes.pieces);
            path.settings.tolerance = Length::from_si(strokes.tolerance);
        } catch (const LineWidthError& error) {
            throw InputError({.file = path.source.file.string(),
                              .line = error.line != 0 ? error.line : path.source.line,
                              .problem = fmt::format("path \"{}\": {}", path.name, error.what()),
                              .value = error.value,
                              .action = error.action});
        }
    }

    /// One stroke of a wide line, or the line, as a path.
    static PlannedPath stroke_of(const PlannedPath& path, const std::vector<Piece>& stroke) {
        PlannedPath one = path;
        one.strokes.clear();
        one.pieces = stroke;
        one.from = {stroke.front().from};
        one.to = {stroke.back().to};
        return one;
    }

    /// Lines with the same split settings, one after the other: one path, dark between them.
    void flush_split() {
        if (split_.empty()) {
            return;
        }
        std::vector<Stroke3> strokes;
        double marked = 0.0;
        std::uint64_t pulses = 0;
        const PlannedPath first = split_.front();
        const MarkSettings& s = first.settings;
        for (const PlannedPath& path : split_) {
            for (std::vector<Piece>& stroke : strokes_of(path)) {
                marked += host::length(stroke);
                pulses += pulses_on(host::length(stroke), s);
                strokes.push_back(std::move(stroke));
            }
        }
        const double depth =
            calibration_.beam ? calibration_.beam->depth_within(s.fluence_tolerance) : GalvoField::kDepthMost;
        const StrokePath made = split_path(begin_of(first, 0), strokes, machine_, depth);
        refuse_split(first, made);
        const std::size_t first_item = plan_.items.size();
        for (std::uint8_t pass = 0; pass < s.passes; ++pass) {
            plan_.items.insert(plan_.items.end(), made.items.begin(), made.items.end());
            std::get<PathBegin>(plan_.items[plan_.items.size() - made.items.size()]).pass = pass;
            const double speed = std::get<PathBegin>(made.items.front()).speed_um_s * 1e-6;
            plan_.expected_seconds_estimate += way_to(made.stage.control.front()) + made.length / speed +
                                               1e-9 * static_cast<double>(machine_.settle_ns);
            plan_.marked_metres += marked;
            plan_.expected_pulses += pulses;
            at_ = made.stage.control.back();
        }
        const std::size_t count = plan_.items.size() - first_item;
        for (std::size_t i = plan_.paths.size() - split_.size(); i < plan_.paths.size(); ++i) {
            plan_.paths[i].id = first.id;
            plan_.paths[i].first_item = first_item;
            plan_.paths[i].item_count = count;
        }
        split_.clear();
    }

    void refuse_split(const PlannedPath& path, const StrokePath& made) const {
        const StageFit& stage = made.stage;
        if (stage.worst > 1.0 + kStageSlack) {
            throw InputError(
                {.file = path.source.file.string(),
                 .line = path.source.line,
                 .problem = stage.by_reach
                                ? "split: the mirrors do not reach from where the stage can be in time"
                                : "split: the stage cannot move as its lines want it to, even at a quarter of "
                                  "their speed",
                 .value = fmt::format("{:.0f} % of what is possible, {:.1f} mm along the path", 100.0 * stage.worst,
                                      1e3 * stage.worst_distance),
                 .action = "give the lines in an order in which neighbours are nearer, mark slower, or use actuator "
                           "\"galvo\""});
        }
        for (std::size_t i = 1; i < stage.control.size(); ++i) {
            for (std::size_t k = 0; k < std::min<std::size_t>(machine_.keep_out_count, kKeepOutCapacity); ++k) {
                if (meets(machine_.keep_out[k], stage.control[i - 1], stage.control[i])) {
                    throw InputError({.file = path.source.file.string(),
                                      .line = path.source.line,
                                      .problem = fmt::format("split: the stage's way meets keep-out volume {}", k),
                                      .value = fmt::format("z = {:.3f} mm", 1e3 * stage.control[i].z),
                                      .action = "use actuator \"galvo\" for these lines"});
                }
            }
        }
    }

    void take_pulse_width(const PlannedPath& path) {
        const std::uint16_t width = path.settings.pulse_width_ns;
        if (!plan_.paths.empty() && width != plan_.pulse_width_ns) {
            throw InputError({.file = job_.file.string(),
                              .problem = "the paths of a job ask for different pulse widths",
                              .value = std::to_string(plan_.pulse_width_ns) + " and " + std::to_string(width) + " ns",
                              .action = "give every path the same pulse_width_ns, or make two jobs of it"});
        }
        plan_.pulse_width_ns = width;
    }

    static PathBegin begin_of(const PlannedPath& path, std::uint8_t pass) {
        const auto whole = [](double value) { return static_cast<std::uint32_t>(std::llround(value)); };
        const MarkSettings& s = path.settings;
        return {.path = path.id,
                .actuator = s.actuator,
                .pass = pass,
                .speed_um_s = whole(1e6 * s.speed.si()),
                .pitch_nm = whole(1e9 * s.pitch.si()),
                .energy_nj = whole(1e9 * s.energy.si()),
                .tolerance_nm = whole(1e9 * s.tolerance.si())};
    }

    void add_pass(const PlannedPath& path, const std::vector<Piece>& pieces, std::uint8_t pass) {
        const MarkSettings& s = path.settings;
        PathBegin begin = begin_of(path, pass);
        if (s.actuator == Actuator::galvo) {
            const PathPoint anchor = wire_point(path.centre.v);
            begin.anchor_x = anchor.x;
            begin.anchor_y = anchor.y;
            begin.anchor_z = anchor.z;
        }
        plan_.items.emplace_back(begin);
        plan_.items.emplace_back(wire_point(pieces.front().from));
        for (const Piece& piece : pieces) {
            add_piece(piece);
        }
        plan_.items.emplace_back(PathEnd{});
    }

    void add_piece(const Piece& piece) {
        if (!piece.circle) {
            plan_.items.emplace_back(wire_point(piece.to));
            return;
        }
        // The middle as via keeps the circle best through rounding; almost a whole circle is two arcs for its sake.
        const int parts = piece.circle->angle > kLongestArc ? 2 : 1;
        for (int part = 1; part <= parts; ++part) {
            const Vec3 to = part == parts ? piece.to : piece.at(0.5);
            plan_.items.emplace_back(PathArc{wire_point(piece.at((part - 0.5) / parts)), wire_point(to)});
        }
    }

    static std::uint64_t pulses_on(double length, const MarkSettings& settings) {
        return static_cast<std::uint64_t>(std::floor(length / settings.pitch.si() + 1e-9)) + 1;
    }
    [[nodiscard]] double way_to(const Vec3& place) const {
        double way = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            way = std::max(way, move_time(place[i] - at_[i], limits_of(machine_.axis[i])));
        }
        return way;
    }

    /// Adds one pass to the sums. The way there: all axes at once, the slowest counts.
    void count(const PlannedPath& path, const std::vector<Piece>& pieces) {
        const MarkSettings& s = path.settings;
        const double length = host::length(pieces);
        const Vec3 direction = pieces.front().direction(0.0);
        const Vec3 last = pieces.back().direction(1.0);
        const bool galvo = s.actuator == Actuator::galvo;
        const double run_in = speed_up_distance(s.speed.si(), limits_along(direction, s.actuator, machine_));
        const Vec3 start = galvo ? path.centre.v : pieces.front().from - run_in * direction;
        const double way = way_to(start);
        const double settle = galvo && way > 0.0 ? 1e-9 * static_cast<double>(machine_.settle_ns) : 0.0;
        const double mark = length / s.speed.si() + 4.0 * run_in / s.speed.si();
        plan_.expected_seconds_estimate += way + settle + mark;
        plan_.marked_metres += length;
        plan_.expected_pulses += pulses_on(length, s);
        at_ = galvo ? path.centre.v : pieces.back().to + run_in * last;
    }

    const Job& job_;
    const VerificationTable& table_;
    const CalibrationSet& calibration_;
    const MachineConfig& machine_;
    const PlanOptions& options_;
    const Compensation compensation_;
    JobPlan plan_;
    std::vector<PlannedPath> split_;  ///< planned last, and not yet in the items
    Vec3 at_;
    double c_ = 0.0;
};

}  // namespace

std::string_view name_of(PathKind kind) noexcept {
    switch (kind) {
        case PathKind::cross_horizontal: return "cross_horizontal";
        case PathKind::cross_vertical: return "cross_vertical";
        case PathKind::datum_line: return "datum_line";
        case PathKind::free_path: return "path";
    }
    return "?";
}

std::vector<Piece> pieces_of(const PlannedPath& path) {
    return path.pieces.empty() ? std::vector<Piece>{{path.from.v, path.to.v, std::nullopt, 0}} : path.pieces;
}

std::vector<std::vector<Piece>> strokes_of(const PlannedPath& path) {
    return path.strokes.empty() ? std::vector<std::vector<Piece>>{pieces_of(path)} : path.strokes;
}

JobPlan plan_job(const Job& job, const VerificationTable& table, const CalibrationSet& calibration,
                 const MachineConfig& machine, const PlanOptions& options) {
    return Planner(job, table, calibration, machine, options).run();
}

}  // namespace sc::host
