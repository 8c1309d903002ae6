// SPDX-License-Identifier: Apache-2.0
#include "host/path/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/formats/error.hpp"
#include "host/path/curve.hpp"
#include "shared/machine/galvo_field.hpp"

namespace sc::host {

namespace {

constexpr std::array<char, 3> kAxisLetter{'x', 'y', 'z'};
constexpr double kRatioSlack = 1e-9;
constexpr double kPowerSteps = 255.0;
constexpr double kStraightError = 10e-6;  ///< metres
constexpr double kSmallestPitch = 1e-9;   ///< metres; the wire's unit

std::string what(const PlannedPath& path) {
    if (path.kind == PathKind::free_path) {
        return fmt::format("path \"{}\" of face {}", path.name, path.face_deg);
    }
    return path.kind == PathKind::datum_line
               ? fmt::format("datum line of face {}", path.face_deg)
               : fmt::format("{} of marker {} on face {}", name_of(path.kind), path.marker, path.face_deg);
}

[[noreturn]] void refuse_place(const PlannedPath& path, std::string problem, std::string value, std::string action) {
    throw InputError({.file = path.source.file.string(),
                      .line = path.source.line,
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

[[noreturn]] void refuse_setting(const Job& job, std::string problem, std::string value, std::string action) {
    throw InputError({.file = job.file.string(),
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

/// What a refusal names of a path whose place stands in this line.
PlannedPath at_line(const PlannedPath& path, int line) {
    PlannedPath named;
    named.id = path.id;
    named.face_deg = path.face_deg;
    named.kind = path.kind;
    named.marker = path.marker;
    named.centre = path.centre;
    named.name = path.name;
    named.source = {path.source.file, line > 0 ? line : path.source.line};
    return named;
}

/// The piece in straight steps that stay within kStraightError of it.
std::vector<Vec3> straight_steps(const Piece& piece) {
    std::vector<Vec3> places{piece.from};
    if (piece.circle) {
        const double ratio = std::min(1.0, kStraightError / piece.circle->radius());
        const auto count = static_cast<int>(std::ceil(piece.circle->angle / (2.0 * std::acos(1.0 - ratio))));
        for (int i = 1; i < count; ++i) {
            places.push_back(piece.at(static_cast<double>(i) / count));
        }
    }
    places.push_back(piece.to);
    return places;
}

/// The places of an arc at which a set-point of the axes, or of the mirrors, turns back.
std::vector<Vec3> extremes(const Piece& piece, const Mat3& mapped) {
    std::vector<Vec3> places;
    if (piece.circle) {
        const Circle& circle = *piece.circle;
        for (const double phi : turning_angles(mapped * circle.first, mapped * circle.second, circle.angle)) {
            places.push_back(circle.at(phi));
        }
    }
    return places;
}

void check_travel(const PlannedPath& path, const Vec3& place, const MachineConfig& machine,
                  const Compensation& compensation, std::string_view part) {
    const Vec3 set_point = compensation.axis_from_h * place + compensation.axis_offset;
    for (std::size_t i = 0; i < 3; ++i) {
        const AxisConfig& axis = machine.axis[i];
        if (set_point[i] < axis.travel_min || set_point[i] > axis.travel_max) {
            refuse_place(
                path, fmt::format("{}: {} is out of the travel of {}", what(path), part, kAxisLetter[i]),
                fmt::format("{:.3f} mm", 1e3 * place[i]),
                fmt::format("keep {} within {:.3f} to {:.3f} mm, or burn it with another face before the laser",
                            kAxisLetter[i], 1e3 * axis.travel_min, 1e3 * axis.travel_max));
        }
    }
}

void check_field(const PlannedPath& path, const Vec3& end, const MachineConfig& machine,
                 const Compensation& compensation) {
    const Vec3 offset = end - path.centre.v;
    const auto& m = compensation.galvo_from_field;
    const std::array<double, 2> command{m[0] * offset.x + m[1] * offset.z + compensation.galvo_offset[0],
                                        m[2] * offset.x + m[3] * offset.z + compensation.galvo_offset[1]};
    const double half = machine.galvo.half_field.si();
    const double largest = std::max(std::abs(command[0]), std::abs(command[1]));
    if (largest > half) {
        refuse_place(
            path, fmt::format("{}: leaves the galvo's field, run-in included", what(path)),
            fmt::format("{:.3f} mm from its centre", 1e3 * largest),
            fmt::format("make it smaller (the field is {:.3f} mm either way), or use actuator \"axes\"", 1e3 * half));
    }
    if (!(std::abs(offset.y) <= GalvoField::kDepthMost)) {
        refuse_place(path, fmt::format("{}: its depth changes too much for the galvo", what(path)),
                     fmt::format("{:.3f} mm from its centre", 1e3 * std::abs(offset.y)),
                     fmt::format("keep y within {:.3f} mm of its centre, or use actuator \"axes\"",
                                 1e3 * GalvoField::kDepthMost));
    }
}

void check_keep_out(const PlannedPath& path, const Vec3& from, const Vec3& to, const MachineConfig& machine,
                    double margin = 0.0) {
    const std::size_t count = std::min<std::size_t>(machine.keep_out_count, kKeepOutCapacity);
    for (std::size_t i = 0; i < count; ++i) {
        const KeepOut& box = machine.keep_out[i];
        const Vec3 slack{margin, margin, margin};
        if (meets({box.min - slack, box.max + slack}, from, to)) {
            const Vec3 at = path.kind == PathKind::free_path ? 0.5 * (from + to) : path.centre.v;
            refuse_place(
                path, fmt::format("{}: meets keep-out volume {}", what(path), i),
                fmt::format("({:.3f}, {:.3f}, {:.3f}) mm", 1e3 * at.x, 1e3 * at.y, 1e3 * at.z),
                fmt::format("stay out of ({:.3f}, {:.3f}, {:.3f}) to ({:.3f}, {:.3f}, {:.3f}) mm", 1e3 * box.min.x,
                            1e3 * box.min.y, 1e3 * box.min.z, 1e3 * box.max.x, 1e3 * box.max.y, 1e3 * box.max.z));
        }
    }
}

/// How fast a circle can be followed at all.
double speed_on(const Piece& piece, const MoveLimits& limits) {
    const double radius = piece.circle->radius();
    return std::min(std::sqrt(limits.acceleration * radius), std::cbrt(limits.jerk * radius * radius));
}

void check_speed(const PlannedPath& path, const std::vector<Piece>& pieces, const Job& job,
                 const MachineConfig& machine) {
    const double speed = path.settings.speed.si();
    const double least = machine.laser.mark_speed_min.si();
    double limit = std::numeric_limits<double>::max();
    for (const Piece& piece : pieces) {
        const MoveLimits limits = limits_along(piece.steepest(), path.settings.actuator, machine);
        limit = std::min(limit, limits.speed);
        if (piece.circle && speed_on(piece, limits) < least) {
            refuse_place(
                at_line(path, piece.line),
                fmt::format("{}: an arc is too small to be followed at the laser's least marking speed", what(path)),
                fmt::format("radius {:.6g} mm", 1e3 * piece.circle->radius()), "make its radius larger");
        }
    }
    if (speed > limit * (1.0 + kRatioSlack)) {
        refuse_setting(job, fmt::format("{}: speed is above the limit of its actuator", what(path)),
                       fmt::format("{:.6g} mm/s", 1e3 * speed), fmt::format("use {:.6g} mm/s or less", 1e3 * limit));
    }
    if (!(speed >= least)) {
        refuse_setting(job, fmt::format("{}: speed is below the laser's least marking speed", what(path)),
                       fmt::format("{:.6g} mm/s", 1e3 * speed), fmt::format("use {:.6g} mm/s or more", 1e3 * least));
    }
}

std::uint8_t check_rate(const PlannedPath& path, double path_length, const Job& job, const LaserConfig& laser) {
    const double pitch = path.settings.pitch.si();
    if (!(pitch >= kSmallestPitch)) {
        refuse_setting(job, fmt::format("{}: pitch is too small", what(path)), fmt::format("{:.6g} mm", 1e3 * pitch),
                       "use at least 1 nm");
    }
    if (path_length < pitch) {
        refuse_setting(job, fmt::format("{}: it is shorter than the distance between two pulses", what(path)),
                       fmt::format("{:.6g} mm", 1e3 * path_length), "make it longer, or the pitch smaller");
    }
    const double rate = path.settings.speed.si() / pitch;
    const double pick = std::max(1.0, std::ceil(laser.prr_min.si() / rate * (1.0 - kRatioSlack)));
    if (pick * rate > laser.prr_nominal.si() * (1.0 + kRatioSlack) ||
        pick > static_cast<double>(std::numeric_limits<std::uint8_t>::max())) {
        refuse_setting(
            job, fmt::format("{}: speed / pitch gives a pulse rate that the laser cannot make", what(path)),
            fmt::format("{:.6g} Hz", rate),
            fmt::format("choose speed and pitch so that speed / pitch, or it times a whole number up to 255, "
                        "is within {} to {} kHz",
                        1e-3 * laser.prr_min.si(), 1e-3 * laser.prr_nominal.si()));
    }
    return static_cast<std::uint8_t>(pick);
}

void check_energy(const PlannedPath& path, const Job& job, const LaserConfig& laser, std::uint8_t pick) {
    const double source_rate = path.settings.speed.si() / path.settings.pitch.si() * pick;
    const double most = laser.power.si() / source_rate;
    const double energy = path.settings.energy.si();
    if (energy > most * (1.0 + kRatioSlack)) {
        refuse_setting(job, fmt::format("{}: pulse energy is above what the laser gives at its rate", what(path)),
                       fmt::format("{:.6g} uJ", 1e6 * energy),
                       fmt::format("use {:.4g} uJ or less ({:.4g} W at {:.4g} kHz), or a lower speed / pitch",
                                   1e6 * most, laser.power.si(), 1e-3 * source_rate));
    }
    if (!(energy * kPowerSteps >= 0.5 * most)) {
        refuse_setting(job, fmt::format("{}: pulse energy is below the smallest step of the laser's power", what(path)),
                       fmt::format("{:.6g} uJ", 1e6 * energy),
                       fmt::format("use {:.4g} uJ or more", 1e6 * most / kPowerSteps));
    }
}

}  // namespace

MoveLimits limits_along(const Vec3& direction, Actuator actuator, const MachineConfig& machine) {
    constexpr double kNone = std::numeric_limits<double>::max();
    MoveLimits least{kNone, kNone, kNone};
    const auto take = [&least](double part, double speed, double acceleration, double jerk) {
        const double share = std::abs(part);
        if (share > 1e-9) {
            least = {std::min(least.speed, speed / share), std::min(least.acceleration, acceleration / share),
                     std::min(least.jerk, jerk / share)};
        }
    };
    for (std::size_t i = 0; i < 3; ++i) {
        if (actuator == Actuator::axes) {
            take(direction[i], machine.axis[i].speed, machine.axis[i].acceleration, machine.axis[i].jerk);
        } else if (i != index(Axis::y)) {
            take(direction[i], machine.galvo.speed.si(), machine.galvo.acceleration.si(), machine.galvo.jerk.si());
        }
    }
    return least;
}

double run_in_length(const Vec3& direction, const MarkSettings& settings, const MachineConfig& machine) {
    const MoveLimits limits = limits_along(direction, settings.actuator, machine);
    const double spare = settings.actuator == Actuator::axes ? 0.5e-3 : 0.1e-3;
    return 1.25 * speed_up_distance(settings.speed.si(), limits) + spare;
}

bool meets(const KeepOut& box, const Vec3& from, const Vec3& to) noexcept {
    double enter = 0.0;
    double leave = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double way = to[i] - from[i];
        if (way == 0.0) {
            if (from[i] < box.min[i] || from[i] > box.max[i]) {
                return false;
            }
            continue;
        }
        const double a = (box.min[i] - from[i]) / way;
        const double b = (box.max[i] - from[i]) / way;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

std::uint8_t check_settings(const PlannedPath& path, const Job& job, const MachineConfig& machine) {
    const std::vector<Piece> pieces = pieces_of(path);
    check_speed(path, pieces, job, machine);
    const std::uint8_t pick = check_rate(path, length(pieces), job, machine.laser);
    check_energy(path, job, machine.laser, pick);
    return pick;
}

void check_depth(const PlannedPath& path, const BeamRecord& beam) {
    if (path.settings.actuator != Actuator::galvo) {
        return;  // y follows the surface
    }
    const double tolerance = path.settings.fluence_tolerance;
    const double window = beam.depth_within(tolerance);
    for (const std::vector<Piece>& stroke : strokes_of(path)) {
        for (const Piece& piece : stroke) {
            const Bounds bounds = bounds_of(piece);
            const double off = std::max(bounds.high.y - path.centre.v.y, path.centre.v.y - bounds.low.y);
            if (off > window) {
                refuse_place(at_line(path, piece.line),
                             fmt::format("{}: the surface leaves the depth in which the fluence stays within {:.4g} %",
                                         what(path), 100.0 * tolerance),
                             fmt::format("{:.3f} mm off focus", 1e3 * off),
                             fmt::format("keep y within {:.3f} mm of its middle, raise fluence_tolerance_pct, or use "
                                         "actuator \"axes\", where y follows the surface",
                                         1e3 * window));
            }
        }
    }
}

void check_places(const PlannedPath& path, const MachineConfig& machine, const Compensation& compensation) {
    const std::vector<Piece> pieces = pieces_of(path);
    const Vec3 first = pieces.front().direction(0.0);
    const Vec3 last = pieces.back().direction(1.0);
    const double run_in = run_in_length(first, path.settings, machine);
    const double run_out = run_in_length(last, path.settings, machine);
    const Vec3 start = path.from.v - run_in * first;
    const Vec3 stop = path.to.v + run_out * last;
    const bool galvo = path.settings.actuator == Actuator::galvo;
    const bool split = path.settings.actuator == Actuator::split;
    const auto check = [&](const PlannedPath& named, const Vec3& place, std::string_view part) {
        if (galvo) {
            check_field(named, place, machine, compensation);
        } else if (!split) {
            check_travel(named, place, machine, compensation, part);
        }
    };
    if (galvo) {
        check_travel(path, path.centre.v, machine, compensation, "its centre");
    } else if (!split) {
        check_travel(path, path.from.v, machine, compensation, "its start");
    }
    const auto& m = compensation.galvo_from_field;
    const Mat3 field{{Vec3{m[0], 0.0, m[1]}, Vec3{}, Vec3{m[2], 0.0, m[3]}}};
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const Piece& piece = pieces[i];
        const bool is_last = i + 1 == pieces.size();
        const PlannedPath named = at_line(path, piece.line);
        check(named, piece.to, is_last ? "its end" : fmt::format("place {}", i + 2));
        for (const Vec3& place : extremes(piece, galvo ? field : compensation.axis_from_h)) {
            check(named, place, fmt::format("the arc to place {}", i + 2));
        }
        const std::vector<Vec3> steps = straight_steps(piece);
        for (std::size_t k = 1; k < steps.size(); ++k) {
            check_keep_out(named, steps[k - 1], steps[k], machine, piece.circle ? kStraightError : 0.0);
        }
    }
    check(path, start, fmt::format("its run-in of {:.2f} mm", 1e3 * run_in));
    check(path, stop, fmt::format("its run-out of {:.2f} mm", 1e3 * run_out));
    check_keep_out(path, start, path.from.v, machine);
    check_keep_out(path, path.to.v, stop, machine);
}

void check_look(const PlannedPath& path, const Vec3& from, const Vec3& to, const MachineConfig& machine,
                const Compensation& compensation) {
    check_travel(path, to, machine, compensation, "a place from which the Y sensor looks at it");
    check_keep_out(path, from, to, machine);
}

}  // namespace sc::host
