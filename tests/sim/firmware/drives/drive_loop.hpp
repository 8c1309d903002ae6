// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "boards/sim/plant/drive.hpp"
#include "firmware/drives/drive_master.hpp"
#include "shared/machine/machine.hpp"

namespace sc::test {

/// Set-point units (pm, ndeg) in a base unit (m, degree).
inline double units_per_base(std::size_t axis) { return axis == index(Axis::c) ? kNdegPerDegree : kPmPerMetre; }

/// The master and four simulated drives in lock-step, with the timing that a board keeps: frames of tick n reach the
/// drives at t_n+1, their answers the master in tick n+1.
class DriveLoop {
public:
    explicit DriveLoop(const MachineConfig& config = reference_machine(), std::array<double, 4> start = kStart,
                       const DrivePlan& plan = kPlainDrives,
                       const std::function<void(std::size_t, sim::SimDriveOptions&)>& change = {})
        : machine(config), master(machine, plan) {
        const std::int64_t cycle_ns = machine.control_period_ns * static_cast<std::int64_t>(machine.drive_cycle_ticks);
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            sim::SimDriveOptions options = sim::drive_options(machine.axis[axis], cycle_ns, start[axis]);
            options.second_bus = plan.drive[axis].bus == 1;
            if (change) {
                change(axis, options);
            }
            drives.emplace_back(options);
        }
    }

    static constexpr std::array<double, 4> kStart{-0.010, -0.020, -0.015, 3.0};

    const drives::Outcome& step() {
        ServoOutputs& out = *outputs;
        out = ServoOutputs{};
        outcome = master.step(tick, received, request, out);
        most_frames = std::max(most_frames, out.drive_tx_size);
        received.clear();
        ++tick;
        const std::int64_t t_ns = tick * machine.control_period_ns;
        for (std::int64_t t = t_ns - machine.control_period_ns; t < t_ns; t += substep_ns) {
            for (sim::SimDrive& drive : drives) {
                drive.step_to(t);
            }
        }
        for (std::size_t i = 0; i < out.drive_tx_size; ++i) {
            sent.push_back(out.drive_tx[i]);
            for (sim::SimDrive& drive : drives) {
                drive.receive(out.drive_tx[i], t_ns);
            }
        }
        for (sim::SimDrive& drive : drives) {
            drive.step_to(t_ns);
            drive.drain(received);
        }
        return outcome;
    }

    /// Steps until `until` holds or so many ticks have passed. Returns whether it holds.
    bool run(std::int64_t ticks, const std::function<bool()>& until) {
        for (std::int64_t i = 0; i < ticks; ++i) {
            step();
            keep_place_while_not_following();
            if (until()) {
                return true;
            }
        }
        return false;
    }
    void run(std::int64_t ticks) {
        run(ticks, [] { return false; });
    }

    bool enable() {
        request.power = true;
        return run(1000, [this] { return outcome.all_follow; });
    }
    bool home(std::uint8_t axes) {
        request.home = true;
        request.home_axes = axes;
        const bool done = run(20'000, [this] { return outcome.homing_done; });
        request.home = false;
        return done && run(100, [this] { return outcome.all_follow; });
    }
    /// What the contract asks of the caller.
    void keep_place_while_not_following() {
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            if (!outcome.axis[axis].follows || !followed[axis]) {
                request.target[axis] = outcome.axis[axis].actual;
            }
            followed[axis] = outcome.axis[axis].follows;
        }
    }

    [[nodiscard]] double count_of(std::size_t axis) const { return 1.0 / machine.axis[axis].counts_per_unit; }

    MachineConfig machine;
    drives::DriveMaster master;
    std::vector<sim::SimDrive> drives;
    drives::Request request{};
    drives::Outcome outcome{};
    std::vector<DriveFrame> received;
    std::vector<DriveFrame> sent;
    std::unique_ptr<ServoOutputs> outputs = std::make_unique<ServoOutputs>();
    std::array<bool, kAxisCount> followed{};
    std::size_t most_frames = 0;
    std::int64_t tick = 0;
    std::int64_t substep_ns = 1'000'000;
};

}  // namespace sc::test
