// SPDX-License-Identifier: Apache-2.0
#include "host/path/plate_plan.hpp"

#include <cmath>

#include <fmt/format.h>

#include "host/formats/error.hpp"
#include "shared/path/job_hash.hpp"
#include "shared/units/quantity.hpp"

namespace sc::host {
namespace {

constexpr std::uint32_t kSpeedUmS = 250'000;
constexpr std::uint32_t kPitchNm = 20'000;
constexpr std::uint32_t kEnergyNj = 300'000;
constexpr double kSecondsACross = 0.06;

[[noreturn]] void refuse(std::string problem, std::string value, std::string action) {
    throw InputError(
        {.file = {}, .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

void check(const PlateOptions& o, const MachineConfig& machine) {
    if (o.side < 5 || o.side > 45) {
        refuse("the grid has too few or too many crosses along an edge", std::to_string(o.side), "choose 5 to 45");
    }
    const double reach = o.half + o.arm;
    if (!(reach <= machine.galvo.half_field.si() + 1e-9)) {
        refuse("the grid leaves the galvo's field", fmt::format("{:.3f} mm", reach * 1e3),
               fmt::format("keep it within {:.3f} mm", machine.galvo.half_field.si() * 1e3));
    }
    const double last = static_cast<double>(o.depths.size()) * o.shift;
    for (const double depth : o.depths) {
        const Vec3 anchor{o.centre.x, o.centre.y - depth, o.centre.z};
        for (std::size_t i = 0; i < 3; ++i) {
            const AxisConfig& axis = machine.axis[i];
            if (!(anchor[i] > axis.travel_min + last + 1e-3 && anchor[i] < axis.travel_max - last - 1e-3)) {
                refuse("the plate is out of the travel of axis " + std::string(1, "xyz"[i]),
                       fmt::format("{:.3f} mm", anchor[i] * 1e3), "move the plate");
            }
        }
    }
}

/// Line i of n, −1 … 1: halfway between equal distances and those of a polynomial's best points.
double line_at(std::size_t i, std::size_t n) {
    const double t = 2.0 * static_cast<double>(i) / static_cast<double>(n - 1) - 1.0;
    return 0.5 * (t + std::sin(0.5 * kPi * t));
}

std::int32_t wire(double metres) { return static_cast<std::int32_t>(std::llround(metres * kWireUnitsPerMetre)); }
double metres(std::int32_t units) { return units / kWireUnitsPerMetre; }

}  // namespace

PlatePlan plan_plate(const PlateOptions& options, const MachineConfig& machine) {
    check(options, machine);
    PlatePlan plan;
    plan.items.emplace_back(Turn{0});
    std::uint32_t path = 0;
    for (std::size_t d = 0; d < options.depths.size(); ++d) {
        // Moved on along the diagonal, so that no cross meets one of another depth.
        const double shift =
            options.shift * (static_cast<double>(d) - 0.5 * static_cast<double>(options.depths.size() - 1));
        PathBegin begin;
        begin.actuator = Actuator::galvo;
        begin.speed_um_s = kSpeedUmS;
        begin.pitch_nm = kPitchNm;
        begin.energy_nj = kEnergyNj;
        begin.anchor_x = wire(options.centre.x + shift);
        begin.anchor_y = wire(options.centre.y - options.depths[d]);
        begin.anchor_z = wire(options.centre.z + shift);
        for (std::size_t j = 0; j < options.side; ++j) {
            for (std::size_t k = 0; k < options.side; ++k) {
                // There and back: short jumps.
                const std::size_t i = j % 2 == 0 ? k : options.side - 1 - k;
                const std::int32_t cx = wire(options.half * line_at(i, options.side));
                const std::int32_t cz = wire(options.half * line_at(j, options.side));
                const std::int32_t arm = wire(options.arm);
                plan.crosses.push_back({static_cast<int>(plan.crosses.size()) + 1,
                                        {metres(cx), metres(cz)},
                                        {metres(begin.anchor_x), metres(begin.anchor_y), metres(begin.anchor_z)}});
                for (const bool along_x : {true, false}) {
                    begin.path = path++;
                    const std::int32_t ax = along_x ? arm : 0;
                    const std::int32_t az = along_x ? 0 : arm;
                    plan.items.emplace_back(begin);
                    // The galvo alone is to be measured: the points lie in the focal plane, whatever the plate does.
                    plan.items.emplace_back(
                        PathPoint{begin.anchor_x + cx - ax, begin.anchor_y, begin.anchor_z + cz - az});
                    plan.items.emplace_back(
                        PathPoint{begin.anchor_x + cx + ax, begin.anchor_y, begin.anchor_z + cz + az});
                    plan.items.emplace_back(PathEnd{});
                }
            }
        }
    }
    plan.items.emplace_back(JobEnd{});
    plan.hash = job_hash(plan.items);
    plan.expected_seconds = 20.0 + kSecondsACross * static_cast<double>(plan.crosses.size());
    return plan;
}

}  // namespace sc::host
