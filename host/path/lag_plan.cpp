// SPDX-License-Identifier: Apache-2.0
#include "host/path/lag_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "host/calibration/lag_curve.hpp"
#include "host/formats/error.hpp"
#include "shared/path/job_hash.hpp"
#include "shared/units/quantity.hpp"

namespace sc::host {
namespace {

constexpr std::uint32_t kEnergyNj = 400'000;
/// Of a straight line nothing is rounded; a sine's points lie so near to each other that the curve through them leaves
/// the sine by a small part of this.
constexpr std::uint32_t kStraightNm = 50;
constexpr std::uint32_t kSineNm = 1'000;
constexpr double kPointSpacing = 25e-6;
/// Of the mirrors' limits: with these the speed along a line stays what was asked for.
constexpr double kShare = 0.75;
constexpr std::array<double, 3> kFrequencies{0.4, 0.6, 0.8};  ///< of the natural one
constexpr std::array<double, 2> kSpeeds{1.0, 0.25};           ///< of the greatest
constexpr double kUnknownFrequency = 2000.0;
constexpr double kSecondsALine = 0.2;
/// How far the lines stay from the middle, and the run-in and run-out from the field's edge.
constexpr double kMiddle = 1e-3;
constexpr double kRunIn = 5e-3;

std::int32_t wire(double metres) { return static_cast<std::int32_t>(std::llround(metres * kWireUnitsPerMetre)); }

class Planner {
public:
    Planner(const LagPlateOptions& options, const MachineConfig& machine) : options_(options), machine_(machine) {
        out_.plan.told = lag_of(machine.galvo);
        out_.items.emplace_back(Turn{0});
    }

    void lines(bool along_x) {
        along_x_ = along_x;
        across_ = kMiddle;
        const double speed = machine_.galvo.speed.si();
        for (const double share : kSpeeds) {
            pair(share * speed, 0.0, 0.0);
        }
        const double stated = machine_.galvo.natural_frequency.si();
        for (const double share : kFrequencies) {
            const double omega = 2.0 * kPi * share * (stated > 0.0 ? stated : kUnknownFrequency);
            const double most = kShare * std::min(machine_.galvo.acceleration.si(), machine_.galvo.jerk.si() / omega);
            pair(kShare * speed, most / (omega * omega), kShare * speed * 2.0 * kPi / omega);
        }
    }

    LagPlatePlan finish() {
        out_.items.emplace_back(JobEnd{});
        out_.hash = job_hash(out_.items);
        out_.expected_seconds = 20.0 + kSecondsALine * static_cast<double>(out_.plan.lines.size());
        return std::move(out_);
    }

private:
    void pair(double speed, double amplitude, double wavelength) {
        for (const int way : {1, -1}) {
            across_ += options_.gap + amplitude;
            line(way, speed, amplitude, wavelength);
            across_ += amplitude;
        }
    }

    void line(int way, double speed, double amplitude, double wavelength) {
        LagLine line;
        line.no = static_cast<int>(out_.plan.lines.size()) + 1;
        line.along_x = along_x_;
        line.way = way;
        // On the wire's grid, so that the plan's file says what is burnt.
        const auto grid = [](double metres) { return wire(metres) / kWireUnitsPerMetre; };
        const std::size_t run = along_x_ ? 0 : 1;
        line.start[run] = grid(-0.5 * way * options_.run);
        line.start[1 - run] = grid(along_x_ ? across_ : -across_);
        line.run = grid(options_.run);
        line.amplitude = grid(amplitude);
        line.wavelength = grid(wavelength);
        line.speed = std::round(speed * 1e6) / 1e6;
        line.pitch = std::round(options_.pitch * 1e9) / 1e9;
        line.anchor = {grid(options_.centre.x), grid(options_.centre.y), grid(options_.centre.z)};
        const double half = machine_.galvo.half_field.si();
        if (!(std::max(across_ + amplitude, 0.5 * options_.run) + kRunIn <= half)) {
            throw InputError({.file = {},
                              .problem = "the lines leave the galvo's field",
                              .value = fmt::format("{:.3f} mm", (across_ + amplitude + kRunIn) * 1e3),
                              .action = fmt::format("keep them within {:.3f} mm", half * 1e3)});
        }
        items(line);
        out_.plan.lines.push_back(line);
    }

    void items(const LagLine& line) {
        PathBegin begin;
        begin.path = static_cast<std::uint32_t>(out_.plan.lines.size());
        begin.actuator = Actuator::galvo;
        begin.speed_um_s = static_cast<std::uint32_t>(std::lround(line.speed * 1e6));
        begin.pitch_nm = static_cast<std::uint32_t>(std::lround(line.pitch * 1e9));
        begin.energy_nj = kEnergyNj;
        begin.tolerance_nm = line.amplitude > 0.0 ? kSineNm : kStraightNm;
        begin.anchor_x = wire(line.anchor.x);
        begin.anchor_y = wire(line.anchor.y);
        begin.anchor_z = wire(line.anchor.z);
        out_.items.emplace_back(begin);
        const LagCurve curve(line);
        const int parts = line.amplitude > 0.0 ? static_cast<int>(std::ceil(line.run / kPointSpacing)) : 1;
        for (int i = 0; i <= parts; ++i) {
            const std::array<double, 2> place = curve.place_of(line.run * i / parts);
            out_.items.emplace_back(
                PathPoint{begin.anchor_x + wire(place[0]), begin.anchor_y, begin.anchor_z + wire(place[1])});
        }
        out_.items.emplace_back(PathEnd{});
    }

    LagPlateOptions options_;
    MachineConfig machine_;
    LagPlatePlan out_;
    bool along_x_ = true;
    double across_ = 0.0;
};

}  // namespace

LagPlatePlan plan_lag_plate(const LagPlateOptions& options, const MachineConfig& machine) {
    Planner planner(options, machine);
    planner.lines(true);
    planner.lines(false);
    return planner.finish();
}

}  // namespace sc::host
