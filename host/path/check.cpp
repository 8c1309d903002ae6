// SPDX-License-Identifier: Apache-2.0
#include "host/path/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/formats/error.hpp"

namespace sc::host {

namespace {

constexpr std::array<char, 3> kAxisLetter{'x', 'y', 'z'};
constexpr double kRatioSlack = 1e-9;
constexpr double kPowerSteps = 255.0;
constexpr double kSmallestPitch = 1e-9;  ///< metres; the wire's unit

std::string what(const PlannedPath& path) {
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

Vec3 direction_of(const PlannedPath& path) {
    const Vec3 way = path.to.v - path.from.v;
    const double length = norm(way);
    return length > 0.0 ? (1.0 / length) * way : Vec3{};
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
}

void check_keep_out(const PlannedPath& path, const Vec3& from, const Vec3& to, const MachineConfig& machine) {
    const std::size_t count = std::min<std::size_t>(machine.keep_out_count, kKeepOutCapacity);
    for (std::size_t i = 0; i < count; ++i) {
        const KeepOut& box = machine.keep_out[i];
        if (meets(box, from, to)) {
            const Vec3 at = path.centre.v;
            refuse_place(
                path, fmt::format("{}: meets keep-out volume {}", what(path), i),
                fmt::format("({:.3f}, {:.3f}, {:.3f}) mm", 1e3 * at.x, 1e3 * at.y, 1e3 * at.z),
                fmt::format("stay out of ({:.3f}, {:.3f}, {:.3f}) to ({:.3f}, {:.3f}, {:.3f}) mm", 1e3 * box.min.x,
                            1e3 * box.min.y, 1e3 * box.min.z, 1e3 * box.max.x, 1e3 * box.max.y, 1e3 * box.max.z));
        }
    }
}

void check_speed(const PlannedPath& path, const Job& job, const MachineConfig& machine) {
    const double speed = path.settings.speed.si();
    const double limit = limits_along(direction_of(path), path.settings.actuator, machine).speed;
    const double least = machine.laser.mark_speed_min.si();
    if (speed > limit * (1.0 + kRatioSlack)) {
        refuse_setting(job, fmt::format("{}: speed is above the limit of its actuator", what(path)),
                       fmt::format("{:.6g} mm/s", 1e3 * speed), fmt::format("use {:.6g} mm/s or less", 1e3 * limit));
    }
    if (!(speed >= least)) {
        refuse_setting(job, fmt::format("{}: speed is below the laser's least marking speed", what(path)),
                       fmt::format("{:.6g} mm/s", 1e3 * speed), fmt::format("use {:.6g} mm/s or more", 1e3 * least));
    }
}

std::uint8_t check_rate(const PlannedPath& path, const Job& job, const LaserConfig& laser) {
    const double pitch = path.settings.pitch.si();
    if (!(pitch >= kSmallestPitch)) {
        refuse_setting(job, fmt::format("{}: pitch is too small", what(path)), fmt::format("{:.6g} mm", 1e3 * pitch),
                       "use at least 1 nm");
    }
    const double path_length = norm(path.to.v - path.from.v);
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
    check_speed(path, job, machine);
    const std::uint8_t pick = check_rate(path, job, machine.laser);
    check_energy(path, job, machine.laser, pick);
    return pick;
}

void check_places(const PlannedPath& path, const MachineConfig& machine, const Compensation& compensation) {
    const Vec3 direction = direction_of(path);
    const double run_in = run_in_length(direction, path.settings, machine);
    const Vec3 start = path.from.v - run_in * direction;
    const Vec3 stop = path.to.v + run_in * direction;
    switch (path.settings.actuator) {
        case Actuator::axes:
            check_travel(path, path.from.v, machine, compensation, "its start");
            check_travel(path, path.to.v, machine, compensation, "its end");
            check_travel(path, start, machine, compensation, fmt::format("its run-in of {:.2f} mm", 1e3 * run_in));
            check_travel(path, stop, machine, compensation, fmt::format("its run-out of {:.2f} mm", 1e3 * run_in));
            break;
        case Actuator::galvo:
            check_travel(path, path.centre.v, machine, compensation, "its centre");
            check_field(path, start, machine, compensation);
            check_field(path, stop, machine, compensation);
            break;
    }
    check_keep_out(path, start, stop, machine);
}

}  // namespace sc::host
