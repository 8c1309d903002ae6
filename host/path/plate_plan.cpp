// SPDX-License-Identifier: Apache-2.0
#include "host/path/plate_plan.hpp"

#include <algorithm>
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
constexpr double kStandShift = 2e-3;  ///< metres

[[noreturn]] void refuse(std::string problem, std::string value, std::string action) {
    throw InputError(
        {.file = {}, .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

void check_side(std::size_t side) {
    if (side < 5 || side > 45) {
        refuse("the grid has too few or too many crosses along an edge", std::to_string(side), "choose 5 to 45");
    }
}

void check(const PlateStand& stand, double arm, const MachineConfig& machine) {
    for (const auto& place : stand.places) {
        const double reach = std::max(std::abs(place[0]), std::abs(place[1])) + arm;
        if (!(reach <= machine.galvo.half_field.si() + 1e-9)) {
            refuse("the grid leaves the galvo's field", fmt::format("{:.3f} mm", reach * 1e3),
                   fmt::format("keep it within {:.3f} mm", machine.galvo.half_field.si() * 1e3));
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const AxisConfig& axis = machine.axis[i];
        if (!(stand.anchor[i] > axis.travel_min + 1e-3 && stand.anchor[i] < axis.travel_max - 1e-3)) {
            refuse("the plate is out of the travel of axis " + std::string(1, "xyz"[i]),
                   fmt::format("{:.3f} mm", stand.anchor[i] * 1e3), "move the plate");
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

PlatePlan plan_stands(const std::vector<PlateStand>& stands, double arm, const MachineConfig& machine) {
    PlatePlan plan;
    plan.items.emplace_back(Turn{0});
    std::uint32_t path = 0;
    const std::int32_t stroke = wire(arm);
    for (const PlateStand& stand : stands) {
        check(stand, arm, machine);
        PathBegin begin;
        begin.actuator = Actuator::galvo;
        begin.speed_um_s = kSpeedUmS;
        begin.pitch_nm = kPitchNm;
        begin.energy_nj = kEnergyNj;
        begin.anchor_x = wire(stand.anchor.x);
        begin.anchor_y = wire(stand.anchor.y);
        begin.anchor_z = wire(stand.anchor.z);
        for (const auto& place : stand.places) {
            const std::int32_t cx = wire(place[0]);
            const std::int32_t cz = wire(place[1]);
            plan.crosses.push_back({static_cast<int>(plan.crosses.size()) + 1,
                                    {metres(cx), metres(cz)},
                                    {metres(begin.anchor_x), metres(begin.anchor_y), metres(begin.anchor_z)}});
            for (const bool along_x : {true, false}) {
                begin.path = path++;
                const std::int32_t ax = along_x ? stroke : 0;
                const std::int32_t az = along_x ? 0 : stroke;
                plan.items.emplace_back(begin);
                // The galvo alone is to be measured: the points lie in the focal plane, whatever the plate does.
                plan.items.emplace_back(PathPoint{begin.anchor_x + cx - ax, begin.anchor_y, begin.anchor_z + cz - az});
                plan.items.emplace_back(PathPoint{begin.anchor_x + cx + ax, begin.anchor_y, begin.anchor_z + cz + az});
                plan.items.emplace_back(PathEnd{});
            }
        }
    }
    plan.items.emplace_back(JobEnd{});
    plan.hash = job_hash(plan.items);
    plan.expected_seconds = 20.0 + kSecondsACross * static_cast<double>(plan.crosses.size());
    return plan;
}

PlatePlan plan_plate(const PlateOptions& options, const MachineConfig& machine) {
    check_side(options.side);
    std::vector<PlateStand> stands;
    for (std::size_t d = 0; d < options.depths.size(); ++d) {
        // Moved on along the diagonal, so that no cross meets one of another depth.
        const double shift =
            options.shift * (static_cast<double>(d) - 0.5 * static_cast<double>(options.depths.size() - 1));
        PlateStand stand{{options.centre.x + shift, options.centre.y - options.depths[d], options.centre.z + shift},
                         {}};
        for (std::size_t j = 0; j < options.side; ++j) {
            for (std::size_t k = 0; k < options.side; ++k) {
                // There and back: short jumps.
                const std::size_t i = j % 2 == 0 ? k : options.side - 1 - k;
                stand.places.push_back(
                    {options.half * line_at(i, options.side), options.half * line_at(j, options.side)});
            }
        }
        stands.push_back(std::move(stand));
    }
    return plan_stands(stands, options.arm, machine);
}

PlatePlan plan_step_plate(const StepPlateOptions& options, const MachineConfig& machine) {
    if (options.across < 2 || options.up < 3 || options.depths.empty() || options.faces.empty()) {
        refuse("a grid on a step has too few crosses", fmt::format("{} x {}", options.across, options.up),
               "burn 2 x 3 or more a stand, on one face or more, at one depth or more");
    }
    std::vector<PlateStand> stands;
    for (const StepFace& face : options.faces) {
        const double left = face.x[0] + options.edge;
        const double right = face.x[1] - options.edge;
        const double middle_z = 0.5 * (face.z[0] + face.z[1]);
        const double half_z = std::min(options.half, 0.5 * (face.z[1] - face.z[0]) - options.edge);
        if (!(right - left > 0.01 && half_z > 0.01)) {
            refuse("a face of the stepped block is too small for crosses", std::to_string(face.step),
                   fmt::format("leave {:.0f} mm and {:.0f} mm at each edge", 10.0, options.edge * 1e3));
        }
        std::size_t number = 0;
        for (const bool from_right : {true, false}) {
            for (const double depth : options.depths) {
                // No cross on another: each stand's grid is moved by so much.
                const double shift =
                    kStandShift * (static_cast<double>(number++) - static_cast<double>(options.depths.size()) + 0.5);
                PlateStand stand{
                    {from_right ? std::min(right, left + options.half) : std::max(left, right - options.half),
                     face.y - depth, middle_z + shift},
                    {}};
                const double low = left + kStandShift - stand.anchor.x;
                const double high = right - kStandShift - stand.anchor.x;
                for (std::size_t j = 0; j < options.up; ++j) {
                    for (std::size_t k = 0; k < options.across; ++k) {
                        const std::size_t i = j % 2 == 0 ? k : options.across - 1 - k;
                        const double x = low + (high - low) * 0.5 * (1.0 + line_at(i, options.across));
                        stand.places.push_back(
                            {std::clamp(x, -options.half, options.half), half_z * line_at(j, options.up)});
                    }
                }
                stands.push_back(std::move(stand));
            }
        }
    }
    return plan_stands(stands, options.arm, machine);
}

}  // namespace sc::host
